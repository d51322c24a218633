//! VLP-16 and VLP-32C against velodyne-decoder: same beam, same count, same azimuth.

use super::captures::{apart_deg, payloads, xyzir};
use super::stream::{Placed, Stream};
use flicr::geometry::sensors::{SensorGeometry, velodyne};
use flicr::packet::{GapCause, Model, ReturnPolicy, Sensor};

/// Returns that the other decoder gives in another order than the packet lie this close.
const WINDOW: usize = 400;

/// A reference point in the sensor's own terms.
struct Point {
    beam: u8,
    count: f64,
    azimuth_deg: f64,
}

fn points(path: &str, sensor: &SensorGeometry) -> Vec<Point> {
    let rows = sensor.beams.len() as u16;
    let unit = f64::from(sensor.spin.range_unit_m);
    xyzir(path)
        .iter()
        .map(|&[x, y, z, _, ring]| {
            let [x, y, z] = [x, y, z].map(f64::from);
            // Rings count from below, from 512 on for last returns.
            let row = rows - 1 - ring as u16 % 512;
            let beam = &sensor.beams[usize::from(row)];
            let v = f64::from(beam.slope).atan();
            let vo = f64::from(beam.z_offset_m) * v.cos();
            let range = x.hypot(y) * v.cos() + vo * v.sin() * v.cos() + (z - vo * v.cos()) * v.sin();
            Point {
                beam: row as u8,
                count: (range - f64::from(beam.range_phase_m)) / unit,
                azimuth_deg: (-y).atan2(x).to_degrees().rem_euclid(360.0),
            }
        })
        .collect()
}

/// Clockwise azimuth at which a beam fired.
fn azimuth_deg(ours: &Placed, sensor: &SensorGeometry) -> f64 {
    let row = usize::from(ours.beam);
    let theta = sensor.spin.theta_rad(ours.tick, ours.step_q8, sensor.fire_ns[row], &sensor.beams[row]);
    (-theta).to_degrees().rem_euclid(360.0)
}

fn is_same(point: &Point, ours: &Placed, sensor: &SensorGeometry) -> bool {
    point.beam == ours.beam
        && (point.count - f64::from(ours.count)).abs() <= 1.0
        && apart_deg(point.azimuth_deg, azimuth_deg(ours, sensor)) <= 0.02
}

/// Ticks beside the sensor's blind sector, if it has one.
fn blind_edges(ours: &[Placed]) -> Vec<u16> {
    let jumps = ours.windows(2).filter(|pair| {
        let ahead = (i32::from(pair[1].tick) - i32::from(pair[0].tick)).rem_euclid(36_000);
        (2_000..34_000).contains(&ahead)
    });
    jumps.flat_map(|pair| [pair[0].tick, pair[1].tick]).collect()
}

/// velodyne-decoder takes the rotation rate from a packet's first and last azimuth. Where the blind
/// sector lies between them that is off by the width of the sector, and so are its azimuths: of such
/// a packet (12 columns of 0.2 degree at most on either side) only beam and count can be compared.
fn is_misplaced(point: &Point, ours: &Placed, edges: &[u16]) -> bool {
    let beside = |&edge: &u16| apart_deg(f64::from(edge) / 100.0, f64::from(ours.tick) / 100.0) <= 2.4;
    point.beam == ours.beam && (point.count - f64::from(ours.count)).abs() <= 1.0 && edges.iter().any(beside)
}

/// What matching a reference scan with the stream found.
struct Matched {
    used: Vec<bool>,
    /// First and last return of the stream that belong to the scan.
    span: std::ops::RangeInclusive<usize>,
    unmatched: usize,
    misplaced: usize,
}

/// Matches each point with a return of its own, in the order of the stream.
fn match_from(start: usize, points: &[Point], ours: &[Placed], sensor: &SensorGeometry) -> Matched {
    let mut used = vec![false; ours.len()];
    let edges = blind_edges(ours);
    let (mut at, mut last, mut unmatched, mut misplaced) = (start, start, 0, 0);
    for point in points {
        let mut window = at.saturating_sub(WINDOW)..(at + WINDOW).min(ours.len());
        let same = |nth: &usize| !used[*nth] && is_same(point, &ours[*nth], sensor);
        let beside = |nth: &usize| !used[*nth] && is_misplaced(point, &ours[*nth], &edges);
        let found = window.clone().find(same).or_else(|| {
            let found = window.find(beside);
            misplaced += usize::from(found.is_some());
            found
        });
        if let Some(nth) = found {
            used[nth] = true;
            at = nth;
            last = last.max(nth);
        } else {
            unmatched += 1;
        }
    }
    Matched { used, span: start..=last, unmatched, misplaced }
}

