//! Which geometry a scan gets, and why.

use std::collections::BTreeSet;
use std::rc::Rc;

use flicr::files::PointCloud;
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
        return of_turn(turn.sensor.clone(), &turn.ticks, asked, columns);
    }
    if let Some(asked) = asked {
        return on_sensor(&scan.cloud, asked.grid(), columns, false);
    }
    let points = scan.cloud.points.as_slice();
    let sensors = built_in();
    let grids: Vec<_> = sensors.iter().map(|sensor| sensor.grid()).collect();
    let found = recognize_sensor(points, &grids);
    if let Some(number) = found.sensor.or(found.maybe) {
        let plan = on_sensor(&scan.cloud, sensors[number].clone(), columns, true)?;
        // Where the places alone do not tell the sensor, the points' order must.
        let in_order = matches!(&plan.shape, Shape::Beams { rows, .. } if !rows.is_empty());
        if found.sensor.is_some() || in_order {
            return Ok(Plan { why: format!("{}; {}", found.why, plan.why), ..plan });
        }
    }
    // Of an Ouster, or a unit that is not quite as designed, the points alone do not tell.
    let why = format!("{}; --sensor NAME or FILE takes its beams, `flicr calibrate` finds them", found.why);
    Ok(Plan { shape: Shape::Uniform { columns: count(columns) }, why })
}

/// Columns where they are no firings.
fn count(columns: Option<Columns>) -> u16 {
    match columns {
        Some(Columns::Count(count)) => count,
        Some(Columns::Native) | None => COLUMNS,
    }
}

fn of_turn(
    sensor: Rc<OwnedGrid>,
    ticks: &[u32],
    asked: Option<&Asked>,
    columns: Option<Columns>,
) -> Result<Plan, EncodeError> {
    let mut why = format!("the packets are {}'s", sensor.grid().name);
    // Packets say whose they are; an Ouster's are read by what was asked for, and a file's beams were taken for these.
    if let Some(Asked::Grid(grid)) = asked
        && grid.grid().name != sensor.grid().name
    {
        why = format!("{why}: --sensor ({}) is not used", grid.grid().name);
    }
    if matches!(asked, Some(Asked::File(_))) {
        why = format!("the packets have the ticks and the range unit of the file's {}", sensor.grid().name);
    }
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
    cloud: &PointCloud,
    sensor: Rc<OwnedGrid>,
    columns: Option<Columns>,
    may_be_uniform: bool,
) -> Result<Plan, EncodeError> {
    let (points, even) = (cloud.points.as_slice(), count(columns));
    let advice = choose_geometry(points, &sensor.grid(), even.into(), UniformView::HDL64E)?;
    let is_on_grid = advice.choice == GeometryChoice::OwnGrid;
    let by_ring = if is_on_grid { None } else { rows_by_ring(cloud, &sensor) };
    if let Some(rows) = by_ring {
        let why = format!("{}; the file's rings say which points share a beam", advice.why);
        return Ok(Plan { shape: Shape::Beams { sensor, columns: even, rows }, why });
    }
    let shape = match advice.choice {
        GeometryChoice::OwnGrid if !matches!(columns, Some(Columns::Count(_))) => native(points, sensor)?,
        GeometryChoice::Uniform if may_be_uniform => Shape::Uniform { columns: even },
        _ => Shape::Beams { sensor, columns: even, rows: advice.rows },
    };
    Ok(Plan { shape, why: advice.why })
}

/// Nearer, points are the sensor's own noise or the car's roof, and say nothing of a beam's elevation.
const NEAR_M: f32 = 2.0;

/// The beam of each point by its ring, where a file has as many as the sensor has beams: counted from above or from
/// below, whichever way they go up.
fn rows_by_ring(cloud: &PointCloud, sensor: &OwnedGrid) -> Option<Vec<u16>> {
    let (rings, beams) = (cloud.rings.as_deref()?, sensor.grid().beams.len());
    let mut elevations = vec![(0.0_f64, 0_u32); beams];
    for (&[x, y, z], &ring) in cloud.points.iter().zip(rings) {
        let of_ring = elevations.get_mut(usize::from(ring))?;
        let range_m = x.hypot(y).hypot(z);
        if range_m > NEAR_M {
            *of_ring = (of_ring.0 + f64::from(z / range_m), of_ring.1 + 1);
        }
    }
    let seen = elevations.iter().filter(|(_, count)| *count > 0);
    let means: Vec<f64> = seen.map(|(sum, count)| sum / f64::from(*count)).collect();
    let last = beams as u16 - 1;
    let (falls, rises) = (means.is_sorted_by(|a, b| a > b), means.is_sorted_by(|a, b| a < b));
    match (2 * means.len() > beams, falls, rises) {
        (true, true, false) => Some(rings.to_vec()),
        (true, false, true) => Some(rings.iter().map(|ring| last - ring).collect()),
        _ => None,
    }
}

/// A sensor's firings where its beams share them, else all ticks, as long as these are not too many.
fn native(points: &[[f32; 3]], sensor: Rc<OwnedGrid>) -> Result<Shape, EncodeError> {
    let grid = sensor.grid();
    let grid = if grid == hdl64e::GRID { hdl64e::FIRING_GRID } else { grid };
    if let Some(found) = find_firings(points, &grid)? {
        let turned = sensor.with_beams(found.beams);
        return by_firings(Rc::new(turned), &found.ticks);
    }
    let is_small = grid.beams.len() * grid.ticks as usize <= Limits::default().pixels;
    let columns = u16::try_from(grid.ticks).ok().filter(|_| is_small).unwrap_or(COLUMNS);
    Ok(Shape::Beams { sensor, columns, rows: Vec::new() })
}

/// What was noted: the same is not said of every scan of a drive.
#[derive(Debug, Default)]
pub struct Noted {
    seen: BTreeSet<(String, &'static str)>,
}

impl Noted {
    /// Says which geometry was chosen and why, the first time.
    pub fn note(&mut self, bar: &ProgressBar, scan: &str, plan: &Plan) {
        if plan.why.is_empty() {
            return;
        }
        let sensor = plan.shape.sensor().map_or_else(String::new, |sensor| sensor.grid().name.to_owned());
        let word = plan.shape.word();
        let gap = if sensor.is_empty() { "" } else { ", " };
        let text = format!("{scan}: {sensor}{gap}{word}: {}", plan.why);
        if self.seen.insert((sensor, word)) {
            console::note(bar, text);
        }
    }
}
