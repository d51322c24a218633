//! The simulated sensor: its beams, its ticks, and the lattice that they span.

use std::borrow::Cow;

use super::shape::Ray;
use crate::geometry::sensors::hdl64e;
use crate::geometry::{Beam, BeamLine};

/// What the simulator has to know about a spinning sensor.
///
/// All fields are open, so that any sensor can be made up:
///
/// ```
/// use flicr::simulate::{Sensor, Simulator};
///
/// let slow = Sensor { period_ns: 200_000_000, firings: 3617, ..Sensor::vlp16() };
/// let turn = Simulator::with_sensor(slow, 1).next().unwrap();
/// assert!(turn.firing_ticks.len() > 3600);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// The beams, highest first; at most 256.
    pub beams: Cow<'static, [Beam]>,
    /// Ticks by which each beam looks ahead of the firing's own tick; none means 0 for all.
    pub tick_shifts: Cow<'static, [i32]>,
    /// Encoder ticks a turn, at most 65,536.
    pub ticks: u32,
    /// Firings of a turn, on average; at most the ticks, for no tick is seen twice.
    pub firings: u32,
    /// The turn's firings vary by as much as this either way, as the motor does.
    pub firings_jitter: u32,
    /// Tick at which a turn begins.
    pub first_tick: u32,
    /// Time of one turn.
    pub period_ns: u64,
    /// One range count, in meters.
    pub range_unit_m: f64,
    /// [`SensorGrid::range_from_axis`](crate::geometry::SensorGrid::range_from_axis).
    pub range_from_axis: bool,
    /// Nothing nearer is reported, in meters.
    pub min_range_m: f64,
    /// Nothing beyond is reported, in meters; returns thin out over the last quarter.
    pub max_range_m: f64,
    /// Standard deviation of a range measured nearby, in meters; beams differ, far is worse.
    pub noise_m: f64,
    /// Height of the sensor's origin over the road, in meters.
    pub height_m: f64,
    /// Whether the car's own roof hides part of the lowest beams.
    pub own_car: bool,
}

impl Sensor {
    /// The Velodyne HDL-64E as KITTI's car carries it: 64 beams, 4000 ticks, about 2150 firings a
    /// turn from the back over the right, 2 mm counts, nothing beyond 80 m.
    #[must_use]
    pub fn hdl64e() -> Self {
        Self {
            beams: Cow::Borrowed(&hdl64e::BEAMS),
            tick_shifts: Cow::Borrowed(&HDL64E_TICK_SHIFTS),
            ticks: hdl64e::TICKS,
            firings: 2150,
            firings_jitter: 4,
            first_tick: 2000,
            period_ns: 100_000_000,
            range_unit_m: hdl64e::RANGE_UNIT_M,
            range_from_axis: hdl64e::GRID.range_from_axis,
            min_range_m: 0.9,
            max_range_m: 80.0,
            noise_m: 0.006,
            height_m: 1.73,
            own_car: true,
        }
    }

    /// A Velodyne VLP-16 by its data sheet: 16 beams 2 degrees apart, 0.01 degree ticks, about
    /// 1808 firings a turn, 2 mm counts, 100 m.
    #[must_use]
    pub fn vlp16() -> Self {
        Self {
            beams: (0..16).map(vlp16_beam).collect(),
            tick_shifts: Cow::Borrowed(&[]),
            ticks: 36_000,
            firings: 1808,
            firings_jitter: 1,
            first_tick: 0,
            period_ns: 100_000_000,
            range_unit_m: 0.002,
            range_from_axis: false,
            min_range_m: 0.4,
            max_range_m: 100.0,
            noise_m: 0.01,
            height_m: 1.73,
            own_car: false,
        }
    }

    /// The tick that a beam measures at when the firing's own tick is given.
    pub(super) fn beam_tick(&self, beam: u8, firing_tick: u16) -> u32 {
        let shift = self.tick_shifts.get(usize::from(beam)).copied().unwrap_or(0);
        let tick = i64::from(firing_tick) + i64::from(shift);
        tick.rem_euclid(i64::from(self.ticks)) as u32
    }
}

/// Beam of the VLP-16's data sheet: +15 to -15 degrees, each with its vertical correction.
fn vlp16_beam(beam: u32) -> Beam {
    const HEIGHTS_MM: [f64; 16] =
        [11.2, 9.7, 8.1, 6.6, 5.1, 3.7, 2.2, 0.7, -0.7, -2.2, -3.7, -5.1, -6.6, -8.1, -9.7, -11.2];
    let slope = libm::tan((15.0 - 2.0 * f64::from(beam)).to_radians());
    // The data sheet's correction is added to z; it grows from low to high.
    let z_offset_m = -HEIGHTS_MM[beam as usize] / 1000.0;
    Beam {
        slope: slope as f32,
        z_offset_m: z_offset_m as f32,
        h_offset_m: 0.0,
        azimuth_phase_rad: 0.0,
        range_phase_m: 0.0,
    }
}

/// What each laser of KITTI's unit looks ahead: so a simulated scan is on [`hdl64e::FIRING_GRID`], which decoders know by
/// its number, and its frames need not carry the beams.
static HDL64E_TICK_SHIFTS: [i32; 64] = {
    let (mut shifts, mut beam) = ([0; 64], 0);
    while beam < shifts.len() {
        shifts[beam] = -(hdl64e::TICKS_BEHIND[beam] as i32);
        beam += 1;
    }
    shifts
};

/// A beam's constants with the sines taken, ready for many points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    line: BeamLine,
    azimuth_phase_rad: f64,
    range_phase_m: f64,
    rad_per_tick: f64,
    range_unit_m: f64,
}

impl Lattice {
    pub(super) fn new(sensor: &Sensor, beam: &Beam) -> Self {
        Self {
            line: BeamLine::new(beam, sensor.range_from_axis),
            azimuth_phase_rad: f64::from(beam.azimuth_phase_rad),
            range_phase_m: f64::from(beam.range_phase_m),
            rad_per_tick: core::f64::consts::TAU / f64::from(sensor.ticks),
            range_unit_m: sensor.range_unit_m,
        }
    }

    fn theta_rad(&self, tick: u32) -> f64 {
        f64::from(tick) * self.rad_per_tick + self.azimuth_phase_rad
    }

    /// The line that the beam looks along, in the sensor's frame; its parameter is the range.
    pub(super) fn ray(&self, tick: u32) -> Ray {
        let (sin, cos) = libm::sincos(self.theta_rad(tick));
        let BeamLine { sin: sin_v, cos: cos_v, lift_m, h_m, .. } = self.line;
        let a = -lift_m * sin_v;
        Ray {
            origin: [a * cos + h_m * sin, a * sin - h_m * cos, lift_m * cos_v],
            direction: [cos_v * cos, cos_v * sin, sin_v],
        }
    }

    /// The count that a range is measured as.
    pub(super) fn count(&self, range_m: f64) -> u32 {
        libm::round((range_m - self.range_phase_m) / self.range_unit_m) as u32
    }

    /// The range that a count stands for, in meters.
    pub(super) fn range_m(&self, count: u32) -> f64 {
        f64::from(count) * self.range_unit_m + self.range_phase_m
    }

    /// Where (tick, count) lies, in the sensor's frame.
    pub(super) fn position(&self, tick: u32, count: u32) -> [f64; 3] {
        self.line.position(self.theta_rad(tick), self.range_m(count))
    }
}
