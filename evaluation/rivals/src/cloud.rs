//! KITTI's files: four little-endian floats a point.

use std::io::{Error, ErrorKind, Result};
use std::path::Path;

pub fn read(path: &Path) -> Result<Vec<[f32; 4]>> {
    let bytes = std::fs::read(path)?;
    if !bytes.len().is_multiple_of(16) {
        return Err(Error::new(ErrorKind::InvalidData, format!("{}: no KITTI scan", path.display())));
    }
    Ok(bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect())
}

/// What something was measured at: a point at the origin is no return, and no system is to spend anything on it.
#[cfg(feature = "codecs")]
pub fn returns(scan: &[[f32; 4]]) -> Vec<[f32; 3]> {
    scan.iter().filter(|&&[x, y, z, _]| x * x + y * y + z * z > 0.0).map(|&[x, y, z, _]| [x, y, z]).collect()
}

pub fn write(path: &Path, points: &[[f32; 3]]) -> Result<()> {
    let records: Vec<[f32; 4]> = points.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
    std::fs::write(path, bytemuck::cast_slice(&records))
}
