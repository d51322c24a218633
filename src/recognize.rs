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
/// Of a row's height from its middle to its edge, on average: points of a unit whose beams are not quite as designed are
/// in other places of their rows, but all of a row in one.
const SPREAD_IN_ROWS: f64 = 0.1;
/// Share of the rows that must have points, lest the beams of a smaller sensor are taken for some of a larger one's.
const ROWS_SEEN: f64 = 0.85;
/// Share of the points that may be in no row.
const OUTSIDE: f64 = 0.01;

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
/// One fits as well whose beams all lie within their rows, though not in the middle: units differ from the design by more
/// than a tenth of a degree.
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
    if sensor.is_none()
        && let Some(found) = by_rows(points, sensors)
    {
        let name = sensors[found].name;
        let why = format!("{name} fits, but for its beams' elevations: points of a row are all in one place of it");
        return Recognition { sensor: Some(found), maybe: None, off, why };
    }
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

/// The sensor in whose rows points are least spread, if that is little.
fn by_rows(points: &[[f32; 3]], sensors: &[SensorGrid<'_>]) -> Option<usize> {
    let sample = beyond(points, NEAR_M);
    let spreads = sensors.iter().enumerate().filter_map(|(number, sensor)| Some((spread(&sample, sensor)?, number)));
    let (spread, found) = spreads.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    (spread <= SPREAD_IN_ROWS).then_some(found)
}

/// How far points are from the middle one of their row, on average; `None` where rows are without points, or points
/// without a row.
fn spread(points: &[[f32; 3]], sensor: &SensorGrid<'_>) -> Option<f64> {
    let mut rows = std::vec![Vec::new(); sensor.beams.len()];
    for (row, off) in points.iter().filter_map(|&point| place(point, sensor)).filter(|(_, off)| off.abs() < 1.0) {
        rows[row].push(off);
    }
    let inside: usize = rows.iter().map(Vec::len).sum();
    let seen = rows.iter().filter(|row| !row.is_empty()).count();
    let enough = inside as f64 >= (1.0 - OUTSIDE) * points.len() as f64 && seen as f64 >= ROWS_SEEN * rows.len() as f64;
    let sum: f64 = rows.iter_mut().map(|row| off_middle(row)).sum();
    (enough && inside > 0).then(|| sum / inside as f64)
}

/// Sum of the distances from the median.
fn off_middle(row: &mut [f64]) -> f64 {
    row.sort_unstable_by(f64::total_cmp);
    let Some(&middle) = row.get(row.len() / 2) else { return 0.0 };
    row.iter().map(|off| (off - middle).abs()).sum()
}

fn sample(points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let far = beyond(points, FAR_M);
    if far.len() < FAR_ENOUGH { beyond(points, NEAR_M) } else { far }
}

/// Some of the points that are at least so far from the axis.
fn beyond(points: &[[f32; 3]], from_m: f64) -> Vec<[f32; 3]> {
    let is_beyond = |&&[x, y, _]: &&[f32; 3]| f64::from(x).hypot(y.into()) >= from_m;
    points.iter().step_by(points.len() / SAMPLE + 1).filter(is_beyond).copied().collect()
}

fn off(points: &[[f32; 3]], sensor: &SensorGrid<'_>) -> f64 {
    let sum: f64 = points.iter().map(|&point| off_one(point, sensor)).sum();
    sum / points.len().max(1) as f64
}

/// How far a point is from the nearest beam, of the way to midway to the next; 1 beyond the outer beams' rows.
fn off_one(point: [f32; 3], sensor: &SensorGrid<'_>) -> f64 {
    place(point, sensor).map_or(1.0, |(_, off)| off.abs().min(1.0))
}

/// The row of the nearest beam, and how far above it a point is, of the way to midway to the next.
fn place(point: [f32; 3], sensor: &SensorGrid<'_>) -> Option<(usize, f64)> {
    let [x, y, z] = point.map(f64::from);
    let rho = x.hypot(y);
    let above = |row: usize| z - f64::from(sensor.beams[row].slope) * rho - f64::from(sensor.beams[row].z_offset_m);
    let rows = sensor.beams.len();
    let nearest = (0..rows).min_by(|&a, &b| above(a).abs().total_cmp(&above(b).abs()))?;
    let off = above(nearest);
    let beside = if off > 0.0 { nearest.checked_sub(1) } else { Some(nearest + 1).filter(|&row| row < rows) };
    // The outer rows are as wide outside as inside.
    let inside = if off > 0.0 { (nearest + 1).min(rows - 1) } else { nearest.saturating_sub(1) };
    let spacing = (above(nearest) - above(beside.unwrap_or(inside))).abs();
    Some((nearest, 2.0 * off / spacing.max(1e-9)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::sensors::{hdl64e, hesai, robosense, velodyne};

    /// A room of points on a sensor's beams, each this much lower than designed.
    fn room(sensor: &SensorGrid<'_>, lower_rad: f64) -> Vec<[f32; 3]> {
        let point = |azimuth: f64, rho: f64, slope: f32| {
            let z = rho * (f64::from(slope).atan() - lower_rad).tan();
            [(rho * azimuth.cos()) as f32, (rho * azimuth.sin()) as f32, z as f32]
        };
        let fired = (0..300).map(|firing| (f64::from(firing) * 0.02, 3.0 + f64::from(firing % 50) * 0.1));
        fired.flat_map(|(azimuth, rho)| sensor.beams.iter().map(move |beam| point(azimuth, rho, beam.slope))).collect()
    }

    #[test]
    fn a_unit_is_known_whose_beams_are_all_a_little_low() {
        let sensors = [hdl64e::GRID, velodyne::VLP16.grid(), robosense::HELIOS16P.grid(), hesai::PANDAR40P.grid()];
        let found = recognize_sensor(&room(&sensors[3], 0.0024), &sensors);
        assert_eq!(found.sensor, Some(3), "{}", found.why);
    }

    #[test]
    fn a_smaller_sensor_is_not_taken_for_a_larger_one() {
        let found = recognize_sensor(&room(&velodyne::VLP16.grid(), 0.0024), &[velodyne::VLS128.grid(), hdl64e::GRID]);
        assert_eq!(found.sensor, None, "{}", found.why);
    }
}
