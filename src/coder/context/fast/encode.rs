//! Forward: columns to tokens and raw bits, tokens to words.

use super::super::super::OutputFull;
use super::band::{Band, CELLS, GROUP_ROWS, GROUPS, Lanes, ROWS, Residuals, Scale};
use super::priors::{self, CERTAIN, LIMITS, NIBBLES, NIBBLES_FIRST};
use super::rans::{self, GROUP, GROUP_LEN};
use super::raw::RawWriter;
use super::symbol::{CLASSES, Class, ESCAPE, SYMBOLS, symbols};
use super::tile::{self, Tile};
use super::{BLOCK_HEAD_LEN, COLUMNS_MAX, LAST_HEAD_LEN, meet, occupancy};
use crate::image::{ImageView, Level};

/// Tokens that are coded together.
pub(crate) type Group = [u16; GROUP];
/// Most groups of tokens of a band's column.
pub(crate) const GROUPS_MAX: usize = GROUPS + occupancy::NIBBLES_MAX.div_ceil(GROUP);

/// What a pass over the image yields.
pub(crate) trait Sink {
    /// A nibble that says which rows hold returns.
    fn nibble(&mut self, context: u16, nibble: u8);
    /// The last nibble of a band's column was given.
    fn nibbles_end(&mut self);
    /// Eight rows, those in `set` with returns.
    fn group(&mut self, group: &Rows<'_>, set: u8) -> Result<(), OutputFull>;
    /// Whether another column may come; a column was completed where `started`.
    fn column(&mut self, bands: usize) -> Result<(), OutputFull>;
}

/// Eight rows' residuals.
#[derive(Debug)]
pub(crate) struct Rows<'a> {
    pub(crate) cells: &'a [u16; GROUP_ROWS],
    pub(crate) symbols: &'a [u16; GROUP_ROWS],
    pub(crate) steps: &'a [u16; GROUP_ROWS],
    pub(crate) negative: &'a [u16; GROUP_ROWS],
}

/// Walks an image that the bands hold all rows of, through a tile a band.
pub(crate) fn walk<L: Level>(
    image: ImageView<'_, L>,
    bands: &mut [Band],
    tiles: &mut [Tile],
    scale: &Scale,
    sink: &mut impl Sink,
) -> Result<(), OutputFull> {
    for first in (0..image.columns()).step_by(tile::COLUMNS) {
        for (number, tile) in tiles.iter_mut().enumerate() {
            tile::load(image, number * ROWS, first, tile);
        }
        for at in 0..tile::COLUMNS.min(image.columns() - first) {
            sink.column(bands.len())?;
            meet(bands);
            for (band, tile) in bands.iter_mut().zip(tiles.iter_mut()) {
                column(band, &mut tile[at], scale, sink)?;
            }
        }
    }
    Ok(())
}

#[inline]
fn column(band: &mut Band, levels: &mut Lanes, scale: &Scale, sink: &mut impl Sink) -> Result<(), OutputFull> {
    let mut sets = sets(levels);
    let _ = occupancy::walk(band, &mut sets, |context, nibble| {
        sink.nibble(context, nibble);
        Ok::<u8, ()>(nibble)
    });
    sink.nibbles_end();
    let cells = band.cells(scale);
    if band.has_new(levels) {
        let given = *levels;
        band.predict_new(&given, scale, |row, predicted| scale.residual(given[row], predicted));
    }
    let mut residuals = Residuals::NONE;
    band.residuals(levels, scale, &mut residuals);
    let symbols = symbols(&residuals, &band.flip);
    let rows = cells.as_chunks().0.iter().zip(symbols.as_chunks().0);
    let rest = residuals.steps.as_chunks().0.iter().zip(residuals.negative.as_chunks().0);
    for (((cells, symbols), (steps, negative)), set) in rows.zip(rest).zip(sets) {
        if set != 0 {
            sink.group(&Rows { cells, symbols, steps, negative }, set)?;
        }
    }
    band.advance(levels, scale, &residuals);
    Ok(())
}

/// Which rows hold returns, by groups.
#[inline]
fn sets(levels: &Lanes) -> [u8; GROUPS] {
    let mut sets = [0; GROUPS];
    for (set, levels) in sets.iter_mut().zip(levels.as_chunks::<GROUP_ROWS>().0) {
        let mut bits = [0; GROUP_ROWS];
        for (row, bit) in bits.iter_mut().enumerate() {
            *bit = u16::from(levels[row] != 0).wrapping_neg() & 1 << row;
        }
        *set = bits.iter().fold(0, |set, &bit| set | bit) as u8;
    }
    sets
}

/// Tokens into blocks.
#[derive(Debug)]
pub(crate) struct Blocks<'a> {
    out: &'a mut [u8],
    tables: &'static [u8; CELLS],
    tokens: &'a mut [Group],
    /// Groups of tokens so far.
    len: usize,
    nibbles: Group,
    /// Nibbles that wait for their group.
    waiting: usize,
    /// Where the block begins.
    start: usize,
    /// Columns of the block.
    columns: u16,
    raw: RawWriter,
}

