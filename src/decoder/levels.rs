//! Payloads to the levels of an image, strip by strip.

use std::vec::Vec;

use crate::coder::context::{Allowed, Recall};
use crate::coder::{self, CoderId};
use crate::error::{DecodeError, PayloadFault};
use crate::frame::{Header, ParsedFrame, Strip};
use crate::image::{ImageViewMut, Level};
use crate::parallel;

/// The levels of a decoded image, row-major, 0 = no return.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Levels {
    /// Of up to 8 bits.
    U8(Vec<u8>),
    /// Of 9 to 16 bits.
    U16(Vec<u16>),
}

impl Default for Levels {
    fn default() -> Self {
        Self::U8(Vec::new())
    }
}

impl Levels {
    /// Made those of the header's levels.
    fn fit(&mut self, header: &Header) {
        let fits_u8 = header.quantizer.level_bits() <= u8::BITS;
        if fits_u8 != matches!(self, Self::U8(_)) {
            *self = if fits_u8 { Self::U8(Vec::new()) } else { Self::U16(Vec::new()) };
        }
    }

    pub(super) fn decode(
        &mut self,
        parsed: &ParsedFrame<'_>,
        gathered: &mut Self,
        memory: Option<&mut Vec<u16>>,
    ) -> Result<(), DecodeError> {
        self.fit(&parsed.header);
        gathered.fit(&parsed.header);
        match (self, gathered) {
            (Self::U8(levels), Self::U8(gathered)) => decode_levels(parsed, levels, gathered, memory),
            (Self::U16(levels), Self::U16(gathered)) => decode_levels(parsed, levels, gathered, memory),
            _ => Ok(()),
        }
    }
}

fn decode_levels<L: Level>(
    parsed: &ParsedFrame<'_>,
    levels: &mut Vec<L>,
    gathered: &mut Vec<L>,
    memory: Option<&mut Vec<u16>>,
) -> Result<(), DecodeError> {
    let header = &parsed.header;
    let strips = parsed.strips().collect::<Result<Vec<_>, _>>()?;
    let decode = |(number, payload, levels, memory): (u32, &[u8], &mut [L], Option<&mut Vec<u16>>)| {
        let columns = levels.len() / usize::from(header.rows);
        let mut recall =
            memory.and_then(|memory| Some(Recall::new(ImageViewMut::new(memory.as_mut_slice(), columns)?, true)));
        decode_payload(header, payload, levels, recall.as_mut())
            .map_err(|fault| DecodeError::Payload { strip: number, fault })
    };
    if let [strip] = strips[..] {
        emptied(levels, header.pixels());
        return decode((0, strip.payload, levels, memory));
    }
    emptied(gathered, header.pixels());
    let mut memories: Vec<Option<Vec<u16>>> =
        strips.iter().map(|strip| memory.as_deref().map(|memory| cut(memory, header.columns.into(), strip))).collect();
    let (mut pieces, mut rest) = (Vec::with_capacity(strips.len()), gathered.as_mut_slice());
    for ((number, strip), memory) in (0..).zip(&strips).zip(&mut memories) {
        let (own, after) = rest.split_at_mut(usize::from(header.rows) * usize::from(strip.columns));
        pieces.push((number, strip.payload, own, memory.as_mut()));
        rest = after;
    }
    parallel::try_for_each(pieces, decode)?;
    if let Some(memory) = memory {
        let memories: Vec<u16> = memories.into_iter().flatten().flatten().collect();
        place_strips(&strips, &memories, header.columns.into(), memory);
    }
    // Every pixel is written: strips cover all columns.
    levels.resize(header.pixels(), L::NONE);
    place_strips(&strips, gathered, header.columns.into(), levels);
    Ok(())
}

/// A strip's part of an image, row-major.
fn cut(levels: &[u16], columns: usize, strip: &Strip<'_>) -> Vec<u16> {
    let (first, width) = (usize::from(strip.first_column), usize::from(strip.columns));
    levels.chunks_exact(columns).flat_map(|row| &row[first..first + width]).copied().collect()
}

fn emptied<L: Level>(levels: &mut Vec<L>, len: usize) {
    levels.clear();
    levels.resize(len, L::NONE);
}

/// Puts strips side by side.
fn place_strips<L: Level>(strips: &[Strip<'_>], gathered: &[L], columns: usize, levels: &mut [L]) {
    let rows = levels.len() / columns;
    let rows_a_piece = rows.div_ceil(parallel::pieces(rows));
    let pieces: Vec<_> = levels.chunks_mut(rows_a_piece * columns).enumerate().collect();
    parallel::for_each(pieces, |(piece, levels)| {
        for (row, levels) in (piece * rows_a_piece..).zip(levels.chunks_exact_mut(columns)) {
            for strip in strips {
                let (first, width) = (usize::from(strip.first_column), usize::from(strip.columns));
                levels[first..first + width].copy_from_slice(&gathered[rows * first + row * width..][..width]);
            }
        }
    });
}

fn decode_payload<L: Level>(
    header: &Header,
    payload: &[u8],
    levels: &mut [L],
    recall: Option<&mut Recall<'_>>,
) -> Result<(), PayloadFault> {
    let max = header.quantizer.max_level();
    match header.coder {
        CoderId::Store => coder::store::decode(payload, levels)?,
        CoderId::Rle => coder::rle::decode(payload, levels)?,
        CoderId::Deflate => coder::inflate::decode(payload, levels)?,
        CoderId::Context => {
            let allowed = Allowed { max_level: max, error_max: header.error_max };
            coder::context::decode(payload, header.rows.into(), levels, allowed, recall)?;
        }
    }
    // All levels fit where the pixel type has no more bits than the header allows.
    let too_large = if u32::from(max) + 1 == 1 << L::BITS { None } else { levels.iter().find(|l| l.get() > max) };
    too_large.map_or(Ok(()), |found| Err(PayloadFault::LevelRange { found: found.get(), max }))
}
