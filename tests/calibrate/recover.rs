//! A made-up sensor comes back as it was made.

use std::f64::consts::TAU;

use flicr::calibrate::{Calibration, Progress, Scan, Stage, calibrate};
use flicr::sensor::{Grid, Sensor};

use crate::made_up::{Made, MadeUp, Random, Recipe, SIXTY_FOUR, TrueBeam, positions};

/// How exactly a sensor must come back.
#[derive(Clone, Copy)]
struct Tolerance {
    slope: f64,
    offset_m: f64,
    azimuth_ticks: f64,
    range_units: f64,
}

/// Millimetre files: what the issue asks for KITTI, 0.003 degrees being a thirtieth of its tick.
const ROUNDED: Tolerance = Tolerance { slope: 3e-5, offset_m: 6e-4, azimuth_ticks: 1.0 / 30.0, range_units: 0.05 };
/// Files with all of `f32`.
const EXACT: Tolerance = Tolerance { slope: 1e-6, offset_m: 1e-5, azimuth_ticks: 0.01, range_units: 0.01 };

fn scans_of(sensor: &MadeUp, count: u64) -> Vec<Vec<Made>> {
    (0..count).map(|scan| sensor.scan(1000 * sensor.recipe.seed + scan)).collect()
}

fn found(clouds: &[Vec<[f32; 3]>]) -> Calibration {
    let scans: Vec<Scan> = clouds.iter().map(|points| Scan { points, beams: None }).collect();
    calibrate("made up", &scans, &mut |_| ()).expect("a sensor on a grid")
}

fn assert_same(sensor: &MadeUp, found: &Sensor, tolerance: Tolerance) {
    let recipe = sensor.recipe;
    assert_eq!((found.ticks_per_turn, found.range_from_axis), (recipe.ticks, recipe.range_from_axis));
    assert!((f64::from(found.range_unit_m) - recipe.unit_m).abs() < 1e-9, "{} m a count", found.range_unit_m);
    assert_eq!(found.beams.len(), sensor.beams.len());
    for (row, (beam, truth)) in found.beams.iter().zip(&sensor.beams).enumerate() {
        let errors = errors(beam, truth, TAU / f64::from(recipe.ticks), recipe.unit_m);
        let limits =
            [tolerance.slope, tolerance.offset_m, tolerance.offset_m, tolerance.azimuth_ticks, tolerance.range_units];
        let all_within = errors.iter().zip(limits).all(|(error, limit)| *error <= limit);
        assert!(all_within, "beam {row}: off by {errors:?}, limits {limits:?}");
    }
}

/// Errors of slope, two offsets (m), azimuth phase (ticks) and range phase (counts).
fn errors(beam: &flicr::sensor::Beam, truth: &TrueBeam, tick: f64, unit: f64) -> [f64; 5] {
    let around = |difference: f64| (difference - difference.round()).abs();
    [
        (f64::from(beam.slope) - truth.slope).abs(),
        (f64::from(beam.z_offset_m) - truth.z_offset_m).abs(),
        (f64::from(beam.h_offset_m) - truth.h_offset_m).abs(),
        around((f64::from(beam.azimuth_phase_rad) - truth.azimuth_phase_rad) / tick),
        around((f64::from(beam.range_phase_m) - truth.range_phase_m) / unit),
    ]
}

/// Share of the points of a new scan that do not come back in the very cell they were made in.
fn misplaced(sensor: &MadeUp, found: &Sensor, seed: u64) -> f64 {
    let grid = Grid::new(found);
    let made = sensor.scan(seed);
    let ticks = i64::from(sensor.recipe.ticks);
    // Phases are only known to whole ticks and counts: each beam may be off by one of each, throughout.
    let mut shifts = vec![None; sensor.beams.len()];
    let wrong = made.iter().filter(|point| {
        let (cell, _) = grid.locate(point.position.map(f64::from)).expect("a return");
        let by = (
            (i64::from(cell.tick) - i64::from(point.tick)).rem_euclid(ticks),
            i64::from(cell.count) - i64::from(point.count),
        );
        cell.beam != point.beam || *shifts[usize::from(cell.beam)].get_or_insert(by) != by
    });
    wrong.count() as f64 / made.len() as f64
}

