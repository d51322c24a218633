//! Rates, latencies and losses of what is received.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use flicr::stream::{ReceivedStrip, ReceivedTurn};

use crate::table::grouped;

/// Rates are of this time.
const WINDOW: Duration = Duration::from_secs(2);

/// What came, in numbers.
#[derive(Debug, Clone, Copy, Default)]
pub struct Amount {
    pub bytes: u64,
    pub datagrams: u64,
    pub turns: u64,
}

/// What came in a time.
#[derive(Debug)]
pub struct Tally {
    pub total: Amount,
    began: Option<Instant>,
    newest: Option<Instant>,
    recent: VecDeque<(Instant, Amount)>,
    /// Of the strips since the last turn was over.
    latencies: Vec<usize>,
    /// Of strips of all turns: how many, their sum, the worst.
    all_latencies: (u64, u64, usize),
}

impl Tally {
    pub const fn new() -> Self {
        let total = Amount { bytes: 0, datagrams: 0, turns: 0 };
        Self {
            total,
            began: None,
            newest: None,
            recent: VecDeque::new(),
            latencies: Vec::new(),
            all_latencies: (0, 0, 0),
        }
    }

    pub fn take_datagram(&mut self, len: usize, now: Instant) {
        self.took(Amount { bytes: len as u64, datagrams: 1, turns: 0 }, now);
    }

    pub fn take_strip(&mut self, strip: &ReceivedStrip) {
        if strip.columns().next().is_none() {
            return;
        }
        let latency = strip.latency();
        self.latencies.push(latency);
        let (count, sum, worst) = &mut self.all_latencies;
        (*count, *sum, *worst) = (*count + 1, *sum + latency as u64, (*worst).max(latency));
    }

    /// A line about a turn that is over.
    pub fn take_turn(&mut self, turn: &ReceivedTurn, points: usize, now: Instant) -> String {
        self.took(Amount { bytes: 0, datagrams: 0, turns: 1 }, now);
        let (median, worst) = self.take_latencies();
        let columns = turn.mask().iter().filter(|&&is_there| is_there).count();
        let lost = if turn.is_complete() {
            "complete".to_owned()
        } else {
            format!("incomplete: {} strips missing", turn.missing().count())
        };
        format!(
            "turn {}: {} points, {} columns, {} strips, {}, latency {median} columns (worst {worst}), {lost}",
            turn.number(),
            grouped(points as u64),
            grouped(columns as u64),
            turn.strips().len(),
            self.rates(now),
        )
    }

    /// Median and worst, in columns, of the strips that came since the last call.
    fn take_latencies(&mut self) -> (usize, usize) {
        self.latencies.sort_unstable();
        let at = |place: usize| self.latencies.get(place).copied().unwrap_or(0);
        let found = (at(self.latencies.len() / 2), at(self.latencies.len().saturating_sub(1)));
        self.latencies.clear();
        found
    }

    fn took(&mut self, amount: Amount, now: Instant) {
        self.began.get_or_insert(now);
        self.newest = Some(now);
        let Amount { bytes, datagrams, turns } = &mut self.total;
        (*bytes, *datagrams) = (*bytes + amount.bytes, *datagrams + amount.datagrams);
        *turns += amount.turns;
        self.recent.push_back((now, amount));
        while self.recent.front().is_some_and(|&(at, _)| now.duration_since(at) > WINDOW) {
            self.recent.pop_front();
        }
    }

    /// Bytes, datagrams and turns a second, of late.
    pub fn rates(&self, now: Instant) -> String {
        let recent = self.recent.iter().map(|(_, amount)| amount);
        let sum = recent.fold(Amount::default(), |sum, amount| Amount {
            bytes: sum.bytes + amount.bytes,
            datagrams: sum.datagrams + amount.datagrams,
            turns: sum.turns + amount.turns,
        });
        let since_first = self.began.map_or(WINDOW, |began| now.duration_since(began));
        rates_of(sum, since_first.min(WINDOW))
    }

    /// The same of all the time, and the latencies.
    pub fn summary(&self) -> String {
        let time = self.began.zip(self.newest).map_or(Duration::ZERO, |(began, newest)| newest.duration_since(began));
        let (count, sum, worst) = self.all_latencies;
        let mean = sum.checked_div(count).unwrap_or(0);
        format!(
            "{} turns, {} datagrams, {} bytes in {:.1} s: {}; latency {mean} columns on average, {worst} at most",
            grouped(self.total.turns),
            grouped(self.total.datagrams),
            grouped(self.total.bytes),
            time.as_secs_f64(),
            rates_of(self.total, time),
        )
    }
}

/// Of less than this no rate is made.
const TIME_MIN: Duration = Duration::from_millis(10);

fn rates_of(Amount { bytes, datagrams, turns }: Amount, time: Duration) -> String {
    let seconds = time.max(TIME_MIN).as_secs_f64();
    let a_second = |amount: u64| amount as f64 / seconds;
    format!(
        "{:.1} KB/s, {:.0} datagrams/s, {:.1} turns/s",
        a_second(bytes) / 1000.0,
        a_second(datagrams),
        a_second(turns)
    )
}
