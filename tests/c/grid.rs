//! The example client of packets and returns (`examples/c/packets.c`) makes Rust's bytes.

use std::path::Path;

use flicr::geometry::sensors::{hdl64e, velodyne};
use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::{DeflateSmall, FrameEncoder, GridConfig, GridReturn, ImageViewMut, PacketEncoder, Rle, Scale, Stamp};
use libtest_mimic::Failed;

use crate::writer::Plan;
use crate::{Client, scratch};

pub fn bytes_are_rusts(client: Client) -> Result<(), Failed> {
    let plan = Plan { start_tick: 18_000, ..Plan::new(Model::Vlp16, true) };
    let mut packets = plan.packets(300);
    // One that is refused.
    packets[77][1205] = 0;
    let out_prefix = scratch(&format!("{}-grid", client.name));
    let input = out_prefix.with_extension("packets");
    let framed = packets.iter().flat_map(|packet| [&(packet.len() as u16).to_le_bytes()[..], packet].concat());
    std::fs::write(&input, framed.collect::<Vec<u8>>())?;
    client.run_example("packets", &out_prefix, Some(&input))?;
    compare(&out_prefix, "packets", &of_packets(&packets))?;
    compare(&out_prefix, "returns", &of_returns())
}

fn compare(out_prefix: &Path, name: &str, expected: &[u8]) -> Result<(), Failed> {
    let from_c = std::fs::read(format!("{}-{name}.flicr", out_prefix.display()))?;
    if from_c == expected {
        return Ok(());
    }
    Err(format!("{name}: {} bytes, Rust's {}", from_c.len(), expected.len()).into())
}

fn of_packets(packets: &[Vec<u8>]) -> Vec<u8> {
    let beams = velodyne::VLP16.beams_at::<16>(600).expect("16 beams");
    let config = GridConfig { table: true, ..GridConfig::new(velodyne::VLP16.grid_of(&beams), 1800) };
    let mut levels = vec![0_u16; 16 * 1800];
    let image = ImageViewMut::new(&mut levels, 1800).expect("whole rows");
    let (mut coder, turns) = (Rle::new(), TurnAssembler::new(Sensor::Spinning(Model::Vlp16), ReturnPolicy::Strongest));
    let mut encoder = PacketEncoder::new(&config, turns, [image], &mut coder).expect("a valid configuration");
    let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
    let mut frames = Vec::new();
    for packet in packets {
        if let Ok(Some(turn)) = encoder.push(packet, &mut out) {
            frames.extend_from_slice(&out[..turn.frames[0].len]);
        }
    }
    if let Some(turn) = encoder.finish(&mut out).expect("fits") {
        frames.extend_from_slice(&out[..turn.frames[0].len]);
    }
    frames
}

fn of_returns() -> Vec<u8> {
    let scale = Scale::Step { step_m: 0.314 };
    let config = GridConfig { level_bits: 8, scale, ..GridConfig::new(hdl64e::GRID, 4000) };
    let mut levels = vec![0_u8; 64 * 4000];
    let image = ImageViewMut::new(&mut levels, 4000).expect("whole rows");
    let mut coder = DeflateSmall::new();
    let stamp = Stamp { sequence: 7, timestamp_ns: 1_000_000_000 };
    let mut frame = FrameEncoder::start(&config, stamp, image, &mut coder).expect("a valid configuration");
    frame.insert_returns((0..4000).step_by(2).flat_map(|tick| {
        (0..64).map(move |row| {
            let count = if (tick / 2 + row) % 5 > 0 { 2000 + (tick * 7 + row * 131) % 30_000 } else { 0 };
            GridReturn { tick, count, row: row as u16 }
        })
    }));
    let mut out = vec![0; config.worst_case_len::<u8, DeflateSmall>()];
    let encoded = frame.finish(&mut out).expect("fits");
    out.truncate(encoded.len);
    out
}