fn recovers(recipe: Recipe, scans: u64, tolerance: Tolerance) {
    let sensor = MadeUp::new(recipe);
    let clouds: Vec<_> = scans_of(&sensor, scans).iter().map(|scan| positions(scan)).collect();
    let found = found(&clouds);
    assert_same(&sensor, &found.sensor, tolerance);
    assert_eq!((found.residuals.lost, found.residuals.off_grid), (0, 0));
    // Rounding to millimetres moves a range over the edge of a 2 mm count now and then;
    // close to the axis beams meet.
    let limit = if recipe.rounding_m > 0.0 { 0.002 } else { 1e-4 };
    let misplaced = misplaced(&sensor, &found.sensor, 7);
    assert!(misplaced <= limit, "{misplaced} of the points of another scan in the wrong cell");
}

#[test]
fn sixty_four_beams_in_millimetres() {
    recovers(SIXTY_FOUR, 8, ROUNDED);
}

#[test]
fn sixty_four_beams_with_ranges_from_the_axis() {
    recovers(Recipe { range_from_axis: true, ..SIXTY_FOUR }, 8, ROUNDED);
}

#[test]
fn thirty_two_beams_with_coarse_ticks_and_counts() {
    let recipe = Recipe {
        beams: 32,
        highest: 0.19,
        lowest: -0.58,
        z_offset_m: 0.05,
        h_offset_m: 0.1,
        ticks: 1800,
        unit_m: 0.004,
        firing_ticks: 1.0,
        seed: 32,
        ..SIXTY_FOUR
    };
    // Counts twice as long leave half as many heights to fit a slope to.
    recovers(recipe, 8, Tolerance { slope: 6e-5, ..ROUNDED });
}

#[test]
fn forty_beams_with_a_unit_that_is_not_round() {
    let recipe = Recipe {
        beams: 40,
        highest: 0.27,
        lowest: -0.45,
        h_offset_m: 0.05,
        ticks: 7200,
        unit_m: 0.1 / 23.0,
        firing_ticks: 3.3,
        seed: 40,
        ..SIXTY_FOUR
    };
    recovers(recipe, 8, ROUNDED);
}

#[test]
fn sixteen_beams_with_hundredths_of_a_degree_unrounded() {
    let recipe = Recipe {
        beams: 16,
        highest: 0.268,
        lowest: -0.268,
        z_offset_m: 0.011,
        h_offset_m: 0.003,
        ticks: 36_000,
        unit_m: 0.002,
        firing_ticks: 19.91,
        range_from_axis: false,
        rounding_m: 0.0,
        seed: 16,
    };
    recovers(recipe, 2, EXACT);
}

#[test]
fn a_hundred_and_twenty_eight_beams_with_columns_unrounded() {
    let recipe = Recipe {
        beams: 128,
        highest: 0.4,
        lowest: -0.4,
        z_offset_m: 0.04,
        h_offset_m: 0.001,
        ticks: 1024,
        unit_m: 0.008,
        firing_ticks: 1.0,
        range_from_axis: false,
        rounding_m: 0.0,
        seed: 128,
    };
    recovers(recipe, 2, EXACT);
}

#[test]
fn the_order_of_the_points_does_not_matter() {
    let sensor = MadeUp::new(SIXTY_FOUR);
    let mut clouds: Vec<_> = scans_of(&sensor, 6).iter().map(|scan| positions(scan)).collect();
    for points in &mut clouds {
        Random(5).shuffle(points);
    }
    assert_same(&sensor, &found(&clouds).sensor, ROUNDED);
}

#[test]
fn stray_points_are_left_out() {
    let sensor = MadeUp::new(SIXTY_FOUR);
    let mut random = Random(9);
    let mut clouds: Vec<_> = scans_of(&sensor, 8).iter().map(|scan| positions(scan)).collect();
    for points in &mut clouds {
        points.extend([[0.0; 3], [f32::NAN; 3], [f32::INFINITY, 0.0, 1.0]]);
        // High up, where no beam is: two in a hundred.
        let stray = points.len() / 50;
        points.extend((0..stray).map(|_| [40.0, 40.0, 20.0].map(|reach| random.between(-reach, reach) as f32 + 0.5)));
    }
    let found = found(&clouds);
    assert_same(&sensor, &found.sensor, ROUNDED);
    assert!((0.96..1.0).contains(&found.beam_share), "{}", found.beam_share);
    assert!(found.residuals.off_grid > 0);
}

