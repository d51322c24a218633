//! The rows are a sensor's beams where the scan is a sensor's: found out or told, and said why.

use flicr::simulate::{Sensor, Simulator};

use super::run::{Place, bin, objects, points};

fn number(place: &Place, frame: &str, field: &str) -> f64 {
    objects(&place.fine(&["info", frame, "--json"]))[0][field].as_f64().unwrap()
}

#[test]
fn a_raw_scan_is_put_on_its_sensors_grid() {
    let place = Place::with_scan();
    let (line, notes) = place.noted(&["encode", "scan.bin", "-o", "f.flicr", "--step", "native"]);
    assert!(notes.starts_with("note: scan.bin: HDL-64E (KITTI), firings: "), "{notes}");
    assert!(notes.contains("on the sensor's own grid") && notes.lines().count() == 1, "{notes}");
    let original = points(&place.read("scan.bin")).len();
    assert!(!line.contains("collided"), "{line}");
    assert_eq!(number(&place, "f.flicr", "kept"), original as f64);
    assert!(number(&place, "f.flicr", "point_bound_m") <= 0.0018);
    let [native, every_tick, few] =
        objects(&place.fine(&["eval", "scan.bin", "--json", "--step", "native", "--columns", "native,4000,1000"]))
            .try_into()
            .unwrap();
    let words = [&native, &every_tick, &few].map(|object| object["geometry"].as_str().unwrap().to_owned());
    assert_eq!(words, ["firings", "every-tick", "even-columns"]);
    for exact in [&native, &every_tick] {
        assert_eq!(exact["se"], 0.0);
        assert!(exact["max_error_m"].as_f64().unwrap() <= 0.0018);
        assert!(exact["why"].as_str().unwrap().contains("on the sensor's own grid"));
    }
    assert!(native["bytes"].as_u64() < every_tick["bytes"].as_u64());
    assert!(few["se"].as_f64().unwrap() > 0.3 && few["columns"] == 1000);
}

#[test]
fn presets_are_no_sensors() {
    let place = Place::with_scan();
    for preset in ["paper", "uniform"] {
        let (_, notes) = place.noted(&["encode", "scan.bin", "-o", "f.flicr", "--preset", preset]);
        assert_eq!(notes, "");
        assert_eq!(number(&place, "f.flicr", "columns"), 4500.0);
        let [object] = objects(&place.fine(&["eval", "scan.bin", "--json", "--preset", preset])).try_into().unwrap();
        assert_eq!((&object["preset"], &object["geometry"]), (&preset.into(), &"uniform".into()));
        assert!(object["sensor"].is_null());
    }
    let encode = ["encode", "scan.bin", "-o", "a.flicr"];
    place.fails(2, &[&encode[..], &["--preset", "uniform", "--sensor", "hdl64e"]].concat());
    place.fails(2, &[&encode[..], &["--preset", "uniform", "--step", "0.1", "--max-range", "80"]].concat());
    let native = place.fails(2, &[&encode[..], &["--preset", "uniform", "--columns", "native"]].concat());
    assert!(native.contains("expected a number"), "{native}");
    let native = place.fails(1, &[&encode[..], &["--preset", "uniform", "--step", "native"]].concat());
    assert!(native.contains("expected meters"), "{native}");
}

#[test]
fn sensors_have_names() {
    let place = Place::with_scan();
    place.fine(&["encode", "scan.bin", "-o", "auto.flicr"]);
    for name in ["hdl64e", "HDL-64E"] {
        let (_, notes) = place.noted(&["encode", "scan.bin", "-o", "named.flicr", "--sensor", name]);
        assert!(notes.contains("HDL-64E (KITTI), firings: the scan is on the sensor's own grid"), "{notes}");
        assert_eq!(place.read("auto.flicr"), place.read("named.flicr"));
    }
    // The wrong one is taken all the same, and said to be wrong.
    let (_, notes) = place.noted(&["encode", "scan.bin", "-o", "wrong.flicr", "--sensor", "vlp16"]);
    assert!(notes.contains("VLP-16") && notes.contains("off the sensor's grid"), "{notes}");
    assert_eq!(number(&place, "wrong.flicr", "rows"), 16.0);
    let encode = ["encode", "scan.bin", "-o", "a.flicr", "--sensor"];
    place.fails_with(2, &[&encode[..], &["vlp17"]].concat(), "vlp17", &["expected auto, hdl64e", "vlp16", ".toml"]);
    place.fails_with(1, &[&encode[..], &["no.toml"]].concat(), "no.toml", &["No such file"]);
    place.write("bad.toml", b"format = 1\nname = 3\n");
    place.fails_with(1, &[&encode[..], &["bad.toml"]].concat(), "bad.toml", &["line 2"]);
    place.write("bad.json", b"{}");
    place.fails_with(1, &[&encode[..], &["bad.json"]].concat(), "bad.json", &["no usable"]);
}