/// The start that matches best: the scene may look alike from turn to turn.
fn best_match(points: &[Point], ours: &[Placed], sensor: &SensorGeometry) -> Matched {
    let starts = (0..ours.len()).filter(|&nth| is_same(&points[0], &ours[nth], sensor));
    let probe = &points[..points.len().min(200)];
    let start = starts
        .min_by_key(|&start| match_from(start, probe, ours, sensor).unmatched)
        .expect("the scan's first point is in the stream");
    match_from(start, points, ours, sensor)
}

fn check(capture: &str, scan: &str, sensor: &SensorGeometry) {
    let (packets, points) = (payloads(capture, 2368), points(scan, sensor));
    let stream = Stream::of(&packets, Sensor::Auto, ReturnPolicy::Both);
    assert_eq!(stream.stats.refused(), 0, "{:?}", stream.errors);
    let matched = best_match(&points, &stream.returns, sensor);
    assert_eq!(matched.unmatched, 0, "points of {scan} not among our returns");
    // At most the one packet of a turn that holds the blind sector.
    assert!(matched.misplaced <= 12 * 32);
    let extra: Vec<&Placed> = matched.span.filter(|&nth| !matched.used[nth]).map(|nth| &stream.returns[nth]).collect();
    let seconds = extra.iter().filter(|ours| ours.layer == 1).count();
    println!(
        "{scan}: {} points, all ours ({} by beam and count only); ours beyond: {} ({seconds} second returns)",
        points.len(),
        matched.misplaced,
        extra.len()
    );
    assert_eq!(extra.len(), seconds, "{:?}", extra.first());
}

pub fn vlp16_dual_equals_the_independent_decode() {
    for scan in ["00", "03"] {
        check("velodyne/vlp16_dual.pcap", &format!("velodyne/vlp16_dual.scan{scan}.xyzir.bin"), &velodyne::VLP16);
    }
}

pub fn vlp32c_equals_the_independent_decode() {
    for scan in ["01", "02"] {
        check(
            "velodyne/vlp32c_single.pcap",
            &format!("velodyne/vlp32c_single.scan{scan}.xyzir.bin"),
            &velodyne::VLP32C,
        );
    }
}

pub fn vlp16_turns_are_whole() {
    let packets = payloads("velodyne/vlp16_dual.pcap", 2368);
    let stream = Stream::of(&packets, Sensor::Spinning(Model::Vlp16), ReturnPolicy::Last);
    // Ten turns a second: 100 ms / 55.296 us.
    for turn in &stream.turns[1..stream.turns.len() - 1] {
        assert!((1807..=1811).contains(&turn.columns), "{turn:?}");
        assert_eq!(turn.missing, 0);
    }
    assert_eq!(stream.stats.lost_columns, 0);
    assert_eq!(stream.stats.columns, 1206 * 12);
}

pub fn vlp32c_blind_sector_is_told_from_loss() {
    let packets = payloads("velodyne/vlp32c_single.pcap", 2368);
    let stream = Stream::of(&packets, Sensor::Auto, ReturnPolicy::Strongest);
    assert_eq!(stream.stats.lost_columns, 0, "{:?}", stream.gaps);
    let blind = |turn| {
        let of_turn = stream.gaps.iter().filter(|gap| gap.0 == turn);
        of_turn.filter(|gap| gap.2 == GapCause::Blind).map(|gap| u32::from(gap.1)).sum::<u32>()
    };
    for (turn, nth) in stream.turns[1..stream.turns.len() - 1].iter().zip(1..) {
        assert!((1790..=1820).contains(&turn.columns), "{turn:?}");
        // Half of the turn is switched off.
        assert!((885..=905).contains(&blind(nth)), "{turn:?} {}", blind(nth));
    }
}
