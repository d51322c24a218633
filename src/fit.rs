//! How well points fit a sensor's grid, and the bound that follows.

use crate::geometry::Lattice;
use crate::kernel::{Miss, miss_lattice, sqrt};
use crate::point::Points;
use crate::quantize::Quantizer;

/// How far points are from where they are decoded: across the beam (the beams' table), around the axis (the columns)
/// and along the beam (the levels). A raw scan on its own grid is off by its files' rounding; motion-compensated,
/// merged or foreign scans by centimeters.
///
/// RAM: 64 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GridFit {
    /// Points measured: those that have a level.
    pub points: u32,
    /// Across the beam, in the vertical plane that it fires in.
    pub across: Residual,
    /// Around the axis.
    pub around: Residual,
    /// Along the beam.
    pub along: Residual,
    farthest_m: f32,
}

/// Nothing is measured, and nothing kept: the fit of a geometry that is not a sensor's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NoFit;

impl From<NoFit> for GridFit {
    fn from(_: NoFit) -> Self {
        Self::new()
    }
}

/// Residuals of many points, meters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Residual {
    square_sum: f64,
    /// Largest, meters.
    pub max_m: f32,
}

impl Residual {
    /// Root mean square over `points` points, meters; 0 for none.
    #[must_use]
    pub fn rms_m(&self, points: u32) -> f64 {
        libm::sqrt(self.square_sum / f64::from(points.max(1)))
    }

    fn add(&mut self, residual_m: f32) {
        self.square_sum += f64::from(residual_m * residual_m);
        self.max_m = self.max_m.max(residual_m.abs());
    }
}

impl GridFit {
    /// Nothing measured.
    #[must_use]
    pub const fn new() -> Self {
        const NONE: Residual = Residual { square_sum: 0.0, max_m: 0.0 };
        Self { points: 0, across: NONE, around: NONE, along: NONE, farthest_m: 0.0 }
    }

    /// Most that any measured point is from where it is decoded, meters; 0 where there is none, infinite where returns
    /// went to other columns than their ticks'.
    #[must_use]
    pub const fn point_bound_m(&self) -> f32 {
        self.farthest_m
    }

    /// Takes account of returns in their sensor's integers: on their own ticks they are off by no more than a range's
    /// rounding, and by what floats do to a position; elsewhere nobody knows.
    pub(crate) fn add_returns(&mut self, quantizer: &Quantizer, is_exact: bool) {
        let bound_m = quantizer.range_bound_m() + 1e-5 + 5e-7 * quantizer.max_range_m();
        self.farthest_m = self.farthest_m.max(if is_exact { bound_m } else { f32::INFINITY });
    }

    /// Measures points that are put into `lattice` and quantized by `quantizer`.
    pub fn add<const LINES: usize, const NODES: usize>(
        &mut self,
        points: &(impl Points + ?Sized),
        lattice: &Lattice<'_, LINES, NODES>,
        quantizer: &Quantizer,
    ) {
        points.for_each_block(|block, len| {
            for i in 0..len {
                self.add_one(lattice, quantizer, [block.x[i], block.y[i], block.z[i]], None);
            }
        });
    }

    /// Measures one point, on a row that is known or on the nearest.
    pub(crate) fn add_one<const LINES: usize, const NODES: usize>(
        &mut self,
        lattice: &Lattice<'_, LINES, NODES>,
        quantizer: &Quantizer,
        point: [f32; 3],
        row: Option<u16>,
    ) {
        if let Some(miss) = miss_lattice(lattice, quantizer, point, row) {
            self.add_miss(lattice, &miss, 0.0);
        }
    }

    /// Measures one point that goes to a column some ticks away from its own.
    pub(crate) fn add_beside<const LINES: usize, const NODES: usize>(
        &mut self,
        lattice: &Lattice<'_, LINES, NODES>,
        quantizer: &Quantizer,
        point: [f32; 3],
        ticks_off: u32,
    ) {
        if let Some(miss) = miss_lattice(lattice, quantizer, point, None) {
            let turns_off = ticks_off as f32 / f32::from(lattice.columns_in_turn());
            self.add_miss(lattice, &miss, turns_off * core::f32::consts::TAU);
        }
    }

    /// Measures one point that goes some columns on in the sensor's direction, or back where they are negative.
    pub(crate) fn add_displaced<const LINES: usize, const NODES: usize>(
        &mut self,
        lattice: &Lattice<'_, LINES, NODES>,
        miss: &Miss,
        columns: i8,
    ) {
        let column_rad = core::f32::consts::TAU / f32::from(lattice.columns_in_turn());
        let more = (miss.columns_off - f32::from(columns)).abs() - miss.columns_off.abs();
        self.add_miss(lattice, miss, more * column_rad);
    }

    fn add_miss<const LINES: usize, const NODES: usize>(
        &mut self,
        lattice: &Lattice<'_, LINES, NODES>,
        miss: &Miss,
        radians_off: f32,
    ) {
        // The table's own error in azimuth, and a float's: what is measured with them is uncertain by as much.
        let intervals = (NODES - 1) as f32;
        let azimuth_error = 1.5e-6 * (256.0 / intervals) * (256.0 / intervals) + 5e-7;
        // The chord around the axis is not quite perpendicular to the beam's plane: half of half a column off.
        let skewed = 1.0 + 2.0 / f32::from(lattice.columns_in_turn()) + radians_off;
        let around_m = miss.around_m + radians_off * miss.rho_m;
        self.points += 1;
        self.across.add(miss.across_m);
        self.around.add(around_m);
        self.along.add(miss.along_m);
        let around_m = around_m + miss.rho_m * azimuth_error;
        let square = miss.across_m * miss.across_m + around_m * around_m + miss.along_m * miss.along_m;
        // Ten micrometers and a two-millionth of the range for the decoder's rounding and ours.
        let off_m = sqrt(square) * skewed + 1e-5 + 5e-7 * miss.rho_m;
        self.farthest_m = self.farthest_m.max(off_m);
    }
}
