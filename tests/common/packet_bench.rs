//! One bad packet among good ones.
#![allow(dead_code, reason = "each test uses a part")]

use super::stream::{Placed, Stream};
use flicr::packet::{PacketError, ReturnPolicy, Sensor, TurnAssembler};

pub const BOTH: ReturnPolicy = ReturnPolicy::Both;

/// Neighbours before and after the bad packet.
pub const BEFORE: usize = 4;
pub const AFTER: usize = 4;

/// Decodes `stream` up to the bad packet once, then runs each variant of it and the packets after.
pub struct Bench {
    assembler: TurnAssembler,
    pub bad_at: usize,
    pub packets: Vec<Vec<u8>>,
    /// Returns of the packets after the bad one, as they should be.
    after: Vec<Placed>,
    first_turn: u32,
}

impl Bench {
    pub fn new(packets: Vec<Vec<u8>>, sensor: Sensor) -> Self {
        let mut assembler = TurnAssembler::new(sensor, BOTH);
        let mut start = Stream::default();
        for packet in &packets[..BEFORE] {
            assembler.push(packet, |event| start.take(event)).expect("good packets");
        }
        let mut bench = Self { assembler, bad_at: BEFORE, packets, after: Vec::new(), first_turn: start.turn };
        let good = bench.packets[BEFORE].clone();
        bench.after = bench.run(&good).1;
        assert!(!bench.after.is_empty());
        bench
    }

    /// Outcome of the bad packet, and the returns of those after it.
    fn run(&self, bad: &[u8]) -> (Result<(), PacketError>, Vec<Placed>) {
        let mut assembler = self.assembler;
        let mut stream = Stream { turn: self.first_turn, ..Stream::default() };
        let mut called = false;
        let outcome = assembler.push(bad, |event| {
            called = true;
            stream.take(event);
        });
        assert!(outcome.is_ok() || !called, "a refused packet was used");
        let before = assembler.stats().refused();
        stream.returns.clear();
        for packet in &self.packets[self.bad_at + 1..] {
            assembler
                .push(packet, |event| stream.take(event))
                .unwrap_or_else(|error| panic!("good packet after a bad one ({outcome:?}): {error}"));
        }
        assert_eq!(assembler.stats().refused(), before);
        (outcome, stream.returns)
    }

    /// The neighbours come out as they should, whatever the packet was.
    pub fn check(&self, bad: &[u8]) -> Result<(), PacketError> {
        let (outcome, after) = self.run(bad);
        let same = after.len() == self.after.len()
            && after.iter().zip(&self.after).all(|(a, b)| {
                // The step from packet to packet may carry what the bad one said for a while.
                Placed { step_q8: 0, ..*a } == Placed { step_q8: 0, ..*b }
            });
        assert!(same, "neighbour changed: {outcome:?} {:?} {:?}", after.first(), self.after.first());
        outcome
    }
}
