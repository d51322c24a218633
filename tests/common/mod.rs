//! What several tests need: the shared scans where they are, and a scan that needs no data.
#![allow(dead_code, reason = "each test uses a part")]

use std::path::PathBuf;

/// The folder of shared scans, or `None` and one line that says so: the caller returns, having tested nothing.
pub fn data_dir(test: &str) -> Option<PathBuf> {
    let dir = std::env::var_os("FLICR_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    if dir.is_dir() {
        return Some(dir);
    }
    // Written past the test harness's capture, so that a skip is never silent.
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "skipped: {test}: no scans at {} (set FLICR_DATA)", dir.display());
    None
}

/// The 29 full raw KITTI scans: paper/0 and 1, object, drive.
pub fn full_scans(test: &str) -> Vec<(String, Vec<[f32; 4]>)> {
    let Some(dir) = data_dir(test) else { return Vec::new() };
    let object = (0..3).map(|n| format!("kitti/object/{n:06}.bin"));
    let drive = (0..24).map(|n| format!("kitti/drive/{n:06}.bin"));
    let paper = ["kitti/paper/0.bin", "kitti/paper/1.bin"].map(String::from);
    let names = paper.into_iter().chain(object).chain(drive);
    names.map(|name| (name.clone(), read_scan(&dir.join(&name)))).collect()
}

pub fn read_scan(path: &std::path::Path) -> Vec<[f32; 4]> {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect()
}

pub fn xyz(points: &[[f32; 4]]) -> Vec<[f32; 3]> {
    points.iter().map(|&[x, y, z, _]| [x, y, z]).collect()
}

pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Points all around at all ranges, a few thousand, the same every time: a spiral over the sphere's band.
pub fn spiral(points: usize) -> Vec<[f32; 3]> {
    (0..points)
        .map(|i| {
            let t = i as f64 / points as f64;
            let (azimuth, elevation) = (t * 977.0, (2.0 - 26.8 * ((t * 64.0) % 1.0)).to_radians());
            let range = 1.0 + 78.0 * ((t * 313.7) % 1.0);
            let ground = range * elevation.cos();
            [ground * azimuth.cos(), ground * azimuth.sin(), range * elevation.sin()].map(|v| v as f32)
        })
        .collect()
}