impl<'a> Blocks<'a> {
    pub(crate) fn new(out: &'a mut [u8], tables: &'static [u8; CELLS], tokens: &'a mut [Group]) -> Self {
        Self {
            out,
            tables,
            tokens,
            len: 0,
            nibbles: [CERTAIN; GROUP],
            waiting: 0,
            start: 0,
            columns: 0,
            raw: RawWriter::new(LAST_HEAD_LEN),
        }
    }

    /// Ends the last block; gives the payload's length.
    pub(crate) fn finish(mut self) -> Result<usize, OutputFull> {
        let end = self.end_block()?;
        let head = self.out.get_mut(self.start..).and_then(|room| room.first_chunk_mut()).ok_or(OutputFull)?;
        *head = 0_u16.to_le_bytes();
        Ok(end)
    }

    /// Words behind the raw bits, states behind the words.
    fn end_block(&mut self) -> Result<usize, OutputFull> {
        let raw = core::mem::replace(&mut self.raw, RawWriter::new(0));
        let mut len = raw.finish(self.out)?;
        let mut coder = rans::Encoder::new();
        for tokens in self.tokens.get(..self.len).unwrap_or(&[]).iter().rev() {
            let room =
                self.out.get_mut(len..).and_then(|room| room.first_chunk_mut::<GROUP_LEN>()).ok_or(OutputFull)?;
            len += coder.put(|token| priors::share(tokens[token]), room);
        }
        self.len = 0;
        coder.finish(self.out, len)
    }

    /// Ends a block that is not the last: its head is longer.
    #[cold]
    fn next_block(&mut self) -> Result<(), OutputFull> {
        let end = self.end_block()? + BLOCK_HEAD_LEN - LAST_HEAD_LEN;
        let block = self.out.get_mut(self.start..end).ok_or(OutputFull)?;
        let body_end = block.len() - (BLOCK_HEAD_LEN - LAST_HEAD_LEN);
        block.copy_within(LAST_HEAD_LEN..body_end, BLOCK_HEAD_LEN);
        let body_len = (block.len() - BLOCK_HEAD_LEN) as u32;
        let (head, _) = block.split_at_mut(BLOCK_HEAD_LEN);
        let (columns, len) = head.split_at_mut(LAST_HEAD_LEN);
        columns.copy_from_slice(&self.columns.to_le_bytes());
        len.copy_from_slice(&body_len.to_le_bytes());
        self.start = end;
        self.columns = 0;
        self.raw = RawWriter::new(end + LAST_HEAD_LEN);
        Ok(())
    }

    #[inline(always)]
    fn push(&mut self, group: Group) {
        if let Some(room) = self.tokens.get_mut(self.len) {
            *room = group;
            self.len += 1;
        }
    }

    #[cold]
    fn escapes(&mut self, rows: &Rows<'_>) -> Result<(), OutputFull> {
        let tokens = self.tokens.get(self.len).ok_or(OutputFull)?;
        for (row, token) in tokens.iter().enumerate() {
            if *token != CERTAIN && token % SYMBOLS as u16 == ESCAPE {
                self.raw.put(u64::from(rows.steps[row]) | u64::from(rows.negative[row]) << 16, 17);
                self.raw.flush(self.out)?;
            }
        }
        Ok(())
    }
}

impl Sink for Blocks<'_> {
    #[inline]
    fn nibble(&mut self, context: u16, nibble: u8) {
        if let Some(room) = self.nibbles.get_mut(self.waiting) {
            *room = NIBBLES_FIRST + NIBBLES as u16 * context + u16::from(nibble);
            self.waiting += 1;
        }
        if self.waiting == GROUP {
            self.nibbles_end();
        }
    }

    #[inline]
    fn nibbles_end(&mut self) {
        if self.waiting > 0 {
            self.push(self.nibbles);
            self.nibbles = [CERTAIN; GROUP];
            self.waiting = 0;
        }
    }

    #[inline(always)]
    fn group(&mut self, rows: &Rows<'_>, set: u8) -> Result<(), OutputFull> {
        // Written where they stay: lanes that are written one by one must not be read as a vector at once.
        let tokens = self.tokens.get_mut(self.len).ok_or(OutputFull)?;
        let mut escaped = false;
        for (row, token) in tokens.iter_mut().enumerate() {
            let table = self.tables.get(usize::from(rows.cells[row])).copied().unwrap_or(0);
            let limit = LIMITS.get(usize::from(table)).copied().unwrap_or(0);
            let escapes = rows.symbols[row] >= u16::from(limit);
            let symbol = if escapes { ESCAPE } else { rows.symbols[row] };
            let class = &CLASSES[usize::from(symbol) % SYMBOLS];
            self.raw.put(u64::from(rows.steps[row] & class.mask), class.raw_bits % Class::ESCAPES);
            escaped |= escapes;
            *token = if set >> row & 1 == 1 { SYMBOLS as u16 * u16::from(table) + symbol } else { CERTAIN };
            if row % 4 == 3 {
                self.raw.flush(self.out)?;
            }
        }
        if escaped {
            self.escapes(rows)?;
        }
        self.len += 1;
        Ok(())
    }

    #[inline]
    fn column(&mut self, bands: usize) -> Result<(), OutputFull> {
        if self.len + bands * GROUPS_MAX > self.tokens.len() || self.columns == COLUMNS_MAX {
            self.next_block()?;
        }
        self.columns += 1;
        Ok(())
    }
}
