//! The default, a promised bound and a promised length, the predictor.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::run::{Place, objects, points};

fn info(place: &Place, options: &[&str]) -> Map<String, Value> {
    place.fine(&[&["encode", "scan.bin", "-o", "f.flicr"], options].concat());
    objects(&place.fine(&["info", "f.flicr", "--json"])).remove(0)
}

fn number(info: &Map<String, Value>, field: &str) -> f64 {
    info[field].as_f64().unwrap()
}

/// The farthest that any of a scan's points is from the nearest decoded one, and the other way, meters.
fn farthest_m(place: &Place) -> f64 {
    place.fine(&["decode", "f.flicr", "-o", "back.bin"]);
    let [a, b] = ["scan.bin", "back.bin"].map(|name| points(&place.read(name)));
    let xyz = |points: &[[f32; 4]]| points.iter().map(|&[x, y, z, _]| [x, y, z]).collect::<Vec<_>>();
    let (a, b) = (xyz(&a), xyz(&b));
    assert_eq!(a.len(), b.len(), "no point is lost");
    let one = flicr::metrics::compare(&a, &b, 80.0).unwrap().max_error_m;
    one.max(flicr::metrics::compare(&b, &a, 80.0).unwrap().max_error_m)
}

#[test]
fn the_default_is_dense_at_two_centimeters_on_the_sensors_grid() {
    let place = Place::with_scan();
    let default = info(&place, &[]);
    let bytes = place.read("f.flicr");
    assert_eq!(default["coder"], "context");
    assert!(number(&default, "range_bound_m") < 0.0131);
    assert_eq!(default["kept"], default["returns"]);
    assert!(farthest_m(&place) < 0.015);
    info(&place, &["--coder", "context", "--tier", "dense", "--step", "0.02", "--columns", "native"]);
    assert!(place.read("f.flicr") == bytes);
    for preset in ["paper", "uniform"] {
        let old = info(&place, &["--preset", preset]);
        assert_eq!((&old["coder"], &old["bits"]), (&"deflate".into(), &8.into()));
    }
}

#[test]
fn a_bound_is_kept_and_the_next_step_would_not() {
    let place = Place::with_scan();
    for bound in ["0.004", "0.05", "0.5"] {
        let found = info(&place, &["--bound", bound]);
        let bound_m: f64 = bound.parse().unwrap();
        assert!(number(&found, "point_bound_m") <= bound_m);
        assert!(farthest_m(&place) <= bound_m);
        // One level more than the coder may change a level by would be too far.
        let coarser = number(&found, "point_bound_m") + 1.1 * number(&found, "range_unit_m");
        assert!(coarser > bound_m, "{bound}: {coarser}");
    }
}

#[test]
fn a_bound_that_nobody_can_promise_is_refused_with_the_reason() {
    let place = Place::with_scan();
    let encode = ["encode", "scan.bin", "-o", "f.flicr"];
    let too_near = [&encode[..], &["--bound", "0.0001"]].concat();
    place.fails_with(1, &too_near, "scan.bin", &["--bound 0.0001", "without any step", " m away"]);
    let cloud: Vec<_> =
        (0..2000_u16).map(|i| [10.0 + f32::from(i % 97), f32::from(i % 89) - 40.0, f32::from(i % 7), 0.0]).collect();
    place.write("cloud.bin", &super::run::bin(&cloud));
    let no_grid = ["encode", "cloud.bin", "-o", "f.flicr", "--bound", "0.1"];
    place.fails_with(1, &no_grid, "cloud.bin", &["no sensor's grid", "middle of its pixel"]);
}