#[test]
fn beam_numbers_help_in_any_numbering() {
    // So few points that a vote would miss beams.
    let recipe = Recipe { rounding_m: 0.0, firing_ticks: 20.3, ..SIXTY_FOUR };
    let sensor = MadeUp::new(recipe);
    let made = scans_of(&sensor, 2);
    let clouds: Vec<_> = made.iter().map(|scan| positions(scan)).collect();
    let rings: Vec<Vec<u16>> =
        made.iter().map(|scan| scan.iter().map(|point| 7 + (point.beam * 37) % 64).collect()).collect();
    let scans: Vec<Scan> =
        clouds.iter().zip(&rings).map(|(points, beams)| Scan { points, beams: Some(beams) }).collect();
    let found = calibrate("hinted", &scans, &mut |_| ()).expect("a sensor on a grid");
    assert_same(&sensor, &found.sensor, EXACT);
}

#[test]
fn residuals_and_deviations_tell_the_truth() {
    let sensor = MadeUp::new(SIXTY_FOUR);
    let clouds: Vec<_> = scans_of(&sensor, 8).iter().map(|scan| positions(scan)).collect();
    let found = found(&clouds);
    let all: usize = clouds.iter().map(Vec::len).sum();
    assert_eq!(found.residuals.points, all);
    assert_eq!(found.residuals.beams.iter().map(|beam| beam.points).sum::<usize>(), all);
    let tick = TAU / f64::from(SIXTY_FOUR.ticks);
    let mut squares = [0.0; 3];
    for ((beam, truth), residuals) in found.sensor.beams.iter().zip(&sensor.beams).zip(&found.residuals.beams) {
        for spread in [&residuals.across, &residuals.around, &residuals.along] {
            // Rounding to a millimetre: 1 mm / sqrt(12), at most half its cube's diagonal.
            assert!((spread.rms_m - 0.000_289).abs() < 0.000_03, "{} of {residuals:?}", spread.rms_m);
            assert!(spread.max_m < 0.001_01, "{}", spread.max_m);
            assert_eq!(spread.histogram.iter().sum::<u32>() as usize, residuals.points);
        }
        let errors = errors(beam, truth, tick, SIXTY_FOUR.unit_m);
        squares[0] += (errors[0] / f64::from(residuals.deviation.slope)).powi(2) / 64.0;
        squares[1] += (errors[1] / f64::from(residuals.deviation.z_offset_m)).powi(2) / 64.0;
        squares[2] += (errors[2] / f64::from(residuals.deviation.h_offset_m)).powi(2) / 64.0;
    }
    // Stated deviations are the errors' true size within a factor of two over all beams; the rounding
    // of the heights gives more away than they say.
    assert!(squares[0] < 1.0 && squares[1] < 1.0 && (0.25..4.0).contains(&squares[2]), "{squares:?}");
}

#[test]
fn progress_runs_through_all_stages() {
    let sensor = MadeUp::new(Recipe { firing_ticks: 8.0, ..SIXTY_FOUR });
    let points = positions(&sensor.scan(3));
    let mut heard: Vec<Progress> = Vec::new();
    let scans = [Scan { points: &points, beams: None }];
    let _ = calibrate("progress", &scans, &mut |progress| heard.push(progress));
    assert!(heard.iter().all(|progress| (0.0..=1.0).contains(&progress.fraction)));
    let mut stages: Vec<Stage> = heard.iter().map(|progress| progress.stage).collect();
    stages.dedup();
    assert_eq!(stages, [Stage::Beams, Stage::Ticks, Stage::Offsets, Stage::Unit, Stage::Residuals]);
    for pair in heard.windows(2).filter(|pair| pair[0].stage == pair[1].stage) {
        assert!(pair[1].fraction >= pair[0].fraction, "{pair:?}");
    }
}

#[test]
fn the_same_scans_give_the_same_sensor() {
    let sensor = MadeUp::new(Recipe { firing_ticks: 8.0, ..SIXTY_FOUR });
    let clouds: Vec<_> = scans_of(&sensor, 3).iter().map(|scan| positions(scan)).collect();
    assert_eq!(found(&clouds).sensor, found(&clouds).sensor);
}
