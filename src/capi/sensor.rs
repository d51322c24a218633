//! Sensors, and what frames on their own grids are to be like.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use core::mem::offset_of;

use super::config::{CollisionCode, CompandingCode, companding, flicr_companding};
use super::memory::{Outcome, choose, deliver};
use super::status::flicr_status;
use crate::config::{GridConfig, Scale};
use crate::geometry::sensors::{SensorGeometry, hdl64e, hesai, velodyne};
use crate::geometry::{Beam, SensorGrid};
use crate::insert::Collision;
use crate::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};

/// A `flicr_sensor` as it comes from C.
pub type SensorCode = u32;
/// A `flicr_return_policy` as it comes from C.
pub type ReturnPolicyCode = u32;

/// Sensors whose grids are known, and but for the first two and the last their packets.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_sensor {
    /// Any that sends no packets known here: its grid is all in flicr_grid_config.
    Custom = 0,
    /// Velodyne HDL-64E, KITTI's unit: returns only.
    Hdl64e = 1,
    /// Velodyne VLP-16 and Puck LITE.
    Vlp16 = 2,
    /// Velodyne Puck Hi-Res.
    PuckHiRes = 3,
    /// Velodyne VLP-32C.
    Vlp32c = 4,
    /// Velodyne HDL-32E.
    Hdl32e = 5,
    /// Velodyne VLS-128.
    Vls128 = 6,
    /// Hesai Pandar40P.
    Pandar40p = 7,
    /// Hesai Pandar64.
    Pandar64 = 8,
    /// Hesai PandarXT-32.
    PandarXt32 = 9,
    /// As FLICR_SENSOR_HDL64E, where each laser's own angle is in its beam and all of a firing share its tick: for streams.
    Hdl64eFirings = 10,
}

/// Which of two returns in a packet is meant.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_return_policy {
    /// The stronger.
    Strongest = 0,
    /// The farther.
    Last = 1,
    /// The one that FLICR_RETURN_POLICY_STRONGEST leaves; none where the sensor repeats the only one it has. For both, push
    /// each packet into an encoder of either.
    Other = 2,
}

/// One laser of a spinning sensor. docs/FORMAT.md says where its returns lie.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct flicr_beam {
    /// Tangent of the elevation.
    pub slope: f32,
    /// Height over the sensor's origin at which the beam, prolonged, crosses the spin axis, meters.
    pub z_offset_m: f32,
    /// Sideways distance of the beam from the spin axis, meters; positive to the right.
    pub h_offset_m: f32,
    /// What the beam adds to the encoder's azimuth, radians counterclockwise seen from above.
    pub azimuth_phase_rad: f32,
    /// Range of count 0, meters.
    pub range_phase_m: f32,
}

/// What frames on a sensor's own grid are to be like. Filled by flicr_grid_config_init; then change what you like.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct flicr_grid_config {
    /// Whose packets come.
    pub sensor: SensorCode,
    /// Turns a minute, at most 6000: the known sensors' beams fire one after another while the sensor turns. 0: all at
    /// once.
    pub turns_per_minute: u32,
    /// The beams, highest first; copied by flicr_grid_encoder_init_... Null: those of the sensor.
    pub beams: *const flicr_beam,
    /// Beams, and rows of the image: 1 to FLICR_BEAMS_MAX.
    pub beam_count: u32,
    /// Encoder ticks a turn.
    pub ticks: u32,
    /// 1 where ticks grow clockwise, seen from above; 0 where not.
    pub clockwise: u32,
    /// Azimuth of tick 0, radians from -pi to pi, counterclockwise from x.
    pub zero_rad: f32,
    /// One range count, meters.
    pub range_unit_m: f32,
    /// 1 where the distance that a range gives along the ground counts from the spin axis, 0 where from the place where
    /// the beam passes it.
    pub range_from_axis: u32,
    /// Columns, spread evenly over the turn from tick 0 on.
    pub columns: u32,
    /// Bits of a level: 1 to 8 take a byte a pixel, 9 to 16 take two.
    pub level_bits: u32,
    /// Distance of the levels, meters. The range unit: nothing is lost.
    pub step_m: f32,
    /// Which return a pixel keeps where several fall into it.
    pub collision: CollisionCode,
    /// Which of two returns in a packet is meant.
    pub returns: ReturnPolicyCode,
    /// 1 where each frame carries the beams (20 bytes each), for receivers that do not know them; 0 where not.
    pub table: u32,
    /// How levels are spread over ranges.
    pub companding: CompandingCode,
    /// Strips that a frame is cut into, 1 to `columns`: runs of columns that decode alone. 1 unless set; with more, see
    /// FLICR_GRID_WORST_CASE_LEN_IN_STRIPS.
    pub strips: u32,
}

