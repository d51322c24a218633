//! The simulated sensor stands in for a real one: the same beams, the same statistics.

use flicr::geometry::sensors::hdl64e;

use crate::common::data;
use crate::common::statistics::{Statistics, median};

pub fn the_beams_are_those_of_the_table() {
    let text = std::fs::read_to_string(data::path("kitti/hdl64e_kitti_beams.csv")).unwrap();
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(rows.len(), 64);
    for (row, beam) in rows.iter().zip(&hdl64e::BEAMS) {
        let listed: Vec<f64> = row.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
        let phase_deg = beam.azimuth_phase_rad.to_degrees();
        let found = [beam.slope, beam.z_offset_m, beam.h_offset_m, phase_deg, beam.range_phase_m].map(f64::from);
        // The table was fitted as if ranges did not begin at the axis, which is a tenth of a millimeter at 3 m.
        let limits = [2e-5, 2e-4, 1e-4, 0.001, 1e-4];
        let off = [0, 1, 2, 3, 4].map(|at| (found[at] - listed[at]).abs());
        assert!(off.iter().zip(limits).all(|(off, limit)| *off < limit), "{row}: {off:?}");
    }
}

pub fn statistics_are_those_of_real_scans() {
    let without_own_car = |points: &[[f32; 4]]| -> Vec<[f32; 4]> {
        points.iter().copied().filter(|[x, y, ..]| x.abs() + y.abs() > 0.3).collect()
    };
    // Every third: neighbors in a drive are much alike.
    let scans = data::KITTI.iter().step_by(3);
    let real = median(scans.map(|scan| Statistics::of(&without_own_car(&scan.points))));
    let found = Statistics::simulated();
    println!("real:      {real}\nsimulated: {found}");
    let within = |found: f64, real: f64, share: f64| (found / real - 1.0).abs() < share;
    assert!(within(found.points, real.points, 0.05));
    assert!(within(found.empty, real.empty, 0.35));
    assert!(within(found.lost, real.lost, 0.15));
    assert!(within(found.step_m, real.step_m, 0.25));
    assert!(within(found.top_step_m, real.top_step_m, 0.35));
    assert!(within(found.zlib_len, real.zlib_len, 0.25));
    assert!(within(found.intensity_bits, real.intensity_bits, 0.15));
}
