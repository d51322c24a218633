//! What columns are made of: the firings themselves, or what looks one way.
//!
//! The beams of a spinning sensor fire together but look apart: an HDL-64E's by up to 18 degrees. An object's edge then is
//! another firing for every beam, and a column of one firing says little of the next row. A delay line for each beam mends
//! that: a firing goes in, a column of what looks one way comes out, as many firings later as its last beam takes to get there.

use crate::coder::context::column::Column;
use crate::error::ConfigError;
use crate::geometry::{Beam, SensorGrid};
use crate::packet::MAX_COLUMNS;

/// A firing without its levels.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Firing {
    pub(super) tick: u16,
    /// Number in the turn.
    pub(super) index: u16,
    pub(super) time_us: u32,
    pub(super) turn: u16,
    /// Whether the turn ends with it.
    pub(super) is_last: bool,
}

/// What the stream encoder asks of a line.
pub(crate) trait Sealed: Sized {
    /// Memory that is to be started; zeros.
    const NEW: Self;

    /// Begins anew, with nothing in it. `columns_a_turn` is how many firings a turn has, about.
    fn start(&mut self, grid: &SensorGrid<'_>, columns_a_turn: u16) -> Result<(), ConfigError>;

    /// What goes into the header: 0 where columns are as fired.
    fn columns_a_turn(&self) -> u16;

    /// Takes a firing's levels and leaves those of the column that is complete with it; gives the firing whose number
    /// the column has.
    fn exchange<const GROUPS: usize>(&mut self, firing: Firing, column: &mut Column<GROUPS>) -> Option<Firing>;

    /// The last column was coded.
    fn coded(&mut self);

    /// Marks the last firing as the turn's last, if its column is yet to come.
    fn mark_last(&mut self) -> bool;

    /// Forgets what it holds.
    fn clear(&mut self);

    /// Firings that a return may wait, at most.
    fn delay(&self) -> u16;

    /// What a stride does to the ticks between those that are coded.
    fn rate_stride(&self, stride: u8) -> u32;

    /// How many more firings bring out all that is held.
    fn held(&self) -> u16;

    /// The tick of the first of the firings of which a strip that begins with the last column is made.
    fn first_tick(&self) -> u16;

    /// Most columns from one that is coded to the next.
    fn stride_max(&self) -> u8;

    /// Ticks from firing to firing that come before the last column: of all that is held where it begins a strip,
    /// else those since the column `stride` before it.
    fn steps(&self, begins: bool, stride: u8, ticks: u32) -> impl Iterator<Item = u16>;
}

/// How columns are made: [`AsFired`] or [`Aligned`].
#[allow(private_bounds, reason = "there are two")]
pub trait Line: Sealed {}

impl<L: Sealed> Line for L {}

/// Ticks from one to the next, around the turn.
pub(super) const fn tick_step(from: u16, to: u16, ticks: u32) -> u16 {
    let (from, to) = (from as u32, to as u32);
    (if to >= from { to - from } else { to + ticks - from }) as u16
}

/// A column is a firing: no delay, no memory.
#[derive(Debug, Clone)]
pub struct AsFired {
    /// Tick of the last column that was coded.
    before: u16,
    tick: u16,
}

impl Sealed for AsFired {
    const NEW: Self = Self { before: 0, tick: 0 };

    fn start(&mut self, _: &SensorGrid<'_>, _: u16) -> Result<(), ConfigError> {
        Ok(())
    }

    fn columns_a_turn(&self) -> u16 {
        0
    }

    fn exchange<const GROUPS: usize>(&mut self, firing: Firing, _: &mut Column<GROUPS>) -> Option<Firing> {
        self.tick = firing.tick;
        Some(firing)
    }

    fn coded(&mut self) {
        self.before = self.tick;
    }

    fn mark_last(&mut self) -> bool {
        false
    }

    fn clear(&mut self) {}

    fn delay(&self) -> u16 {
        0
    }

