//! What an assembler makes of packets, written down.
#![allow(dead_code, reason = "each test uses a part")]

use flicr::packet::{Event, ReturnPolicy, Sensor, Turn, TurnAssembler};

/// A return with what is needed to place it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    pub turn: u32,
    pub column: u16,
    pub layer: u8,
    pub beam: u8,
    pub tick: u16,
    pub step_q8: u32,
    pub count: u32,
    pub intensity: u16,
    pub time_ns: u64,
}

/// All that an assembler makes of a sequence of packets.
#[derive(Debug, Default)]
pub struct Stream {
    pub returns: Vec<Placed>,
    pub turns: Vec<Turn>,
    pub gaps: Vec<(u32, u16, flicr::packet::GapCause)>,
    pub lost_turns: u32,
    pub stats: flicr::packet::PacketStats,
    pub errors: Vec<(usize, flicr::packet::PacketError)>,
    pub turn: u32,
}

impl Stream {
    pub fn of(packets: &[Vec<u8>], sensor: Sensor, policy: ReturnPolicy) -> Self {
        let mut turns = TurnAssembler::new(sensor, policy);
        let mut stream = Self::default();
        for (nth, packet) in packets.iter().enumerate() {
            if let Err(error) = turns.push(packet, |event| stream.take(event)) {
                stream.errors.push((nth, error));
            }
        }
        turns.finish(|event| stream.take(event));
        stream.stats = turns.stats();
        stream
    }

    pub fn take(&mut self, event: Event<'_>) {
        match event {
            Event::Column(column) => column.for_each_return(|r| {
                self.returns.push(Placed {
                    turn: self.turn,
                    column: r.column,
                    layer: column.layer,
                    beam: r.beam,
                    tick: r.tick,
                    step_q8: column.step_q8,
                    count: r.count,
                    intensity: r.intensity,
                    time_ns: r.time_ns,
                });
            }),
            Event::Gap { columns, cause } => self.gaps.push((self.turn, columns, cause)),
            Event::TurnEnd(turn) => {
                self.turns.push(turn);
                self.turn += 1;
            }
            Event::TurnsLost { turns } => {
                self.lost_turns += turns;
                self.turn += turns;
            }
            _ => {}
        }
    }
}
