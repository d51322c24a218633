//! `flicr eval` says of a real scan what an independent implementation found.

use std::process::Command;

use crate::common::data;

pub fn the_papers_frame_of_a_kitti_scan() {
    let scan = data::path("kitti/drive/000000.bin");
    let mut program = Command::new(env!("CARGO_BIN_EXE_flicr"));
    let output = program.arg("eval").arg(&scan).args(["--preset", "paper", "--json"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let file_points = std::fs::metadata(&scan).unwrap().len() / 16;
    assert_eq!(object["points"], file_points - 1, "one point is at the origin");
    let (lost, psnr_db) = (object["se"].as_f64().unwrap(), object["psnr_db"].as_f64().unwrap());
    assert!((0.068..0.076).contains(&lost), "{lost}");
    assert!((58.0..58.8).contains(&psnr_db), "{psnr_db}");
}
