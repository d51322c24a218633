//! Bad data is exit code 1, bad usage 2; both say which file, what was found, what was expected, and leave nothing.

use super::run::Place;

#[test]
fn no_words_or_wrong_words_are_bad_usage() {
    let place = Place::new();
    let wrong: [&[&str]; 10] = [
        &[],
        &["compress"],
        &["encode", "a.bin"],
        &["encode", "-o", "a.flicr"],
        &["encode", "a.bin", "-o", "a.flicr", "--bits", "17"],
        &["encode", "a.bin", "-o", "a.flicr", "--columns", "0"],
        &["encode", "a.bin", "-o", "a.flicr", "--max-range", "-5"],
        &["encode", "a.bin", "-o", "a.flicr", "--coder", "zip"],
        &["eval", "a.bin", "--columns", "512,"],
        &["simulate", "-o", "a.bin", "--turns", "0"],
    ];
    for args in wrong {
        assert!(!place.fails(2, args).is_empty(), "{args:?}");
    }
    place.fine(&["--help"]);
    place.fine(&["--version"]);
}

#[test]
fn sizes_and_scales_without_a_frame_are_bad_usage() {
    let place = Place::with_scan();
    let encode = ["encode", "scan.bin", "-o", "a.flicr"];
    let huge = place.fails(2, &[&encode[..], &["--rows", "128", "--columns", "65535"]].concat());
    assert!(huge.contains("8388480 pixels") && huge.contains("expected"), "{huge}");
    place.fails(2, &[&encode[..], &["--max-range", "1e-44"]].concat());
}

#[test]
fn unknown_extensions_are_bad_usage() {
    let place = Place::with_scan();
    place.write("scan.las", b"LASF");
    place.fine(&["encode", "scan.bin", "-o", "scan.flicr", "--columns", "256"]);
    place.fails_with(2, &["encode", "scan.las", "-o", "a.flicr"], "scan.las", &["expected", ".pcd"]);
    place.fails_with(2, &["eval", "scan.las"], "scan.las", &["expected", ".pcd"]);
    place.fails_with(2, &["info", "scan.las"], "scan.las", &["expected", ".pcd"]);
    place.fails_with(2, &["view", "scan.las", "-o", "a.png"], "scan.las", &["expected", ".pcd"]);
    place.fails_with(2, &["decode", "scan.flicr", "-o", "a.las"], "a.las", &["expected", ".ply"]);
    place.fails_with(2, &["simulate", "-o", "a.las"], "a.las", &["expected", ".ply"]);
}

#[test]
fn missing_files_are_bad_data() {
    let place = Place::new();
    for args in [
        &["encode", "no.bin", "-o", "a.flicr"][..],
        &["eval", "no.bin"],
        &["info", "no.bin"],
        &["view", "no.bin", "-o", "a.png"],
    ] {
        place.fails_with(1, args, "no.bin", &["No such file"]);
    }
    place.fails_with(1, &["decode", "no.flicr", "-o", "a.bin"], "no.flicr", &["No such file"]);
    place.fails_with(1, &["simulate", "-o", "no/a.bin"], "no/a.bin", &["No such file"]);
}

#[test]
fn a_length_that_is_no_multiple_of_16_is_bad_data() {
    let place = Place::with_scan();
    let scan = place.read("scan.bin");
    place.write("cut.bin", &scan[..1001]);
    for args in [&["encode", "cut.bin", "-o", "a.flicr"][..], &["eval", "cut.bin"], &["info", "cut.bin"]] {
        place.fails_with(1, args, "cut.bin", &["at byte 992", "found 9 bytes", "expected records of 16 bytes"]);
    }
    // The second of two inputs: the first has been encoded by then.
    place.fails(1, &["encode", "scan.bin", "cut.bin", "-o", "a.flicr"]);
    std::fs::create_dir(place.path("out")).unwrap();
    place.fails(1, &["encode", "scan.bin", "cut.bin", "-o", "out"]);
    assert_eq!(std::fs::read_dir(place.path("out")).unwrap().count(), 0);
}

#[test]
fn truncated_frames_are_bad_data() {
    let place = Place::with_scan();
    place.fine(&["encode", "scan.bin", "scan.bin", "-o", "f.flicr", "--columns", "256"]);
    let frames = place.read("f.flicr");
    let half = frames.len() / 2;
    for len in [0, 1, 4, 7, 63, 64, 75, half - 1, half + 1, half + 64, frames.len() - 1] {
        place.write("cut.flicr", &frames[..len]);
        place.fails_with(1, &["decode", "cut.flicr", "-o", "a.bin"], "cut.flicr", &[]);
        place.fails_with(1, &["view", "cut.flicr", "-o", "a.png"], "cut.flicr", &[]);
        place.fails_with(1, &["info", "cut.flicr"], "cut.flicr", &[]);
    }
    place.write("cut.flicr", &frames[..half + 64]);
    place.fails_with(1, &["decode", "cut.flicr", "-o", "a.bin"], "cut.flicr", &["frame 1", &format!("byte {half}")]);
}

