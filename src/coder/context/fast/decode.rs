//! Inverse: words to symbols, symbols and raw bits to columns.

use super::band::{Band, CELLS, GROUP_ROWS, GROUPS, Lanes, ROWS, Residuals, Scale};
use super::priors::{Inverse, inverse};
use super::rans;
use super::raw::RawReader;
use super::symbol::{CLASSES, Class, ESCAPE, SYMBOLS, signs};
use super::tile::{self, Tile};
use super::{BLOCK_HEAD_LEN, LAST_HEAD_LEN, meet, occupancy};
use crate::error::PayloadFault;
use crate::image::{ImageViewMut, Level};

/// Reads blocks into an image that the bands hold all rows of, through a tile a band.
pub(crate) fn walk<L: Level>(
    payload: &[u8],
    image: &mut ImageViewMut<'_, L>,
    bands: &mut [Band],
    tiles: &mut [Tile],
    scale: &Scale,
    tables: &[u8; CELLS],
) -> Result<(), PayloadFault> {
    let columns = image.columns();
    let (mut rest, mut at) = (payload, 0);
    while at < columns {
        let (block_columns, body, after) = block(rest, columns - at)?;
        let mut block = Block::new(body, tables)?;
        for column in at..at + block_columns {
            meet(bands);
            for (band, tile) in bands.iter_mut().zip(tiles.iter_mut()) {
                block.column(band, &mut tile[column % tile::COLUMNS], scale)?;
            }
            if (column + 1) % tile::COLUMNS == 0 || column + 1 == columns {
                for (number, tile) in tiles.iter().enumerate() {
                    tile::store(image, number * ROWS, column / tile::COLUMNS * tile::COLUMNS, tile);
                }
            }
        }
        block.finish()?;
        (rest, at) = (after, at + block_columns);
    }
    if rest.is_empty() { Ok(()) } else { Err(PayloadFault::TooLong) }
}

/// Columns and body of the first block, of which `left` columns are to come, and what is behind it.
fn block(payload: &[u8], left: usize) -> Result<(usize, &[u8], &[u8]), PayloadFault> {
    let (head, rest) = payload.split_first_chunk::<LAST_HEAD_LEN>().ok_or(PayloadFault::TooShort)?;
    let columns = usize::from(u16::from_le_bytes(*head));
    if columns == 0 {
        return Ok((left, rest, &[]));
    }
    let (len, rest) = rest.split_first_chunk::<{ BLOCK_HEAD_LEN - LAST_HEAD_LEN }>().ok_or(PayloadFault::TooShort)?;
    let (body, after) = rest.split_at_checked(u32::from_le_bytes(*len) as usize).ok_or(PayloadFault::TooShort)?;
    if columns > left { Err(PayloadFault::TooLong) } else { Ok((columns, body, after)) }
}

/// A block's two streams.
struct Block<'a> {
    words: rans::Decoder<'a>,
    raw: RawReader<'a>,
    tables: &'a [u8; CELLS],
    inverse: &'static Inverse,
}

/// Escaped rows of a column, and which of them are negative.
#[derive(Default)]
struct Escapes {
    rows: u64,
    negative: u64,
}

impl<'a> Block<'a> {
    fn new(body: &'a [u8], tables: &'a [u8; CELLS]) -> Result<Self, PayloadFault> {
        let words = rans::Decoder::new(body).ok_or(PayloadFault::TooShort)?;
        Ok(Self { words, raw: RawReader::new(body), tables, inverse: inverse() })
    }

    /// What both streams read must be what there is, and the states those that the encoder began with.
    fn finish(&self) -> Result<(), PayloadFault> {
        let (raw_len, padded) = self.raw.end();
        super::super::super::check_len(self.words.len, raw_len)
            .map_err(|fault| if fault == PayloadFault::TooLong { fault } else { PayloadFault::TooShort })?;
        if padded && self.words.is_at_start() { Ok(()) } else { Err(PayloadFault::Malformed) }
    }

