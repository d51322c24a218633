//! Promise: the table-driven angles are as exact as the docs say, and points land in the column that double-precision
//! arithmetic puts them into.
#![allow(missing_docs)]

mod common;

use flicr::geometry::angles::{self, AngleTables};
use flicr::geometry::{Pixels, Projection};
use flicr::{BLOCK_LEN, Block, Quantizer, UniformGrid, UniformView};
use proptest::prelude::*;

/// Largest error of `ours` against `libm` in double precision, degrees.
fn largest_error_deg(samples: u32, ours: impl Fn(f32) -> f32, exact: impl Fn(f64) -> f64) -> f64 {
    let at = (0..=samples).map(|i| i as f32 / samples as f32);
    at.map(|t| (f64::from(ours(t)) - exact(t.into())).abs().to_degrees()).fold(0.0, f64::max)
}

fn atan2_error_deg<const N: usize>(tables: &AngleTables<N>) -> f64 {
    let angle = |t: f32| (t - 0.5) * 6.283_185;
    let (x, y) = (|t: f32| angle(t).cos() * 37.0, |t: f32| angle(t).sin() * 37.0);
    let ours = |t: f32| tables.atan2(y(t), x(t));
    largest_error_deg(1_000_000, ours, |t| libm::atan2(y(t as f32).into(), x(t as f32).into()))
}

fn acos_error_deg<const N: usize>(tables: &AngleTables<N>, from: f32, to: f32) -> f64 {
    let c = |t: f32| from + (to - from) * t;
    largest_error_deg(1_000_000, |t| tables.acos(c(t)), |t| libm::acos(c(t as f32).into()))
}

#[test]
fn fine_tables_are_within_a_ten_thousandth_of_a_degree() {
    assert!(atan2_error_deg(&angles::FINE) < 0.0001);
    // acos steepens without bound at the poles, where a float cosine itself is no longer exact.
    assert!(acos_error_deg(&angles::FINE, -0.999, 0.999) < 0.0001);
    let view = [(-24.8_f32).to_radians().sin(), 2.0_f32.to_radians().sin()];
    assert!(acos_error_deg(&angles::FINE, view[0], view[1]) < 0.0001);
    assert!(size_of_val(&angles::FINE) <= 2_200);
}

#[test]
fn coarse_tables_are_as_documented() {
    let error = atan2_error_deg(&angles::COARSE);
    assert!((0.0009..0.0012).contains(&error), "{error}");
    let error = acos_error_deg(&angles::COARSE, -0.99, 0.99);
    assert!((0.0003..0.0012).contains(&error), "{error}");
    assert_eq!(size_of_val(&angles::COARSE), 520);
}

#[test]
fn angles_on_the_axes_are_exact() {
    let atan2 = |y, x| angles::FINE.atan2(y, x);
    use core::f32::consts::{FRAC_PI_2, PI};
    assert_eq!(atan2(0.0, 0.0), 0.0);
    assert_eq!(atan2(0.0, 5.0), 0.0);
    assert_eq!(atan2(5.0, 0.0), FRAC_PI_2);
    assert_eq!(atan2(-5.0, 0.0), -FRAC_PI_2);
    assert_eq!(atan2(0.0, -5.0), PI);
    assert_eq!(atan2(-0.0, -5.0), -PI);
    assert_eq!(angles::FINE.acos(1.0), 0.0);
    assert!((angles::FINE.acos(-1.0) - PI).abs() < 1e-6);
}

/// Row (from one) and column by libm in double precision.
fn exact_cell(view: &UniformView, rows: f64, columns: f64, [x, y, z]: [f32; 3]) -> (i64, f64) {
    let [x, y, z] = [x, y, z].map(f64::from);
    let range = (x * x + y * y + z * z).sqrt();
    let elevation = libm::asin(z / range);
    let row = (f64::from(view.top_rad) - elevation) / (f64::from(view.top_rad) - f64::from(view.bottom_rad)) * rows;
    let turn = core::f64::consts::TAU;
    let from_start = (libm::atan2(y, x) - f64::from(view.start_rad)).rem_euclid(turn);
    (row.floor() as i64, from_start / f64::from(view.span_rad) * columns)
}

fn pixel_of(grid: &impl Projection, [x, y, z]: [f32; 3]) -> u32 {
    let mut block = Block::new();
    block.fill([[x, y, z]; BLOCK_LEN].into_iter());
    let mut pixels = Pixels::new();
    grid.project(&block, &Quantizer::new(8, 80.0).unwrap(), &mut pixels);
    assert!(pixels.pixel.iter().all(|&pixel| pixel == pixels.pixel[0]), "every lane computes the same");
    pixels.pixel[0]
}

