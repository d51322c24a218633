//! Pandar40P and PandarXT-32 against the Nebula driver's clouds.

use super::captures::{apart_deg, payloads, pcd_xyz};
use super::stream::{Placed, Stream};
use flicr::geometry::sensors::{SensorGeometry, hesai};
use flicr::packet::{ReturnPolicy, Sensor};
use std::collections::HashMap;

/// A reference point in the sensor's own terms. `elevation_deg` is the unit's own: Nebula used its angle
/// file, not the design.
#[derive(Clone, Copy)]
struct Point {
    elevation_deg: f64,
    azimuth_deg: f64,
    count: f64,
}

fn points(path: &str, sensor: &SensorGeometry) -> Vec<Point> {
    let unit = f64::from(sensor.spin.range_unit_m);
    let point = |&[x, y, z]: &[f32; 3]| {
        let [x, y, z] = [x, y, z].map(f64::from);
        let range = (x * x + y * y + z * z).sqrt();
        Point {
            elevation_deg: (z / range).asin().to_degrees(),
            // Azimuth 0 is the y axis, and grows clockwise.
            azimuth_deg: x.atan2(y).to_degrees().rem_euclid(360.0),
            count: range / unit,
        }
    };
    pcd_xyz(path).iter().map(point).collect()
}

/// The row whose design elevation is nearest: a unit's own is at most half a beam off.
fn beam_of(elevation_deg: f64, sensor: &SensorGeometry) -> u8 {
    let design = |row: &usize| f64::from(sensor.beams[*row].slope).atan().to_degrees();
    let off = |row: &usize| (design(row) - elevation_deg).abs();
    let nearest = (0..sensor.beams.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.expect("rows") as u8
}

/// Our returns of one turn by beam and tick.
type Grid = HashMap<(u8, u16), Vec<u32>>;

fn grid(stream: &Stream, turn: u32) -> Grid {
    let mut grid = Grid::new();
    for ours in stream.returns.iter().filter(|ours| ours.turn == turn) {
        grid.entry((ours.beam, ours.tick)).or_default().push(ours.count);
    }
    grid
}

/// Azimuth of `beam` in a column, by the design's offset and the unit's own correction to it.
fn azimuth_deg(tick: u16, beam: u8, sensor: &SensorGeometry, own_deg: &[f64]) -> f64 {
    let phase = f64::from(sensor.beams[usize::from(beam)].azimuth_phase_rad).to_degrees();
    f64::from(tick) / 100.0 - phase + own_deg[usize::from(beam)]
}

fn is_ours(point: &Point, beam: u8, grid: &Grid, sensor: &SensorGeometry, own_deg: &[f64]) -> bool {
    let zero = azimuth_deg(0, beam, sensor, own_deg);
    let tick = ((point.azimuth_deg - zero) * 100.0).round() as i32;
    (tick - 2..=tick + 2).any(|tick| {
        let tick = tick.rem_euclid(36_000) as u16;
        let near = apart_deg(azimuth_deg(tick, beam, sensor, own_deg), point.azimuth_deg) <= 0.02;
        let counts = grid.get(&(beam, tick));
        near && counts.is_some_and(|counts| counts.iter().any(|&count| (f64::from(count) - point.count).abs() <= 1.0))
    })
}

/// The unit's own azimuth corrections of the design's, one a beam: the one under which most of its
/// points are ours, of none and all that put the beam's median
/// point on a column.
fn own_offsets(points: &[(Point, u8)], stream: &Stream, grid: &Grid, sensor: &SensorGeometry) -> Vec<f64> {
    let step_deg = column_step_deg(stream);
    let rows = sensor.beams.len();
    (0..rows)
        .map(|row| {
            let of_row: Vec<&(Point, u8)> = points.iter().filter(|(_, beam)| usize::from(*beam) == row).collect();
            let aside = off_columns(&of_row, stream, sensor, step_deg);
            let misses = |own: &f64| {
                let own_deg = vec![*own; rows];
                let absent = of_row.iter().filter(|(point, beam)| !is_ours(point, *beam, grid, sensor, &own_deg));
                absent.count()
            };
            let candidates = [0.0, aside - step_deg, aside, aside + step_deg];
            candidates.into_iter().min_by_key(misses).expect("four")
        })
        .collect()
}

fn column_step_deg(stream: &Stream) -> f64 {
    f64::from(stream.returns[0].step_q8) / 25_600.0
}

/// How far a beam's points lie beside our columns by the design, in the median.
fn off_columns(of_row: &[&(Point, u8)], stream: &Stream, sensor: &SensorGeometry, step_deg: f64) -> f64 {
    let zero = vec![0.0; sensor.beams.len()];
    let first = f64::from(stream.returns[0].tick) / 100.0;
    let mut off: Vec<f64> = of_row
        .iter()
        .map(|(point, beam)| {
            let aside = point.azimuth_deg - azimuth_deg(0, *beam, sensor, &zero) - first;
            aside - (aside / step_deg).round() * step_deg
        })
        .collect();
    off.sort_by(f64::total_cmp);
    off.get(off.len() / 2).copied().unwrap_or(0.0)
}

fn check(name: &str, sensor: &SensorGeometry, most_own_deg: f64) {
    let packets = payloads(&format!("hesai/{name}.pcap"), 2368);
    let points = points(&format!("hesai/{name}.reference.pcd"), sensor);
    let points: Vec<(Point, u8)> = points.iter().map(|point| (*point, beam_of(point.elevation_deg, sensor))).collect();
    let stream = Stream::of(&packets, Sensor::Auto, ReturnPolicy::Both);
    assert_eq!(stream.stats.refused(), 0, "{:?}", stream.errors);
    assert_eq!(stream.stats.lost_columns, 0);
    let missing = |turn: u32| {
        let grid = grid(&stream, turn);
        let own_deg = own_offsets(&points, &stream, &grid, sensor);
        let absent = points.iter().filter(|(point, beam)| !is_ours(point, *beam, &grid, sensor, &own_deg));
        let absent: Vec<&Point> = absent.map(|(point, _)| point).collect();
        (absent, own_deg)
    };
    let turns = (0..stream.turns.len() as u32).map(missing);
    let (best, own_deg) = turns.min_by_key(|(absent, _)| absent.len()).expect("a turn");
    let most = own_deg.iter().fold(0.0, |most: f64, own| most.max(own.abs()));
    assert!(most <= most_own_deg, "{own_deg:?}");
    // Nebula cuts by each beam's own azimuth, we by the column's: up to the largest offset differs.
    let widest =
        sensor.beams.iter().fold(0.0, |most: f64, beam| most.max(f64::from(beam.azimuth_phase_rad).to_degrees().abs()));
    let away = best.iter().filter(|point| apart_deg(point.azimuth_deg, 0.0) > 1.0 + widest);
    println!(
        "{name}: {} points, {} not ours, of these {} away from the cut; own offsets up to {most:.3} deg",
        points.len(),
        best.len(),
        away.clone().count(),
    );
    assert_eq!(away.count(), 0);
    both_turns(&points, &stream, sensor, &own_deg);
}

/// Around the cut the points are in the turns beside: none is lost altogether.
fn both_turns(points: &[(Point, u8)], stream: &Stream, sensor: &SensorGeometry, own_deg: &[f64]) {
    let whole = stream.returns.iter().map(|ours| Placed { turn: 0, ..*ours });
    let stream = Stream { returns: whole.collect(), ..Stream::default() };
    let grid = grid(&stream, 0);
    let absent = points.iter().filter(|(point, beam)| !is_ours(point, *beam, &grid, sensor, own_deg));
    assert_eq!(absent.count(), 0);
}

pub fn pandar40p_has_every_reference_point() {
    check("pandar40p_dual", &hesai::PANDAR40P, 0.005);
}

pub fn pandar_xt32_has_every_reference_point() {
    check("xt32_dual", &hesai::PANDAR_XT32, 0.14);
}