/// Most beams of a sensor.
pub const FLICR_BEAMS_MAX: usize = 128;

/// Faster than any sensor turns.
const TURNS_PER_MINUTE_MAX: u32 = 6000;

/// C's beams can be looked at as Rust's.
const _: () = {
    assert!(size_of::<flicr_beam>() == size_of::<Beam>() && align_of::<flicr_beam>() == align_of::<Beam>());
    assert!(offset_of!(flicr_beam, slope) == offset_of!(Beam, slope));
    assert!(offset_of!(flicr_beam, z_offset_m) == offset_of!(Beam, z_offset_m));
    assert!(offset_of!(flicr_beam, h_offset_m) == offset_of!(Beam, h_offset_m));
    assert!(offset_of!(flicr_beam, azimuth_phase_rad) == offset_of!(Beam, azimuth_phase_rad));
    assert!(offset_of!(flicr_beam, range_phase_m) == offset_of!(Beam, range_phase_m));
};

/// Fills a configuration for a known sensor at its usual 600 turns a minute: lossless, the nearest return wins, the
/// beams are carried. columns: about as many as the sensor fires in a turn, or its ticks.
///
/// FLICR_STATUS_SENSOR, for FLICR_SENSOR_CUSTOM too; FLICR_STATUS_SIZE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_grid_config_init(
    sensor: SensorCode,
    columns: u32,
    out_config: *mut flicr_grid_config,
) -> flicr_status {
    // SAFETY: the caller's promise about `out_config`.
    unsafe { deliver(out_config, |_| grid_config(sensor, columns)) }
}

fn grid_config(sensor: SensorCode, columns: u32) -> Outcome<flicr_grid_config> {
    let known = flicr_sensor::from_code(sensor)?;
    let grid = known.grid().ok_or(flicr_status::Sensor)?;
    if columns == 0 || columns > u32::from(u16::MAX) {
        return Err(flicr_status::Size);
    }
    Ok(flicr_grid_config {
        sensor,
        turns_per_minute: 600,
        beams: core::ptr::null(),
        beam_count: grid.beams.len() as u32,
        ticks: grid.ticks,
        clockwise: grid.clockwise.into(),
        zero_rad: grid.zero_rad,
        range_unit_m: grid.range_unit_m,
        range_from_axis: grid.range_from_axis.into(),
        columns,
        level_bits: 16,
        step_m: grid.range_unit_m,
        collision: Collision::Nearest as u32,
        returns: flicr_return_policy::Strongest as u32,
        table: 1,
        companding: flicr_companding::None as u32,
        strips: 1,
    })
}

impl flicr_sensor {
    fn from_code(code: SensorCode) -> Outcome<Self> {
        const ALL: [flicr_sensor; 11] = [
            flicr_sensor::Custom,
            flicr_sensor::Hdl64e,
            flicr_sensor::Vlp16,
            flicr_sensor::PuckHiRes,
            flicr_sensor::Vlp32c,
            flicr_sensor::Hdl32e,
            flicr_sensor::Vls128,
            flicr_sensor::Pandar40p,
            flicr_sensor::Pandar64,
            flicr_sensor::PandarXt32,
            flicr_sensor::Hdl64eFirings,
        ];
        choose(&ALL, code, flicr_status::Sensor)
    }

