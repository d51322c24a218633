//! Promise: the metrics are the paper's, to twelve digits of what other tools compute.
#![cfg(feature = "std")]
#![allow(clippy::unreadable_literal, reason = "as the reference script prints them")]

use std::time::Instant;

use flicr::metrics::{
    self, Cloud, EpsnrParameters, MetricError, PAPER_MAX_RANGE_M, Quality, compare, epsnr_db, sampling_error,
};
use proptest::collection::vec;
use proptest::prelude::*;

type Cloud3 = Vec<[f32; 3]>;

// --- against SciPy: values printed by tests/reference/metrics_scipy.py ---------------------------------------------

const SMALL: Quality = Quality {
    mse_m2: 0.011412575142458081,
    mse_reverse_m2: 3376.1269439006232,
    psnr_db: 57.4879632395873,
    psnr_reverse_db: 2.777612060542439,
    cd_m2: 3376.1383564757657,
    cd_mean_m: 17.201234089021334,
    max_error_m: 0.1284352207561695,
    max_error_reverse_m: 137.27334170842047,
};
const SOLID: Quality = Quality {
    mse_m2: 0.015986862804619098,
    mse_reverse_m2: 71.50337804078497,
    psnr_db: 56.02416726017279,
    psnr_reverse_db: 19.518534142832586,
    cd_m2: 71.51936490358959,
    cd_mean_m: 2.3866452749639118,
    max_error_m: 0.20480787203988765,
    max_error_reverse_m: 32.38169118737124,
};
const FLAT: Quality = Quality {
    mse_m2: 0.015986862804619098,
    mse_reverse_m2: 5.2111972680256,
    psnr_db: 56.02416726017279,
    psnr_reverse_db: 30.892424604422644,
    cd_m2: 5.227184130830219,
    cd_mean_m: 0.6873249961275062,
    max_error_m: 0.20480787203988765,
    max_error_reverse_m: 11.102953540440621,
};
const LINE: Quality = Quality {
    mse_m2: 0.012851802118867356,
    mse_reverse_m2: 0.01824063331214711,
    psnr_db: 56.97215943950468,
    psnr_reverse_db: 55.45140061088199,
    cd_m2: 0.031092435431014465,
    cd_mean_m: 0.11301128699538526,
    max_error_m: 0.20480787203988765,
    max_error_reverse_m: 0.5815386818039963,
};
const REPEATED: Quality = Quality {
    mse_m2: 0.015986862804619098,
    mse_reverse_m2: 0.0009400393491378054,
    psnr_db: 56.02416726017279,
    psnr_reverse_db: 68.33033940856801,
    cd_m2: 0.016926902153756904,
    cd_mean_m: 0.0755178401460375,
    max_error_m: 0.20480787203988765,
    max_error_reverse_m: 0.041423916871429364,
};
const LARGE: Quality = Quality {
    mse_m2: 0.015667421455749807,
    mse_reverse_m2: 13.915400301476637,
    psnr_db: 56.11182447820747,
    psnr_reverse_db: 26.626842698735203,
    cd_m2: 13.931067722932386,
    cd_mean_m: 1.1108700142852515,
    max_error_m: 0.213687740339286,
    max_error_reverse_m: 14.950321876659324,
};

/// The generator of the reference script: 24 good bits a step.
struct Words(u32);

impl Words {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0
    }

    /// A signed number of `bits` bits, in units of 2^-16 m.
    fn ticks(&mut self, bits: u32) -> i32 {
        (self.next() >> (32 - bits)).cast_signed() - (1 << (bits - 1))
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Solid,
    Flat,
    Line,
    Repeated,
}

fn original_ticks(points: usize, shape: Shape) -> Vec<[i32; 3]> {
    let mut words = Words(1);
    let solid: Vec<[i32; 3]> = (0..points).map(|_| std::array::from_fn(|_| words.ticks(24))).collect();
    let shaped = |(index, &[x, y, z]): (usize, &[i32; 3])| match shape {
        Shape::Solid => [x, y, z],
        Shape::Flat => [x, y, -113_000],
        Shape::Line => [65_536, 65_536, z],
        Shape::Repeated => solid[index % 7],
    };
    solid.iter().enumerate().map(shaped).collect()
}

/// Every third point lost, the others moved by less than 1/8 m along each axis.
fn reconstructed_ticks(original: &[[i32; 3]]) -> Vec<[i32; 3]> {
    let mut words = Words(2);
    let kept = original.iter().enumerate().filter(|(index, _)| index % 3 != 0);
    kept.map(|(_, point)| point.map(|tick| tick + words.ticks(14))).collect()
}