#[test]
fn a_calibrated_sensor_encodes_its_scans_without_loss() {
    let place = Place::new();
    place.fine(&["simulate", "--turns", "4", "-o", "t.bin"]);
    place.fine(&["calibrate", "t-000000.bin", "t-000001.bin", "t-000002.bin", "-o", "found.toml"]);
    for columns in [&["--columns", "native"][..], &["--columns", "4000"]] {
        let encode = ["encode", "t-000003.bin", "-o", "f.flicr", "--sensor", "found.toml", "--step", "native"];
        let (_, notes) = place.noted(&[&encode[..], columns].concat());
        assert!(notes.contains("found, ") && notes.contains("own grid"), "{notes}");
        place.fine(&["decode", "f.flicr", "-o", "back.bin"]);
        let (original, back) = (points(&place.read("t-000003.bin")), points(&place.read("back.bin")));
        assert_eq!(back.len(), original.len());
        assert!(number(&place, "f.flicr", "point_bound_m") <= 0.0025);
    }
}

#[test]
fn other_sensors_are_told_by_their_beams() {
    let place = Place::new();
    let turn = Simulator::with_sensor(Sensor::vlp16(), 4).next().unwrap();
    place.write("vlp16.bin", &bin(&turn.points));
    let (_, notes) = place.noted(&["encode", "vlp16.bin", "-o", "f.flicr"]);
    assert!(notes.starts_with("note: vlp16.bin: VLP-16, "), "{notes}");
    assert_eq!(number(&place, "f.flicr", "rows"), 16.0);
    assert!(number(&place, "f.flicr", "kept") >= 0.99 * turn.points.len() as f64);
}

#[test]
fn scattered_points_get_a_uniform_frame_and_the_reason() {
    let place = Place::new();
    let scattered: Vec<[f32; 4]> = (0..20_000_u32)
        .map(|i| {
            let part = |factor: f64| (f64::from(i) * factor).fract();
            let (range, azimuth) = (5.0 + 40.0 * part(0.618_034), std::f64::consts::TAU * part(0.754_877_666));
            let z = range * (0.3 - 0.6 * part(0.569_840_29));
            [range * azimuth.cos(), range * azimuth.sin(), z, 0.5].map(|v| v as f32)
        })
        .collect();
    place.write("s.bin", &bin(&scattered));
    let (_, notes) = place.noted(&["encode", "s.bin", "-o", "s.flicr"]);
    assert!(notes.starts_with("note: s.bin: uniform: ") && notes.contains("does not fit"), "{notes}");
    place.fails_with(1, &["encode", "s.bin", "-o", "t.flicr", "--step", "native"], "s.bin", &["expected meters"]);
}

#[test]
fn levels_that_do_not_reach_the_scan_are_refused() {
    let place = Place::with_scan();
    let encode = ["encode", "scan.bin", "-o", "f.flicr", "--bits", "8", "--coder", "deflate", "--step"];
    let by_context = ["encode", "scan.bin", "-o", "f.flicr", "--bits", "8", "--step"];
    for (encode, step, reach) in
        [(&encode[..], "native", "reach 0.51 m"), (&encode, "0.01", "reach 2.5"), (&by_context, "0.01", "reach 0.51 m")]
    {
        let words = ["8 bits", reach, "points are beyond", "--bits 16", "longer --step"];
        place.fails_with(1, &[encode, &[step]].concat(), "scan.bin", &words);
    }
    assert!(!place.path("f.flicr").exists());
    let (line, _) = place.noted(&[&encode[..], &["0.2"]].concat());
    assert!(line.contains("beyond range"), "what is dropped is counted: {line}");
}

/// A scan that was moved after it was measured is off the grid: encoded all the same, its bound said, little lost.
#[test]
fn moved_scans_keep_their_beams() {
    let place = Place::with_scan();
    let moved = points(&place.read("scan.bin"));
    let turned = |[x, y, z, intensity]: [f32; 4]| [x + y.atan2(x) / std::f32::consts::TAU, y, z, intensity];
    let moved: Vec<[f32; 4]> = moved.into_iter().map(turned).collect();
    place.write("moved.bin", &bin(&moved));
    let (_, notes) = place.noted(&["encode", "moved.bin", "-o", "f.flicr", "--step", "0.002"]);
    assert!(notes.contains("HDL-64E (KITTI), ") && notes.contains("off the sensor's grid"), "{notes}");
    assert!(number(&place, "f.flicr", "kept") >= 0.99 * moved.len() as f64);
    assert!(number(&place, "f.flicr", "point_bound_m") < 0.6);
}
