//! Packets of the simulated sensors, as real ones would send them.
#![allow(dead_code, reason = "each test uses a part")]

use flicr::packet::Model;
use flicr::simulate::{Sensor, Simulator};
use flicr::stream::write_framed;

/// A firing of all beams: its tick, its time and its counts, from the highest beam.
pub struct Firing {
    pub tick: u16,
    pub time_ns: u64,
    pub counts: Vec<u16>,
}

/// All firings of a drive, turn after turn.
pub fn firings(sensor: Sensor, seed: u64) -> impl Iterator<Item = Firing> {
    let (beams, period_ns) = (sensor.beams.len(), sensor.period_ns);
    Simulator::with_sensor(sensor, seed).flat_map(move |turn| {
        let columns = turn.firing_ticks.len();
        let mut counts = vec![vec![0; beams]; columns];
        for found in &turn.returns {
            counts[usize::from(found.firing)][usize::from(found.beam)] = found.count as u16;
        }
        let (time_ns, ticks) = (turn.time_ns, turn.firing_ticks);
        ticks.into_iter().zip(counts).zip(0..).map(move |((tick, counts), nth)| Firing {
            tick,
            time_ns: time_ns + nth * period_ns / columns as u64,
            counts,
        })
    })
}

/// A VLP-16's packets: 12 blocks of two firings each, endless.
pub fn vlp16(seed: u64) -> impl Iterator<Item = Vec<u8>> {
    let mut firings = firings(Sensor::vlp16(), seed);
    std::iter::from_fn(move || {
        let packet: Vec<_> = firings.by_ref().take(24).collect();
        let blocks = packet.chunks_exact(2).flat_map(|pair| {
            let mut block = [&[0xff, 0xee][..], &pair[0].tick.to_le_bytes()].concat();
            for firing in pair {
                for &row in Model::Vlp16.facts().beam_of_channel {
                    put(&mut block, firing.counts[usize::from(row)]);
                }
            }
            block
        });
        Some(velodyne(blocks.collect(), packet[0].time_ns, [0x37, 0x22]))
    })
}

/// Packets like an HDL-64E's, as `examples/live_firmware/packets.rs` reads them: six firings of two blocks each, endless.
pub fn hdl64e(seed: u64) -> impl Iterator<Item = Vec<u8>> {
    let mut firings = firings(Sensor::hdl64e(), seed);
    std::iter::from_fn(move || {
        let packet: Vec<_> = firings.by_ref().take(6).collect();
        let blocks = packet.iter().flat_map(|firing| {
            let halves = firing.counts.chunks_exact(32).zip([[0xff, 0xee], [0xff, 0xdd]]);
            halves.flat_map(|(counts, flag)| {
                let mut block = [flag, (9 * firing.tick).to_le_bytes()].concat();
                for &count in counts {
                    put(&mut block, count);
                }
                block
            })
        });
        Some(velodyne(blocks.collect(), packet[0].time_ns, [0, 0]))
    })
}

/// A return: its count and an intensity.
fn put(block: &mut Vec<u8>, count: u16) {
    block.extend(count.to_le_bytes());
    block.push(if count == 0 { 0 } else { 100 });
}

fn velodyne(mut packet: Vec<u8>, time_ns: u64, tail: [u8; 2]) -> Vec<u8> {
    packet.extend(((time_ns / 1000 % 3_600_000_000) as u32).to_le_bytes());
    packet.extend(tail);
    assert_eq!(packet.len(), 1206);
    packet
}

/// Packets over a byte stream, and the one of no bytes that says that no more will come.
pub fn framed(packets: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for packet in packets.iter().map(Vec::as_slice).chain([&[][..]]) {
        write_framed(&mut bytes, packet).expect("a vector takes all");
    }
    bytes
}
