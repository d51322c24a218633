//! How finely to stream, for a budget: steps and columns turn by turn, within what the user allows.
//!
//! What perception needs last is cut first: steps are coarsened as far as they may be, and only then columns are left out. What
//! a turn takes is foreseen from the turn before; where a turn turns out longer, its steps are coarsened from strip to strip,
//! and where that is not enough, it is cut off: the receiver is told the turn's end, and columns that were not sent are
//! counted. So a turn takes its budget and at most one strip more, besides the datagram that tells its end, and what it takes
//! more is taken off the next one's.
//!
//! All in integers: the same turns give the same steps everywhere.

mod cost;
mod report;

pub use report::TurnReport;

use crate::coder::Step;
use crate::coder::context::strip::StripTier;
use crate::stream::{Line, Sent, StreamEncoder};
use cost::Relative;

/// What a turn may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Budget {
    /// Bytes of datagrams in a second of the sensor's clock.
    BytesASecond(u32),
    /// Bytes of datagrams in a turn.
    BytesATurn(u32),
    /// Instructions, cycles or whatever the caller counts, in a turn. A turn is not cut off for it.
    InstructionsATurn(u32),
}

/// What the user allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bounds {
    /// The step where the budget leaves room for it.
    pub finest: Step,
    /// The step of which no coarser one is chosen.
    pub coarsest: Step,
    /// Of so many columns at least one is kept, 1 for all.
    pub stride_max: u8,
}

impl Bounds {
    /// 2 cm to 20 cm in levels of 2 mm, half the columns at least: what detection and odometry still do well with.
    pub const USUAL: Self = Self { finest: step(10), coarsest: step(100), stride_max: 2 };
}

/// A step with a dead zone, of at least one level.
const fn step(levels: u16) -> Step {
    match Step::new(levels) {
        Some(step) => step,
        None => Step::LOSSLESS,
    }
}

/// Steps a stream so that it keeps to a budget.
///
/// RAM: itself, some 130 bytes.
///
/// ```
/// use flicr::coder::ContextSettings;
/// use flicr::control::{Bounds, Budget, Control};
/// use flicr::geometry::sensors::hdl64e;
/// use flicr::stream::{StreamConfig, StreamEncoder};
///
/// let mut stream: StreamEncoder = StreamEncoder::new(StreamConfig::new(&hdl64e::FIRING_GRID, 1, ContextSettings::FINE)?)?;
/// // 2 Mbit/s.
/// let mut control = Control::new(Budget::BytesASecond(250_000), Bounds::USUAL);
/// control.begin(&mut stream);
/// # fn send(_: &[u8]) {}
/// # let columns: [(u16, [u32; 64]); 0] = [];
/// for (index, counts) in columns {
///     stream.feed_counts(index, 2 * index, 0, &counts);
///     while let Some(datagram) = stream.next_datagram() {
///         send(datagram);
///         if let Some(turn) = control.sent(&mut stream, 0) {
///             println!("turn {}: {} bytes of {}", turn.turn, turn.bytes, turn.budget);
///         }
///     }
/// }
/// # Ok::<(), flicr::ConfigError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Control {
    budget: Budget,
    bounds: Bounds,
    /// What this turn may take: its share of the budget, less what the one before took too much.
    allowed: u32,
    /// Since the last turn's first datagram, in microseconds; of a turn of 10 Hz until that is known.
    turn_us: u32,
    began_us: Option<u32>,
    /// Columns of a turn; 0 until that is known.
    columns: u16,
    /// Levels of a step, and columns from one to the next, that the turn began with.
    planned: (u16, u8),
    /// What a column takes of a turn in steps of one level with all columns, x 256; 0 until that is known.
    column_cost_q8: u32,
    turn: ThisTurn,
    /// Counts of the stream when the turn began.
    cut_before: u32,
}

/// What is known of the turn that goes on.
#[derive(Debug, Clone, Copy, Default)]
struct ThisTurn {
    bytes: u32,
    instructions: u32,
    /// What its datagrams would have taken in steps of one level, in all columns.
    fine_cost: u32,
    /// Columns up to the end of the last datagram.
    end: u16,
    datagrams: u16,
    coarsest: u16,
}