    #[inline]
    fn column(&mut self, band: &mut Band, levels: &mut Lanes, scale: &Scale) -> Result<(), PayloadFault> {
        let mut sets = band.sets;
        let (words, inverse, mut token) = (&mut self.words, self.inverse, 0);
        occupancy::walk(band, &mut sets, |context, _| {
            let nibble = words.take(token, |slot| inverse.nibble(usize::from(context), slot));
            token += 1;
            nibble.map(|nibble| nibble as u8).ok_or(PayloadFault::TooShort)
        })?;
        let cells = band.cells(scale);
        let mut residuals = Residuals::NONE;
        let mut symbols = [0; ROWS];
        let mut escapes = Escapes::default();
        let lanes = cells.as_chunks().0.iter().zip(symbols.as_chunks_mut().0);
        for (group, ((cells, symbols), steps)) in lanes.zip(residuals.steps.as_chunks_mut().0).enumerate() {
            if sets[group] != 0 && self.group(cells, sets[group], symbols, steps)? {
                self.escapes(group, symbols, steps, &mut escapes);
            }
        }
        signs(&symbols, &band.flip, &mut residuals);
        if escapes.rows != 0 {
            escapes.signs(&mut residuals.negative);
        }
        occupy(sets, levels);
        if band.has_new(levels) {
            band.predict_new(levels, scale, |row, _| (residuals.steps[row], residuals.negative[row]));
        }
        band.advance(levels, scale, &residuals);
        Ok(())
    }

    /// Symbols of eight rows, those in `set` with returns, and how many steps they stand for; gives whether some are
    /// escapes.
    #[inline(always)]
    fn group(
        &mut self,
        cells: &[u16; GROUP_ROWS],
        set: u8,
        symbols: &mut [u16; GROUP_ROWS],
        steps: &mut [u16; GROUP_ROWS],
    ) -> Result<bool, PayloadFault> {
        let inverse = self.inverse;
        let mut tables = cells.map(|cell| inverse.table(self.tables.get(usize::from(cell)).copied().unwrap_or(0)));
        if set != u8::MAX {
            for (row, table) in tables.iter_mut().enumerate() {
                if set >> row & 1 == 0 {
                    *table = &inverse.certain;
                }
            }
        }
        let taken = self.words.take_group(symbols, |token, slot| tables[token].symbol(slot));
        taken.ok_or(PayloadFault::TooShort)?;
        let mut escaped = 0;
        for (symbols, steps) in symbols.as_chunks::<4>().0.iter().zip(steps.as_chunks_mut::<4>().0) {
            let (mut bits, mut taken) = (self.raw.peek(), 0);
            for (&symbol, steps) in symbols.iter().zip(steps) {
                let class = &CLASSES[usize::from(symbol) % SYMBOLS];
                *steps = class.first | (bits as u16 & class.mask);
                bits >>= class.raw_bits % 64;
                taken += class.raw_bits;
            }
            self.raw.take(taken % Class::ESCAPES);
            escaped |= taken / Class::ESCAPES;
        }
        Ok(escaped != 0)
    }

    #[cold]
    fn escapes(
        &mut self,
        group: usize,
        symbols: &[u16; GROUP_ROWS],
        steps: &mut [u16; GROUP_ROWS],
        escapes: &mut Escapes,
    ) {
        for (row, _) in symbols.iter().enumerate().filter(|(_, symbol)| **symbol == ESCAPE) {
            let bits = self.raw.peek();
            steps[row] = bits as u16;
            let row = GROUP_ROWS * group + row;
            escapes.rows |= 1 << row;
            escapes.negative |= (bits >> 16 & 1) << row;
            self.raw.take(17);
        }
    }
}

impl Escapes {
    #[cold]
    fn signs(&self, negative: &mut Lanes) {
        for (row, negative) in negative.iter_mut().enumerate() {
            if self.rows >> row & 1 == 1 {
                *negative = (self.negative >> row & 1) as u16;
            }
        }
    }
}

/// 1 where a row holds a return.
#[inline]
fn occupy(sets: [u8; GROUPS], levels: &mut Lanes) {
    for (levels, set) in levels.as_chunks_mut::<GROUP_ROWS>().0.iter_mut().zip(sets) {
        for (row, level) in levels.iter_mut().enumerate() {
            *level = u16::from(u16::from(set) & 1 << row != 0);
        }
    }
}
