//! How fast packets become the range image of a frame: returns a second, on packets made here.
//!
//! ```text
//! cargo bench --features std --bench packets
//! valgrind --tool=callgrind target/release/deps/packets-... vlp32c 40
//! ```
//!
//! With a sensor and a number of rounds it only does that, for counting instructions: take the difference of two
//! numbers of rounds.
#![allow(missing_docs)]

use flicr::geometry::{Beam, SensorGrid};
use flicr::packet::{Event, ReturnPolicy, Sensor, TurnAssembler};
use flicr::{FrameEncoder, GridConfig, ImageViewMut, Stamp, Store};
use std::hint::black_box;
use std::time::Instant;

const COLUMNS: u16 = 1800;

/// Packets of one turn and a little more: what the formats have in common is blocks.
struct Kind {
    name: &'static str,
    header: &'static [u8],
    flags: &'static [u8],
    channels: usize,
    firings_a_block: usize,
    cell_len: usize,
    blocks: usize,
    /// Ticks a block.
    step: u16,
    tail: fn(packet: u32) -> Vec<u8>,
}

const KINDS: [Kind; 4] = [
    Kind {
        name: "vlp16",
        header: &[],
        flags: &[0xff, 0xee],
        channels: 16,
        firings_a_block: 2,
        cell_len: 3,
        blocks: 12,
        step: 40,
        tail: |packet| velodyne_tail(packet * 1327, 0x22),
    },
    Kind {
        name: "vlp32c",
        header: &[],
        flags: &[0xff, 0xee],
        channels: 32,
        firings_a_block: 1,
        cell_len: 3,
        blocks: 12,
        step: 20,
        tail: |packet| velodyne_tail(packet * 664, 0x28),
    },
    Kind {
        name: "pandar40p",
        header: &[],
        flags: &[0xff, 0xee],
        channels: 40,
        firings_a_block: 1,
        cell_len: 3,
        blocks: 10,
        step: 20,
        tail: |packet| {
            let mut tail = vec![0; 22];
            tail[10..14].copy_from_slice(&(packet * 556).to_le_bytes());
            tail[14] = 0x37;
            tail
        },
    },
    Kind {
        name: "xt32",
        header: &[0xee, 0xff, 6, 1, 0, 0, 32, 8, 0, 4, 1, 1],
        flags: &[],
        channels: 32,
        firings_a_block: 1,
        cell_len: 4,
        blocks: 8,
        step: 18,
        tail: |packet| {
            let mut tail = vec![0; 28];
            tail[10] = 0x37;
            tail[19..23].copy_from_slice(&(packet * 400).to_le_bytes());
            tail[24..].copy_from_slice(&packet.to_le_bytes());
            tail
        },
    },
];

fn velodyne_tail(micros: u32, product: u8) -> Vec<u8> {
    let mut tail = micros.to_le_bytes().to_vec();
    tail.extend([0x37, product]);
    tail
}

/// Two turns, every beam with a return but one in sixteen.
fn packets(kind: &Kind) -> Vec<Vec<u8>> {
    let count = 72_000 / (usize::from(kind.step) * kind.blocks);
    let mut scramble = 1u32;
    let mut tick = 0;
    (0..count as u32)
        .map(|nth| {
            let mut packet = kind.header.to_vec();
            for _ in 0..kind.blocks {
                packet.extend(kind.flags);
                packet.extend((tick % 36_000u16).to_le_bytes());
                tick = (tick + kind.step) % 36_000;
                for _ in 0..kind.channels * kind.firings_a_block {
                    scramble = scramble.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let none = scramble >> 28 == 0;
                    let count = if none { 0 } else { (scramble >> 12) as u16 | 1 };
                    packet.extend(count.to_le_bytes());
                    packet.resize(packet.len() + kind.cell_len - 2, (scramble >> 8) as u8);
                }
            }
            packet.extend((kind.tail)(nth));
            packet
        })
        .collect()
}

/// As many beams: an image knows them by their numbers only.
fn beams(rows: usize) -> Vec<Beam> {
    (0..rows).map(|row| Beam { slope: 0.3 - 0.01 * row as f32, ..Beam::default() }).collect()
}

/// Puts all packets into the frame's image, which is emptied first; returns how many returns there were.
#[inline(never)]
fn into_image(config: &GridConfig<'_>, packets: &[Vec<u8>], levels: &mut [u16]) -> u64 {
    let image = ImageViewMut::new(levels, config.columns.into()).expect("whole rows");
    let mut coder = Store::new();
    let mut frame = FrameEncoder::start(config, Stamp::default(), image, &mut coder).expect("a valid configuration");
    let mut turns = TurnAssembler::new(Sensor::Auto, ReturnPolicy::Strongest);
    for packet in packets {
        let outcome = turns.push(packet, |event| {
            if let Event::Column(column) = event {
                frame.insert_column(&column);
            }
        });
        outcome.expect("good packets");
    }
    u64::from(frame.tally().returns())
}

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|argument| !argument.starts_with("--"));
    let only = arguments.next();
    let rounds = arguments.next().and_then(|rounds| rounds.parse().ok());
    for kind in KINDS.iter().filter(|kind| only.as_ref().is_none_or(|only| only == kind.name)) {
        let beams = beams(kind.channels);
        let (range_unit_m, beams) = (0.002, beams.as_slice());
        let grid = SensorGrid {
            name: kind.name,
            beams,
            ticks: 36_000,
            clockwise: true,
            zero_rad: 0.0,
            range_unit_m,
            range_from_axis: false,
        };
        let config = GridConfig::new(grid, COLUMNS);
        let mut levels = vec![0; beams.len() * usize::from(COLUMNS)];
        measure(kind, &config, &mut levels, rounds);
    }
}

fn measure(kind: &Kind, config: &GridConfig<'_>, levels: &mut [u16], rounds: Option<u32>) {
    let packets = packets(kind);
    let mut times = Vec::new();
    let mut returns = 0;
    for _ in 0..rounds.unwrap_or(200) {
        let start = Instant::now();
        returns = black_box(into_image(config, black_box(&packets), levels));
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let [best, median] = [0, times.len() / 2].map(|at| returns as f64 / times[at] / 1e6);
    println!("{:10} {returns} returns, {best:.0} million a second at best, {median:.0} in the median", kind.name);
}
