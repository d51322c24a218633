//! Datagrams in any order to strips, as they come, and to turns, when they are over.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::vec::Vec;

use super::datagram::{Datagram, DatagramError, StripHeader};
use super::received::{Known, ReceivedStrip, ReceivedTurn};
use crate::error::ConfigError;
use crate::geometry::{SensorGrid, sensors};

/// How many turns before or behind the newest one a datagram may be of the same stream; one from farther off means that the
/// sender began anew.
const TURNS_APART_MAX: i16 = 64;

/// What a decoder may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamLimits {
    /// Turns of a stream that are waited for at a time, at least 1: with a datagram of a newer one the oldest is over. 2 by
    /// default.
    pub open_turns: usize,
    /// Turns that are over and not yet taken, at least 1: beyond them the oldest is dropped. 8 by default.
    pub turns_over: usize,
    /// Streams, each of one sensor and number. 8 by default.
    pub streams: usize,
}

impl Default for StreamLimits {
    fn default() -> Self {
        Self { open_turns: 2, turns_over: 8, streams: 8 }
    }
}

/// What did not come, or was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StreamLosses {
    /// Datagrams received.
    pub datagrams: u64,
    /// Of these, refused, for whatever reason.
    pub refused: u64,
    /// Turns given out without all that was sent of them.
    pub incomplete_turns: u64,
    /// Strips of these that did not come, as far as that is known.
    pub missing_strips: u64,
    /// Turns that nobody took in time.
    pub dropped_turns: u64,
}

#[derive(Debug)]
struct OpenTurn {
    number: u16,
    sent: Option<u16>,
    strips: BTreeMap<u16, ReceivedStrip>,
}

/// A sensor's turns.
#[derive(Debug)]
struct Stream {
    sensor: Arc<Known>,
    id: u8,
    /// By age.
    open: VecDeque<OpenTurn>,
    /// The newest turn that is over.
    last_over: Option<u16>,
}

/// Datagrams in any order, doubled, late or missing, to strips and turns.
///
/// ```
/// use flicr::stream::StreamDecoder;
/// # let datagrams: [&[u8]; 0] = [];
/// let mut stream = StreamDecoder::default();
/// for datagram in datagrams {
///     match stream.push(datagram) {
///         Ok(strip) => println!("{} points at once", strip.points().len()),
///         Err(error) => println!("refused: {error}"),
///     }
///     while let Some(turn) = stream.next_turn() {
///         println!("turn {} is over: {} points", turn.number(), turn.points().len());
///     }
/// }
/// ```
///
/// RAM: of [`StreamLimits::open_turns`] turns a stream, and [`StreamLimits::turns_over`] that are over and not yet taken, 2
/// bytes a pixel; a turn has at most 8192 columns, whoever sends it.
#[derive(Debug, Default)]
pub struct StreamDecoder {
    limits: StreamLimits,
    known: Vec<Arc<Known>>,
    streams: Vec<Stream>,
    over: VecDeque<ReceivedTurn>,
    losses: StreamLosses,
}

impl StreamDecoder {
    /// A decoder that holds no more than `limits` say.
    #[must_use]
    pub fn new(limits: StreamLimits) -> Self {
        Self { limits, ..Self::default() }
    }

    /// Makes a sensor's grid known; the built-in ones that measure on one grid are.
    ///
    /// # Errors
    /// What [`SensorGrid::check`] finds.
    pub fn know(&mut self, grid: &SensorGrid<'_>) -> Result<(), ConfigError> {
        grid.check()?;
        if !self.known.iter().any(|known| known.sensor == grid.checksum()) {
            self.known.push(Arc::new(Known::new(grid)));
        }
        Ok(())
    }

    /// Takes a datagram; gives the columns that it brought. What is refused changes nothing.
    ///
    /// # Errors
    /// [`DatagramError`].
    pub fn push(&mut self, datagram: &[u8]) -> Result<&ReceivedStrip, DatagramError> {
        self.losses.datagrams += 1;
        let (stream, turn, strip) = self.take(datagram).inspect_err(|_| self.losses.refused += 1)?;
        Ok(&self.streams[stream].open[turn].strips[&strip])
    }

    /// The oldest turn that is over: all of it has come, or newer ones have.
    pub fn next_turn(&mut self) -> Option<ReceivedTurn> {
        (0..self.streams.len()).for_each(|stream| self.end_complete(stream));
        self.over.pop_front()
    }

    /// Ends the oldest turns as long as all of them has come. Not at once when it has: its last strip is lent out then.
    fn end_complete(&mut self, stream: usize) {
        while self.streams[stream].open.front().is_some_and(OpenTurn::is_complete) {
            self.end_oldest(stream);
        }
    }

    /// Ends all turns that are open, as when the time for them is over; [`next_turn`](Self::next_turn) then gives them.
    pub fn flush(&mut self) {
        for stream in 0..self.streams.len() {
            while !self.streams[stream].open.is_empty() {
                self.end_oldest(stream);
            }
        }
    }

    /// What did not come.
    #[must_use]
    pub const fn losses(&self) -> StreamLosses {
        self.losses
    }

