use core::f64::consts::TAU;
use std::vec::Vec;

use super::{Beam, Sensor};
use crate::geometry::BeamLine;

/// Where on the sensor's grid a return lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    /// Row; 0 = the highest beam.
    pub beam: u16,
    /// Encoder tick, `0..ticks_per_turn`.
    pub tick: u32,
    /// Range in counts; may be slightly negative for a return on the spin axis.
    pub count: i32,
}

/// How far a point lies from the middle of its [`Cell`], metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Miss {
    /// Across the beam, in its vertical plane: the beam's elevation and offset.
    pub across_m: f64,
    /// Along the turn: the encoder's tick.
    pub around_m: f64,
    /// Along the beam: the range count.
    pub along_m: f64,
}

impl Miss {
    /// The distance itself, metres.
    #[must_use]
    pub fn norm_m(&self) -> f64 {
        let Self { across_m, around_m, along_m } = *self;
        (across_m * across_m + around_m * around_m + along_m * along_m).sqrt()
    }
}

/// A [`Sensor`] made ready for finding cells: sines and cosines worked out once.
///
/// ```
/// use flicr::sensor::{Beam, Cell, Grid, Sensor};
///
/// let sensor = Sensor {
///     name: "one beam".into(),
///     beams: vec![Beam { slope: 0.1, z_offset_m: 0.05, ..Beam::default() }],
///     ticks_per_turn: 4000,
///     range_unit_m: 0.002,
///     range_from_axis: false,
/// };
/// let grid = Grid::new(&sensor);
/// let cell = Cell { beam: 0, tick: 1234, count: 5678 };
/// let (found, miss) = grid.locate(grid.position(cell)).unwrap();
/// assert_eq!(found, cell);
/// assert!(miss.norm_m() < 1e-9);
/// ```
#[derive(Debug, Clone)]
pub struct Grid {
    rays: Vec<Ray>,
    tick_rad: f64,
    ticks: u32,
    unit_m: f64,
}

/// A beam with its sines and cosines.
#[derive(Debug, Clone, Copy)]
struct Ray {
    slope: f64,
    z_offset: f64,
    azimuth_phase: f64,
    range_phase: f64,
    line: BeamLine,
}

impl Ray {
    fn new(beam: &Beam, range_from_axis: bool) -> Self {
        Self {
            slope: f64::from(beam.slope),
            z_offset: f64::from(beam.z_offset_m),
            azimuth_phase: f64::from(beam.azimuth_phase_rad),
            range_phase: f64::from(beam.range_phase_m),
            line: BeamLine::new(beam, range_from_axis),
        }
    }

    fn across(&self, rho: f64, z: f64) -> f64 {
        (z - self.z_offset - self.slope * self.line.reach_m(rho)) * self.line.cos
    }
}

impl Grid {
    /// Works out the sensor's sines and cosines. A sensor without ticks counts as having one.
    #[must_use]
    pub fn new(sensor: &Sensor) -> Self {
        Self {
            rays: sensor.beams.iter().map(|beam| Ray::new(beam, sensor.range_from_axis)).collect(),
            tick_rad: TAU / f64::from(sensor.ticks_per_turn.max(1)),
            ticks: sensor.ticks_per_turn.max(1),
            unit_m: f64::from(sensor.range_unit_m),
        }
    }

    /// The cell nearest to a point and the distance to it.
    ///
    /// `None` for a point at the origin (which files use for 'no return'), for
    /// one that is not finite, and when the sensor has no beams.
    #[must_use]
    pub fn locate(&self, [x, y, z]: [f64; 3]) -> Option<(Cell, Miss)> {
        let rho = x.hypot(y);
        if !rho.is_finite() || !z.is_finite() || (rho == 0.0 && z == 0.0) {
            return None;
        }
        let beam = self.nearest_beam(rho, z)?;
        Some(self.cell_of_beam(beam, rho, y.atan2(x), z))
    }

    /// The cell on a beam that is already known, such as from a file's ring column.
    ///
    /// `None` as for [`Grid::locate`], and when there is no such beam.
    #[must_use]
    pub fn locate_on_beam(&self, beam: u16, [x, y, z]: [f64; 3]) -> Option<(Cell, Miss)> {
        let rho = x.hypot(y);
        let known = usize::from(beam) < self.rays.len();
        (known && rho > 0.0 && rho.is_finite() && z.is_finite())
            .then(|| self.cell_of_beam(usize::from(beam), rho, y.atan2(x), z))
    }

    fn nearest_beam(&self, rho: f64, z: f64) -> Option<usize> {
        let distance = |ray: &Ray| ray.across(rho, z).abs();
        let nearest = self.rays.iter().enumerate().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
        nearest.map(|(index, _)| index)
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates, which is wanted")]
    fn cell_of_beam(&self, beam: usize, rho: f64, azimuth: f64, z: f64) -> (Cell, Miss) {
        let ray = &self.rays[beam];
        let turn = azimuth + (ray.line.h_m / rho).clamp(-1.0, 1.0).asin() - ray.azimuth_phase;
        let tick = (turn / self.tick_rad).round();
        let range = ray.line.reach_m(rho) * ray.line.cos + z * ray.line.sin - ray.range_phase;
        let count = (range / self.unit_m).round();
        let miss = Miss {
            across_m: ray.across(rho, z),
            around_m: (turn - tick * self.tick_rad) * rho,
            along_m: range - count * self.unit_m,
        };
        let cell = Cell {
            beam: beam as u16,
            tick: (tick as i64).rem_euclid(i64::from(self.ticks)) as u32,
            count: count as i32,
        };
        (cell, miss)
    }

    /// The point in the middle of a cell: the inverse of [`Grid::locate`].
    ///
    /// A beam that the sensor does not have gives the origin.
    #[must_use]
    pub fn position(&self, cell: Cell) -> [f64; 3] {
        let Some(ray) = self.rays.get(usize::from(cell.beam)) else {
            return [0.0; 3];
        };
        let range_m = f64::from(cell.count) * self.unit_m + ray.range_phase;
        ray.line.position(f64::from(cell.tick) * self.tick_rad + ray.azimuth_phase, range_m)
    }
}
