//! Columns to datagrams, on the device: what is fed, and what is asked of a stream.

mod strips;

use super::config::StreamConfig;
use super::datagram::{DATAGRAM_LEN, OVERHEAD_LEN, StripHeader};
use super::line::{AsFired, Firing, Line, tick_step};
use super::tally::{Sent, StreamTally};
use crate::coder::ContextSettings;
use crate::coder::context::SmallModel;
use crate::coder::context::column::{Column as Levels, GROUP_ROWS};
use crate::coder::context::strip::{StripCoder, StripTier};
use crate::coder::context::ticks::TickRate;
use crate::error::ConfigError;
use crate::packet::{Column, Event};
use strips::Todo;

/// What is done with a turn's columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Plan {
    pub(crate) coder: ContextSettings,
    /// Of so many columns one is kept: those whose numbers it divides.
    pub(crate) stride: u8,
}

/// Those of a stream that was not started.
const NO_SETTINGS: ContextSettings = ContextSettings { noise: 0, ..ContextSettings::FINE };

/// A sensor's columns to datagrams of at most `LEN` bytes, as they are fired.
///
/// `M` is the coder's tier: that of [`Small`](crate::Small), or of [`Dense`](crate::Dense). Sensors of up to `8 * GROUPS`
/// beams. `L` is [`AsFired`], or [`Aligned`](super::Aligned): fewer bytes, some milliseconds later.
///
/// RAM: itself, nothing else: with [`SmallModel`] and 64 beams as fired 3.4 KB, the datagram included. One in a `static` is
/// made of [`BLANK`](Self::BLANK) and then [`start`](Self::start)ed, so that it never lies on the stack.
///
/// What goes in is either pushed, with a callback for the datagrams that it fills, or fed, and the datagrams taken with
/// [`next_datagram`](Self::next_datagram) until there are none: as suits where sending waits, or may fail.
///
/// ```
/// use flicr::coder::{ContextSettings, SmallModel, Step};
/// use flicr::geometry::sensors::velodyne;
/// use flicr::packet::{ReturnPolicy, Sensor, TurnAssembler};
/// use flicr::stream::{StreamConfig, StreamEncoder};
///
/// // 2 cm of 2 mm counts.
/// let settings = ContextSettings::FINE.with_step(Step::new(10).unwrap());
/// let grid = velodyne::VLP16.grid();
/// let mut stream: StreamEncoder<SmallModel, 2> = StreamEncoder::new(StreamConfig::new(&grid, 1, settings)?)?;
/// let mut turns = TurnAssembler::new(Sensor::Auto, ReturnPolicy::Strongest);
/// # let packets = [[0; 100]];
/// for packet in &packets {
///     let _ = turns.push(packet, |event| {
///         stream.push(&event, |datagram| println!("{} bytes to send", datagram.len()));
///     });
/// }
/// // The same where sending may fail, here into a buffer of a byte stream.
/// # fn send(stream: &mut StreamEncoder<SmallModel, 2>, event: &flicr::packet::Event<'_>, mut uart: &mut [u8])
/// # -> Result<(), Box<dyn std::error::Error>> {
/// stream.feed(event);
/// while let Some(datagram) = stream.next_datagram() {
///     flicr::stream::write_framed(&mut uart, datagram)?;
/// }
/// # Ok(())
/// # }
/// # Ok::<(), flicr::ConfigError>(())
/// ```
#[derive(Debug, Clone)]
pub struct StreamEncoder<M = SmallModel, const GROUPS: usize = 8, const LEN: usize = DATAGRAM_LEN, L = AsFired> {
    /// 0: not started.
    rows: u16,
    ticks: u32,
    layer: u8,
    line: L,
    /// Of the next turn, and of this one, where it has begun.
    plans: [Plan; 2],
    strip: StripCoder<M, GROUPS>,
    /// Of the strip that is open; without columns where none is.
    header: StripHeader,
    header_len: usize,
    /// Columns are passed over until the turn ends.
    is_cut: bool,
    /// Firings since the last column that was coded.
    since: u16,
    rate: TickRate,
    turn: u16,
    last: Firing,
    todo: Todo,
    column: Levels<GROUPS>,
    datagram: [u8; LEN],
    tally: StreamTally,
    sent: Sent,
}

