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
///
/// on a grid whose ranges run [from the axis](SensorGrid::range_from_axis) with `sqrt(a^2 - h^2)` for `a`.
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
    /// Whether the distance that a beam's range gives along the ground counts from the spin axis, to which the beam's
    /// sideways offset then adds nothing; else it counts from where the beam passes the axis, and the return is
    /// `sqrt(a^2 + h^2)` from the axis.
    pub range_from_axis: bool,
}

impl SensorGrid<'_> {
    /// Most beams of a sensor.
    pub const BEAMS_MAX: usize = 1024;
    /// Longest range count, meters.
    pub const RANGE_UNIT_MAX_M: f32 = 1.0;
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
        if !(self.range_unit_m > 0.0 && self.range_unit_m <= Self::RANGE_UNIT_MAX_M) {
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
        let theta_rad = f64::from(self.zero_rad) + turned_rad + f64::from(beam.azimuth_phase_rad);
        let range_m = count.into() * f64::from(self.range_unit_m) + f64::from(beam.range_phase_m);
        Some(BeamLine::new(beam, self.range_from_axis).position(theta_rad, range_m))
    }
}

impl Beam {
    /// To be written over.
    pub(crate) const ZERO: Self =
        Self { slope: 0.0, z_offset_m: 0.0, h_offset_m: 0.0, azimuth_phase_rad: 0.0, range_phase_m: 0.0 };

    /// Steepest, either way: 89 degrees.
    pub(crate) const SLOPE_MAX: f32 = 57.0;
    /// Highest over or lowest under the origin, meters.
    pub(crate) const Z_OFFSET_MAX_M: f32 = 1.0;
    /// Farthest beside the axis, meters.
    pub(crate) const H_OFFSET_MAX_M: f32 = 0.25;
    /// A turn either way.
    pub(crate) const AZIMUTH_PHASE_MAX_RAD: f32 = core::f32::consts::TAU;
    /// Longest range of count 0, meters.
    pub(crate) const RANGE_PHASE_MAX_M: f32 = 10.0;

    /// Whether no number is one that no sensor has.
    const fn is_usable(&self) -> bool {
        self.slope.abs() <= Self::SLOPE_MAX
            && self.z_offset_m.abs() <= Self::Z_OFFSET_MAX_M
            && self.h_offset_m.abs() <= Self::H_OFFSET_MAX_M
            && self.azimuth_phase_rad.abs() <= Self::AZIMUTH_PHASE_MAX_RAD
            && self.range_phase_m.abs() <= Self::RANGE_PHASE_MAX_M
    }
}

/// A beam's line in the plane of the spin axis, in double precision: what is exact of a grid is computed here.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BeamLine {
    /// Sine of the elevation.
    pub(crate) sin: f64,
    /// Cosine of the elevation.
    pub(crate) cos: f64,
    /// Distance of the line from the sensor's origin, upwards: `vo`.
    pub(crate) lift_m: f64,
    /// Sideways distance from the axis.
    pub(crate) h_m: f64,
    range_from_axis: bool,
}

impl BeamLine {
    pub(crate) const fn new(beam: &Beam, range_from_axis: bool) -> Self {
        let slope = beam.slope as f64;
        let cos = 1.0 / sqrt(1.0 + slope * slope);
        let (lift_m, h_m) = (beam.z_offset_m as f64 * cos, beam.h_offset_m as f64);
        Self { sin: slope * cos, cos, lift_m, h_m, range_from_axis }
    }

    /// A point of the beam: the formulas of [`Beam`].
    pub(crate) fn position(&self, theta_rad: f64, range_m: f64) -> [f64; 3] {
        let (sin, cos) = libm::sincos(theta_rad);
        let ahead_m = self.ahead_m(range_m * self.cos - self.lift_m * self.sin);
        let Self { h_m, .. } = *self;
        [ahead_m * cos + h_m * sin, ahead_m * sin - h_m * cos, range_m * self.sin + self.lift_m * self.cos]
    }

    /// The distance from where the beam passes the axis, of the one that its range gives.
    #[inline]
    pub(crate) fn ahead_m(&self, a_m: f64) -> f64 {
        if self.range_from_axis { root((a_m * a_m - self.h_m * self.h_m).max(0.0)) } else { a_m }
    }

    /// The inverse: the distance that a range gives, of a point that is `rho_m` from the axis.
    #[cfg(feature = "std")]
    pub(crate) fn reach_m(&self, rho_m: f64) -> f64 {
        let aside_m = if self.range_from_axis { 0.0 } else { self.h_m };
        root((rho_m * rho_m - aside_m * aside_m).max(0.0))
    }
}

/// Square root: the same bits either way, and with `std` an instruction in the decoder's loop.
#[inline(always)]
fn root(v: f64) -> f64 {
    #[cfg(feature = "std")]
    return v.sqrt();
    #[cfg(not(feature = "std"))]
    libm::sqrt(v)
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
