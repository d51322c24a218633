//! How fast packets become an image: returns a second, on packets made here.
//!
//! ```text
//! cargo run --release --example packet_speed
//! valgrind --tool=callgrind target/release/examples/packet_speed vlp32c 40
//! ```
//!
//! With a sensor and a number of rounds it only decodes, for counting instructions: take the
//! difference of two numbers of rounds.

use flicr::packet::{Event, ReturnPolicy, Sensor, TurnAssembler};
use std::hint::black_box;
use std::time::Instant;

const ROWS: usize = 128;
const COLS: usize = 2048;
type Image = [[u16; COLS]; ROWS];

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

/// Decodes all packets into the image; returns what was written.
#[inline(never)]
fn into_image(packets: &[Vec<u8>], image: &mut Image) -> u64 {
    let mut turns = TurnAssembler::new(Sensor::Auto, ReturnPolicy::Strongest);
    let mut returns = 0;
    for packet in packets {
        let outcome = turns.push(packet, |event| {
            if let Event::Column(column) = event {
                let at = usize::from(column.index) % COLS;
                column.for_each_cell(|beam, cell| {
                    image[usize::from(beam) % ROWS][at] = cell.count as u16;
                    returns += u64::from(cell.count != 0);
                });
            }
        });
        outcome.expect("good packets");
    }
    returns
}

fn measure(kind: &Kind, image: &mut Image) {
    let packets = packets(kind);
    let mut best = f64::MAX;
    let mut returns = 0;
    for _ in 0..200 {
        let start = Instant::now();
        returns = black_box(into_image(black_box(&packets), image));
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!("{:10} {returns} returns, {:.0} million a second", kind.name, returns as f64 / best / 1e6);
}

fn main() {
    let mut image: Box<Image> = vec![[0; COLS]; ROWS].into_boxed_slice().try_into().expect("as many rows");
    let mut args = std::env::args().skip(1);
    let Some(name) = args.next() else {
        for kind in &KINDS {
            measure(kind, &mut image);
        }
        return;
    };
    let kind = KINDS.iter().find(|kind| kind.name == name);
    let packets = packets(kind.expect("vlp16, vlp32c, pandar40p or xt32"));
    let rounds = args.next().and_then(|rounds| rounds.parse().ok()).unwrap_or(1);
    let returns: u64 = (0..rounds).map(|_| into_image(black_box(&packets), &mut image)).sum();
    println!("{returns} returns");
}
