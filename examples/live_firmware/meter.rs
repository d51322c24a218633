//! What columns, strips and turns cost. A board whose users do not ask leaves this out.

use heapless::Vec;

use super::stage::Clock;

/// Units of the clock that a column's cost is told by, and how many of them are told apart.
const BIN_WIDTH: u64 = 64;
const BINS: usize = 1024;
/// Turns whose costs are kept; later ones take the place of the last.
const TURNS_MAX: usize = 64;

/// Costs, in ticks of the clock until they are told.
pub struct Meter {
    mark: u32,
    column: u32,
    strip: u32,
    turn: u32,
    columns: Columns,
    strip_worst: u32,
    turns: Vec<u32, TURNS_MAX>,
}

struct Columns {
    count: u32,
    worst: u32,
    bins: [u16; BINS],
}

/// The median and the worst, in the clock's unit.
pub struct Spread {
    pub median: u64,
    pub worst: u64,
}

impl Meter {
    pub const fn new() -> Self {
        Self {
            mark: 0,
            column: 0,
            strip: 0,
            turn: 0,
            columns: Columns { count: 0, worst: 0, bins: [0; BINS] },
            strip_worst: 0,
            turns: Vec::new(),
        }
    }

    /// What comes now counts.
    pub fn go(&mut self, clock: impl Clock) {
        self.mark = clock.ticks();
    }

    /// What came since the last call counts.
    pub fn count(&mut self, clock: impl Clock) {
        let now = clock.ticks();
        let ticks = now.wrapping_sub(self.mark);
        for sum in [&mut self.column, &mut self.strip, &mut self.turn] {
            *sum = sum.saturating_add(ticks);
        }
        // What counting takes does not count.
        self.mark = clock.ticks();
    }

    pub fn begin_column(&mut self) {
        self.column = 0;
    }

    pub fn end_column(&mut self, clock: impl Clock) {
        let Columns { count, worst, bins } = &mut self.columns;
        *count += 1;
        *worst = (*worst).max(self.column);
        let bin = (in_units(self.column, clock) / BIN_WIDTH) as usize;
        if let Some(bin) = bins.get_mut(bin.min(BINS - 1)) {
            *bin = bin.saturating_add(1);
        }
    }

    /// What the strip took, in the clock's unit.
    pub fn end_strip(&mut self, clock: impl Clock) -> u32 {
        let ticks = core::mem::take(&mut self.strip);
        self.strip_worst = self.strip_worst.max(ticks);
        in_units(ticks, clock).min(u32::MAX.into()) as u32
    }

    pub fn end_turn(&mut self) {
        if let Err(turn) = self.turns.push(self.turn) {
            let _ = self.turns.pop();
            let _ = self.turns.push(turn);
        }
        self.turn = 0;
    }

    /// Of columns; the median is the upper end of its 64 units.
    pub fn columns(&self, clock: impl Clock) -> Spread {
        let Columns { count, worst, bins } = &self.columns;
        let mut left = count / 2;
        let median = bins.iter().position(|&bin| {
            let is_here = u32::from(bin) > left;
            left = left.saturating_sub(bin.into());
            is_here
        });
        Spread { median: (median.unwrap_or(0) as u64 + 1) * BIN_WIDTH, worst: in_units(*worst, clock) }
    }

    /// The worst strip.
    pub fn strip_worst(&self, clock: impl Clock) -> u64 {
        in_units(self.strip_worst, clock)
    }

    /// Of turns.
    pub fn turns(&mut self, clock: impl Clock) -> Spread {
        self.turns.sort_unstable();
        let at = |place: usize| in_units(self.turns.get(place).copied().unwrap_or(0), clock);
        Spread { median: at(self.turns.len() / 2), worst: at(self.turns.len().saturating_sub(1)) }
    }
}

fn in_units(ticks: u32, clock: impl Clock) -> u64 {
    u64::from(ticks) * u64::from(clock.per_tick())
}
