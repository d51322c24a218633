//! Raw scans on the sensor's own grid.

use flicr::geometry::{Lattice, sensors};
use flicr::{Geometry, GeometryChoice, LatticeConfig, choose_geometry};

#[path = "../common/lattice.rs"]
pub mod support;

use crate::common::{data, xyz};
use support::{distances, encoded, exact_cell, hdl64e, projected};

pub fn every_point_of_the_raw_scans_is_on_its_beam_tick_and_count() {
    let (lattice, grid) = (hdl64e(), sensors::hdl64e::GRID);
    for data::Scan { name, points: scan } in data::all_kitti() {
        let points: Vec<_> = xyz(scan).into_iter().filter(|p| *p != [0.0; 3]).collect();
        let mut taken = std::collections::HashSet::new();
        for (point, (row, column, level)) in points.iter().zip(projected(&lattice, points.as_slice())) {
            let (beam, tick, count) = exact_cell(&grid, point.map(f64::from));
            assert_eq!((row as usize, column), (beam, tick), "{name}: {point:?}");
            assert_eq!(f64::from(level), count.round(), "{name}: {point:?} {count}");
            assert!(taken.insert((row, column)), "{name}: {point:?} collides");
        }
    }
}

pub fn raw_scans_come_back_to_the_millimeter() {
    let lattice = hdl64e();
    let config = LatticeConfig { measure: true, ..LatticeConfig::new(&lattice) };
    for data::Scan { name, points: scan } in data::all_kitti() {
        let points: Vec<_> = xyz(scan).into_iter().filter(|p| *p != [0.0; 3]).collect();
        let (encoded, bytes) = encoded::<u16, 66>(&config, scan.as_slice());
        assert_eq!((encoded.tally.lost(), encoded.tally.kept() as usize), (0, points.len()), "{name}");
        let found = distances(&lattice, &points, &bytes);
        assert_eq!(found.len(), points.len());
        let farthest = found.iter().map(|f| f.2).fold(0.0, f64::max);
        let rms = (found.iter().map(|f| f.2 * f.2).sum::<f64>() / found.len() as f64).sqrt();
        let mm = |p: [f32; 3]| p.map(|v| (f64::from(v) * 1000.0).round() as i64);
        let equal = found.iter().filter(|f| mm(f.0) == mm(f.1)).count() as f64 / found.len() as f64;
        let bound = f64::from(encoded.fit.point_bound_m());
        println!("{name}: {farthest:.5} m at most, bound {bound:.5}, rms {rms:.6}, {:.2} % equal", 100.0 * equal);
        assert!(farthest <= 0.0018 && rms <= 0.0006 && equal >= 0.994, "{name}: {farthest} {rms} {equal}");
        assert!(farthest <= bound && bound <= 1.2 * farthest + 2e-4, "{name}: {farthest} {bound}");
        let Geometry::Beams(beams) = flicr::frame::parse_header(&bytes).unwrap().geometry else { panic!("beams") };
        assert_eq!(beams.point_bound_m, encoded.fit.point_bound_m());
    }
}

/// `paper frames on the beam table`.
pub fn few_points_are_lost_on_other_columns() {
    for data::Scan { name, points: scan } in data::all_kitti() {
        for (columns, most) in [(4500, 0.0015), (2048, 0.08)] {
            let lattice = Lattice::<66>::new(sensors::hdl64e::GRID, columns).unwrap();
            let (encoded, _) = encoded::<u16, 66>(&LatticeConfig::new(&lattice), scan.as_slice());
            let lost = f64::from(encoded.tally.lost()) / f64::from(encoded.tally.returns());
            assert!(lost <= most, "{name} at {columns}: {lost}");
        }
    }
}

pub fn raw_scans_are_told_to_be_on_the_grid() {
    for data::Scan { name, points } in data::KITTI.iter().step_by(4) {
        let advice = choose_geometry(&xyz(points), &sensors::hdl64e::GRID, 4500, flicr::UniformView::HDL64E).unwrap();
        assert_eq!(advice.choice, GeometryChoice::OwnGrid, "{name}: {}", advice.why);
    }
}
