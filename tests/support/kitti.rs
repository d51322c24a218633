//! Real scans, where they are at hand: `FLICR_DATA`, else `../shared/data` beside the crate.

use std::path::{Path, PathBuf};

fn data() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    std::env::var_os("FLICR_DATA").map_or_else(beside, PathBuf::from)
}

fn is_scan(path: &Path) -> bool {
    let full = !path.ends_with("paper/4.bin");
    full && path.extension().is_some_and(|extension| extension == "bin")
}

/// All full raw KITTI scans, or nothing and a line that says so.
pub fn full_scans() -> Option<impl Iterator<Item = Vec<[f32; 4]>>> {
    let mut paths: Vec<PathBuf> = ["drive", "object", "paper"]
        .iter()
        .filter_map(|folder| std::fs::read_dir(data().join("kitti").join(folder)).ok())
        .flatten()
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| is_scan(path))
        .collect();
    paths.sort();
    if paths.is_empty() {
        println!("skipped: no KITTI scans in {}", data().display());
        return None;
    }
    Some(paths.into_iter().map(|path| read(&path)))
}

/// The fitted beam table, five numbers a beam, or nothing and a line that says so.
pub fn beam_table() -> Option<Vec<[f64; 5]>> {
    let path = data().join("kitti/hdl64e_kitti_beams.csv");
    let Ok(text) = std::fs::read_to_string(&path) else {
        println!("skipped: no {}", path.display());
        return None;
    };
    let number = |cell: &str| cell.parse::<f64>().expect("a table of numbers");
    let row = |line: &str| line.split(',').skip(1).map(number).collect::<Vec<f64>>();
    let five = |line: &str| row(line).try_into().expect("five numbers a beam");
    Some(text.lines().skip(1).map(five).collect())
}

fn read(path: &Path) -> Vec<[f32; 4]> {
    let bytes = std::fs::read(path).expect("a scan that can be listed can be read");
    let (points, rest) = bytes.as_chunks::<16>();
    assert!(rest.is_empty(), "{} is no KITTI scan", path.display());
    let float = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("four bytes"));
    points
        .iter()
        .map(|point| [0, 4, 8, 12].map(|at| float(&point[at..at + 4])))
        // One point at the origin in each drive scan is no return.
        .filter(|point| point[0].abs() + point[1].abs() > 0.3)
        .collect()
}
