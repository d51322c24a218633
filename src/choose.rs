//! Which geometry loses least of a scan, and why.

use std::format;
use std::string::String;
use std::vec;
use std::vec::Vec;

use crate::beam_order::rows_in_order;
use crate::config::{Config, LatticeConfig, Scale, Settings};
use crate::encoder::{FrameEncoder, Stamp};
use crate::error::EncodeError;
use crate::fit::GridFit;
use crate::geometry::{Lattice, SensorGrid};
use crate::image::ImageViewMut;
use crate::tally::Tally;
use crate::{Store, UniformView};

/// Lines for the largest sensor that a choice is made for.
const LINES: usize = 258;
/// Share of the points that the sensor's own grid may lose, and still be the best.
const LOST_ON_GRID: f64 = 0.001;
/// Most that a scan on its own grid is off across the beams, meters rms: files in millimeters are off by 0.3 mm.
const ACROSS_ON_GRID_M: f64 = 0.002;

/// A geometry that a scan can be put into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum GeometryChoice {
    /// The sensor's beams at every tick of its encoder.
    OwnGrid,
    /// The sensor's beams by evenly spread columns.
    EvenColumns,
    /// As `EvenColumns`, but a point's beam is taken from its place in the file, which holds beam after beam.
    BeamsInOrder,
    /// Rows and columns evenly spread.
    Uniform,
}

/// What became of the points in one of the geometries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// The geometry.
    pub choice: GeometryChoice,
    /// Columns of the image.
    pub columns: usize,
    /// What became of every point.
    pub tally: Tally,
    /// How far the points are off; empty for `Uniform`.
    pub fit: GridFit,
}

/// The best geometry for a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// The geometry to use.
    pub choice: GeometryChoice,
    /// All that were tried; `choice` is among them.
    pub trials: Vec<Trial>,
    /// The beam of each point: for [`FrameEncoder::insert_on_rows`] where the choice is `BeamsInOrder`, else empty.
    pub rows: Vec<u16>,
    /// One sentence.
    pub why: String,
}

impl Trial {
    /// Share of the returns that the image loses.
    #[must_use]
    pub fn lost(&self) -> f64 {
        f64::from(self.tally.lost()) / f64::from(self.tally.returns().max(1))
    }
}

/// Tries all geometries on a scan: the grid of `sensor` at every tick; its beams, and its beams as the points' order
/// has them, by `columns` columns; the uniform one of `view`.
///
/// Takes about ten projections' time, and 2 bytes for each pixel of the largest image.
///
/// ```
/// use flicr::geometry::sensors::hdl64e;
/// use flicr::simulate::Simulator;
/// use flicr::{GeometryChoice, UniformView, choose_geometry};
/// let scan: Vec<[f32; 3]> = Simulator::hdl64e(1).turn(0).points.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
/// let advice = choose_geometry(&scan, &hdl64e::GRID, 4500, UniformView::HDL64E)?;
/// assert_eq!(advice.choice, GeometryChoice::OwnGrid);
/// # Ok::<(), flicr::EncodeError>(())
/// ```
///
/// # Errors
/// [`EncodeError::Config`] where the sensor has more than 256 beams or more than 65,535 ticks, or `columns` or `view`
/// cannot be.
pub fn choose_geometry(
    points: &[[f32; 3]],
    sensor: &SensorGrid<'_>,
    columns: usize,
    view: UniformView,
) -> Result<Advice, EncodeError> {
    let own = Lattice::<LINES>::new(*sensor, sensor.ticks as usize)?;
    let even = Lattice::<LINES>::new(*sensor, columns)?;
    let rows = rows_in_order(points, sensor);
    let mut trials = vec![
        try_lattice(GeometryChoice::OwnGrid, points, &own, None)?,
        try_lattice(GeometryChoice::EvenColumns, points, &even, None)?,
    ];
    if let Some(rows) = &rows {
        trials.push(try_lattice(GeometryChoice::BeamsInOrder, points, &even, Some(rows))?);
    }
    trials.push(try_uniform(points, sensor.beams.len(), columns, view)?);
    let on_grid =
        |trial: &Trial| trial.lost() <= LOST_ON_GRID && trial.fit.across.rms_m(trial.fit.points) <= ACROSS_ON_GRID_M;
    let own = trials[0];
    let best = if on_grid(&own) { own } else { least_lost(&trials[1..]) };
    let why = why(&best, &own, sensor.name);
    let rows = rows.filter(|_| best.choice == GeometryChoice::BeamsInOrder).unwrap_or_default();
    Ok(Advice { choice: best.choice, trials, rows, why })
}

/// The first of those that lose least.
fn least_lost(trials: &[Trial]) -> Trial {
    let mut best = trials[0];
    for trial in trials {
        best = if trial.lost() < best.lost() { *trial } else { best };
    }
    best
}

fn why(best: &Trial, own: &Trial, name: &str) -> String {
    let across_mm = 1000.0 * own.fit.across.rms_m(own.fit.points);
    let grid = format!(
        "points are {across_mm:.1} mm rms off {name}'s beams, {:.2} % are lost on its grid",
        100.0 * own.lost()
    );
    match best.choice {
        GeometryChoice::OwnGrid => format!("the scan is on the sensor's own grid: {grid}"),
        // The bound is the frame's to say, whose steps may be longer than those tried here.
        choice => {
            format!("the scan is off the sensor's grid: {grid}; {choice:?} loses {:.2} %", 100.0 * best.lost())
        }
    }
}

fn try_lattice(
    choice: GeometryChoice,
    points: &[[f32; 3]],
    lattice: &Lattice<'_, LINES>,
    rows: Option<&[u16]>,
) -> Result<Trial, EncodeError> {
    let config = LatticeConfig { measure: true, ..LatticeConfig::new(lattice) };
    let columns = usize::from(lattice.columns_in_turn());
    let (tally, fit) = attempt(&config, lattice.grid().beams.len(), columns, |frame| match rows {
        Some(rows) => frame.insert_on_rows(points, rows),
        None => frame.insert(points),
    })?;
    Ok(Trial { choice, columns, tally, fit })
}

fn try_uniform(points: &[[f32; 3]], rows: usize, columns: usize, view: UniformView) -> Result<Trial, EncodeError> {
    let config = Config { view, level_bits: 16, scale: Scale::Step { step_m: 0.002 }, ..Config::UNIFORM };
    let (tally, fit) = attempt(&config, rows, columns, |frame| frame.insert(points))?;
    Ok(Trial { choice: GeometryChoice::Uniform, columns, tally, fit })
}

fn attempt<S: Settings>(
    config: &S,
    rows: usize,
    columns: usize,
    insert: impl FnOnce(&mut FrameEncoder<'_, u16, Store, S>),
) -> Result<(Tally, GridFit), EncodeError> {
    let mut levels = vec![0_u16; rows * columns];
    let size = crate::ConfigError::Size { rows, columns };
    let image = ImageViewMut::new(&mut levels, columns).ok_or(size)?;
    let mut coder = Store::new();
    let mut frame = FrameEncoder::start(config, Stamp::default(), image, &mut coder)?;
    insert(&mut frame);
    Ok((*frame.tally(), frame.fit()))
}