fn meters(ticks: &[[i32; 3]]) -> Cloud3 {
    ticks.iter().map(|point| point.map(|tick| tick as f32 / 65_536.0)).collect()
}

fn compare_synthetic(points: usize, shape: Shape) -> Quality {
    let ticks = original_ticks(points, shape);
    let reconstructed = meters(&reconstructed_ticks(&ticks));
    compare(&meters(&ticks), &reconstructed, PAPER_MAX_RANGE_M).unwrap()
}

fn fields(quality: &Quality) -> [(&'static str, f64); 8] {
    [
        ("mse_m2", quality.mse_m2),
        ("mse_reverse_m2", quality.mse_reverse_m2),
        ("psnr_db", quality.psnr_db),
        ("psnr_reverse_db", quality.psnr_reverse_db),
        ("cd_m2", quality.cd_m2),
        ("cd_mean_m", quality.cd_mean_m),
        ("max_error_m", quality.max_error_m),
        ("max_error_reverse_m", quality.max_error_reverse_m),
    ]
}

#[track_caller]
fn assert_close(found: &Quality, expected: &Quality) {
    for ((name, found), (_, expected)) in fields(found).into_iter().zip(fields(expected)) {
        let close = found == expected || (found - expected).abs() <= 1e-12 * expected.abs();
        assert!(close, "{name}: found {found}, expected {expected}");
    }
}

#[test]
fn agrees_with_scipy_on_synthetic_clouds() {
    assert_close(&compare_synthetic(10, Shape::Solid), &SMALL);
    assert_close(&compare_synthetic(2_000, Shape::Solid), &SOLID);
    assert_close(&compare_synthetic(20_000, Shape::Solid), &LARGE);
}

#[test]
fn agrees_with_scipy_on_degenerate_clouds() {
    assert_close(&compare_synthetic(2_000, Shape::Flat), &FLAT);
    assert_close(&compare_synthetic(2_000, Shape::Line), &LINE);
    assert_close(&compare_synthetic(2_000, Shape::Repeated), &REPEATED);
}

// --- against a search that tries every pair ---------------------------------------------------------------------------

fn nearest_square(from: &[f32; 3], to: &[[f32; 3]]) -> f64 {
    let square = |point: &[f32; 3]| -> f64 {
        let along = |axis: usize| f64::from(from[axis]) - f64::from(point[axis]);
        (0..3).map(|axis| along(axis) * along(axis)).sum()
    };
    to.iter().map(square).fold(f64::INFINITY, f64::min)
}

fn brute_force(original: &[[f32; 3]], reconstructed: &[[f32; 3]], max_range_m: f64) -> Quality {
    let squares = |from: &[[f32; 3]], to: &[[f32; 3]]| -> Vec<f64> {
        from.iter().map(|point| nearest_square(point, to)).collect()
    };
    let (forward, reverse) = (squares(reconstructed, original), squares(original, reconstructed));
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let mean_m = |values: &[f64]| mean(&values.iter().map(|square| square.sqrt()).collect::<Vec<_>>());
    let max_m = |values: &[f64]| values.iter().copied().fold(0.0, f64::max).sqrt();
    let psnr_db = |mse: f64| 10.0 * (max_range_m.powi(2) / mse).log10();
    Quality {
        mse_m2: mean(&forward),
        mse_reverse_m2: mean(&reverse),
        psnr_db: psnr_db(mean(&forward)),
        psnr_reverse_db: psnr_db(mean(&reverse)),
        cd_m2: mean(&forward) + mean(&reverse),
        cd_mean_m: f64::midpoint(mean_m(&forward), mean_m(&reverse)),
        max_error_m: max_m(&forward),
        max_error_reverse_m: max_m(&reverse),
    }
}

/// Few distinct values give shared coordinates and repeated points; the wide range gives everything else.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![(-3_i8..=3).prop_map(f32::from), -120.0_f32..120.0, Just(-0.0),]
}

fn cloud() -> impl Strategy<Value = Cloud3> {
    vec([coordinate(), coordinate(), coordinate()], 1..150)
}

