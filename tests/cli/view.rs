//! The picture is a PNG that shows something.

use std::collections::BTreeSet;

use super::picture::Picture;
use super::run::{Place, bin};

#[test]
fn a_scan_is_shown_with_its_frame() {
    let place = Place::with_scan();
    place.fine(&["view", "scan.bin", "-o", "scan.png"]);
    let picture = Picture::of(&place.read("scan.png"));
    assert!(picture.width >= 1000 && picture.height() >= 800);
    let (middle, bottom) = (picture.width / 2, picture.height());
    assert!(picture.colored(20..picture.width - 20, 60..280) > 0.6, "range image");
    assert!(picture.colored(20..middle - 20, 400..bottom) > 0.02, "original from above");
    assert!(picture.colored(middle + 20..picture.width, 400..bottom) > 0.02, "decoded from above");
    let colors: BTreeSet<[u8; 3]> = picture.rgb.iter().copied().collect();
    assert!(colors.len() > 100);
}

#[test]
fn a_frame_is_shown_by_its_number() {
    let place = Place::new();
    place.fine(&["simulate", "-o", "t.bin", "--turns", "2"]);
    place.fine(&["encode", "t-000000.bin", "t-000001.bin", "-o", "t.flicr", "--columns", "512", "--bits", "12"]);
    place.fine(&["view", "t.flicr", "-o", "0.png"]);
    place.fine(&["view", "t.flicr", "-o", "1.png", "--frame", "1"]);
    assert_ne!(place.read("0.png"), place.read("1.png"));
    let picture = Picture::of(&place.read("1.png"));
    assert!(picture.colored(20..picture.width - 20, 60..280) > 0.6, "range image");
}

#[test]
fn columns_change_the_picture() {
    let place = Place::with_scan();
    place.fine(&["view", "scan.bin", "-o", "many.png"]);
    place.fine(&["view", "scan.bin", "-o", "few.png", "--columns", "64"]);
    let [many, few] = ["many.png", "few.png"].map(|name| Picture::of(&place.read(name)));
    let right = |picture: &Picture| picture.colored(picture.width / 2 + 20..picture.width, 400..picture.height());
    assert!(right(&few) < 0.2 * right(&many), "64 columns keep few points");
}

#[test]
fn points_that_no_sensor_measures_are_shown_too() {
    let place = Place::new();
    for most in [1e6, 1e18, 1e38, f32::MAX] {
        let points: Vec<[f32; 4]> = (0..200).map(|i| [5.0, 1.0, if i % 2 == 0 { most } else { -most }, 0.0]).collect();
        place.write("far.bin", &bin(&points));
        place.fine(&["view", "far.bin", "-o", "far.png", "--columns", "64", "--max-range", "80"]);
        place.fine(&["view", "far.bin", "-o", "far.png", "--columns", "64"]);
    }
    place.write("odd.bin", &bin(&[[f32::NAN; 4], [f32::INFINITY; 4], [0.0; 4]]));
    place.fine(&["view", "odd.bin", "-o", "odd.png", "--columns", "64"]);
}
