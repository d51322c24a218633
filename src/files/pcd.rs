//! PCD, the point cloud library's format, version 0.5 to 0.7.
//!
//! Read: `DATA ascii`, `binary` and `binary_compressed`; fields in any order, type and size, those of other names
//! skipped. x, y and z must be there; the intensity is taken from a field `intensity` or `i`, the ring from `ring` or
//! `channel`. Points are as the file has them: the viewpoint is not applied, organized clouds keep their NaN points.
//! Written: `DATA binary`.
//!
//! Source: <https://pointclouds.org/documentation/tutorials/pcd_file_format.html>; the compressed form, as PCL
//! writes it, is two little-endian `u32` (compressed and plain length) and an LZF stream of the fields, each of all
//! points, one field after the other.

mod data;
mod header;
mod lzf;

use std::io::{self, Write};

use super::{ParseError, PointCloud, record};
use header::Header;

/// Parses a PCD file. Takes memory for the points that the input holds, whatever its header claims; a compressed one
/// is held once more as it was before compression.
///
/// # Errors
/// [`Header`](super::Fault::Header), [`Fields`](super::Fault::Fields) and [`PointCount`](super::Fault::PointCount) for
/// a header that is none; [`Truncated`](super::Fault::Truncated) and [`TrailingBytes`](super::Fault::TrailingBytes) if
/// the data are not of the length it promises (zeros may follow them: PCL pads its files); [`Value`](super::Fault::Value) for text that is no number and rings out
/// of range; [`Compressed`](super::Fault::Compressed) for a broken LZF stream.
pub fn parse(bytes: &[u8]) -> Result<PointCloud, ParseError> {
    let header = Header::parse(bytes)?;
    data::parse(bytes, &header)
}

/// Writes a cloud as binary PCD 0.7: 12 bytes a point, 4 more with intensities (`F 4`), 2 more with rings (`U 2`).
///
/// # Errors
/// `out`'s own, and `InvalidInput` if there are intensities or rings, but not one a point.
pub fn write(out: &mut impl Write, cloud: &PointCloud) -> io::Result<()> {
    cloud.check_lengths()?;
    write_header(out, cloud)?;
    record::write_all(out, cloud)
}

fn write_header(out: &mut impl Write, cloud: &PointCloud) -> io::Result<()> {
    let intensity = if cloud.intensities.is_some() { [" intensity", " 4", " F", " 1"] } else { [""; 4] };
    let ring = if cloud.rings.is_some() { [" ring", " 2", " U", " 1"] } else { [""; 4] };
    let points = cloud.points.len();
    writeln!(out, "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7")?;
    writeln!(out, "FIELDS x y z{}{}", intensity[0], ring[0])?;
    writeln!(out, "SIZE 4 4 4{}{}", intensity[1], ring[1])?;
    writeln!(out, "TYPE F F F{}{}", intensity[2], ring[2])?;
    writeln!(out, "COUNT 1 1 1{}{}", intensity[3], ring[3])?;
    writeln!(out, "WIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA binary")
}