/// A return's level: at least 1, for one that is nearer than half a level is still a return.
const fn level_of(count: u32, unit: u32) -> u32 {
    // The usual case, and no division.
    if unit == 1 {
        return count;
    }
    match count.saturating_add(unit / 2).checked_div(unit) {
        Some(level @ 1..) => level,
        _ => 1,
    }
}

/// Microseconds, modulo 2^32: digit by digit, for a division of 64 bits is a hundred instructions on a microcontroller.
const fn micros(time_ns: u64) -> u32 {
    let (high, low) = ((time_ns >> 32) as u32, time_ns as u32);
    let upper = ((high % 1000) << 16) | (low >> 16);
    let lower = ((upper % 1000) << 16) | (low & 0xffff);
    ((upper / 1000) << 16) | (lower / 1000)
}

#[allow(private_bounds, reason = "the tiers there are")]
impl<M: StripTier, const GROUPS: usize, const LEN: usize, L: Line> StreamEncoder<M, GROUPS, LEN, L> {
    /// Memory that has yet to be [`start`](Self::start)ed; until then it makes nothing of what it is given. All zeros, which
    /// cost no flash in a `static`.
    pub const BLANK: Self = Self {
        rows: 0,
        ticks: 0,
        layer: 0,
        line: L::NEW,
        plans: [Plan { coder: NO_SETTINGS, stride: 0 }; 2],
        strip: StripCoder::NEW,
        header: StripHeader {
            last: false,
            counts_a_level: 0,
            sensor: 0,
            id: 0,
            turn: 0,
            strip: 0,
            first_column: 0,
            columns: 0,
            stride: 0,
            time_us: 0,
            first_tick: 0,
            rate_q10: 0,
            tier: 0,
            settings: NO_SETTINGS,
            columns_a_turn: 0,
        },
        header_len: 0,
        is_cut: false,
        since: 0,
        rate: TickRate::NEW,
        turn: 0,
        last: Firing { tick: 0, index: 0, time_us: 0, turn: 0, is_last: false },
        todo: Todo::Nothing,
        column: Levels::new(),
        datagram: [0; LEN],
        tally: StreamTally::NONE,
        sent: Sent::NONE,
    };