    /// The packets' model, and its beams when it does not turn.
    fn model(self) -> Option<(Model, &'static SensorGeometry)> {
        match self {
            Self::Custom | Self::Hdl64e | Self::Hdl64eFirings => None,
            Self::Vlp16 => Some((Model::Vlp16, &velodyne::VLP16)),
            Self::PuckHiRes => Some((Model::PuckHiRes, &velodyne::PUCK_HI_RES)),
            Self::Vlp32c => Some((Model::Vlp32c, &velodyne::VLP32C)),
            Self::Hdl32e => Some((Model::Hdl32e, &velodyne::HDL32E)),
            Self::Vls128 => Some((Model::Vls128, &velodyne::VLS128)),
            Self::Pandar40p => Some((Model::Pandar40p, &hesai::PANDAR40P)),
            Self::Pandar64 => Some((Model::Pandar64, &hesai::PANDAR64)),
            Self::PandarXt32 => Some((Model::PandarXt32, &hesai::PANDAR_XT32)),
        }
    }

    fn grid(self) -> Option<SensorGrid<'static>> {
        match self {
            Self::Hdl64e => Some(hdl64e::GRID),
            Self::Hdl64eFirings => Some(hdl64e::FIRING_GRID),
            _ => self.model().map(|(_, geometry)| geometry.grid()),
        }
    }
}

impl flicr_grid_config {
    /// The beams: C's, or the sensor's own as if all fired at once.
    ///
    /// # Safety
    /// `beams` is null or `beam_count` of them may be read before the result's last use.
    pub(super) unsafe fn still_beams<'a>(&self) -> Outcome<&'a [Beam]> {
        if self.beams.is_null() {
            let grid = flicr_sensor::from_code(self.sensor)?.grid().ok_or(flicr_status::Sensor)?;
            let fits = grid.beams.len() == self.beam_count as usize && self.turns_per_minute <= TURNS_PER_MINUTE_MAX;
            return if fits { Ok(grid.beams) } else { Err(flicr_status::Sensor) };
        }
        if !self.beams.is_aligned() {
            return Err(flicr_status::Misaligned);
        }
        // SAFETY: aligned, of the same layout, and the caller's promise.
        Ok(unsafe { core::slice::from_raw_parts(self.beams.cast(), self.beam_count as usize) })
    }

    /// Makes the sensor's own beams those of one that turns.
    pub(super) fn turn(&self, beams: &mut [Beam]) -> Outcome<()> {
        if self.beams.is_null()
            && let Some((_, geometry)) = flicr_sensor::from_code(self.sensor)?.model()
        {
            geometry.fill_beams_at(self.turns_per_minute, beams).ok_or(flicr_status::Sensor)?;
        }
        Ok(())
    }

    pub(super) fn to_config(self, beams: &[Beam]) -> Outcome<GridConfig<'_>> {
        let Self { ticks, zero_rad, range_unit_m, level_bits, step_m, .. } = self;
        let collisions = [Collision::Nearest, Collision::Farthest, Collision::First, Collision::Last];
        let (clockwise, range_from_axis) = (self.clockwise != 0, self.range_from_axis != 0);
        Ok(GridConfig {
            grid: SensorGrid { name: "", beams, ticks, clockwise, zero_rad, range_unit_m, range_from_axis },
            columns: u16::try_from(self.columns).map_err(|_| flicr_status::Size)?,
            level_bits,
            scale: Scale::Step { step_m },
            collision: choose(&collisions, self.collision, flicr_status::Collision)?,
            table: self.table != 0,
            companding: companding(self.companding)?,
            strips: u16::try_from(self.strips).map_err(|_| flicr_status::Strips)?,
        })
    }

    /// What takes the packets; of sensors that send none, none will be right.
    pub(super) fn assembler(&self) -> Outcome<TurnAssembler> {
        let policies = [ReturnPolicy::Strongest, ReturnPolicy::Last, ReturnPolicy::Both];
        let policy = choose(&policies, self.returns, flicr_status::ReturnPolicy)?;
        let model = flicr_sensor::from_code(self.sensor)?.model().map(|(model, _)| model);
        Ok(TurnAssembler::new(model.map_or(Sensor::Auto, Sensor::Spinning), policy))
    }

    /// Which of the columns that [`assembler`](Self::assembler) gives of a firing are meant.
    pub(super) const fn layer(&self) -> u8 {
        (self.returns == flicr_return_policy::Other as u32) as u8
    }

    /// Whether packets can come.
    pub(super) fn has_packets(&self) -> bool {
        flicr_sensor::from_code(self.sensor).is_ok_and(|sensor| sensor.model().is_some())
    }
}
