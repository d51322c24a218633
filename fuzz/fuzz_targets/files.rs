//! Any bytes as a file: a point cloud (KITTI, with rings, PCD) or a sensor, or an error that says where; what was read is
//! written and read again as it was.
#![no_main]

use flicr::files::{PointCloud, kitti, pcd};
use flicr::geometry::Lattice;
use flicr::sensor::Sensor;
use libfuzzer_sys::fuzz_target;

fn bits(cloud: &PointCloud) -> (Vec<[u32; 3]>, &Option<Vec<u16>>) {
    (cloud.points.iter().map(|point| point.map(f32::to_bits)).collect(), &cloud.rings)
}

fn check_cloud(bytes: &[u8]) {
    let Ok(cloud) = pcd::parse(bytes) else { return };
    assert!(cloud.points.len() <= 256 * bytes.len());
    let mut written = Vec::new();
    pcd::write(&mut written, &cloud).expect("a vector has room");
    assert_eq!(bits(&cloud), bits(&pcd::parse(&written).expect("what was written")));
}

fn check_sensor(text: &str) {
    let Ok(sensor) = Sensor::from_toml(text) else { return };
    assert_eq!(sensor, Sensor::from_toml(&sensor.to_toml()).expect("what was written"));
    let grid = sensor.grid();
    assert_eq!(grid.check().is_ok(), Lattice::<1026>::new(grid, 100).is_ok() || grid.beams.len() > 1024);
}

fuzz_target!(|data: &[u8]| {
    let Some((&kind, bytes)) = data.split_first() else { return };
    match kind % 3 {
        0 => {
            let _ = (kitti::parse(bytes), kitti::parse_with_rings(bytes), kitti::parse_either(bytes));
        }
        1 => check_cloud(bytes),
        _ => {
            if let Ok(text) = std::str::from_utf8(bytes) {
                check_sensor(text);
            }
        }
    }
});