    /// A stream that begins with its first column.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn new(config: StreamConfig<'_>) -> Result<Self, ConfigError> {
        let mut stream = Self::BLANK;
        stream.start(config)?;
        Ok(stream)
    }

    /// Begins anew, with turn 0.
    ///
    /// # Errors
    /// As [`StreamConfig::new`]; [`ConfigError::CoderRows`] where the sensor has more beams than there is room for: 8 *
    /// `GROUPS`, and as many as fit a datagram of `LEN` bytes at two bytes each; [`ConfigError::Delay`] where
    /// [`Aligned`](super::Aligned) columns take more room than there is.
    pub fn start(&mut self, config: StreamConfig<'_>) -> Result<(), ConfigError> {
        config.check()?;
        let rows = config.grid.beams.len();
        let max = (GROUPS * GROUP_ROWS).min(LEN.saturating_sub(OVERHEAD_LEN + 2) / 2);
        if rows > max {
            return Err(ConfigError::CoderRows { found: rows, max });
        }
        self.rows = 0;
        self.line.start(config.grid, config.columns_a_turn)?;
        (self.ticks, self.layer, self.rate) = (config.grid.ticks, config.layer, TickRate::NEW);
        self.plans = [Plan { coder: config.coder, stride: 1 }; 2];
        self.header.sensor = config.grid.checksum();
        self.header.columns_a_turn = self.line.columns_a_turn();
        (self.header.counts_a_level, self.header.id) = (config.counts_a_level, config.id);
        (self.header.last, self.header.turn, self.header.strip, self.header.columns) = (false, 0, 0, 0);
        (self.header.settings, self.header.stride) = (config.coder, 1);
        (self.is_cut, self.since, self.turn, self.todo) = (false, 0, 0, Todo::Nothing);
        (self.last, self.tally, self.sent) = (Firing::default(), StreamTally::NONE, Sent::NONE);
        self.rows = rows as u16;
        Ok(())
    }

    /// Takes what happened in the stream of columns; calls `send` with each datagram that this fills.
    pub fn push(&mut self, event: &Event<'_>, send: impl FnMut(&[u8])) {
        self.feed(event);
        self.send_all(send);
    }

    /// Takes a firing of all beams.
    pub fn push_column(&mut self, column: &Column<'_>, send: impl FnMut(&[u8])) {
        self.feed_column(column);
        self.send_all(send);
    }

    /// Takes a column of range counts, from the highest beam on, 0 where nothing came back: number `index` of its turn,
    /// fired at `tick`. Columns of a turn must come in ascending order; one that does not begins a strip of its own.
    pub fn push_counts(&mut self, index: u16, tick: u16, time_ns: u64, counts: &[u32], send: impl FnMut(&[u8])) {
        self.feed_counts(index, tick, time_ns, counts);
        self.send_all(send);
    }

    /// Ends the turn that is open: what is coded of it goes out, and the receiver is told that no more will come; where
    /// columns are aligned, when they have come out of the delay line. [`push`](Self::push) does it where the events say so.
    pub fn end_turn(&mut self, send: impl FnMut(&[u8])) {
        self.feed_turn_end();
        self.send_all(send);
    }

    /// No more columns will come, or none for a while: what the delay line holds goes out, as the turn that is open, which
    /// then is over.
    pub fn finish(&mut self, send: impl FnMut(&[u8])) {
        self.feed_finish();
        self.send_all(send);
    }

    fn send_all(&mut self, mut send: impl FnMut(&[u8])) {
        while let Some(datagram) = self.next_datagram() {
            send(datagram);
        }
    }

    /// As [`push`](Self::push); its datagrams are [`next_datagram`](Self::next_datagram)s. Those that are not taken before
    /// the next is fed are lost.
    pub fn feed(&mut self, event: &Event<'_>) {
        match event {
            Event::Column(column) => self.feed_column(column),
            Event::TurnEnd(turn) => {
                self.feed_turn_end();
                self.turn = turn.number as u16 + 1;
            }
            Event::TurnsLost { turns } => self.turn = self.turn.wrapping_add(*turns as u16),
            // The next column's index tells.
            Event::Gap { .. } => {}
        }
    }

    /// As [`push_column`](Self::push_column).
    pub fn feed_column(&mut self, column: &Column<'_>) {
        if column.layer != self.layer {
            return;
        }
        self.begin_column();
        column.for_each_return(|found| self.put(found.beam.into(), found.count));
        self.feed_firing(column.index, column.tick, micros(column.time_ns));
    }

    /// As [`push_counts`](Self::push_counts).
    pub fn feed_counts(&mut self, index: u16, tick: u16, time_ns: u64, counts: &[u32]) {
        self.begin_column();
        counts.iter().enumerate().for_each(|(row, &count)| self.put(row, count));
        self.feed_firing(index, tick, micros(time_ns));
    }

    /// As [`end_turn`](Self::end_turn).
    pub fn feed_turn_end(&mut self) {
        self.drop_undone();
        if self.rows > 0 && !self.line.mark_last() {
            self.todo = Todo::End { turn: self.turn, flush: None };
        }
        self.turn = self.turn.wrapping_add(1);
    }

    /// As [`finish`](Self::finish).
    pub fn feed_finish(&mut self) {
        self.drop_undone();
        self.todo = Todo::Flush(self.line.held());
    }

    /// Finishes what was fed, up to the next datagram; `None` where there is no more to do.
    pub fn next_datagram(&mut self) -> Option<&[u8]> {
        let len = self.work()?;
        self.datagram.get(..len)
    }

    /// Keeps ranges in other steps, from the next turn on; one that has no strip yet begins with them.
    pub const fn set(&mut self, coder: ContextSettings) {
        self.plan(Plan { coder, ..self.plans[0] });
    }

    /// Keeps ranges in other steps, from the next strip on: every strip says what its own are.
    pub const fn set_now(&mut self, coder: ContextSettings) {
        self.plans[0].coder = coder;
        self.plans[1].coder = coder;
    }

    /// Keeps one column of `stride`, from the next turn on: those whose numbers it divides. 0 counts as 1; the most is 255,
    /// and where columns are aligned one less than the firings that there is room for.
    pub fn set_stride(&mut self, stride: u8) {
        let stride = stride.clamp(1, self.line.stride_max());
        self.plan(Plan { stride, ..self.plans[0] });
    }

    /// Ends the strip that is open with the next column, and passes over the columns that are left of the turn, which
    /// [`StreamTally::cut`] counts. The turn's end is still told.
    pub const fn cut(&mut self) {
        self.is_cut = true;
    }

    const fn plan(&mut self, plan: Plan) {
        self.plans[0] = plan;
        if self.header.strip == 0 && self.header.columns == 0 {
            self.plans[1] = plan;
        }
    }

    /// How the next strip's ranges are kept.
    #[must_use]
    pub const fn settings(&self) -> ContextSettings {
        self.plans[1].coder
    }

    /// What the last datagram was: the one that [`next_datagram`](Self::next_datagram) gave, or that was last sent.
    #[must_use]
    pub const fn sent(&self) -> Sent {
        self.sent
    }

    /// Beams of its sensor; 0 before it is started.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.rows as usize
    }

    /// What has become of the returns so far.
    #[must_use]
    pub const fn tally(&self) -> StreamTally {
        self.tally
    }

    /// Firings that a return may wait before its column is coded, at most: 0 as fired.
    #[must_use]
    pub fn delay(&self) -> u16 {
        if self.rows == 0 { 0 } else { self.line.delay() }
    }

    fn begin_column(&mut self) {
        self.drop_undone();
        self.column = Levels::new();
    }

    /// What was not taken is lost.
    fn drop_undone(&mut self) {
        while self.work().is_some() {}
    }

    fn put(&mut self, row: usize, count: u32) {
        if count == 0 || row >= usize::from(self.rows) {
            return;
        }
        let Ok(level) = u16::try_from(level_of(count, self.header.counts_a_level.into())) else {
            self.tally.beyond_range += 1;
            return;
        };
        if let Some(place) = self.column.levels.as_flattened_mut().get_mut(row) {
            *place = level;
        }
        if let Some(set) = self.column.sets.get_mut(row / GROUP_ROWS) {
            *set |= 1 << (row % GROUP_ROWS);
        }
    }

    /// Takes the firing whose levels are in `column`.
    fn feed_firing(&mut self, index: u16, tick: u16, time_us: u32) {
        if self.rows == 0 {
            return;
        }
        let returns = self.column.sets.iter().map(|set| set.count_ones()).sum::<u32>();
        self.tally.returns += u64::from(returns);
        let firing = Firing { tick, index, time_us, turn: self.turn, is_last: false };
        let follows = index == self.last.index.wrapping_add(1) || index == 0;
        if follows && self.tally.firings > 0 {
            self.rate.take(tick_step(self.last.tick, tick, self.ticks));
        }
        self.tally.firings = self.tally.firings.saturating_add(1);
        self.last = firing;
        self.since = self.since.saturating_add(1);
        if let Some(firing) = self.line.exchange(firing, &mut self.column) {
            self.todo = Todo::Column(firing);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::micros;

    #[test]
    fn microseconds_are_thousandths() {
        let mut time_ns = 1_u64;
        for step in 0..64 {
            for found in [time_ns - 1, time_ns, time_ns + 999, u64::MAX - time_ns] {
                assert_eq!(micros(found), (found / 1000) as u32, "{found}");
            }
            time_ns = (time_ns.rotate_left(1) ^ ((step * 7919) << 13)) | 1;
            time_ns &= u64::MAX >> 1;
        }
    }
}
