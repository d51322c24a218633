//! Columns that were fed to strips, and strips to datagrams.

use super::{Plan, StreamEncoder};
use crate::coder::context::column::Column as Levels;
use crate::coder::context::strip::{StripCoder, StripTier};
use crate::stream::datagram::{CHECKSUM_LEN, RATE_MAX, STORED, StripHeader};
use crate::stream::line::{Firing, Line};
use crate::stream::tally::Sent;

/// What a stream has yet to do with what it was fed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Todo {
    Nothing,
    /// The column that is there, whose number is this firing's.
    Column(Firing),
    /// To say that the turn is over; behind it, so many firings of nothing, if any.
    End {
        turn: u16,
        flush: Option<u16>,
    },
    /// So many firings more, of nothing, to bring out what is held.
    Flush(u16),
    /// The column that a firing of nothing brought out; behind it, so many more of these.
    Flushed(Firing, u16),
}

#[allow(private_bounds, reason = "the tiers there are")]
impl<M: StripTier, const GROUPS: usize, const LEN: usize, L: Line> StreamEncoder<M, GROUPS, LEN, L> {
    /// Does what there is to do, up to a datagram, whose length it gives.
    pub(super) fn work(&mut self) -> Option<usize> {
        loop {
            match self.todo {
                Todo::Nothing => return None,
                Todo::Column(firing) => {
                    if let Some(len) = self.code(firing) {
                        return Some(len);
                    }
                    self.todo =
                        if firing.is_last { Todo::End { turn: firing.turn, flush: None } } else { Todo::Nothing };
                }
                Todo::End { turn, flush } => {
                    // A turn whose end was not told goes out first.
                    if self.header.columns > 0 && self.header.turn != turn {
                        return Some(self.seal());
                    }
                    self.todo = flush.map_or(Todo::Nothing, Todo::Flush);
                    return Some(self.end(turn));
                }
                Todo::Flush(0) => {
                    self.line.clear();
                    let is_begun = self.header.columns > 0 || self.header.strip > 0;
                    self.todo =
                        if is_begun { Todo::End { turn: self.header.turn, flush: None } } else { Todo::Nothing };
                    self.turn = self.header.turn.wrapping_add(u16::from(is_begun));
                }
                Todo::Flush(firings) => self.flush(firings - 1),
                Todo::Flushed(firing, left) => {
                    if let Some(len) = self.code(firing) {
                        return Some(len);
                    }
                    let end = Todo::End { turn: firing.turn, flush: Some(left) };
                    self.todo = if firing.is_last { end } else { Todo::Flush(left) };
                }
            }
        }
    }

    /// A firing of nothing, where the next would be.
    fn flush(&mut self, left: u16) {
        let tick = u32::from(self.last.tick) + u32::from(self.rate.ticks());
        let tick = tick.checked_rem(self.ticks).unwrap_or(0) as u16;
        let index = if self.turn == self.last.turn { self.last.index.saturating_add(1) } else { 0 };
        let firing = Firing { tick, index, turn: self.turn, is_last: false, ..self.last };
        self.last = firing;
        self.since = self.since.saturating_add(1);
        self.column = Levels::new();
        let found = self.line.exchange(firing, &mut self.column);
        self.todo = found.map_or(Todo::Flush(left), |firing| Todo::Flushed(firing, left));
    }

    /// Codes the column; where the strip that is open must go out before, gives its length.
    fn code(&mut self, firing: Firing) -> Option<usize> {
        let is_begun = self.header.turn == firing.turn && (self.header.columns > 0 || self.header.strip > 0);
        if !is_begun && self.header.columns == 0 {
            // One that was cut off without an end is no reason to cut off this one.
            self.is_cut &= self.header.turn == firing.turn;
            (self.header.turn, self.header.strip, self.header.first_column) = (firing.turn, 0, 0);
            self.plans[1] = self.plans[0];
        }
        let stride = self.plans[1].stride;
        if self.is_cut || firing.index.checked_rem(stride.into()) != Some(0) {
            if self.is_cut && self.header.columns > 0 {
                return Some(self.seal());
            }
            let passed = if self.is_cut { &mut self.tally.cut } else { &mut self.tally.thinned };
            *passed = passed.saturating_add(1);
            return None;
        }
        let next = self.header.columns.wrapping_mul(u16::from(stride)).wrapping_add(self.header.first_column);
        let is_open = self.header.columns > 0;
        let follows = firing.index == next && self.header.turn == firing.turn && self.since == u16::from(stride);
        if is_open && !(follows && self.try_column(false)) {
            return Some(self.seal());
        }
        if !is_open {
            self.start_strip(firing);
            if !self.try_column(true) && !self.store_column() {
                // So many ticks out of the ordinary that not even they fit.
                self.tally.unfit = self.tally.unfit.saturating_add(1);
                return None;
            }
        }
        self.line.coded();
        self.since = 0;
        self.tally.columns = self.tally.columns.saturating_add(1);
        None
    }

