//! Cuts the image into literals and matches, left to right, patient for a few pixels where a better match follows.

use super::block::{Block, Sequence};
use super::matcher::{Found, KEY_LEN, Match, Place, next_return, returns, words};
use super::symbols::{MAX_MATCH, MIN_MATCH};
use super::{Deflate, OutputFull};
use crate::coder::bits::BitWriter;

/// A match of this length is taken without looking for a better one behind it.
const GOOD_LEN: usize = 32;
/// The next return must be this near for a match there to be compared.
const PATIENCE: usize = 3;
/// By how many bits a later match must be better.
const LATER_SCORE: usize = 2;
/// Matches shorter than this may cost more than their literals.
const DOUBTFUL_LEN: usize = 5;
/// As many zeros get a match of their own.
const MIN_ZEROS: usize = 4;
/// Rows up to this long are enough alike for a match with the one above to be tried: measured, from 2048 columns
/// down it gains 0.5 %, at 4096 it loses 0.1 %.
const ALIKE_ROW_LEN: usize = 2048;
/// As many zeros get it before anything else is tried.
const MANY_ZEROS: usize = 24;

/// One image on its way through the encoder.
pub(super) struct Parse<'a, const SHORT: usize, const LONG: usize, const WAYS: usize, const SEQUENCES: usize> {
    state: &'a mut Deflate<SHORT, LONG, WAYS, SEQUENCES>,
    bytes: &'a [u8],
    row: usize,
    out: BitWriter<'a>,
    /// Where the block begins.
    block: usize,
    /// Sequences of the block so far.
    sequences: usize,
    /// Where the literals behind the last match begin.
    literals: usize,
    /// Everything before is settled: in a sequence, or one of those literals.
    settled: usize,
}

/// A match and where it begins.
#[derive(Clone, Copy)]
struct Placed {
    start: usize,
    found: Match,
}

impl Placed {
    const fn end(self) -> usize {
        self.start + self.found.len
    }
}

