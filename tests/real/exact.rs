//! `--exact` on every shared raw KITTI scan: byte for byte, and at least 12 times smaller in the middle.

use std::process::Command;

use crate::common::data::{self, median};

fn flicr(args: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_flicr")).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

pub fn raw_scans_come_back_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let raw = data::KITTI.iter().filter(|scan| !scan.name.contains("object"));
    let ratios: Vec<f64> = raw
        .map(|scan| {
            let file = data::path(&scan.name);
            flicr(&["encode", &file.display().to_string(), "-o", &path("f.flicr"), "--exact"]);
            flicr(&["decode", &path("f.flicr"), "-o", &path("back.bin")]);
            let bytes = std::fs::read(&file).unwrap();
            assert!(std::fs::read(path("back.bin")).unwrap() == bytes, "{}", scan.name);
            bytes.len() as f64 / std::fs::metadata(path("f.flicr")).unwrap().len() as f64
        })
        .collect();
    let middle = median(ratios.iter().copied());
    println!("{} scans, ratio {middle:.2}, least {:.2}", ratios.len(), ratios.iter().copied().fold(f64::MAX, f64::min));
    assert!(middle >= 12.0);
}
