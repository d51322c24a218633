//! A receiver's memory does not grow, whatever a bad link does to ten thousand turns. Alone in its process, because what is
//! counted is the process's.

#[path = "common/small_sensor.rs"]
mod small_sensor;

use std::alloc::System;

use cap::Cap;
use flicr::coder::{ContextSettings, SmallModel, Step};
use flicr::stream::{StreamConfig, StreamDecoder, StreamEncoder};
use small_sensor::{GRID, Place, tick};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

const TURNS: u32 = 10_000;
const COLUMNS: usize = 40;

#[test]
fn ten_thousand_turns_take_no_more_than_a_thousand() {
    let settings = ContextSettings::FINE.with_step(Step::new(10).unwrap());
    let mut stream: StreamEncoder<SmallModel, 2, 150> =
        StreamEncoder::new(StreamConfig::new(&GRID, 1, settings).unwrap()).unwrap();
    let (mut taken, mut neglected) = (StreamDecoder::default(), StreamDecoder::default());
    taken.know(&GRID).unwrap();
    neglected.know(&GRID).unwrap();
    let (mut place, mut random) = (Place::new(1), Place::new(2));
    let (mut most_early, mut most) = (0, 0);
    let mut held_back: Vec<u8> = Vec::new();
    for turn in 0..TURNS {
        let mut arrive = |datagram: &[u8]| match random.random(10) {
            0 => {}
            1 => {
                let mut bytes = datagram.to_vec();
                let at = random.random(bytes.len() as u64) as usize;
                bytes[at] ^= 1;
                let _ = (taken.push(&bytes), neglected.push(&bytes));
            }
            2 => {
                // The last one that was held back comes now, this one later.
                let _ = (taken.push(&held_back), neglected.push(&held_back));
                held_back.clear();
                held_back.extend_from_slice(datagram);
            }
            _ => {
                let _ = (taken.push(datagram), neglected.push(datagram));
            }
        };
        for column in 0..COLUMNS {
            stream.push_counts(column as u16, tick(column, COLUMNS), 0, &place.column(), &mut arrive);
        }
        stream.end_turn(&mut arrive);
        // One whose turns are taken, one whose turns nobody takes.
        while taken.next_turn().is_some() {}
        most = most.max(ALLOCATOR.allocated());
        if turn == 1000 {
            most_early = most;
        }
    }
    println!("{most_early} bytes at most in the first thousand turns, {most} in all");
    let [taken, neglected] = [taken.losses(), neglected.losses()];
    println!("{taken:?} {neglected:?}");
    assert!(taken.refused > 1000 && taken.dropped_turns == 0 && neglected.dropped_turns > 7000);
    assert!(most <= most_early + most_early / 20, "{most_early} {most}");
}
