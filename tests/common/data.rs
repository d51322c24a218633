//! Real scans, where they are at hand: `FLICR_DATA`, else `../shared/data` beside the crate.

#![allow(dead_code, reason = "each test uses a part")]

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// The folder that holds the shared data, if it is there.
pub static FOLDER: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    Some(std::env::var_os("FLICR_DATA").map_or_else(beside, PathBuf::from)).filter(|folder| folder.is_dir())
});

/// A file of the shared data.
pub fn path(name: &str) -> PathBuf {
    FOLDER.as_ref().expect("tests run only where there is data").join(name)
}

/// One turn of a sensor.
pub struct Scan {
    pub name: String,
    /// x, y, z, intensity, as in the file.
    pub points: Vec<[f32; 4]>,
}

/// The 29 full raw KITTI scans: paper/0 and 1, object, drive.
pub static KITTI: LazyLock<Vec<Scan>> = LazyLock::new(|| {
    let paper = ["kitti/paper/0.bin", "kitti/paper/1.bin"].map(String::from);
    let object = (0..3).map(|number| format!("kitti/object/{number:06}.bin"));
    let drive = (0..24).map(|number| format!("kitti/drive/{number:06}.bin"));
    paper.into_iter().chain(object).chain(drive).map(read).collect()
});

/// One that is cut: of 49 of the beams.
static KITTI_CUT: LazyLock<Scan> = LazyLock::new(|| read("kitti/paper/4.bin".into()));

/// All raw KITTI scans.
pub fn all_kitti() -> impl Iterator<Item = &'static Scan> {
    KITTI.iter().chain([&*KITTI_CUT])
}

fn read(name: String) -> Scan {
    Scan { points: read_points(&path(&name)), name }
}

/// The points of a KITTI file.
pub fn read_points(path: &Path) -> Vec<[f32; 4]> {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert_eq!(bytes.len() % 16, 0, "{} is no KITTI scan", path.display());
    bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect()
}

/// The middle one; `values` must not be empty.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