proptest! {
    #[test]
    fn agrees_with_a_search_of_all_pairs(original in cloud(), reconstructed in cloud(), max_range_m in 1.0..300.0) {
        let found = compare(&original, &reconstructed, max_range_m).unwrap();
        assert_close(&found, &brute_force(&original, &reconstructed, max_range_m));
    }

    #[test]
    fn swapping_the_clouds_swaps_the_directions(original in cloud(), reconstructed in cloud()) {
        let one = compare(&original, &reconstructed, 80.0).unwrap();
        let other = compare(&reconstructed, &original, 80.0).unwrap();
        prop_assert_eq!(one.mse_m2.to_bits(), other.mse_reverse_m2.to_bits());
        prop_assert_eq!(one.max_error_m.to_bits(), other.max_error_reverse_m.to_bits());
        prop_assert_eq!(one.cd_m2.to_bits(), other.cd_m2.to_bits());
    }

    #[test]
    fn epsnr_never_exceeds_psnr(psnr_db in 0.0..120.0, se in 0.0..=1.0, alpha in -1.0..1.0, beta in 0.01..10.0) {
        let found = epsnr_db(psnr_db, se, EpsnrParameters { alpha, beta }).unwrap();
        prop_assert!((0.0..=psnr_db).contains(&found), "{found}");
    }
}

// --- clouds that break careless k-d trees -----------------------------------------------------------------------------

#[test]
fn repeated_points_cost_no_time() {
    let time = |points: &[[f32; 3]]| {
        let started = Instant::now();
        let quality = compare(points, points, PAPER_MAX_RANGE_M).unwrap();
        assert_eq!((quality.mse_m2, quality.max_error_m), (0.0, 0.0));
        started.elapsed()
    };
    let distinct = time(&meters(&original_ticks(20_000, Shape::Solid)));
    let repeated = time(&vec![[1.0, -2.0, 3.0]; 20_000]);
    // A tree that keeps repetitions looks at all of them for each point: 50 times the time of distinct points.
    assert!(repeated < 5 * distinct, "{repeated:?} for equal points, {distinct:?} for distinct ones");
}

#[test]
fn points_that_share_coordinates_are_found() {
    for axis in 0..3 {
        let mut points = meters(&original_ticks(10_000, Shape::Solid));
        for point in &mut points {
            point[axis] = 7.5;
        }
        let (lost, kept) = points.split_at(200);
        let quality = compare(&points, kept, PAPER_MAX_RANGE_M).unwrap();
        assert_eq!(quality.mse_m2, 0.0);
        let farthest = lost.iter().map(|point| nearest_square(point, kept)).fold(0.0, f64::max);
        assert_eq!(quality.max_error_reverse_m, farthest.sqrt());
    }
}

#[test]
fn the_largest_floats_do_not_overflow() {
    let quality = compare(&[[f32::MAX; 3]], &[[f32::MIN; 3]], PAPER_MAX_RANGE_M).unwrap();
    let expected = 2.0 * f64::from(f32::MAX) * 3.0_f64.sqrt();
    assert!((quality.max_error_m / expected - 1.0).abs() < 1e-15);
}

// --- identical, empty and broken clouds -------------------------------------------------------------------------------

#[test]
fn identical_clouds_have_infinite_psnr_and_no_error() {
    let points = meters(&original_ticks(100, Shape::Solid));
    let quality = compare(&points, &points, PAPER_MAX_RANGE_M).unwrap();
    assert_eq!((quality.psnr_db, quality.psnr_reverse_db), (f64::INFINITY, f64::INFINITY));
    assert_eq!((quality.cd_m2, quality.cd_mean_m, quality.max_error_m), (0.0, 0.0, 0.0));
}

#[test]
fn a_lost_point_shows_in_the_reverse_direction_only() {
    let original = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]];
    let quality = compare(&original, &original[..1], 50.0).unwrap();
    assert_eq!((quality.psnr_db, quality.max_error_m), (f64::INFINITY, 0.0));
    assert_eq!((quality.mse_reverse_m2, quality.max_error_reverse_m), (12.5, 5.0));
    assert!((quality.psnr_reverse_db - 10.0 * 200.0_f64.log10()).abs() < 1e-12);
    assert_eq!((quality.cd_m2, quality.cd_mean_m), (12.5, 1.25));
}

#[test]
fn empty_clouds_are_an_error() {
    let one = [[1.0, 2.0, 3.0]];
    let empty = |cloud| Err(MetricError::Empty { cloud });
    assert_eq!(compare(&[], &one, 80.0), empty(Cloud::Original));
    assert_eq!(compare(&one, &[], 80.0), empty(Cloud::Reconstructed));
    assert_eq!(metrics::distances(&[], &one), Err(MetricError::Empty { cloud: Cloud::Reconstructed }));
    assert_eq!(metrics::distances(&one, &[]), Err(MetricError::Empty { cloud: Cloud::Original }));
}