/// A turn, until it has been seen how long they are.
const TURN_US: u32 = 100_000;
/// What tells that a turn is over.
const END_LEN: u32 = 32;

impl Control {
    /// A control that has seen no turn: it begins in the coarsest steps, so as not to have to cut off.
    #[must_use]
    pub const fn new(budget: Budget, bounds: Bounds) -> Self {
        Self {
            budget,
            bounds,
            allowed: 0,
            turn_us: TURN_US,
            began_us: None,
            columns: 0,
            planned: (bounds.coarsest.levels(), 1),
            column_cost_q8: 0,
            turn: ThisTurn { bytes: 0, instructions: 0, fine_cost: 0, end: 0, datagrams: 0, coarsest: 0 },
            cut_before: 0,
        }
    }

    /// Takes the stream in hand: to be called before its first column.
    #[allow(private_bounds, reason = "the tiers and lines there are")]
    pub fn begin<M: StripTier, const GROUPS: usize, const LEN: usize, L: Line>(
        &mut self,
        stream: &mut StreamEncoder<M, GROUPS, LEN, L>,
    ) {
        self.cut_before = stream.tally().cut;
        self.allowed = self.share();
        self.begin_turn(stream);
    }

    #[allow(private_bounds, reason = "the tiers and lines there are")]
    fn begin_turn<M: StripTier, const GROUPS: usize, const LEN: usize, L: Line>(
        &self,
        stream: &mut StreamEncoder<M, GROUPS, LEN, L>,
    ) {
        stream.set(stream.settings().with_step(self.step(self.planned.0)));
        stream.set_stride(self.planned.1);
        if self.is_spent() {
            stream.cut();
        }
    }

    /// Whether the next datagram would be too much.
    const fn is_spent(&self) -> bool {
        !matches!(self.budget, Budget::InstructionsATurn(_)) && self.turn.bytes.saturating_add(END_LEN) >= self.allowed
    }

    /// Another budget, as when the link has changed: of this turn too, from the next datagram on.
    pub fn set_budget(&mut self, budget: Budget) {
        let owed = self.share().saturating_sub(self.allowed);
        self.budget = budget;
        self.allowed = self.share().saturating_sub(owed);
    }

    /// Other bounds, from the next datagram on.
    pub const fn set_bounds(&mut self, bounds: Bounds) {
        self.bounds = bounds;
    }

    /// To be called when the datagram that the stream gave last was sent; `instructions` are what it took, where the budget
    /// is of these. Gives what became of a turn when that was its last.
    #[allow(private_bounds, reason = "the tiers and lines there are")]
    pub fn sent<M: StripTier, const GROUPS: usize, const LEN: usize, L: Line>(
        &mut self,
        stream: &mut StreamEncoder<M, GROUPS, LEN, L>,
        instructions: u32,
    ) -> Option<TurnReport> {
        let sent = stream.sent();
        self.count(&sent, instructions);
        if sent.is_last {
            let report = self.end_turn(&sent, stream.tally().cut);
            self.begin_turn(stream);
            return Some(report);
        }
        if self.is_spent() {
            stream.cut();
        } else if let Some(levels) = self.levels_for_the_rest() {
            stream.set_now(stream.settings().with_step(self.step(levels)));
        }
        None
    }

    fn count(&mut self, sent: &Sent, instructions: u32) {
        let turn = &mut self.turn;
        if turn.datagrams == 0 {
            let began = sent.time_us;
            if let Some(before) = self.began_us.replace(began) {
                // Turns of 1 to 100 Hz; others have stood still, or were lost.
                let turn_us = began.wrapping_sub(before);
                self.turn_us = if (10_000..=1_000_000).contains(&turn_us) { turn_us } else { self.turn_us };
            }
        }
        turn.datagrams = turn.datagrams.saturating_add(1);
        turn.bytes = turn.bytes.saturating_add(sent.len);
        turn.instructions = turn.instructions.saturating_add(instructions);
        if sent.columns > 0 {
            turn.end = sent.end_column;
            turn.coarsest = turn.coarsest.max(sent.step);
            let cost = if matches!(self.budget, Budget::InstructionsATurn(_)) { instructions } else { sent.len };
            let fine = Relative::of(self.budget, sent.step, sent.stride).finest_of(cost);
            turn.fine_cost = turn.fine_cost.saturating_add(fine);
        }
    }

