//! How well a sensor's grid fits scans.

use std::vec;
use std::vec::Vec;

use super::Scan;
use crate::sensor::{Beam, Grid, Miss, Sensor};

/// Bins of a [`Spread`]'s histogram.
pub const HISTOGRAM_BINS: usize = 61;
/// Half the histogram's width, metres: bin 0 begins at minus this.
pub const HISTOGRAM_REACH_M: f64 = 0.0015;
/// Farther than this from its cell's middle, a point counts as off the grid, metres.
pub const OFF_GRID_M: f64 = 0.002;

/// How misses spread along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Root mean square, metres.
    pub rms_m: f64,
    /// Largest, metres.
    pub max_m: f64,
    /// Counts over -[`HISTOGRAM_REACH_M`] to +[`HISTOGRAM_REACH_M`]; the outer bins also hold what lies beyond.
    pub histogram: [u32; HISTOGRAM_BINS],
}

impl Default for Spread {
    fn default() -> Self {
        Self { rms_m: 0.0, max_m: 0.0, histogram: [0; HISTOGRAM_BINS] }
    }
}

impl Spread {
    /// Adds a miss; `rms_m` holds the sum of squares until [`Spread::close`].
    fn add(&mut self, miss_m: f64) {
        self.rms_m += miss_m * miss_m;
        self.max_m = self.max_m.max(miss_m.abs());
        let place = (miss_m / HISTOGRAM_REACH_M + 1.0) * (HISTOGRAM_BINS as f64 / 2.0);
        let bin = place.clamp(0.0, (HISTOGRAM_BINS - 1) as f64) as usize;
        self.histogram[bin] += 1;
    }

    fn close(&mut self, points: usize) {
        self.rms_m = (self.rms_m / points.max(1) as f64).sqrt();
    }
}

/// One beam's fit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BeamResiduals {
    /// Points on the beam.
    pub points: usize,
    /// Misses across the beam, in its vertical plane.
    pub across: Spread,
    /// Misses along the turn.
    pub around: Spread,
    /// Misses along the beam.
    pub along: Spread,
    /// About one standard deviation of each of the beam's numbers, as least squares over this many
    /// points has it; slope and height offset are truer in files that are rounded. 0 where only
    /// residuals were asked for.
    pub deviation: Beam,
}

impl BeamResiduals {
    fn add(&mut self, miss: &Miss) {
        self.points += 1;
        self.across.add(miss.across_m);
        self.around.add(miss.around_m);
        self.along.add(miss.along_m);
    }

    fn close(&mut self) {
        let Self { points, across, around, along, .. } = self;
        for spread in [across, around, along] {
            spread.close(*points);
        }
    }
}

/// How well a sensor's grid fits scans, beam by beam.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Residuals {
    /// Returns looked at: finite points that are not at the origin.
    pub points: usize,
    /// Those farther than [`OFF_GRID_M`] from the middle of their cell.
    pub off_grid: usize,
    /// Those that a scan loses because another of its points has the same beam and tick.
    pub lost: usize,
    /// Each beam's share, in the sensor's order.
    pub beams: Vec<BeamResiduals>,
}

impl Residuals {
    /// Puts every point of the scans on the sensor's grid and sums up how far it had to move.
    ///
    /// Beam numbers that the scans bring are not used: this is what an encoder
    /// that knows only the points will do.
    #[must_use]
    pub fn of(sensor: &Sensor, scans: &[Scan<'_>]) -> Self {
        let grid = Grid::new(sensor);
        let mut residuals = Self { beams: vec![BeamResiduals::default(); sensor.beams.len()], ..Self::default() };
        for scan in scans {
            residuals.add_scan(&grid, scan);
        }
        residuals.beams.iter_mut().for_each(BeamResiduals::close);
        residuals
    }

    fn add_scan(&mut self, grid: &Grid, scan: &Scan<'_>) {
        let mut places = Vec::with_capacity(scan.points.len());
        for point in scan.points {
            if let Some((cell, miss)) = grid.locate(point.map(f64::from)) {
                places.push((cell.beam, cell.tick));
                self.off_grid += usize::from(miss.norm_m() > OFF_GRID_M);
                self.beams[usize::from(cell.beam)].add(&miss);
            }
        }
        self.points += places.len();
        let all = places.len();
        places.sort_unstable();
        places.dedup();
        self.lost += all - places.len();
    }
}
