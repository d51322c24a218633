//! PLY, written as `binary_little_endian 1.0`: one `vertex` element with x, y, z, and intensity and ring if known.
//!
//! Source: Greg Turk, "The PLY Polygon File Format", 1994.

use std::io::{self, Write};

use super::{PointCloud, record};

/// Writes a cloud: 12 bytes a point, 4 more with intensities (`float`), 2 more with rings (`ushort`).
///
/// # Errors
/// `out`'s own, and `InvalidInput` if there are intensities or rings, but not one a point.
///
/// ```
/// use flicr::files::{PointCloud, ply};
///
/// let mut bytes = Vec::new();
/// ply::write(&mut bytes, &PointCloud { points: vec![[1.0, 2.0, 3.0]; 7], ..Default::default() })?;
/// assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\nelement vertex 7\n"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write(out: &mut impl Write, cloud: &PointCloud) -> io::Result<()> {
    cloud.check_lengths()?;
    write_header(out, cloud)?;
    record::write_all(out, cloud)
}

fn write_header(out: &mut impl Write, cloud: &PointCloud) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {}", cloud.points.len())?;
    writeln!(out, "property float x\nproperty float y\nproperty float z")?;
    if cloud.intensities.is_some() {
        writeln!(out, "property float intensity")?;
    }
    if cloud.rings.is_some() {
        writeln!(out, "property ushort ring")?;
    }
    writeln!(out, "end_header")
}
