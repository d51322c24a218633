//! What a sequence of packets becomes.

use super::{Column, PacketStats};

/// One thing that happened in the stream of columns.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'p> {
    /// A firing of all beams. Under [`ReturnPolicy::Both`](super::ReturnPolicy::Both) a second
    /// one of the same index, layer 1, follows.
    Column(Column<'p>),
    /// This many columns are missing here; the index of the next column counts them.
    Gap {
        /// How many, within this turn.
        columns: u16,
        /// Why.
        cause: GapCause,
    },
    /// The turn is over; the next column has index 0 again (or a gap leads to it).
    TurnEnd(Turn),
    /// Whole turns passed of which nothing was received.
    TurnsLost {
        /// How many.
        turns: u32,
    },
}

/// Why columns are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum GapCause {
    /// Their packets were lost, or refused.
    Lost,
    /// The sensor is told not to look there.
    Blind,
    /// The sensor itself marks the column as not valid.
    Invalid,
    /// The stream starts in the middle of a turn.
    Start,
}

/// A turn that ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Turn {
    /// Number of the turn since the stream started, lost ones counted; wraps.
    pub number: u32,
    /// Columns it spans, gaps counted: indices run from 0 to `columns - 1`.
    pub columns: u16,
    /// How many of them are missing, for whatever cause.
    pub missing: u16,
    /// What ended it.
    pub end: TurnCut,
}

/// What ended a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TurnCut {
    /// The azimuth passed the cut, or the sensor's frame number went up.
    Wrap,
    /// The turn grew past [`MAX_COLUMNS`]: the sensor does not turn.
    Overflow,
    /// [`TurnAssembler::finish`](super::TurnAssembler::finish) was called.
    Finish,
}

/// Most columns that a turn can have. The slowest sensor here has 3,750 at five turns a second.
pub const MAX_COLUMNS: u16 = 8192;

/// The turn that is being assembled: counts columns, speaks to the sink.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenTurn {
    number: u32,
    next: u16,
    missing: u16,
}

impl OpenTurn {
    pub const fn new() -> Self {
        Self { number: 0, next: 0, missing: 0 }
    }

    /// Index of the next column.
    pub const fn next(self) -> u16 {
        self.next
    }

    pub fn count_column(&mut self, stats: &mut PacketStats) {
        self.next = self.next.saturating_add(1);
        stats.columns = stats.columns.saturating_add(1);
    }

    /// Marks `columns` missing ones; no event if there are none.
    pub fn gap(&mut self, columns: u32, cause: GapCause, stats: &mut PacketStats, sink: &mut impl FnMut(Event<'_>)) {
        let room = u32::from(MAX_COLUMNS.saturating_sub(self.next));
        let columns = columns.min(room) as u16;
        if columns == 0 {
            return;
        }
        self.next += columns;
        self.missing += columns;
        let counter = match cause {
            GapCause::Lost | GapCause::Invalid => &mut stats.lost_columns,
            GapCause::Blind => &mut stats.blind_columns,
            GapCause::Start => &mut 0,
        };
        *counter = counter.saturating_add(u32::from(columns));
        sink(Event::Gap { columns, cause });
    }

    /// Ends the turn.
    pub fn end(&mut self, end: TurnCut, stats: &mut PacketStats, sink: &mut impl FnMut(Event<'_>)) {
        stats.turns = stats.turns.saturating_add(1);
        sink(Event::TurnEnd(Turn { number: self.number, columns: self.next, missing: self.missing, end }));
        *self = Self { number: self.number.wrapping_add(1), ..Self::new() };
    }

    /// Passes over whole turns; no event if there are none.
    pub fn lose(&mut self, turns: u32, stats: &mut PacketStats, sink: &mut impl FnMut(Event<'_>)) {
        if turns == 0 {
            return;
        }
        self.number = self.number.wrapping_add(turns);
        stats.lost_turns = stats.lost_turns.saturating_add(turns);
        sink(Event::TurnsLost { turns });
    }
}
