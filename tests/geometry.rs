//! Promise: the table-driven angles are as exact as the docs say, and points land in the column that double-precision
//! arithmetic puts them into.
#![allow(missing_docs)]

mod common;
#[path = "common/reference.rs"]
mod reference;

use flicr::geometry::Pixels;
use flicr::geometry::angles::{self, AngleTables};
use flicr::{UniformGrid, UniformView};
use proptest::prelude::*;
use reference::{exact_cell, pixel_of};

/// Largest error of `ours` against `libm` in double precision, degrees.
fn largest_error_deg(samples: u32, ours: impl Fn(f32) -> f32, exact: impl Fn(f64) -> f64) -> f64 {
    let at = (0..=samples).map(|i| i as f32 / samples as f32);
    at.map(|t| (f64::from(ours(t)) - exact(t.into())).abs().to_degrees()).fold(0.0, f64::max)
}

fn atan2_error_deg<const N: usize>(tables: &AngleTables<N>) -> f64 {
    let angle = |t: f32| (t - 0.5) * core::f32::consts::TAU;
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
    use core::f32::consts::{FRAC_PI_2, PI};
    let atan2 = |y, x| angles::FINE.atan2(y, x);
    assert_eq!(atan2(0.0, 0.0), 0.0);
    assert_eq!(atan2(0.0, 5.0), 0.0);
    assert_eq!(atan2(5.0, 0.0), FRAC_PI_2);
    assert_eq!(atan2(-5.0, 0.0), -FRAC_PI_2);
    assert_eq!(atan2(0.0, -5.0), PI);
    assert_eq!(atan2(-0.0, -5.0), -PI);
    assert_eq!(angles::FINE.acos(1.0), 0.0);
    assert!((angles::FINE.acos(-1.0) - PI).abs() < 1e-6);
}

#[test]
fn points_land_in_the_column_of_double_precision() {
    reference::assert_columns_agree("spiral", &common::spiral(50_000));
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
        span in 0.2_f32..6.25,
        rows in 1_usize..200,
        columns in 1_usize..5000,
        azimuth in -3.1_f64..3.1,
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
        let rows = i64::try_from(rows).unwrap();
        prop_assert!((i64::from(row) - exact_row.clamp(0, rows - 1)).abs() <= 1, "{row} {exact_row}");
        let well_inside = (1..rows - 1).contains(&exact_row);
        let well_outside = exact_row < -1 || exact_row > rows;
        prop_assert!(!well_inside || !clamped);
        prop_assert!(!well_outside || clamped);
    }
}
