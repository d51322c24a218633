//! Whose scan it is: the sensor on whose beams the points lie.

use std::format;
use std::string::String;
use std::vec::Vec;

use crate::geometry::SensorGrid;

/// Points that are looked at, spread over the scan.
const SAMPLE: usize = 20_000;
/// Of the way from a beam to midway to the next, on average; points that lie anywhere are at 0.5.
const OFF_BEAMS: f64 = 0.3;
/// Farther off, but not yet by chance: the order of the points may tell more.
const MAYBE_OFF_BEAMS: f64 = 0.45;
/// Nearer points do not tell: there the beams are close to each other.
const NEAR_M: f64 = 2.0;
/// Points beyond tell best, and all by themselves where there are enough: moving them changes little.
const FAR_M: f64 = 10.0;
const FAR_ENOUGH: usize = 1000;

/// How well a scan fits a sensor's beams.
#[derive(Debug, Clone, PartialEq)]
pub struct Recognition {
    /// Number of the sensor that fits best, where one fits.
    pub sensor: Option<usize>,
    /// Number of the one that comes nearest, where none fits but points are nearer to its beams than by chance: a scan
    /// that was moved after it was measured may be its, which [`choose_geometry`](crate::choose_geometry) can tell by
    /// the points' order.
    pub maybe: Option<usize>,
    /// For each sensor: how far points are from their beams, of the way to midway to the next beam, on average; those
    /// outside all beams count as 1. Points that lie anywhere are at 0.5.
    pub off: Vec<f64>,
    /// One sentence.
    pub why: String,
}

/// Finds the sensor that a scan is of, by its beams' elevations. Where none of `sensors` fits, none is found.
///
/// Of some 20,000 points each is compared with all beams of all sensors: a fraction of a second.
///
/// ```
/// use flicr::geometry::sensors::{hdl64e, velodyne};
/// use flicr::recognize_sensor;
/// use flicr::simulate::Simulator;
/// let scan: Vec<[f32; 3]> = Simulator::hdl64e(1).turn(0).points.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
/// let found = recognize_sensor(&scan, &[velodyne::VLS128.grid(), hdl64e::GRID]);
/// assert_eq!(found.sensor, Some(1));
/// ```
#[must_use]
pub fn recognize_sensor(points: &[[f32; 3]], sensors: &[SensorGrid<'_>]) -> Recognition {
    let sample = sample(points);
    let off: Vec<f64> = sensors.iter().map(|sensor| off(&sample, sensor)).collect();
    let best = (0..off.len()).min_by(|&a, &b| off[a].total_cmp(&off[b]));
    let sensor = best.filter(|&best| off[best] <= OFF_BEAMS);
    let why = match best {
        None => String::from("no sensor to compare with"),
        Some(_) if sample.is_empty() => format!("no points beyond {NEAR_M} m to tell the sensor by"),
        Some(best) => {
            let (name, percent) = (sensors[best].name, 100.0 * off[best]);
            let fits = if sensor.is_some() { "fits best" } else { "comes nearest, but does not fit" };
            format!("{name} {fits}: points are {percent:.1} % of the way between beams off (50 % by chance)")
        }
    };
    let sensor = sensor.filter(|_| !sample.is_empty());
    let maybe = best.filter(|&best| sensor.is_none() && !sample.is_empty() && off[best] <= MAYBE_OFF_BEAMS);
    Recognition { sensor, maybe, off, why }
}

fn sample(points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let beyond = |from_m: f64| {
        let is_beyond = move |&&[x, y, _]: &&[f32; 3]| f64::from(x).hypot(y.into()) >= from_m;
        points.iter().step_by(points.len() / SAMPLE + 1).filter(is_beyond).copied()
    };
    let far: Vec<[f32; 3]> = beyond(FAR_M).collect();
    if far.len() < FAR_ENOUGH { beyond(NEAR_M).collect() } else { far }
}

fn off(points: &[[f32; 3]], sensor: &SensorGrid<'_>) -> f64 {
    let sum: f64 = points.iter().map(|&point| off_one(point, sensor)).sum();
    sum / points.len().max(1) as f64
}

/// How far a point is from the nearest beam, of the way to midway to the next; 1 beyond the outer beams' rows.
fn off_one(point: [f32; 3], sensor: &SensorGrid<'_>) -> f64 {
    let [x, y, z] = point.map(f64::from);
    let rho = x.hypot(y);
    let above = |row: usize| z - f64::from(sensor.beams[row].slope) * rho - f64::from(sensor.beams[row].z_offset_m);
    let rows = sensor.beams.len();
    let Some(nearest) = (0..rows).min_by(|&a, &b| above(a).abs().total_cmp(&above(b).abs())) else { return 1.0 };
    let off = above(nearest);
    let beside = if off > 0.0 { nearest.checked_sub(1) } else { Some(nearest + 1).filter(|&row| row < rows) };
    // The outer rows are as wide outside as inside.
    let inside = if off > 0.0 { (nearest + 1).min(rows - 1) } else { nearest.saturating_sub(1) };
    let spacing = (above(nearest) - above(beside.unwrap_or(inside))).abs();
    (2.0 * off.abs() / spacing.max(1e-9)).min(1.0)
}