    fn start_strip(&mut self, firing: Firing) {
        let Plan { coder, stride } = self.plans[1];
        let rate_q10 = self.rate.q10().saturating_mul(self.line.rate_stride(stride)).min(RATE_MAX);
        self.header = StripHeader {
            first_column: firing.index,
            columns: 0,
            stride,
            first_tick: self.line.first_tick(),
            time_us: firing.time_us,
            rate_q10,
            tier: StripCoder::<M, GROUPS>::TIER,
            settings: coder,
            ..self.header
        };
        self.header_len = self.header.len();
        self.strip.start(coder, self.header.order(), self.header.rate_q10);
    }

    /// Codes the column, if it fits.
    fn try_column(&mut self, begins: bool) -> bool {
        if self.header.tier == STORED || self.header.columns == u16::MAX {
            return false;
        }
        // It stays as it is until it is in a strip.
        let mut column = self.column.clone();
        let code = self.datagram.get_mut(self.header_len..LEN.saturating_sub(CHECKSUM_LEN)).unwrap_or_default();
        let steps = self.line.steps(begins, self.header.stride, self.ticks);
        let fits = self.strip.push(self.header.settings, self.rows.into(), steps, &mut column, code);
        self.header.columns += u16::from(fits);
        fits
    }

    /// A strip of one column whose code is longer than its levels can be.
    fn store_column(&mut self) -> bool {
        let code = self.datagram.get_mut(self.header_len..LEN.saturating_sub(CHECKSUM_LEN)).unwrap_or_default();
        let steps = self.line.steps(true, self.header.stride, self.ticks);
        let fits = self.strip.store(self.rows.into(), self.header.rate_q10, steps, &self.column, code);
        if fits {
            (self.header.tier, self.header.columns) = (STORED, 1);
        }
        fits
    }

    /// Makes a datagram of the strip that is open, the turn's last.
    fn end(&mut self, turn: u16) -> usize {
        if self.header.columns == 0 {
            if self.header.turn != turn {
                (self.header.turn, self.header.strip, self.header.first_column) = (turn, 0, 0);
            }
            self.header.tier = StripCoder::<M, GROUPS>::TIER;
            self.header_len = self.header.len();
        }
        self.header.last = true;
        let len = self.seal();
        self.header = StripHeader { last: false, turn: turn.wrapping_add(1), strip: 0, first_column: 0, ..self.header };
        self.is_cut = false;
        len
    }

    /// Makes a datagram of the strip that is open; where none is, of nothing but the turn's end.
    fn seal(&mut self) -> usize {
        let code = self.datagram.get_mut(self.header_len..).unwrap_or_default();
        let code_len = match self.header {
            StripHeader { columns: 0, .. } => 0,
            _ => self.strip.finish(code),
        };
        let len = self.header.seal(code_len, &mut self.datagram);
        self.tally.datagrams = self.tally.datagrams.saturating_add(1);
        self.tally.bytes += len as u64;
        self.header.strip = self.header.strip.wrapping_add(1);
        let stride = u16::from(self.header.stride);
        self.header.first_column = self.header.columns.wrapping_mul(stride).wrapping_add(self.header.first_column);
        self.sent = Sent {
            turn: self.header.turn,
            len: len as u32,
            columns: self.header.columns,
            end_column: self.header.first_column,
            time_us: self.header.time_us,
            step: self.header.settings.step.levels(),
            stride: self.header.stride,
            is_last: self.header.last,
        };
        self.header.columns = 0;
        len
    }
}