#[test]
fn corrupt_frames_are_bad_data() {
    let place = Place::with_scan();
    place.fine(&["encode", "scan.bin", "scan.bin", "-o", "f.flicr", "--columns", "256"]);
    let frames = place.read("f.flicr");
    let second = frames.len() / 2;
    let flips = (0..64).chain([80, 1000, second - 1]).map(|at| second + at % second);
    for at in flips {
        let mut bad = frames.clone();
        bad[at] ^= 0x10;
        place.write("bad.flicr", &bad);
        place.fails_with(1, &["decode", "bad.flicr", "-o", "a.bin"], "bad.flicr", &["frame 1"]);
    }
    // The first frame is good, and is told of before the second is found bad.
    let info = place.run(&["info", "bad.flicr", "--json"]);
    assert_eq!((info.status.code(), String::from_utf8(info.stdout).unwrap().lines().count()), (Some(1), 1));
    let text = place.fails(1, &["decode", "scan.bin", "-o", "a.pcd"]);
    assert!(text.starts_with("flicr: scan.bin: frame 0 at byte 0: "), "{text}");
}

#[test]
fn frame_lengths_that_lie_are_bad_data() {
    let place = Place::with_scan();
    place.fine(&["encode", "scan.bin", "-o", "f.flicr", "--columns", "256"]);
    let frame = place.read("f.flicr");
    for len in [0_u32, 1, 63, 75, frame.len() as u32 - 1, frame.len() as u32 + 1, u32::MAX] {
        let mut bad = frame.clone();
        bad[8..12].copy_from_slice(&len.to_le_bytes());
        place.write("bad.flicr", &bad);
        place.fails_with(1, &["decode", "bad.flicr", "-o", "a.bin"], "bad.flicr", &[]);
    }
    place.write("more.flicr", &[frame.as_slice(), b"more"].concat());
    place.fails_with(1, &["decode", "more.flicr", "-o", "a.bin"], "more.flicr", &["frame 1"]);
}

#[test]
fn a_frame_that_is_not_there_is_bad_usage() {
    let place = Place::with_scan();
    place.fine(&["encode", "scan.bin", "-o", "f.flicr"]);
    place.fails_with(2, &["view", "f.flicr", "-o", "a.png", "--frame", "1"], "f.flicr", &["frame 1", "found 1"]);
}

#[test]
fn inputs_are_never_written_over() {
    let place = Place::with_scan();
    place.fine(&["encode", "scan.bin", "-o", "f.flicr"]);
    let (scan, frame) = (place.read("scan.bin"), place.read("f.flicr"));
    std::fs::create_dir(place.path("sub")).unwrap();
    place.fails_with(2, &["encode", "scan.bin", "-o", "scan.bin"], "scan.bin", &["input"]);
    place.fails_with(2, &["encode", "scan.bin", "-o", "sub/../scan.bin"], "sub/../scan.bin", &["input"]);
    place.fails_with(2, &["view", "scan.bin", "-o", "scan.bin"], "scan.bin", &["input"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("f.flicr", place.path("link.bin")).unwrap();
        place.fails_with(2, &["decode", "f.flicr", "-o", "link.bin"], "link.bin", &["input"]);
    }
    assert!(place.read("scan.bin") == scan && place.read("f.flicr") == frame);
}

#[test]
fn two_inputs_of_one_name_do_not_share_an_output() {
    let place = Place::with_scan();
    for folder in ["a", "b", "out"] {
        std::fs::create_dir(place.path(folder)).unwrap();
    }
    place.write("a/0.bin", &place.read("scan.bin"));
    place.write("b/0.bin", &place.read("scan.bin"));
    place.fails_with(2, &["encode", "a/0.bin", "b/0.bin", "-o", "out"], "out/0.flicr", &["two outputs"]);
    assert_eq!(std::fs::read_dir(place.path("out")).unwrap().count(), 0);
}

#[test]
fn a_failure_keeps_the_file_that_was_there() {
    let place = Place::with_scan();
    place.write("cut.bin", &[0; 17]);
    place.write("a.flicr", b"precious");
    place.fails(1, &["encode", "scan.bin", "cut.bin", "-o", "a.flicr"]);
    assert_eq!(place.read("a.flicr"), b"precious");
    place.fine(&["encode", "scan.bin", "-o", "a.flicr"]);
    assert!(place.read("a.flicr").starts_with(b"FLCR"));
}

#[cfg(unix)]
#[test]
fn devices_are_written_into_and_links_stay() {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    let place = Place::with_scan();
    place.fine(&["encode", "scan.bin", "-o", "/dev/null"]);
    assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    place.write("real.flicr", b"old");
    symlink("real.flicr", place.path("link.flicr")).unwrap();
    place.fine(&["encode", "scan.bin", "-o", "link.flicr"]);
    assert!(place.path("link.flicr").is_symlink());
    assert!(place.read("real.flicr").starts_with(b"FLCR"));
    // As readable as any file that is made with the user's mask.
    place.write("plain", b"");
    let mode = |name: &str| std::fs::metadata(place.path(name)).unwrap().permissions().mode() & 0o777;
    place.fine(&["encode", "scan.bin", "-o", "new.flicr"]);
    assert_eq!(mode("new.flicr"), mode("plain"));
}