#[test]
fn coordinates_that_are_not_finite_are_an_error() {
    let good = [[1.0, 2.0, 3.0]; 3];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let mut points = good;
            points[2][axis] = bad;
            let not_finite = |cloud| Err(MetricError::NotFinite { cloud, index: 2 });
            assert_eq!(compare(&points, &good, 80.0), not_finite(Cloud::Original));
            assert_eq!(compare(&good, &points, 80.0), not_finite(Cloud::Reconstructed));
        }
    }
}

#[test]
fn a_max_range_that_is_no_range_is_an_error() {
    let one = [[1.0, 2.0, 3.0]];
    for found_m in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(compare(&one, &one, found_m), Err(MetricError::MaxRange { found_m }));
    }
    assert!(matches!(compare(&one, &one, f64::NAN), Err(MetricError::MaxRange { .. })));
}

// --- sampling error and ePSNR -----------------------------------------------------------------------------------------

#[test]
fn sampling_error_counts_points() {
    assert_eq!(sampling_error(8, 8), Ok(0.0));
    assert_eq!(sampling_error(8, 2), Ok(0.75));
    assert_eq!(sampling_error(8, 0), Ok(1.0));
    assert_eq!(sampling_error(0, 0), Err(MetricError::PointCount { original: 0, kept: 0 }));
    assert_eq!(sampling_error(8, 9), Err(MetricError::PointCount { original: 8, kept: 9 }));
}

/// SE, PSNR and ePSNR of the paper's comparison with Draco. Its ePSNR is a mean over frames of a curve, so it is only
/// near the curve at the mean SE; where the curve is flat or straight the printed digits come out.
#[test]
fn epsnr_is_the_papers() {
    let table = [
        (67.29, 0.067, 67.27, 0.01),
        (63.18, 0.084, 63.13, 0.005),
        (63.09, 0.091, 63.01, 0.015),
        (62.40, 0.210, 61.64, 0.05),
        (61.41, 0.588, 51.38, 0.5),
        (58.61, 0.789, 35.40, 0.25),
        (53.71, 0.892, 22.29, 0.01),
    ];
    for (psnr_db, se, expected, tolerance) in table {
        let found = epsnr_db(psnr_db, se, EpsnrParameters::PAPER).unwrap();
        assert!((found - expected).abs() <= tolerance, "SE {se}: found {found}, paper {expected}");
    }
}

#[test]
fn the_entropy_function_is_held_between_nothing_and_all() {
    let with = |se, alpha| epsnr_db(60.0, se, EpsnrParameters { alpha, beta: 0.5 }).unwrap();
    assert_eq!(with(0.0, -0.15), 60.0);
    assert_eq!(with(0.5, -1.0), 60.0); // F + alpha below 0 counts as 0
    assert_eq!(with(0.5, 1.0), 30.0); // above 1 as 1: the paper's "naive way"
    assert_eq!(with(1.0, 0.0), 0.0);
}

#[test]
fn epsnr_of_an_exact_reconstruction_is_a_number() {
    let infinite = |se, alpha| epsnr_db(f64::INFINITY, se, EpsnrParameters { alpha, beta: 0.5 });
    assert_eq!(infinite(0.0, -0.15), Ok(f64::INFINITY));
    assert_eq!(infinite(0.9, -0.15), Ok(f64::INFINITY));
    assert_eq!(infinite(1.0, 0.0), Ok(0.0));
}

#[test]
fn epsnr_refuses_what_it_is_not_defined_for() {
    let paper = EpsnrParameters::PAPER;
    assert_eq!(epsnr_db(f64::NAN, 0.1, paper), Err(MetricError::Psnr));
    for found in [-0.1, 1.1, f64::INFINITY] {
        assert_eq!(epsnr_db(60.0, found, paper), Err(MetricError::SamplingError { found }));
    }
    assert!(matches!(epsnr_db(60.0, f64::NAN, paper), Err(MetricError::SamplingError { .. })));
    for (alpha, beta) in [(0.0, 0.0), (0.0, -1.0), (0.0, f64::INFINITY), (f64::INFINITY, 0.5)] {
        let refused = epsnr_db(60.0, 0.5, EpsnrParameters { alpha, beta });
        assert_eq!(refused, Err(MetricError::EpsnrParameters { alpha, beta }));
    }
}

#[test]
fn errors_say_what_was_found_and_expected() {
    let text = |error: MetricError| error.to_string();
    let empty = MetricError::Empty { cloud: Cloud::Reconstructed };
    assert_eq!(text(empty), "the reconstructed cloud has no points: expected at least one");
    let count = MetricError::PointCount { original: 3, kept: 4 };
    assert_eq!(text(count), "4 points kept of 3: expected 1 original point or more, and no more kept");
}
