//! simulate -> encode -> info -> decode, with one frame and several.

use super::run::{Place, bin, objects, points};

#[test]
fn a_scan_comes_back_within_its_bound() {
    let place = Place::with_scan();
    let original = points(&place.read("scan.bin"));
    assert!((100_000..130_000).contains(&original.len()));
    let line = place.fine(&["encode", "scan.bin", "-o", "scan.flicr", "--bits", "16"]);
    assert!(line.starts_with("scan.bin: frame 0, "), "{line}");
    place.fine(&["decode", "scan.flicr", "-o", "back.bin"]);
    let info = &objects(&place.fine(&["info", "scan.flicr", "--json"]))[0];
    let back = points(&place.read("back.bin"));
    assert_eq!(info["kept"], back.len());
    assert_eq!(info["returns"], original.len());
    assert_eq!(info["bits"], 16);
    assert_eq!(info["bytes"], place.read("scan.flicr").len());
    let farthest_m = |points: &[[f32; 4]]| points.iter().map(range_m).fold(0.0, f64::max);
    let bound_m = info["range_bound_m"].as_f64().unwrap();
    assert!(bound_m < 0.001);
    assert!((farthest_m(&original) - farthest_m(&back)).abs() <= bound_m + 1e-5);
}

fn range_m(&[x, y, z, _]: &[f32; 4]) -> f64 {
    [x, y, z].map(|part| f64::from(part).powi(2)).iter().sum::<f64>().sqrt()
}

#[test]
fn every_point_is_accounted_for() {
    let place = Place::new();
    let cloud = [
        [10.0, 0.0, -1.0, 0.5],
        [10.0, 0.0, -1.0, 0.5],
        [0.0, 0.0, 0.0, 0.0],
        [f32::NAN, 0.0, 0.0, 0.0],
        [0.0, 0.05, 0.0, 0.0],
        [0.0, 90.0, -1.0, 0.0],
        [3.0, 3.0, 9.0, 0.0],
    ];
    place.write("odd.bin", &bin(&cloud));
    let line = place.fine(&["encode", "odd.bin", "-o", "odd.flicr", "--max-range", "80"]);
    let account = "7 points: 2 kept, 1 collided, 1 beyond range, 1 too near, 1 no return, 1 not finite (1 clamped into an edge row)";
    assert!(line.trim_end().ends_with(account), "{line}");
    assert_eq!(place.fine(&["encode", "odd.bin", "-o", "odd.flicr", "--max-range", "80"]), line);
    let info = &objects(&place.fine(&["info", "odd.flicr", "--json"]))[0];
    assert_eq!((info["returns"].as_u64(), info["kept"].as_u64()), (Some(5), Some(2)));
    let info = &objects(&place.fine(&["info", "odd.bin", "--json"]))[0];
    assert_eq!((info["points"].as_u64(), info["returns"].as_u64()), (Some(7), Some(5)));
}

#[test]
fn coders_and_levels_of_all_widths_give_the_same_points() {
    let place = Place::with_scan();
    for bits in ["5", "8", "12"] {
        let [rle, deflate, store] = ["rle", "deflate", "store"].map(|coder| {
            place.fine(&["encode", "scan.bin", "-o", "f.flicr", "--coder", coder, "--bits", bits, "--columns", "512"]);
            place.fine(&["decode", "f.flicr", "-o", "back.pcd"]);
            let info = &objects(&place.fine(&["info", "f.flicr", "--json"]))[0];
            assert_eq!(info["coder"], coder);
            (place.read("f.flicr").len(), place.read("back.pcd"))
        });
        assert!(rle.1 == deflate.1 && deflate.1 == store.1, "{bits} bits");
        assert!(deflate.0 < rle.0 && deflate.0 < store.0, "{bits} bits");
    }
}

#[test]
fn presets_differ_as_they_say() {
    let place = Place::with_scan();
    for (preset, placement) in [("paper", "corner"), ("uniform", "center")] {
        place.fine(&["encode", "scan.bin", "-o", "f.flicr", "--preset", preset, "--rows", "32", "--columns", "1024"]);
        let info = &objects(&place.fine(&["info", "f.flicr", "--json"]))[0];
        assert_eq!(info["placement"], placement);
        assert_eq!((info["rows"].as_u64(), info["columns"].as_u64()), (Some(32), Some(1024)));
    }
}