#[test]
fn a_length_is_kept_by_the_finest_step_that_keeps_it() {
    let place = Place::with_scan();
    let mut steps = BTreeMap::new();
    for most in [60_000, 30_000, 12_000_usize] {
        let line = place.fine(&["encode", "scan.bin", "-o", "f.flicr", "--target-bytes", &most.to_string()]);
        let len = place.read("f.flicr").len();
        // One count more a step is up to a tenth of the bytes where steps are of few counts.
        assert!(len <= most && len > most * 9 / 10, "{len} of {most}");
        let (_, step) = line.split_once("step ").unwrap();
        let step_m: f64 = step.split_once(' ').unwrap().0.parse().unwrap();
        let finer = format!("{:.4}", step_m - 0.002);
        place.fine(&["encode", "scan.bin", "-o", "finer.flicr", "--step", &finer]);
        assert!(place.read("finer.flicr").len() > most);
        steps.insert(most, step_m);
    }
    assert!(steps.values().rev().is_sorted(), "{steps:?}");
    let impossible = ["encode", "scan.bin", "-o", "f.flicr", "--target-bytes", "100"];
    place.fails_with(1, &impossible, "scan.bin", &["--target-bytes 100", "coarsest step"]);
    // As fine as the sensor counts is fine enough.
    let line = place.fine(&["encode", "scan.bin", "-o", "f.flicr", "--target-bytes", "1000000"]);
    assert!(line.contains("step 0.0020 m"), "{line}");
}

#[test]
fn choices_that_contradict_each_other_are_bad_usage() {
    let place = Place::with_scan();
    for options in [
        &["--bound", "0.1", "--step", "0.1"][..],
        &["--bound", "0.1", "--target-bytes", "1000"],
        &["--bound", "0.1", "--max-range", "80"],
        &["--bound", "0.1", "--preset", "uniform"],
        &["--bound", "0.1", "--coder", "rle"],
        &["--bound", "0"],
        &["--target-bytes", "1000", "--step", "0.1"],
        &["--target-bytes", "1000", "--max-range", "80"],
        &["--target-bytes", "1000", "--preset", "uniform"],
        &["--target-bytes", "0"],
        &["--tier", "fast", "--predictor", "median-edge"],
    ] {
        place.fails(2, &[&["encode", "scan.bin", "-o", "f.flicr"], options].concat());
    }
}

#[test]
fn the_shorter_predictor_is_taken() {
    let place = Place::with_scan();
    for columns in ["256", "native"] {
        let options = ["--columns", columns, "--predictor"];
        let [west, median_edge, auto] = ["west", "median-edge", "auto"].map(|predictor| {
            info(&place, &[&options[..], &[predictor]].concat());
            place.read("f.flicr")
        });
        assert!(west != median_edge);
        assert!(auto == if median_edge.len() < west.len() { median_edge } else { west }, "{columns}");
    }
}

#[test]
fn smoothing_moves_no_range_by_more_than_the_bound_and_helps_where_steps_are_coarse() {
    let place = Place::with_scan();
    for options in [&["--step", "0.4"][..], &["--bits", "8"], &["--preset", "uniform", "--columns", "1024"]] {
        let bound_m = number(&info(&place, options), "range_bound_m");
        place.fine(&["decode", "f.flicr", "-o", "plain.bin"]);
        place.fine(&["decode", "f.flicr", "-o", "smooth.bin", "--smooth"]);
        let [plain, smooth] = ["plain.bin", "smooth.bin"].map(|name| points(&place.read(name)));
        assert_eq!(plain.len(), smooth.len());
        let off_m = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|i| f64::from(a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let most_m = plain.iter().zip(&smooth).map(off_m).fold(0.0, f64::max);
        // The coordinates' rounding: a few units of 2^-24 of 120 m.
        assert!(most_m > 0.3 * bound_m && most_m <= bound_m + 4e-5, "{options:?}: {most_m} of {bound_m}");
    }
    let psnr_db = |options: &[&str]| {
        let text = place.fine(&[&["eval", "scan.bin", "--json", "--step", "0.4"], options].concat());
        objects(&text)[0]["psnr_db"].as_f64().unwrap()
    };
    assert!(psnr_db(&["--smooth"]) > psnr_db(&[]) + 0.5);
}
