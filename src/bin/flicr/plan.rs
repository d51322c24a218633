//! Which geometry a scan gets, and why.

use std::rc::Rc;

use flicr::geometry::sensors::hdl64e;
use flicr::geometry::{Firings, find_firings};
use flicr::{EncodeError, GeometryChoice, Limits, UniformView, choose_geometry, recognize_sensor};
use indicatif::ProgressBar;

use crate::args::Columns;
use crate::console;
use crate::input::Scan;
use crate::sensors::{Asked, OwnedGrid, built_in};

/// Columns of frames that do not have a sensor's own; the paper's largest.
pub const COLUMNS: u16 = 4500;
/// For sensors of up to 65,535 ticks.
pub const WORDS: usize = 2048;

/// The geometry of one frame.
#[derive(Debug)]
pub enum Shape {
    Uniform {
        columns: u16,
    },
    /// A sensor's beams by evenly spread columns.
    Beams {
        sensor: Rc<OwnedGrid>,
        columns: u16,
        /// The beam of each point, where the points' order says more than their places.
        rows: Vec<u16>,
    },
    /// A sensor's beams by its firings.
    Firings {
        sensor: Rc<OwnedGrid>,
        firings: Box<Firings<WORDS>>,
    },
}

/// A geometry and why it is that.
#[derive(Debug)]
pub struct Plan {
    pub shape: Shape,
    /// Nothing where nothing was chosen.
    pub why: String,
}

impl Shape {
    pub fn columns(&self) -> usize {
        match self {
            Self::Uniform { columns } | Self::Beams { columns, .. } => (*columns).into(),
            Self::Firings { firings, .. } => firings.len().into(),
        }
    }

    pub fn sensor(&self) -> Option<&Rc<OwnedGrid>> {
        match self {
            Self::Uniform { .. } => None,
            Self::Beams { sensor, .. } | Self::Firings { sensor, .. } => Some(sensor),
        }
    }

    /// What JSON and notes call it.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Uniform { .. } => "uniform",
            Self::Beams { rows, .. } if !rows.is_empty() => "beams-in-order",
            Self::Beams { sensor, columns, .. } if u32::from(*columns) == sensor.grid().ticks => "every-tick",
            Self::Beams { .. } => "even-columns",
            Self::Firings { .. } => "firings",
        }
    }
}

/// The best geometry for a scan, of those that were asked for.
pub fn plan(scan: &Scan, asked: Option<&Asked>, columns: Option<Columns>) -> Result<Plan, EncodeError> {
    if let Some(turn) = &scan.turn {
        return of_turn(turn.sensor.clone(), &turn.ticks, columns);
    }
    let points = scan.cloud.points.as_slice();
    if let Some(asked) = asked {
        return on_sensor(points, asked.grid(), columns, false);
    }
    let sensors = built_in();
    let grids: Vec<_> = sensors.iter().map(|sensor| sensor.grid()).collect();
    let found = recognize_sensor(points, &grids);
    match found.sensor {
        Some(number) => {
            let plan = on_sensor(points, sensors[number].clone(), columns, true)?;
            Ok(Plan { why: format!("{}; {}", found.why, plan.why), ..plan })
        }
        None => Ok(Plan { shape: Shape::Uniform { columns: count(columns) }, why: found.why }),
    }
}

/// Columns where they are no firings.
fn count(columns: Option<Columns>) -> u16 {
    match columns {
        Some(Columns::Count(count)) => count,
        Some(Columns::Native) | None => COLUMNS,
    }
}

fn of_turn(sensor: Rc<OwnedGrid>, ticks: &[u32], columns: Option<Columns>) -> Result<Plan, EncodeError> {
    let why = format!("the packets are {}'s", sensor.grid().name);
    let shape = match columns {
        Some(Columns::Count(columns)) => Shape::Beams { sensor, columns, rows: Vec::new() },
        _ => by_firings(sensor, ticks)?,
    };
    Ok(Plan { shape, why })
}

fn by_firings(sensor: Rc<OwnedGrid>, ticks: &[u32]) -> Result<Shape, EncodeError> {
    let firings = Box::new(Firings::new(sensor.grid().ticks, ticks.iter().copied())?);
    Ok(Shape::Firings { sensor, firings })
}

/// The best geometry with a sensor's beams; or uniform, where that may be and loses least.
fn on_sensor(
    points: &[[f32; 3]],
    sensor: Rc<OwnedGrid>,
    columns: Option<Columns>,
    may_be_uniform: bool,
) -> Result<Plan, EncodeError> {
    let even = count(columns);
    let mut advice = choose_geometry(points, &sensor.grid(), even.into(), UniformView::HDL64E)?;
    let rows = std::mem::take(&mut advice.rows);
    let shape = match advice.choice {
        GeometryChoice::OwnGrid if !matches!(columns, Some(Columns::Count(_))) => native(points, sensor)?,
        GeometryChoice::Uniform if may_be_uniform => Shape::Uniform { columns: even },
        _ => Shape::Beams { sensor, columns: even, rows },
    };
    Ok(Plan { shape, why: advice.why })
}

/// A sensor's firings where its beams share them, else all ticks, as long as these are not too many.
fn native(points: &[[f32; 3]], sensor: Rc<OwnedGrid>) -> Result<Shape, EncodeError> {
    let grid = sensor.grid();
    let grid = if grid == hdl64e::GRID { hdl64e::FIRING_GRID } else { grid };
    if let Some(found) = find_firings(points, &grid)? {
        let turned = OwnedGrid::new(&grid).with_beams(found.beams);
        return by_firings(Rc::new(turned), &found.ticks);
    }
    let is_small = grid.beams.len() * grid.ticks as usize <= Limits::default().pixels;
    let columns = u16::try_from(grid.ticks).ok().filter(|_| is_small).unwrap_or(COLUMNS);
    Ok(Shape::Beams { sensor, columns, rows: Vec::new() })
}

/// What was noted last: the same is not said of every scan of a drive.
#[derive(Debug, Default)]
pub struct Noted {
    last: Option<(String, &'static str)>,
}

impl Noted {
    /// Says which geometry was chosen and why, where it is another than before.
    pub fn note(&mut self, bar: &ProgressBar, scan: &str, plan: &Plan) {
        if plan.why.is_empty() {
            return;
        }
        let sensor = plan.shape.sensor().map_or_else(String::new, |sensor| sensor.grid().name.to_owned());
        let chosen = Some((sensor, plan.shape.word()));
        if self.last != chosen {
            let (sensor, word) = chosen.as_ref().map_or(("", ""), |(sensor, word)| (sensor, word));
            let gap = if sensor.is_empty() { "" } else { ", " };
            console::note(bar, format_args!("{scan}: {sensor}{gap}{word}: {}", plan.why));
            self.last = chosen;
        }
    }
}
