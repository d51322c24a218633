//! Progress is for terminals only, and a reader who leaves early is no failure.

use std::process::{Command, Stdio};

use super::run::{Place, without_notes};

#[test]
fn no_progress_where_no_terminal_watches() {
    let place = Place::new();
    // `fine` checks that stderr is empty but for notes.
    place.fine(&["simulate", "-o", "t.bin", "--turns", "2"]);
    let stdout = place.fine(&["encode", "t-000000.bin", "t-000001.bin", "-o", "t.flicr"]);
    assert!(!stdout.contains('\u{1b}') && !stdout.contains('\r'));
    place.fine(&["decode", "t.flicr", "-o", "back.bin"]);
    let stdout = place.fine(&["eval", "t-000000.bin", "t-000001.bin", "--columns", "256"]);
    assert!(!stdout.contains('\u{1b}') && !stdout.contains('\r'));
}

/// `script` (util-linux) runs a command on a terminal of its own.
#[cfg(target_os = "linux")]
#[test]
fn progress_where_a_terminal_watches() {
    let place = Place::new();
    let command = format!("{} simulate -o t.bin --turns 2", env!("CARGO_BIN_EXE_flicr"));
    let on_terminal = Command::new("script")
        .args(["-qec", &command, "/dev/null"])
        .env("TERM", "xterm")
        .current_dir(place.folder())
        .stdin(Stdio::null())
        .output();
    let output = on_terminal.expect("`script`, which every Linux has, to make a terminal with");
    let seen = String::from_utf8_lossy(&output.stdout);
    assert!(seen.contains("simulating") && seen.contains("/2"), "{seen:?}");
    assert_eq!(place.names().len(), 2);
}

#[cfg(unix)]
#[test]
fn a_reader_who_leaves_early_is_no_failure() {
    let place = Place::with_scan();
    let flicr = env!("CARGO_BIN_EXE_flicr");
    let run = |args: &str| {
        // The reader is gone before the first line is written.
        let pipe = format!("{flicr} {args} 2>errors | true; test ${{PIPESTATUS[0]}} = 0");
        let status = Command::new("bash").args(["-c", &pipe]).current_dir(place.folder()).status().unwrap();
        assert!(status.success(), "{args}");
        let errors = String::from_utf8(place.read("errors")).unwrap();
        assert_eq!(without_notes(&errors).1, "", "{args}");
    };
    run("eval scan.bin --json --columns 256");
    run("encode scan.bin -o f.flicr");
    assert!(place.read("f.flicr").starts_with(b"FLCR"));
}