    fn rate_stride(&self, stride: u8) -> u32 {
        stride.into()
    }

    fn held(&self) -> u16 {
        0
    }

    fn first_tick(&self) -> u16 {
        self.tick
    }

    fn stride_max(&self) -> u8 {
        u8::MAX
    }

    fn steps(&self, begins: bool, _: u8, ticks: u32) -> impl Iterator<Item = u16> {
        (!begins).then_some(tick_step(self.before, self.tick, ticks)).into_iter()
    }
}

/// Columns whose beams look one way.
///
/// Each beam has a delay line of as many firings as it is ahead of the last one; all of them together take `CELLS` levels,
/// two of them for each line's own numbers. The last `FIRINGS` firings' ticks and times are remembered too.
/// [`Aligned::room`] says how much a sensor takes.
///
/// RAM: 2 bytes a cell, 12 a firing. Delay: [`Aligned::room`]'s firings, less one, at most.
#[derive(Debug, Clone)]
pub struct Aligned<const CELLS: usize, const FIRINGS: usize> {
    /// Line by line, from the highest beam: its length, where in it the next level goes, and the levels.
    cells: [u16; CELLS],
    firings: [Firing; FIRINGS],
    /// Firings that a column is made of, from the first to the last.
    window: u16,
    /// How many firings the one whose number a column has is behind the last.
    behind: u16,
    columns_a_turn: u16,
    /// Whether a firing has come.
    is_begun: bool,
    /// Where the next firing goes.
    at: u16,
}

/// [`Aligned`] for an HDL-64E of 2000 to 2300 firings a turn: 9.6 KB.
pub type AlignedHdl64e = Aligned<4096, 128>;

/// Columns by which a beam looks ahead of azimuth phase 0: rounded, halves to even. Phases are of less than a turn: it may
/// be more than half a turn to the other side.
pub(super) fn lead(beam: &Beam, clockwise: bool, columns_a_turn: u16) -> i32 {
    let turns = f64::from(beam.azimuth_phase_rad) / core::f64::consts::TAU;
    libm::rint(if clockwise { -turns } else { turns } * f64::from(columns_a_turn)) as i32
}

/// The least and the largest lead, 0 among them.
pub(super) fn leads(grid: &SensorGrid<'_>, columns_a_turn: u16) -> (i32, i32) {
    let leads = grid.beams.iter().map(|beam| lead(beam, grid.clockwise, columns_a_turn));
    leads.fold((0, 0), |(least, most), lead| (least.min(lead), most.max(lead)))
}

impl<const CELLS: usize, const FIRINGS: usize> Aligned<CELLS, FIRINGS> {
    /// The cells and firings that a sensor takes, of about so many firings a turn.
    #[must_use]
    pub fn room(grid: &SensorGrid<'_>, columns_a_turn: u16) -> (usize, usize) {
        let (least, most) = leads(grid, columns_a_turn);
        let cells = grid.beams.iter().map(|beam| 2 + (lead(beam, grid.clockwise, columns_a_turn) - least) as usize);
        (cells.sum(), (most - least) as usize + 1)
    }

    /// The firing `back` before the last.
    fn firing(&self, back: u16) -> Firing {
        let at = (usize::from(self.at) + FIRINGS - 1).wrapping_sub(back.into());
        self.firings.get(if at >= FIRINGS { at - FIRINGS } else { at }).copied().unwrap_or_default()
    }

    fn take(&mut self, firing: Firing) {
        if !self.is_begun {
            self.begin(firing);
        }
        if let Some(place) = self.firings.get_mut(usize::from(self.at)) {
            *place = firing;
        }
        self.at = if usize::from(self.at) + 1 < FIRINGS { self.at + 1 } else { 0 };
    }

