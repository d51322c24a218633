//! Captures through frames and back: encoded from packets, decoded, and compared with the independent decodes.

use std::collections::HashMap;

use super::captures::{apart_deg, payloads, pcd_xyz, xyzir};
use flicr::geometry::SensorGrid;
use flicr::geometry::sensors::{SensorGeometry, hesai, velodyne};
use flicr::packet::{ReturnPolicy, Sensor, TurnAssembler};
use flicr::{Decoder, EncodedTurn, GridConfig, ImageViewMut, Limits, PacketEncoder, Rle};

/// The points of every turn's frames, all layers together. Each frame carries its beams.
fn decoded(grid: SensorGrid<'_>, columns: u16, sensor: Sensor, packets: &[Vec<u8>]) -> Vec<Vec<[f32; 3]>> {
    let config = GridConfig { table: true, ..GridConfig::new(grid, columns) };
    let columns = usize::from(columns);
    let mut levels = [(); 2].map(|()| vec![0_u16; grid.beams.len() * columns]);
    let images = levels.each_mut().map(|levels| ImageViewMut::new(levels, columns).expect("whole rows"));
    let (mut coder, turns) = (Rle::new(), TurnAssembler::new(sensor, ReturnPolicy::Both));
    let mut encoder = PacketEncoder::new(&config, turns, images, &mut coder).expect("a valid configuration");
    let mut out = vec![0; 2 * config.worst_case_len::<u16, Rle>()];
    let mut decoder = Decoder::new(Limits::default());
    let (mut decoded, mut tallies) = (Vec::new(), Vec::new());
    let mut take = |turn: EncodedTurn<2>, out: &[u8]| {
        let (mut points, mut at) = (Vec::new(), 0);
        for frame in turn.frames {
            points.extend(decoder.decode(&out[at..at + frame.len]).expect("a frame").points());
            at += frame.len;
            tallies.push(frame.tally);
        }
        decoded.push(points);
    };
    for packet in packets {
        if let Some(turn) = encoder.push(packet, &mut out).expect("good packets") {
            take(turn, &out);
        }
    }
    if let Some(turn) = encoder.finish(&mut out).expect("fits") {
        take(turn, &out);
    }
    let (kept, lost) = tallies.iter().fold((0, 0), |(kept, lost), tally| (kept + tally.kept(), lost + tally.lost()));
    println!("{}: {} turns, {kept} returns kept, {lost} lost", grid.name, decoded.len());
    assert_eq!(lost, 0, "every return has a pixel of its own");
    decoded
}

/// Azimuth, elevation (degrees) and range of a point.
fn sphere([x, y, z]: [f64; 3]) -> [f64; 3] {
    let range = (x * x + y * y + z * z).sqrt();
    [y.atan2(x).to_degrees().rem_euclid(360.0), (z / range).asin().to_degrees(), range]
}

/// Points by whole degree of azimuth, so that few are near each other.
struct Near(HashMap<i32, Vec<[f64; 3]>>);

impl Near {
    fn of(points: &[[f32; 3]]) -> Self {
        let mut near = HashMap::<i32, Vec<[f64; 3]>>::new();
        for point in points {
            let found = sphere(point.map(f64::from));
            near.entry(found[0] as i32).or_default().push(found);
        }
        Self(near)
    }

    /// Whether a point of these is within the tolerances.
    fn has(&self, point: [f64; 3], azimuth_deg: f64, elevation_deg: f64, range_m: f64) -> bool {
        let around = [-1, 0, 1].map(|step| (point[0] as i32 + step).rem_euclid(360));
        around.iter().filter_map(|degree| self.0.get(degree)).flatten().any(|found| {
            apart_deg(found[0], point[0]) <= azimuth_deg
                && (found[1] - point[1]).abs() <= elevation_deg
                && (found[2] - point[2]).abs() <= range_m
        })
    }
}

