//! A spinning sensor's own grid: its beams, its encoder's ticks, its range counts.
//!
//! What is here is exact, in double precision, and slow; [`Lattice`](super::Lattice) is the same made ready for whole
//! scans.

use core::f64::consts::TAU;

use crate::error::ConfigError;

/// One laser of a spinning sensor.
///
/// At tick `t` and range count `n`, with elevation `v = atan(slope)`, `vo = z_offset_m * cos v`, `h = h_offset_m` and
/// the turning direction `turn` (+1 counterclockwise seen from above, -1 clockwise), the return lies at
///
/// ```text
/// theta = zero_rad + turn * t * 2 pi / ticks + azimuth_phase_rad
/// d = n * range_unit_m + range_phase_m            a = d cos v - vo sin v
/// x = a cos theta + h sin theta                   y = a sin theta - h cos theta
/// z = d sin v + vo cos v
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Beam {
    /// Tangent of the elevation.
    pub slope: f32,
    /// Height over the sensor's origin at which the beam, prolonged, crosses the spin axis, meters.
    pub z_offset_m: f32,
    /// Sideways distance of the beam from the spin axis, meters; positive to the right.
    pub h_offset_m: f32,
    /// What the beam adds to the encoder's azimuth, radians, counterclockwise seen from above (whichever way the
    /// sensor turns).
    pub azimuth_phase_rad: f32,
    /// Range of count 0, meters.
    pub range_phase_m: f32,
}

/// The grid on which a sensor measures: everything that its returns have in common.
///
/// Built-in ones are in [`sensors`](super::sensors).
///
/// ```
/// use flicr::geometry::sensors::hdl64e;
/// let grid = hdl64e::GRID;
/// let [x, y, z] = grid.position(0, 1000, 5000).unwrap();
/// assert!(x.abs() < 0.05 && (y - 9.994).abs() < 0.01 && z > 0.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorGrid<'a> {
    /// What the sensor is called; no part of its identity.
    pub name: &'a str,
    /// The beams, highest first: their slopes fall from each to the next. 1 to [`BEAMS_MAX`](Self::BEAMS_MAX).
    pub beams: &'a [Beam],
    /// Encoder ticks a turn, 1 to 2^20.
    pub ticks: u32,
    /// Whether ticks grow clockwise, seen from above.
    pub clockwise: bool,
    /// Azimuth of tick 0, radians from -pi to pi, counterclockwise from x.
    pub zero_rad: f32,
    /// One range count, meters.
    pub range_unit_m: f32,
}

impl SensorGrid<'_> {
    /// Most beams of a sensor.
    pub const BEAMS_MAX: usize = 1024;
    /// Most ticks a turn: finer ones could not be told apart with the `f32` coordinates of a point.
    pub const TICKS_MAX: u32 = 1 << 20;

    /// Checks what the docs of the fields say, and that all numbers are finite and of a size that a sensor has.
    ///
    /// # Errors
    /// [`ConfigError::Beams`], [`ConfigError::Beam`], [`ConfigError::Ticks`], [`ConfigError::AzimuthView`],
    /// [`ConfigError::RangeUnit`].
    pub const fn check(&self) -> Result<(), ConfigError> {
        if self.beams.is_empty() || self.beams.len() > Self::BEAMS_MAX {
            return Err(ConfigError::Beams { found: self.beams.len(), max: Self::BEAMS_MAX });
        }
        if self.ticks == 0 || self.ticks > Self::TICKS_MAX {
            return Err(ConfigError::Ticks { found: self.ticks, max: Self::TICKS_MAX });
        }
        let is_azimuth = self.zero_rad.abs() <= core::f32::consts::PI;
        if !is_azimuth {
            return Err(ConfigError::AzimuthView { start_rad: self.zero_rad, span_rad: core::f32::consts::TAU });
        }
        if !(self.range_unit_m > 0.0 && self.range_unit_m <= 1.0) {
            return Err(ConfigError::RangeUnit { found_m: self.range_unit_m });
        }
        let mut row = 0;
        while row < self.beams.len() {
            let falls = row == 0 || self.beams[row].slope < self.beams[row - 1].slope;
            if !(falls && self.beams[row].is_usable()) {
                return Err(ConfigError::Beam { row });
            }
            row += 1;
        }
        Ok(())
    }

    /// Where a return lies, x, y, z in meters. `None` where there is no such beam.
    ///
    /// `tick` and `count` may be fractions: the middle of a coarser column or level.
    #[must_use]
    pub fn position(&self, row: usize, tick: impl Into<f64>, count: impl Into<f64>) -> Option<[f64; 3]> {
        let beam = self.beams.get(row)?;
        let turned_rad = tick.into() * TAU / f64::from(self.ticks);
        let turned_rad = if self.clockwise { -turned_rad } else { turned_rad };
        let (sin, cos) = libm::sincos(f64::from(self.zero_rad) + turned_rad + f64::from(beam.azimuth_phase_rad));
        let line = BeamLine::new(beam);
        let d = count.into() * f64::from(self.range_unit_m) + f64::from(beam.range_phase_m);
        let a = d * line.cos - line.lift_m * line.sin;
        let h = f64::from(beam.h_offset_m);
        Some([a * cos + h * sin, a * sin - h * cos, d * line.sin + line.lift_m * line.cos])
    }
}

impl Beam {
    /// To be written over.
    pub(crate) const ZERO: Self =
        Self { slope: 0.0, z_offset_m: 0.0, h_offset_m: 0.0, azimuth_phase_rad: 0.0, range_phase_m: 0.0 };

    /// Whether no number is one that no sensor has: steeper than 89 degrees, or a quarter of a meter beside the axis.
    const fn is_usable(&self) -> bool {
        self.slope.abs() <= 57.0
            && self.z_offset_m.abs() <= 1.0
            && self.h_offset_m.abs() <= 0.25
            && self.azimuth_phase_rad.abs() <= core::f32::consts::TAU
            && self.range_phase_m.abs() <= 10.0
    }
}

/// A beam's line in the plane of the spin axis, in double precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BeamLine {
    /// Sine of the elevation.
    pub(crate) sin: f64,
    /// Cosine of the elevation.
    pub(crate) cos: f64,
    /// Distance of the line from the sensor's origin, upwards: `vo`.
    pub(crate) lift_m: f64,
}

impl BeamLine {
    pub(crate) const fn new(beam: &Beam) -> Self {
        let slope = beam.slope as f64;
        let cos = 1.0 / sqrt(1.0 + slope * slope);
        Self { sin: slope * cos, cos, lift_m: beam.z_offset_m as f64 * cos }
    }
}

/// Square root of `v`, at least 1, at compile time.
const fn sqrt(v: f64) -> f64 {
    let mut root = v;
    // From above, Newton's steps fall until they are exact but for the last rounding.
    loop {
        let next = 0.5 * (root + v / root);
        if next >= root {
            return root;
        }
        root = next;
    }
}