    /// The sensor whose datagram it is, its header and its strip's code.
    fn parse<'a>(&mut self, datagram: &'a [u8]) -> Result<(Arc<Known>, StripHeader, &'a [u8]), DatagramError> {
        let datagram = Datagram::new(datagram)?;
        let is_half = |sensor: u32| sensor as u16 == datagram.sensor();
        let mut error = DatagramError::UnknownSensor { sensor: datagram.sensor() };
        for known in self.known.iter().filter(|known| is_half(known.sensor)) {
            match datagram.of(known.sensor) {
                Ok((header, code)) => return Ok((known.clone(), header, code)),
                Err(found) => error = found,
            }
        }
        for grid in sensors::ALL.iter().filter(|grid| is_half(grid.checksum())) {
            match datagram.of(grid.checksum()) {
                Ok((header, code)) => {
                    let known = Arc::new(Known::new(grid));
                    self.known.push(known.clone());
                    return Ok((known, header, code));
                }
                Err(found) => error = found,
            }
        }
        Err(error)
    }

    fn take(&mut self, datagram: &[u8]) -> Result<(usize, usize, u16), DatagramError> {
        let (sensor, header, code) = self.parse(datagram)?;
        let found =
            self.streams.iter().position(|stream| stream.sensor.sensor == header.sensor && stream.id == header.id);
        let max = self.limits.streams.max(1);
        if found.is_none() && self.streams.len() >= max {
            return Err(DatagramError::Streams { max });
        }
        // Before the work of decoding it.
        let begins_anew =
            found.map_or(Ok(false), |stream| self.streams[stream].check(&header, self.limits.open_turns.max(1)))?;
        let strip = ReceivedStrip::decode(header, sensor.clone(), code)?;
        let stream = found.unwrap_or_else(|| {
            self.streams.push(Stream { sensor, id: header.id, open: VecDeque::new(), last_over: None });
            self.streams.len() - 1
        });
        self.end_complete(stream);
        if begins_anew {
            while !self.streams[stream].open.is_empty() {
                self.end_oldest(stream);
            }
            self.streams[stream].last_over = None;
        }
        let turn = self.open_turn(stream, header.turn);
        self.streams[stream].open[turn].insert(strip);
        Ok((stream, turn, header.strip))
    }

    /// Where the turn is, opened if it was not.
    fn open_turn(&mut self, stream: usize, number: u16) -> usize {
        let open = &mut self.streams[stream].open;
        let mut at = open.iter().position(|open| ahead_of(number, open.number) <= 0).unwrap_or(open.len());
        if open.get(at).is_none_or(|open| open.number != number) {
            open.insert(at, OpenTurn { number, sent: None, strips: BTreeMap::new() });
        }
        // Never the one that was asked for: it is given back.
        while self.streams[stream].open.len() > self.limits.open_turns.max(1) && at > 0 {
            self.end_oldest(stream);
            at -= 1;
        }
        at
    }

    fn end_oldest(&mut self, stream: usize) {
        let Stream { sensor, id, open, last_over } = &mut self.streams[stream];
        let Some(OpenTurn { number, sent, strips }) = open.pop_front() else { return };
        *last_over = Some(number);
        let strips = strips.into_values().collect();
        let turn = ReceivedTurn { sensor: sensor.sensor, stream: *id, number, sent, strips };
        self.losses.incomplete_turns += u64::from(!turn.is_complete());
        self.losses.missing_strips += turn.missing().count() as u64;
        while self.over.len() >= self.limits.turns_over.max(1) {
            self.over.pop_front();
            self.losses.dropped_turns += 1;
        }
        self.over.push_back(turn);
    }
}

/// How many turns `turn` is ahead of `other`, around the numbers' end.
const fn ahead_of(turn: u16, other: u16) -> i16 {
    turn.wrapping_sub(other).cast_signed()
}

impl Stream {
    /// Whether a strip may be taken; gives whether the sender began anew with it. A turn that is over stays so.
    fn check(&self, header: &StripHeader, open_turns: usize) -> Result<bool, DatagramError> {
        let turn = header.turn;
        let newest = self.open.back().map(|open| open.number).or(self.last_over);
        let apart = newest.map_or(0, |newest| ahead_of(turn, newest).unsigned_abs());
        if apart > TURNS_APART_MAX.unsigned_abs() {
            return Ok(true);
        }
        let is_waited_for =
            self.open.len() < open_turns || self.open.iter().any(|open| ahead_of(turn, open.number) >= 0);
        if !is_waited_for || self.last_over.is_some_and(|last| ahead_of(turn, last) <= 0) {
            return Err(DatagramError::TooLate { turn });
        }
        self.open.iter().find(|open| open.number == turn).map_or(Ok(()), |open| open.check(header))?;
        Ok(false)
    }
}

impl OpenTurn {
    fn is_complete(&self) -> bool {
        self.sent.is_some_and(|sent| usize::from(sent) == self.strips.len())
    }

    /// Whether a strip goes with those that are here: behind those of lower numbers, before those of higher ones.
    fn check(&self, header: &StripHeader) -> Result<(), DatagramError> {
        let StripHeader { turn, strip, .. } = *header;
        if self.strips.contains_key(&strip) {
            return Err(DatagramError::Twice { turn, strip });
        }
        let before = self.strips.range(..strip).next_back().map(|(_, before)| before.header);
        let behind = self.strips.range(strip..).next().map(|(_, behind)| behind.header);
        let span = header.span();
        let right = before.is_none_or(|before| !before.last && before.span().end <= span.start)
            && behind.is_none_or(|behind| !header.last && span.end <= behind.span().start);
        if right { Ok(()) } else { Err(DatagramError::Disagrees { turn, strip }) }
    }

    fn insert(&mut self, strip: ReceivedStrip) {
        if strip.header.last {
            self.sent = Some(strip.header.strip.saturating_add(1));
        }
        self.strips.insert(strip.header.strip, strip);
    }
}
