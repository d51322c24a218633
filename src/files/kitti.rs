//! KITTI's `.bin`: nothing but records of little-endian `f32`: x, y, z, intensity, meters; with rings a fifth, the ring.
//!
//! Source: KITTI raw data development kit, `readme.txt`, "Velodyne 3D laser scan data".

use std::io::{self, Write};

use super::error::counted;
use super::{Fault, ParseError, PointCloud, record};

/// Bytes of a point: x, y, z, intensity.
const RECORD_LEN: usize = 16;
/// Bytes of a point with its ring.
const RECORD_WITH_RING_LEN: usize = 20;

/// Parses x, y, z, intensity. No bytes are a cloud of no points.
///
/// # Errors
/// [`Fault::Length`] if the length is not a multiple of 16.
pub fn parse(bytes: &[u8]) -> Result<PointCloud, ParseError> {
    let records = records::<RECORD_LEN>(bytes)?;
    Ok(PointCloud {
        points: records.iter().map(|record| [0, 1, 2].map(|index| float(record, index))).collect(),
        intensities: Some(records.iter().map(|record| float(record, 3)).collect()),
        rings: None,
    })
}

/// Parses x, y, z, intensity, ring, all of them `f32`.
///
/// # Errors
/// [`Fault::Length`] if the length is not a multiple of 20, [`Fault::Value`] if a ring is no whole number from 0 to
/// 65535.
pub fn parse_with_rings(bytes: &[u8]) -> Result<PointCloud, ParseError> {
    let records = records::<RECORD_WITH_RING_LEN>(bytes)?;
    let ring = |(index, record)| {
        let offset = index * RECORD_WITH_RING_LEN + RECORD_LEN;
        record::ring(f64::from(float(record, 4)), offset)
    };
    Ok(PointCloud {
        points: records.iter().map(|record| [0, 1, 2].map(|index| float(record, index))).collect(),
        intensities: Some(records.iter().map(|record| float(record, 3)).collect()),
        rings: Some(records.iter().enumerate().map(ring).collect::<Result<_, _>>()?),
    })
}

/// Parses four floats a point or five, whichever they are: nuScenes and others write the ring behind x, y, z and
/// intensity under the same name.
///
/// They are five where the length allows it and every fifth is a whole number that can be a ring, more than one number
/// among them: coordinates, of which one in five would stand there if there were four, are not.
///
/// # Errors
/// As [`parse`], where they are not five.
pub fn parse_either(bytes: &[u8]) -> Result<PointCloud, ParseError> {
    if holds_rings(bytes) { parse_with_rings(bytes) } else { parse(bytes) }
}

/// More beams than any sensor has.
const RINGS: f32 = 1024.0;

fn holds_rings(bytes: &[u8]) -> bool {
    let (records, rest) = bytes.as_chunks::<RECORD_WITH_RING_LEN>();
    let mut rings = records.iter().map(|record| float(record, 4));
    let is_ring = |ring: f32| (0.0..RINGS).contains(&ring) && ring.fract() == 0.0;
    let first = rings.clone().next();
    rest.is_empty() && rings.clone().all(is_ring) && rings.any(|ring| Some(ring) != first)
}

/// Writes x, y, z, intensity: 16 bytes a point. A cloud without intensities gets zeros; the format has no rings.
///
/// # Errors
/// `out`'s own, and `InvalidInput` if there are intensities, but not one a point.
pub fn write(out: &mut impl Write, cloud: &PointCloud) -> io::Result<()> {
    cloud.check_lengths()?;
    for (index, &[x, y, z]) in cloud.points.iter().enumerate() {
        record::write_floats(out, &[x, y, z, cloud.intensity(index)])?;
    }
    Ok(())
}

/// Writes x, y, z, intensity, ring: 20 bytes a point. What the cloud lacks gets zeros.
///
/// # Errors
/// As [`write()`].
pub fn write_with_rings(out: &mut impl Write, cloud: &PointCloud) -> io::Result<()> {
    cloud.check_lengths()?;
    for (index, &[x, y, z]) in cloud.points.iter().enumerate() {
        let ring = f32::from(cloud.ring(index));
        record::write_floats(out, &[x, y, z, cloud.intensity(index), ring])?;
    }
    Ok(())
}

fn records<const LEN: usize>(bytes: &[u8]) -> Result<&[[u8; LEN]], ParseError> {
    let (records, rest) = bytes.as_chunks::<LEN>();
    if rest.is_empty() {
        return Ok(records);
    }
    let points = counted(records.len(), "point");
    let found = std::format!("{} after {points}", counted(rest.len(), "byte"));
    let expected = std::format!("records of {LEN} bytes");
    Err(ParseError::new(Fault::Length, records.len() * LEN, found, expected))
}

fn float<const LEN: usize>(record: &[u8; LEN], index: usize) -> f32 {
    let mut bytes = [0; 4];
    bytes.copy_from_slice(&record[4 * index..4 * index + 4]);
    f32::from_le_bytes(bytes)
}
