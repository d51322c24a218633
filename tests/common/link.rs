//! A link of which the bandwidth changes, as a discrete-event simulation: datagrams queue before it, are lost or come later at
//! the other end, and what the link can carry is told to the sender when it is a little old.
#![allow(dead_code, reason = "each user takes a part")]

use std::collections::VecDeque;

use flicr::coder::{ContextSettings, SmallModel};
use flicr::control::{Bounds, Budget, Control, TurnReport};
use flicr::geometry::sensors::hdl64e;
use flicr::simulate::Simulator;
use flicr::stream::{AsFired, StreamConfig, StreamDecoder, StreamEncoder, StreamLimits};

/// Of the sensor, microseconds.
const TURN_US: u64 = 100_000;

#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// Share of the datagrams that never come.
    pub loss: f64,
    /// From one end to the other, besides the time that the bytes take.
    pub delay_us: u64,
    /// How old what the sender knows of the bandwidth is.
    pub feedback_us: u64,
    pub seed: u64,
}

impl Link {
    /// Bytes a second: a good link that falls to a tenth, gets better by and by, and sways.
    pub fn bandwidth(time_us: u64) -> u32 {
        let second = time_us as f64 / 1e6;
        let bytes = match second {
            ..0.6 => 900_000.0,
            0.6..1.2 => 90_000.0,
            1.2..1.8 => 90_000.0 + (second - 1.2) / 0.6 * 510_000.0,
            _ => 400_000.0 + 200_000.0 * (second * 9.0).sin(),
        };
        bytes as u32
    }
}

/// What became of a turn.
#[derive(Debug, Clone)]
pub struct Outcome {
    pub report: TurnReport,
    /// When it began.
    pub began_us: u64,
    /// What the link carries then.
    pub bandwidth: u32,
    /// From the turn's begin until its last datagram was at the other end.
    pub latency_us: u64,
    pub strips_sent: usize,
    pub strips_received: usize,
    /// Share of the turn's columns that came.
    pub columns_received: f64,
}

/// Datagrams on their way.
struct Way {
    link: Link,
    /// When the last of them will have left.
    free_us: f64,
    state: u64,
    /// When it arrives, its turn, and its bytes.
    flying: VecDeque<(u64, u16, Vec<u8>)>,
}

impl Way {
    fn random(&mut self) -> f64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Gives when it will be there.
    fn send(&mut self, now_us: u64, turn: u16, datagram: &[u8]) -> u64 {
        self.free_us = self.free_us.max(now_us as f64);
        self.free_us += datagram.len() as f64 / f64::from(Link::bandwidth(self.free_us as u64)) * 1e6;
        let there_us = self.free_us as u64 + self.link.delay_us;
        if self.random() >= self.link.loss {
            self.flying.push_back((there_us, turn, datagram.to_vec()));
        }
        there_us
    }
}

/// A drive's turns over the link, steered by what is known of it.
pub fn run(link: Link, turns: usize, bounds: Bounds) -> Vec<Outcome> {
    let config = StreamConfig::new(&hdl64e::FIRING_GRID, 1, ContextSettings::FINE).unwrap();
    let mut stream: StreamEncoder<SmallModel, 8, 1400, AsFired> = StreamEncoder::new(config).unwrap();
    let known = |now_us: u64| Budget::BytesASecond(Link::bandwidth(now_us.saturating_sub(link.feedback_us)));
    let mut control = Control::new(known(0), bounds);
    control.begin(&mut stream);
    let mut receiver = StreamDecoder::new(StreamLimits { turns_over: turns, ..StreamLimits::default() });
    let mut way = Way { link, free_us: 0.0, state: link.seed, flying: VecDeque::new() };
    let (mut outcomes, mut received): (Vec<Outcome>, _) = (Vec::new(), vec![0; turns]);
    for (number, turn) in Simulator::hdl64e(9).take(turns).enumerate() {
        let began_us = number as u64 * TURN_US;
        let columns = turn.firing_ticks.len();
        let mut levels = vec![[0_u32; 64]; columns];
        for found in &turn.returns {
            levels[usize::from(found.firing)][usize::from(found.beam)] = found.count;
        }
        let mut sent = 0;
        for index in 0..=columns {
            let now_us = began_us + (index as u64 * TURN_US) / columns as u64;
            control.set_budget(known(now_us));
            match levels.get(index) {
                Some(counts) => stream.feed_counts(index as u16, turn.firing_ticks[index], now_us * 1000, counts),
                None => stream.feed_turn_end(),
            }
            while let Some(datagram) = stream.next_datagram() {
                let there_us = way.send(now_us, number as u16, datagram);
                sent += 1;
                if let Some(report) = control.sent(&mut stream, 0) {
                    outcomes.push(Outcome {
                        report,
                        began_us,
                        bandwidth: Link::bandwidth(began_us),
                        latency_us: there_us - began_us,
                        strips_sent: sent,
                        strips_received: 0,
                        columns_received: columns as f64,
                    });
                }
            }
            while way.flying.front().is_some_and(|(there_us, ..)| *there_us <= now_us) {
                receive(&mut way, &mut receiver, &mut received);
            }
        }
    }
    while !way.flying.is_empty() {
        receive(&mut way, &mut receiver, &mut received);
    }
    receiver.flush();
    for (outcome, received) in outcomes.iter_mut().zip(received) {
        outcome.strips_received = received;
    }
    while let Some(turn) = receiver.next_turn() {
        let outcome = &mut outcomes[usize::from(turn.number())];
        let columns = turn.mask().iter().filter(|&&came| came).count();
        outcome.columns_received = columns as f64 / outcome.columns_received;
    }
    outcomes
}

fn receive(way: &mut Way, receiver: &mut StreamDecoder, received: &mut [usize]) {
    let Some((_, turn, datagram)) = way.flying.pop_front() else { return };
    receiver.push(&datagram).unwrap();
    received[usize::from(turn)] += 1;
}
