//! The file that a frame was made from, byte for byte: order, digits and intensities of its points.
//!
//! A raw scan of a spinning sensor is a grid's points, rounded to millimeters, in order of beam and azimuth. A frame that
//! keeps the grid without loss gives nearly all of that back; what is left goes into a section of its own: the few
//! coordinates that round another way, the few points out of order, and the points that the grid does not have, as they are.
//!
//! ```text
//! decoded frame ──> returns ──> corrections ──> order ──> points off the grid ──> file
//!                   f64, by     a unit or       rows by   x, y, z, intensity,
//!                   pixels      so, rarely      azimuth   where they were
//! ```

mod code;
mod corrections;
mod order;
mod returns;

use core::fmt;
use std::vec::Vec;

pub(crate) use returns::FrameReturn;

use crate::decoder::{Decoder, Frame, Limits};
use crate::error::{DecodeError, PayloadFault};
use crate::plane::{SectionKind, append_section};

/// Bytes of a point in a file: x, y, z, intensity, each a little-endian `f32`.
pub(crate) const RECORD_LEN: usize = 16;
/// Of so many points one may be stored as it is; with more, the frame is no gain.
const POINTS_PER_STRANGER: usize = 16;
/// So many may always.
const STRANGERS_MIN: usize = 16;

/// Why a file cannot be given back byte for byte.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum NotExact {
    /// The file is not made of records of four floats.
    Length {
        /// Bytes of the file.
        found: usize,
    },
    /// Too many points are not those of the frame, rounded to millimeters and with its intensities.
    OffGrid {
        /// Points that are not.
        found: usize,
        /// Points of the file.
        points: usize,
        /// The first of them: its place in the file, and x, y, z and intensity.
        first: (usize, [f32; 4]),
    },
    /// The frame cannot be decoded, or has such a section already.
    Frame(DecodeError),
    /// What came back differed. No file is known to do this.
    Differs,
}

impl fmt::Display for NotExact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { found } => write!(f, "found {found} bytes, expected records of {RECORD_LEN}"),
            Self::OffGrid { found, points, first: (at, point) } => write!(
                f,
                "{found} of {points} points are not on the sensor's grid, rounded to millimeters, or lie where another is: the \
                 first is point {at}, {point:?}"
            ),
            Self::Frame(error) => error.fmt(f),
            Self::Differs => f.write_str("what came back differed"),
        }
    }
}

impl core::error::Error for NotExact {}

impl From<DecodeError> for NotExact {
    fn from(error: DecodeError) -> Self {
        Self::Frame(error)
    }
}

/// Has a frame give back the bytes of the KITTI file (`.bin`) that it was made from: adds the section that
/// [`Frame::original`] reads. The frame should keep the points' levels and intensities without loss, on the sensor's own grid:
/// what it does not tell is stored as it is.
///
/// That the bytes come back is checked. Time: about that of decoding the frame and sorting its points, twice.
///
/// # Errors
/// [`NotExact`]; the frame is then as it was.
pub fn append(frame: &mut Vec<u8>, file: &[u8]) -> Result<(), NotExact> {
    let (records, rest) = file.as_chunks::<RECORD_LEN>();
    if !rest.is_empty() {
        return Err(NotExact::Length { found: file.len() });
    }
    let mut decoder = Decoder::new(Limits { frame_len: usize::MAX, pixels: usize::MAX });
    let body = {
        let decoded = decoder.decode(frame)?;
        code::encode(&decoded.returns(), records)?
    };
    let mut longer = frame.clone();
    append_section(&mut longer, SectionKind::Original, &body);
    if decoder.decode(&longer)?.original()?.as_deref() != Some(file) {
        return Err(NotExact::Differs);
    }
    *frame = longer;
    Ok(())
}

/// The file's bytes.
pub(crate) fn decode(frame: &Frame<'_>, body: &[u8]) -> Result<Vec<u8>, PayloadFault> {
    code::decode(&frame.returns(), body)
}
