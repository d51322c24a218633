//! What the formats' records have in common.

use std::io::{self, Write};

use super::{Fault, ParseError, PointCloud};

/// A ring as the formats hold it, as an integer.
pub(super) fn ring(value: f64, offset: usize) -> Result<u16, ParseError> {
    let whole = value.fract() == 0.0 && (0.0..=f64::from(u16::MAX)).contains(&value);
    if !whole {
        let found = std::format!("a ring of {value}");
        return Err(ParseError::new(Fault::Value, offset, found, "a whole number from 0 to 65535"));
    }
    Ok(value as u16)
}

/// Little-endian, one after the other.
pub(super) fn write_floats(out: &mut impl Write, values: &[f32]) -> io::Result<()> {
    values.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))
}

/// The records of PCD and PLY: x, y, z, the intensity if there are any, the ring as `u16` if there are any.
pub(super) fn write_all(out: &mut impl Write, cloud: &PointCloud) -> io::Result<()> {
    for (index, point) in cloud.points.iter().enumerate() {
        write_floats(out, point)?;
        if cloud.intensities.is_some() {
            write_floats(out, &[cloud.intensity(index)])?;
        }
        if cloud.rings.is_some() {
            out.write_all(&cloud.ring(index).to_le_bytes())?;
        }
    }
    Ok(())
}
