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