impl<'a, const SHORT: usize, const LONG: usize, const WAYS: usize, const SEQUENCES: usize>
    Parse<'a, SHORT, LONG, WAYS, SEQUENCES>
{
    pub fn new(
        state: &'a mut Deflate<SHORT, LONG, WAYS, SEQUENCES>,
        bytes: &'a [u8],
        row_len: usize,
        out: &'a mut [u8],
    ) -> Self {
        let row = if row_len <= ALIKE_ROW_LEN { row_len } else { 0 };
        Self { state, bytes, row, out: BitWriter::new(out), block: 0, sequences: 0, literals: 0, settled: 0 }
    }

    /// Codes the image; gives the length of the stream.
    pub fn run(mut self) -> Result<usize, OutputFull> {
        while self.settled < self.bytes.len() {
            let here = next_return(self.bytes, self.settled);
            if here - self.settled >= MANY_ZEROS {
                self.zeros(here)?;
            }
            if let Some(first) = self.look_up(here, |found, place| found.search(place)) {
                self.take(here, first)?;
            } else {
                self.zeros(here)?;
                self.settled = self.bytes.len().min(here + 1);
            }
        }
        self.finish()
    }

    /// Settles the best match around `here`, where `best` was found.
    #[inline(always)]
    fn take(&mut self, here: usize, mut best: Placed) -> Result<(), OutputFull> {
        let mut entered = here;
        while best.found.len < GOOD_LEN {
            let next = next_return(self.bytes, entered + 1);
            if next > entered + PATIENCE || next >= best.end() {
                break;
            }
            entered = next;
            let floor = (best.end() - next).max(MIN_MATCH);
            let Some(later) = self.look_up(next, |found, place| found.search_longer(place, floor)) else {
                break;
            };
            if later.found.score() <= best.found.score() + LATER_SCORE {
                break;
            }
            best = later;
        }
        self.zeros(here.min(best.start))?;
        self.settled = best.start;
        self.push(best.found)?;
        self.enter_until(entered + 1, best.end());
        Ok(())
    }

    /// Enters the return at `at` in the tables; gives the best match there, if it is longer than `floor`, grown to
    /// the left.
    #[inline(always)]
    fn look_up(&mut self, at: usize, search: impl FnOnce(Found<WAYS>, Place<'_>) -> Option<Match>) -> Option<Placed> {
        let key = self.bytes.get(at..)?.first_chunk::<KEY_LEN>()?;
        let found = self.state.tables.enter(key, at);
        let found = search(found, Place { bytes: self.bytes, at, row: self.row })?;
        let placed = self.grow(at, found);
        if placed.found.len < DOUBTFUL_LEN && self.too_dear(placed) { None } else { Some(placed) }
    }

    #[inline(never)]
    fn grow(&self, at: usize, found: Match) -> Placed {
        let (mut start, Match { mut len, distance }) = (at, found);
        while start > self.settled && start > distance && len < MAX_MATCH {
            if self.bytes.get(start - 1) != self.bytes.get(start - 1 - distance) {
                break;
            }
            start -= 1;
            len += 1;
        }
        Placed { start, found: Match { len, distance } }
    }

    #[inline(always)]
    fn too_dear(&self, placed: Placed) -> bool {
        let bytes = self.bytes.get(placed.start..placed.end()).unwrap_or_default();
        self.state.costs.literals(bytes) <= self.state.costs.matched(placed.found)
    }

    /// Enters the returns of a match in the tables.
    #[inline(always)]
    fn enter_until(&mut self, from: usize, to: usize) {
        for (word_at, word) in words(self.bytes, from) {
            if word_at >= to {
                return;
            }
            for byte in returns(word) {
                let at = word_at + byte;
                let key = self.bytes.get(at..).and_then(<[u8]>::first_chunk);
                let (true, Some(key)) = (at < to, key) else {
                    return;
                };
                self.state.tables.enter(key, at);
            }
        }
    }

    /// Settles the zeros up to `end`.
    #[inline(always)]
    fn zeros(&mut self, end: usize) -> Result<(), OutputFull> {
        if end.saturating_sub(self.settled) >= MIN_ZEROS {
            self.repeat_zeros(end)?;
        }
        self.settled = end;
        Ok(())
    }

    fn repeat_zeros(&mut self, end: usize) -> Result<(), OutputFull> {
        let before = self.bytes.get(self.settled.wrapping_sub(1));
        if before != Some(&0) {
            self.settled += 1;
        }
        while end - self.settled >= MIN_MATCH {
            self.push(Match { len: (end - self.settled).min(MAX_MATCH), distance: 1 })?;
        }
        Ok(())
    }

    /// Settles a match that begins where all is settled.
    #[inline(always)]
    fn push(&mut self, found: Match) -> Result<(), OutputFull> {
        let mut literals = self.settled - self.literals;
        while literals >= Sequence::MAX_LITERALS {
            literals -= Sequence::MAX_LITERALS;
            self.literals += Sequence::MAX_LITERALS;
            self.sequence(Sequence::only_literals(), self.literals)?;
        }
        self.settled += found.len;
        self.literals = self.settled;
        self.sequence(Sequence::new(literals, found.len - MIN_MATCH, found.distance - 1), self.settled)
    }

    #[inline(always)]
    fn sequence(&mut self, sequence: Sequence, end: usize) -> Result<(), OutputFull> {
        if let Some(slot) = self.state.sequences.get_mut(self.sequences) {
            *slot = sequence;
        }
        self.sequences += 1;
        if self.sequences == SEQUENCES { self.write_block(end, false) } else { Ok(()) }
    }

    #[inline(never)]
    fn write_block(&mut self, end: usize, last: bool) -> Result<(), OutputFull> {
        let bytes = self.bytes.get(self.block..end).unwrap_or_default();
        let sequences = self.state.sequences.get(..self.sequences).unwrap_or_default();
        self.state.codes.write(Block { bytes, sequences, last }, &mut self.out)?;
        self.state.costs.learn(&self.state.codes);
        self.block = end;
        self.sequences = 0;
        Ok(())
    }

    fn finish(mut self) -> Result<usize, OutputFull> {
        self.write_block(self.bytes.len(), true)?;
        self.out.finish()
    }
}