    /// What a turn may take of the budget.
    fn share(&self) -> u32 {
        match self.budget {
            Budget::BytesASecond(bytes) => (u64::from(bytes) * u64::from(self.turn_us) / 1_000_000) as u32,
            Budget::BytesATurn(most) | Budget::InstructionsATurn(most) => most,
        }
    }

    /// What the rest of the turn is to be coded in; `None` where nothing is known of how much that is.
    fn levels_for_the_rest(&self) -> Option<u16> {
        let left = u32::from(self.columns.checked_sub(self.turn.end)?);
        let taken =
            if matches!(self.budget, Budget::InstructionsATurn(_)) { self.turn.instructions } else { self.turn.bytes };
        let allowed = self.allowed.saturating_sub(taken);
        // A quarter of the last turn and what has come of this one say what columns take.
        let weight = u32::from(self.columns / 4);
        let so_far = (u64::from(self.turn.fine_cost) << 8) + u64::from(self.column_cost_q8) * u64::from(weight);
        let column_cost_q8 = so_far.checked_div(u64::from(u32::from(self.turn.end) + weight))?;
        let fine_cost = ((column_cost_q8 * u64::from(left)) >> 8) as u32;
        Some(
            self.finest_within(fine_cost, allowed, self.planned.0, self.planned.1)
                .unwrap_or(self.bounds.coarsest.levels()),
        )
    }

    /// The finest step, from `finest` levels on, in which this takes no more than is allowed.
    fn finest_within(&self, fine_cost: u32, allowed: u32, finest: u16, stride: u8) -> Option<u16> {
        let coarsest = self.bounds.coarsest.levels();
        let fits = |levels: u16| Relative::of(self.budget, levels, stride).of_finest(fine_cost) <= allowed;
        let mut levels = finest.min(coarsest);
        while !fits(levels) {
            if levels >= coarsest {
                return None;
            }
            levels = levels.saturating_add((levels / 8).max(1)).min(coarsest);
        }
        Some(levels)
    }

    fn step(&self, levels: u16) -> Step {
        let Bounds { finest, coarsest, .. } = self.bounds;
        [finest, coarsest].into_iter().find(|bound| bound.levels() == levels).unwrap_or(step(levels))
    }

    fn end_turn(&mut self, sent: &Sent, cut: u32) -> TurnReport {
        let turn = self.turn;
        let is_bytes = !matches!(self.budget, Budget::InstructionsATurn(_));
        let taken = if is_bytes { turn.bytes } else { turn.instructions };
        let report = TurnReport {
            turn: sent.turn,
            budget: self.allowed,
            bytes: turn.bytes,
            instructions: turn.instructions,
            datagrams: turn.datagrams,
            finest: self.planned.0,
            coarsest: turn.coarsest,
            stride: self.planned.1,
            cut: cut.wrapping_sub(self.cut_before),
        };
        if let Some(cost) = (u64::from(turn.fine_cost) << 8).checked_div(turn.end.into()) {
            self.column_cost_q8 = cost as u32;
        }
        // Of a turn that was cut off it is not known how many columns it would have had, but that there were these too.
        let cut_end = u32::from(turn.end) + report.cut * u32::from(sent.stride.max(1));
        self.columns = if turn.end == 0 { self.columns } else { cut_end.min(u16::MAX.into()) as u16 };
        let owed = if is_bytes { taken.saturating_sub(self.allowed) } else { 0 };
        self.allowed = self.share().saturating_sub(owed);
        self.cut_before = cut;
        self.turn = ThisTurn::default();
        self.plan();
        report
    }

    /// Steps first, then columns; a little below what is allowed, for turns differ.
    fn plan(&mut self) {
        let fine_cost = ((u64::from(self.column_cost_q8) * u64::from(self.columns)) >> 8).min(u32::MAX.into()) as u32;
        let allowed = self.allowed - self.allowed / 32;
        let finest = self.bounds.finest.levels();
        let stride_max = self.bounds.stride_max.max(1);
        let found =
            (1..=stride_max).find_map(|stride| Some((self.finest_within(fine_cost, allowed, finest, stride)?, stride)));
        self.planned = found.unwrap_or((self.bounds.coarsest.levels(), stride_max));
    }
}
