//! Columns to datagrams, on the device.

use super::datagram::{CHECKSUM_LEN, DATAGRAM_LEN, OVERHEAD_LEN, RATE_MAX, STORED, StripHeader};
use super::line::{AsFired, Firing, Line, tick_step};
use super::tally::{Sent, StreamTally};
use crate::coder::ContextSettings;
use crate::coder::context::SmallModel;
use crate::coder::context::column::{Column as Levels, GROUP_ROWS};
use crate::coder::context::strip::{StripCoder, StripTier};
use crate::coder::context::ticks::TickRate;
use crate::error::ConfigError;
use crate::geometry::SensorGrid;
use crate::packet::{Column, Event};

/// What a stream is to be like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamConfig<'a> {
    /// The sensor's grid. The receiver must know the same: a built-in one, or one that it is told.
    pub grid: &'a SensorGrid<'a>,
    /// Range counts of the sensor in a level. 1 suits sensors whose counts fit 16 bits: all here but Ouster, whose
    /// millimeters need 4 for ranges of up to 262 m.
    pub counts_a_level: u8,
    /// How finely ranges are kept, in levels, and what they are predicted from.
    pub coder: ContextSettings,
    /// Which of the sender's streams this is, where several go to one receiver from sensors of the same kind. 0 by default.
    pub id: u8,
    /// Of a sensor that gives two returns a beam, which layer is streamed: 0 (the default) the one that the return policy
    /// prefers, 1 the other. Columns of another layer are passed over.
    pub layer: u8,
    /// Firings of a turn, about, where columns are [`Aligned`](super::Aligned): 1 to 8192. Of no use where they are not.
    pub columns_a_turn: u16,
}

impl<'a> StreamConfig<'a> {
    /// A stream of a sensor's columns, in levels of so many of its range counts.
    ///
    /// # Errors
    /// What [`SensorGrid::check`] finds; [`ConfigError::Ticks`] also where a turn has more than 65,536;
    /// [`ConfigError::RangeUnit`] for 0 counts a level.
    pub fn new(grid: &'a SensorGrid<'a>, counts_a_level: u8, coder: ContextSettings) -> Result<Self, ConfigError> {
        let config = Self { grid, counts_a_level, coder, id: 0, layer: 0, columns_a_turn: 0 };
        config.check()?;
        Ok(config)
    }

    fn check(&self) -> Result<(), ConfigError> {
        self.grid.check()?;
        if self.grid.ticks > 1 << 16 {
            return Err(ConfigError::Ticks { found: self.grid.ticks, max: 1 << 16 });
        }
        if self.counts_a_level == 0 {
            return Err(ConfigError::RangeUnit { found_m: 0.0 });
        }
        Ok(())
    }
}

/// What is done with a turn's columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Plan {
    pub(crate) coder: ContextSettings,
    /// Of so many columns one is kept: those whose numbers it divides.
    pub(crate) stride: u8,
}

/// What a stream has yet to do with what it was fed.
#[derive(Debug, Clone, Copy)]
enum Todo {
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
        (self.header.settings, self.header.stride) = (config.coder, 1);
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

    /// Does what there is to do, up to a datagram, whose length it gives.
    fn work(&mut self) -> Option<usize> {
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