/// Points in another column than the reference's, and how far the farthest is off, columns.
fn misplaced(grid: &UniformGrid, points: &[[f32; 3]]) -> (usize, u32) {
    let columns = u32::from(grid.columns());
    let (mut count, mut farthest) = (0, 0);
    for &point in points.iter().filter(|p| **p != [0.0; 3]) {
        let pixel = pixel_of(grid, point);
        let (_, exact) = exact_cell(grid.view(), grid.rows().into(), columns.into(), point);
        let column = (pixel & !Pixels::CLAMPED) % columns;
        let apart = column.abs_diff(exact as u32 % columns);
        let apart = apart.min(columns - apart);
        count += usize::from(apart > 0);
        farthest = farthest.max(apart);
    }
    (count, farthest)
}

#[test]
fn at_most_two_points_in_a_thousand_of_a_scan_land_in_another_column() {
    let grid = UniformGrid::new(64, 4500, UniformView::HDL64E).unwrap();
    let mut scans = common::full_scans("columns against double precision");
    scans.push(("spiral".into(), common::spiral(50_000).iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect()));
    for (name, scan) in scans {
        let (count, farthest) = misplaced(&grid, &common::xyz(&scan));
        assert!(count * 1000 <= 2 * scan.len(), "{name}: {count} of {}", scan.len());
        assert!(farthest <= 1, "{name}: {farthest} columns away");
    }
}

#[test]
fn sizes_and_views_that_cannot_be_are_refused() {
    use flicr::ConfigError::{AzimuthView, ElevationView, Size};
    let view = UniformView::HDL64E;
    for (rows, columns) in [(0, 10), (10, 0), (65_536, 1), (1, 65_536), (65_535, 65_535)] {
        assert_eq!(UniformGrid::new(rows, columns, view).unwrap_err(), Size { rows, columns });
    }
    let flipped = UniformView::all_around(-10.0, 10.0);
    assert!(matches!(UniformGrid::new(1, 1, flipped), Err(ElevationView { .. })));
    let over_the_pole = UniformView { top_rad: 2.0, ..view };
    assert!(matches!(UniformGrid::new(1, 1, over_the_pole), Err(ElevationView { .. })));
    for (start_rad, span_rad) in [(-4.0, 1.0), (0.0, 0.0), (0.0, 6.3), (f32::NAN, 1.0), (0.0, f32::NAN)] {
        let wrong = UniformView { start_rad, span_rad, ..view };
        assert!(matches!(UniformGrid::new(1, 1, wrong), Err(AzimuthView { .. })));
    }
}

proptest! {
    #[test]
    fn any_view_agrees_with_double_precision(
        top in -80.0_f32..90.0,
        height in 1.0_f32..100.0,
        start in -3.1_f32..3.1,
        span in 0.2_f32..6.28,
        rows in 1_usize..200,
        columns in 1_usize..5000,
        azimuth in -3.14_f64..3.14,
        elevation in -1.55_f64..1.55,
        range in 0.5_f64..200.0,
    ) {
        let view = UniformView {
            top_rad: top.to_radians(),
            bottom_rad: (top - height).max(-90.0).to_radians(),
            start_rad: start,
            span_rad: span,
        };
        let grid = UniformGrid::new(rows, columns, view).unwrap();
        let ground = range * elevation.cos();
        let point = [ground * azimuth.cos(), ground * azimuth.sin(), range * elevation.sin()].map(|v| v as f32);
        let (exact_row, exact_column) = exact_cell(&view, rows as f64, columns as f64, point);
        let pixel = pixel_of(&grid, point);
        if pixel & Pixels::OUT_OF_VIEW != 0 {
            prop_assert!(exact_column > columns as f64 * 0.9999);
            return Ok(());
        }
        let clamped = pixel & Pixels::CLAMPED != 0;
        let (row, column) = ((pixel & !Pixels::CLAMPED) / columns as u32, (pixel & !Pixels::CLAMPED) % columns as u32);
        prop_assert!((f64::from(column) - exact_column.floor()).abs() <= 1.0, "{column} {exact_column}");
        prop_assert!((i64::from(row) - exact_row.clamp(0, rows as i64 - 1)).abs() <= 1, "{row} {exact_row}");
        let well_inside = (1..rows as i64 - 1).contains(&exact_row);
        let well_outside = exact_row < -1 || exact_row > rows as i64;
        prop_assert!(!(well_inside && clamped) && !(well_outside && !clamped));
    }
}
