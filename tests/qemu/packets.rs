//! Packets to frames: the host's side of `examples/firmware/packets.rs`.

use flicr::geometry::Beam;
use flicr::geometry::sensors::{SensorGeometry, hesai, velodyne};
use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::{EncodedTurn, GridConfig, ImageViewMut, PacketEncoder, Rle, Scale};
use libtest_mimic::Failed;

use crate::board::Board;
use crate::frames::{Even, Frame};

/// Every second tick at a sensor's usual 600 turns a minute, and so few columns that returns collide.
static VLP16: [Frame; 2] = [frame(1800, "vlp16"), frame(256, "vlp16")];
static VLP32C: [Frame; 2] = [frame(1800, "vlp32c"), frame(256, "vlp32c")];
static PANDAR40P: [Frame; 2] = [frame(1800, "pandar40p"), frame(256, "pandar40p")];

/// Most Thumb-2 instructions from packets to image, a return that is in the packets; a fifth of the made-up cells hold
/// none, and are paid for by the others. Promised are 45: where each beam sends two returns, one is read for nothing.
fn instructions_max(line: &str) -> f64 {
    let is = |what: &str| line.split(' ').any(|field| field == what);
    match (is("coder=pandar40p"), is("coder=vlp16"), is("columns=256")) {
        (true, _, false) => 34.0,
        (true, _, true) => 38.0,
        (_, true, false) => 45.0,
        (_, true, true) => 58.0,
        (_, _, false) => 54.0,
        (_, _, true) => 59.0,
    }
}

const fn frame(columns: usize, coder: &'static str) -> Frame {
    Frame::Even(Even { columns, coder, max_range_m: 120.0 })
}

/// What is made of a sensor's packets.
pub fn jobs(model: Model) -> &'static [Frame] {
    match model {
        Model::Vlp16 => &VLP16,
        Model::Vlp32c => &VLP32C,
        Model::Pandar40p => &PANDAR40P,
        other => unreachable!("no firmware for {other:?}"),
    }
}

fn sensor(model: Model) -> &'static SensorGeometry {
    match model {
        Model::Vlp16 => &velodyne::VLP16,
        Model::Vlp32c => &velodyne::VLP32C,
        Model::Pandar40p => &hesai::PANDAR40P,
        other => unreachable!("no firmware for {other:?}"),
    }
}

/// The file that the firmware reads: each packet behind its length.
pub fn file_of(packets: &[Vec<u8>]) -> Vec<u8> {
    packets.iter().flat_map(|packet| [&(packet.len() as u16).to_le_bytes()[..], packet].concat()).collect()
}

/// The frames of all turns, one behind the other.
pub fn encode(frame: &Frame, model: Model, packets: &[Vec<u8>]) -> Vec<u8> {
    let Frame::Even(frame) = frame else { unreachable!("packets are not encoded by firings") };
    let sensor = sensor(model);
    let mut beams = vec![Beam::default(); sensor.beams.len()];
    let beams = sensor.fill_beams_at(600, &mut beams).expect("as many beams");
    let scale = Scale::Fixed { max_range_m: frame.max_range_m };
    let grid = GridConfig::new(sensor.grid_of(beams), frame.columns as u16);
    let config = GridConfig { scale, level_bits: u8::BITS, table: true, ..grid };
    let mut levels = vec![0_u8; beams.len() * frame.columns];
    let image = ImageViewMut::new(&mut levels, frame.columns).expect("whole rows");
    let (mut coder, turns) = (Rle::new(), TurnAssembler::new(Sensor::Spinning(model), ReturnPolicy::Strongest));
    let mut encoder = PacketEncoder::new(&config, turns, [image], &mut coder).expect("a valid configuration");
    let mut out = vec![0; config.worst_case_len::<u8, Rle>()];
    let mut frames = Vec::new();
    let mut take = |turn: Option<EncodedTurn>, out: &[u8]| {
        turn.iter().flat_map(|turn| turn.frames).for_each(|frame| frames.extend_from_slice(&out[..frame.len]));
    };
    for packet in packets {
        take(encoder.push(packet, &mut out).expect("good packets"), &out);
    }
    take(encoder.finish(&mut out).expect("fits"), &out);
    frames
}

/// Instructions a return on Thumb-2 do not grow.
pub fn check_cost(board: &Board, printed: &str) -> Result<(), Failed> {
    println!("{}: {printed}", board.name);
    for line in printed.lines() {
        let field = line.split(' ').find_map(|field| field.strip_prefix("hundredths_a_return="));
        let instructions = field.ok_or("no cost")?.parse::<f64>()? / 100.0;
        if board.is_thumb() && instructions > instructions_max(line) {
            return Err(format!("{instructions} instructions a return: {line}").into());
        }
    }
    Ok(())
}