    /// Before the first firing are the last of a turn of which nothing came: some beams then looked where the first columns
    /// of others look.
    fn begin(&mut self, firing: Firing) {
        (self.is_begun, self.at) = (true, 0);
        let turn = firing.turn.wrapping_sub(1);
        for (back, place) in (1..).zip(self.firings.iter_mut().rev()) {
            *place = Firing { index: self.columns_a_turn.saturating_sub(back), turn, is_last: back == 1, ..firing };
        }
    }
}

impl<const CELLS: usize, const FIRINGS: usize> Sealed for Aligned<CELLS, FIRINGS> {
    const NEW: Self = Self {
        cells: [0; CELLS],
        firings: [Firing { tick: 0, index: 0, time_us: 0, turn: 0, is_last: false }; FIRINGS],
        window: 0,
        behind: 0,
        columns_a_turn: 0,
        is_begun: false,
        at: 0,
    };

    fn start(&mut self, grid: &SensorGrid<'_>, columns_a_turn: u16) -> Result<(), ConfigError> {
        let (cells, firings) = Self::room(grid, columns_a_turn);
        if columns_a_turn == 0 || columns_a_turn > MAX_COLUMNS || cells > CELLS || firings > FIRINGS {
            return Err(ConfigError::Delay { cells, cells_max: CELLS, firings, firings_max: FIRINGS });
        }
        let (least, _) = leads(grid, columns_a_turn);
        self.cells.fill(0);
        let mut line = 0;
        for beam in grid.beams {
            let len = (lead(beam, grid.clockwise, columns_a_turn) - least) as u16;
            if let Some(place) = self.cells.get_mut(line) {
                *place = len;
            }
            line += 2 + usize::from(len);
        }
        (self.window, self.behind, self.columns_a_turn) = (firings as u16, least.unsigned_abs() as u16, columns_a_turn);
        (self.is_begun, self.at) = (false, 0);
        Ok(())
    }

    fn columns_a_turn(&self) -> u16 {
        self.columns_a_turn
    }

    fn exchange<const GROUPS: usize>(&mut self, firing: Firing, column: &mut Column<GROUPS>) -> Option<Firing> {
        self.take(firing);
        let mut lines = self.cells.as_mut_slice();
        let mut rows = column.levels.as_flattened_mut().iter_mut();
        while let ([len, at, cells @ ..], Some(level)) = (lines, rows.next()) {
            let Some((line, others)) = cells.split_at_mut_checked(usize::from(*len)) else { break };
            if let Some(cell) = line.get_mut(usize::from(*at)) {
                core::mem::swap(cell, level);
                *at = if *at + 1 < *len { *at + 1 } else { 0 };
            }
            lines = others;
        }
        column.find_sets();
        Some(self.firing(self.behind))
    }

    fn coded(&mut self) {}

    fn mark_last(&mut self) -> bool {
        if self.behind == 0 || !self.is_begun {
            return false;
        }
        let last = if self.at == 0 { FIRINGS - 1 } else { usize::from(self.at) - 1 };
        // A turn without firings leaves no mark.
        if let Some(firing) = self.firings.get_mut(last) {
            firing.is_last = true;
        }
        true
    }

    fn clear(&mut self) {
        // The lines are empty when it comes to this.
        (self.is_begun, self.at) = (false, 0);
    }

    fn delay(&self) -> u16 {
        self.window - 1
    }

    fn rate_stride(&self, _: u8) -> u32 {
        1
    }

    fn held(&self) -> u16 {
        if self.is_begun { self.window - 1 } else { 0 }
    }

    fn first_tick(&self) -> u16 {
        self.firing(self.window - 1).tick
    }

    fn stride_max(&self) -> u8 {
        FIRINGS.saturating_sub(1).clamp(1, u8::MAX.into()) as u8
    }

    fn steps(&self, begins: bool, stride: u8, ticks: u32) -> impl Iterator<Item = u16> {
        let count = if begins { self.window - 1 } else { stride.into() };
        (0..count).rev().map(move |back| tick_step(self.firing(back + 1).tick, self.firing(back).tick, ticks))
    }
}