/// Every reference point is among the decoded ones but `most`: range within one count, azimuth and elevation as near.
fn check(
    turns: &[Vec<[f32; 3]>],
    reference: &[[f64; 3]],
    sensor: &SensorGeometry,
    [azimuth_deg, elevation_deg]: [f64; 2],
    most: usize,
) {
    let points: Vec<[f32; 3]> = turns.concat();
    let near = Near::of(&points);
    let range_m = 1.05 * f64::from(sensor.spin.range_unit_m);
    let spheres = reference.iter().map(|&point| sphere(point));
    let absent: Vec<_> = spheres.filter(|&point| !near.has(point, azimuth_deg, elevation_deg, range_m)).collect();
    println!("{}: {} reference points, {} absent", sensor.name, reference.len(), absent.len());
    assert!(absent.len() <= most, "{}", absent.len());
    // Those of the packet that holds the blind sector, on both of its sides: columns of 0.2 degrees, twelve at most, from
    // beams up to 4.2 degrees aside, misplaced by the other decoder.
    let beside = |a: &[f64; 3], b: &[f64; 3]| apart_deg(a[0], b[0]) <= 18.0;
    let across = absent.iter().find(|point| !beside(point, &absent[0]));
    let explained = |point| beside(point, &absent[0]) || across.is_some_and(|across| beside(point, across));
    assert!(absent.iter().all(explained));
}

fn velodyne(sensor: &SensorGeometry, rows: usize, capture: &str, scan: &str, most: usize) {
    let packets = payloads(&format!("velodyne/{capture}.pcap"), 2368);
    let mut beams = vec![flicr::geometry::Beam::default(); rows];
    let beams = sensor.fill_beams_at(600, &mut beams).expect("as many beams");
    // Every tick: nothing is lost, and azimuths are as exact as the packets'.
    let turns = decoded(sensor.grid_of(beams), 36_000, Sensor::Auto, &packets);
    let reference: Vec<_> = xyzir(&format!("velodyne/{capture}.{scan}.xyzir.bin"))
        .iter()
        .map(|&[x, y, z, ..]| [x, y, z].map(f64::from))
        .collect();
    check(&turns, &reference, sensor, [0.02; 2], most);
}

pub fn vlp16_comes_back_from_frames() {
    velodyne(&velodyne::VLP16, 16, "vlp16_dual", "scan03", 0);
}

pub fn vlp32c_comes_back_from_frames() {
    // The other decoder misplaces the packet beside the blind sector: see `velodyne`.
    velodyne(&velodyne::VLP32C, 32, "vlp32c_single", "scan02", 12 * 32);
}

pub fn pandar40p_comes_back_from_frames() {
    let packets = payloads("hesai/pandar40p_dual.pcap", 2368);
    let sensor = &hesai::PANDAR40P;
    let turns = decoded(sensor.grid(), 36_000, Sensor::Auto, &packets);
    let reference: Vec<_> =
        pcd_xyz("hesai/pandar40p_dual.reference.pcd").iter().map(|point| point.map(f64::from)).collect();
    // The reference has the unit's own elevations, up to 0.2 degrees off the design's.
    check(&turns, &reference, sensor, [0.025, 0.25], 0);
}

#[cfg(feature = "cli")]
pub fn ouster_comes_back_from_frames() {
    use crate::common::data;
    use flicr::geometry::sensors::ouster::OusterSensor;

    for (pcap, json) in [
        ("OS-0-32-U1_v2.2.0_1024x10", "OS-0-32-U1_v2.2.0_1024x10"),
        ("OS-1-128_v2.3.0_1024x10_lb_n3", "OS-1-128_v2.3.0_1024x10"),
    ] {
        let json = std::fs::read_to_string(data::path(&format!("ouster/{json}.json"))).expect("reads");
        let sensor = OusterSensor::from_json(&json).expect("metadata");
        let packets = payloads(&format!("ouster/{pcap}.pcap"), 7502);
        // The sensor's columns are the image's, so that points come back in the order of the reference.
        let turns = decoded(sensor.grid(), sensor.format.columns_per_frame, Sensor::Ouster(sensor.format), &packets);
        let reference = xyzir(&format!("ouster/{pcap}.scan000.xyzir.bin"));
        let first = &turns[0][..reference.len()];
        let off = |(ours, theirs): (&[f32; 3], &[f32; 5])| {
            let off = |axis: usize| (f64::from(ours[axis]) - f64::from(theirs[axis])).powi(2);
            (off(0) + off(1) + off(2)).sqrt()
        };
        let worst = first.iter().zip(&reference).map(off).fold(0.0, f64::max);
        println!("{}: {} points, worst {:.3} mm", sensor.name, first.len(), worst * 1e3);
        assert!(worst <= f64::from(sensor.spin.range_unit_m) + 0.002);
    }
}
