//! Scans out of files, whatever their format.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flicr::files::{self, Format, PointCloud};

use crate::failure::Failure;

/// What the reading commands say of their input.
pub const SCAN_EXTENSIONS: &str = ".bin, .xyzir.bin or .pcd";

/// One turn of a sensor.
#[derive(Debug, Clone, Default)]
pub struct Scan {
    /// As the file has them, points at the origin (no return) included.
    pub cloud: PointCloud,
    /// When the turn began; 0 where the file does not say.
    pub timestamp_ns: u64,
}

impl Scan {
    /// The points that something was measured at: not at the origin, not NaN. As the library counts them.
    pub fn returns(&self) -> Vec<[f32; 3]> {
        let measured = |&&[x, y, z]: &&[f32; 3]| {
            [x, y, z].iter().all(|coordinate| coordinate.is_finite()) && x * x + y * y + z * z > 0.0
        };
        self.cloud.points.iter().filter(measured).copied().collect()
    }
}

/// The scans of a file, one after the other. Point files hold one each.
pub fn scans(file: &Path) -> Result<impl Iterator<Item = Result<Scan, Failure>>, Failure> {
    check_scan_extension(file)?;
    let cloud = files::read(file)?;
    Ok(std::iter::once(Ok(Scan { cloud, timestamp_ns: 0 })))
}

/// Refuses what [`scans`] would not know how to read, before any work is done.
pub fn check_scan_extension(file: &Path) -> Result<(), Failure> {
    match Format::of(file) {
        Some(Format::Kitti | Format::KittiRing | Format::Pcd) => Ok(()),
        _ => Err(Failure::usage(file, format_args!("unknown kind of file: expected {SCAN_EXTENSIONS}"))),
    }
}

/// As [`check_scan_extension`], for many.
pub fn check_scan_extensions(files: &[PathBuf]) -> Result<(), Failure> {
    files.iter().try_for_each(|file| check_scan_extension(file))
}

/// Whether a file holds frames: by its name, else by its first bytes.
pub fn holds_frames(file: &Path) -> Result<bool, Failure> {
    if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("flicr")) {
        return Ok(true);
    }
    let mut start = Vec::new();
    let read = File::open(file).and_then(|open| open.take(4).read_to_end(&mut start));
    read.map_err(|error| Failure::data(file, error))?;
    Ok(start == flicr::frame::MAGIC)
}
