//! The inverse direction: a frame's sections are found and read.

use std::vec::Vec;

use super::intensity::{self, IntensityImage};
use super::times;
use super::{SECTION_HEADER_LEN, SectionKind};
use crate::error::{DecodeError, PayloadFault};
use crate::frame::ParsedFrame;
use crate::image::Level;

/// What a frame carried besides ranges.
#[derive(Debug, Default)]
pub(crate) struct DecodedPlanes {
    pub(crate) intensity: IntensityImage,
    pub(crate) times_ns: Option<Vec<u64>>,
    /// The body of the section of the original file.
    pub(crate) original: Option<Vec<u8>>,
}

impl DecodedPlanes {
    /// Reads the sections of a frame whose levels are decoded.
    pub(crate) fn decode<L: Level>(&mut self, parsed: &ParsedFrame<'_>, levels: &[L]) -> Result<(), DecodeError> {
        self.intensity.scale = None;
        self.times_ns = None;
        self.original = None;
        if !parsed.has_sections() {
            return Ok(());
        }
        let mut strips = Vec::new();
        for strip in parsed.strips() {
            let strip = strip?;
            strips.push((usize::from(strip.first_column), usize::from(strip.columns)));
        }
        let is_return: Vec<bool> = levels.iter().map(|&level| level != L::NONE).collect();
        let bytes = parsed.behind_strips();
        if bytes.is_empty() {
            return Err(DecodeError::Truncated { need: SECTION_HEADER_LEN, have: 0 });
        }
        for section in sections(bytes) {
            let (kind, body) = section?;
            let fault = |fault| DecodeError::Section { kind: kind as u8, fault };
            match kind {
                SectionKind::Times => {
                    let times_ns = self.times_ns.insert(Vec::new());
                    times::decode(body, parsed.header.timestamp_ns, &strips, times_ns).map_err(fault)?;
                }
                SectionKind::Original => self.original = Some(body.to_vec()),
                // Read before the levels.
                SectionKind::Previous => {}
                SectionKind::Intensity => {
                    let rows = parsed.header.rows.into();
                    intensity::decode(body, rows, &strips, &is_return, &mut self.intensity).map_err(fault)?;
                }
            }
        }
        Ok(())
    }
}

/// The sections in `bytes`, which are all of them; checked to ascend.
pub(crate) fn sections(mut bytes: &[u8]) -> impl Iterator<Item = Result<(SectionKind, &[u8]), DecodeError>> + use<'_> {
    let mut last = None;
    core::iter::from_fn(move || {
        if bytes.is_empty() {
            return None;
        }
        let section = next_section(&mut bytes, &mut last);
        if section.is_err() {
            bytes = &[];
        }
        Some(section)
    })
}

fn next_section<'a>(
    bytes: &mut &'a [u8],
    last: &mut Option<SectionKind>,
) -> Result<(SectionKind, &'a [u8]), DecodeError> {
    let have = bytes.len();
    let truncated = |need| DecodeError::Truncated { need, have };
    let (&[kind, r0, r1, r2, l0, l1, l2, l3], rest) =
        bytes.split_first_chunk::<SECTION_HEADER_LEN>().ok_or(truncated(SECTION_HEADER_LEN))?;
    let malformed = DecodeError::Section { kind, fault: PayloadFault::Malformed };
    let found = SectionKind::from_byte(kind).filter(|found| Some(*found) > *last && [r0, r1, r2] == [0; 3]);
    let found = found.ok_or(malformed)?;
    *last = Some(found);
    let len = u32::from_le_bytes([l0, l1, l2, l3]) as usize;
    let (body, rest) = rest.split_at_checked(len).ok_or(truncated(SECTION_HEADER_LEN.saturating_add(len)))?;
    *bytes = rest;
    Ok((found, body))
}

/// The strips' parts of a section.
pub(crate) struct Parts<'a> {
    bytes: &'a [u8],
}

impl<'a> Parts<'a> {
    pub(crate) const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    pub(crate) fn next(&mut self) -> Result<&'a [u8], PayloadFault> {
        let (&len, rest) = self.bytes.split_first_chunk().ok_or(PayloadFault::TooShort)?;
        let (part, rest) = rest.split_at_checked(u32::from_le_bytes(len) as usize).ok_or(PayloadFault::TooShort)?;
        self.bytes = rest;
        Ok(part)
    }

    pub(crate) fn finish(self) -> Result<(), PayloadFault> {
        if self.bytes.is_empty() { Ok(()) } else { Err(PayloadFault::TooLong) }
    }
}