#[test]
fn formats_agree_on_the_points() {
    let place = Place::new();
    place.fine(&["simulate", "-o", "s.bin"]);
    place.fine(&["simulate", "-o", "s.pcd"]);
    place.fine(&["simulate", "-o", "s.xyzir.bin"]);
    place.fine(&["simulate", "-o", "s.ply"]);
    let frames = ["s.bin", "s.pcd", "s.xyzir.bin"].map(|name| {
        place.fine(&["encode", name, "-o", "f.flicr"]);
        place.read("f.flicr")
    });
    assert!(frames[0] == frames[1] && frames[1] == frames[2]);
    assert!(place.read("s.ply").starts_with(b"ply\nformat binary_little_endian"));
}

#[test]
fn seeds_are_reproducible_and_differ() {
    let place = Place::new();
    for (seed, name) in [("5", "a.bin"), ("5", "b.bin"), ("6", "c.bin")] {
        place.fine(&["simulate", "-o", name, "--seed", seed]);
    }
    assert_eq!(place.read("a.bin"), place.read("b.bin"));
    assert_ne!(place.read("a.bin"), place.read("c.bin"));
}

#[test]
fn several_frames_are_numbered() {
    let place = Place::new();
    place.fine(&["simulate", "-o", "turn.bin", "--turns", "3"]);
    let turns = ["turn-000000.bin", "turn-000001.bin", "turn-000002.bin"];
    assert_eq!(place.names(), turns);
    let lines = place.fine(&[&["encode"], turns.as_slice(), &["-o", "all.flicr", "--columns", "256"]].concat());
    assert_eq!(lines.lines().count(), 3);
    let infos = objects(&place.fine(&["info", "all.flicr", "--json"]));
    let sequences: Vec<u64> = infos.iter().map(|info| info["sequence"].as_u64().unwrap()).collect();
    assert_eq!(sequences, [0, 1, 2]);
    place.fine(&["decode", "all.flicr", "-o", "back.ply"]);
    place.fine(&["decode", "all.flicr", "-o", "back.xyzir.bin"]);
    std::fs::create_dir(place.path("folder")).unwrap();
    place.fine(&["decode", "all.flicr", "-o", "folder"]);
    for (number, info) in infos.iter().enumerate() {
        assert!(place.path(&format!("back-{number:06}.ply")).exists());
        assert!(place.path(&format!("back-{number:06}.xyzir.bin")).exists());
        assert_eq!(info["kept"], points(&place.read(&format!("folder/{number:06}.bin"))).len());
    }
}

#[test]
fn a_folder_gets_a_file_an_input_with_the_same_frames() {
    let place = Place::new();
    place.fine(&["simulate", "-o", "turn.bin", "--turns", "2"]);
    std::fs::create_dir(place.path("out")).unwrap();
    let inputs = ["turn-000000.bin", "turn-000001.bin"];
    place.fine(&[&["encode"], inputs.as_slice(), &["-o", "out"]].concat());
    place.fine(&[&["encode"], inputs.as_slice(), &["-o", "all.flicr"]].concat());
    let apart = ["out/turn-000000.flicr", "out/turn-000001.flicr"].map(|name| place.read(name));
    assert_eq!(apart.concat(), place.read("all.flicr"));
}

#[test]
fn an_empty_scan_is_an_empty_frame() {
    let place = Place::new();
    place.write("none.bin", &[]);
    let line = place.fine(&["encode", "none.bin", "-o", "none.flicr"]);
    assert!(line.contains("0 points: 0 kept"), "{line}");
    place.fine(&["decode", "none.flicr", "-o", "back.bin"]);
    assert!(place.read("back.bin").is_empty());
    place.fine(&["view", "none.bin", "-o", "none.png"]);
}

#[test]
fn info_is_readable_too() {
    let place = Place::with_scan();
    let columns = ["--columns", "1024"];
    for (options, shape) in [
        (&["--preset", "uniform", "--columns", "1024", "--coder", "context"][..], &["64 rows", "1024 columns"][..]),
        (&columns, &["64 beams of HDL-64E (KITTI), 1024 columns over its 4000 ticks", "points within"]),
        (&["--columns", "native"], &["64 beams of ", " firings at some of its 4000 ticks (a list of "]),
    ] {
        place.fine(&[&["encode", "scan.bin", "-o", "f.flicr"], options].concat());
        let text = place.fine(&["info", "f.flicr"]);
        for words in [&["f.flicr: frame 0", "coder context", " kept"], shape].concat() {
            assert!(text.contains(words), "no {words:?} in {text}");
        }
    }
    assert!(place.fine(&["info", "scan.bin"]).contains("with intensities, without rings"));
}
