//! Packets to frames: the image is what a few plain lines make of the returns, for every model, policy and layer; a bad
//! packet changes no other packet's pixels.

use crate::models::MODELS;
use crate::stream::{Placed, Stream};
use crate::writer::{self, Plan};
use flicr::geometry::{Beam, SensorGrid};
use flicr::packet::{Model, OusterFormat, OusterProfile, PacketError, ReturnPolicy, Sensor, TurnAssembler};
use flicr::{
    Collision, Decoder, EncodeError, EncodedTurn, GridConfig, ImageViewMut, Levels, Limits, PacketEncoder, PushError,
    Quantizer, Rle, Scale,
};
use proptest::prelude::*;

const POLICIES: [ReturnPolicy; 3] = [ReturnPolicy::Strongest, ReturnPolicy::Last, ReturnPolicy::Both];

/// As many beams, of any kind: images know them by their numbers only.
fn beams(rows: usize) -> Vec<Beam> {
    (0..rows).map(|row| Beam { slope: 0.3 - 0.005 * row as f32, ..Beam::default() }).collect()
}

fn grid(beams: &[Beam], ticks: u32, unit_um: u16) -> SensorGrid<'_> {
    let range_unit_m = f32::from(unit_um) * 1e-6;
    SensorGrid { name: "", beams, ticks, clockwise: true, zero_rad: 0.0, range_unit_m, range_from_axis: false }
}

/// What came out of a stream: every turn's frames.
#[derive(Debug, PartialEq)]
struct Frames<const LAYERS: usize> {
    turns: Vec<(EncodedTurn<LAYERS>, [Vec<u8>; LAYERS])>,
    refused: Vec<(usize, PacketError)>,
}

fn encode<const LAYERS: usize>(config: &GridConfig<'_>, turns: TurnAssembler, packets: &[Vec<u8>]) -> Frames<LAYERS> {
    let (rows, columns) = (config.grid.beams.len(), usize::from(config.columns));
    let mut levels: [Vec<u16>; LAYERS] = std::array::from_fn(|_| vec![7; rows * columns]);
    let images = levels.each_mut().map(|levels| ImageViewMut::new(levels, columns).expect("whole rows"));
    let mut coder = Rle::new();
    let mut encoder = PacketEncoder::new(config, turns, images, &mut coder).expect("a valid configuration");
    let mut out = vec![0; LAYERS * config.worst_case_len::<u16, Rle>()];
    let mut frames = Frames { turns: Vec::new(), refused: Vec::new() };
    for (nth, packet) in packets.iter().enumerate() {
        match encoder.push(packet, &mut out) {
            Ok(ended) => frames.turns.extend(ended.map(|turn| (turn, cut(&turn, &out)))),
            Err(PushError::Packet(error)) => frames.refused.push((nth, error)),
            Err(error) => panic!("{error}"),
        }
    }
    let ended = encoder.finish(&mut out).expect("fits");
    frames.turns.extend(ended.map(|turn| (turn, cut(&turn, &out))));
    assert_eq!(encoder.stats().used as usize + frames.refused.len(), packets.len());
    frames
}

fn cut<const LAYERS: usize>(turn: &EncodedTurn<LAYERS>, out: &[u8]) -> [Vec<u8>; LAYERS] {
    let mut at = 0;
    turn.frames.map(|frame| {
        at += frame.len;
        out[at - frame.len..at].to_vec()
    })
}

/// The levels of a frame, and its number and time.
fn decode(bytes: &[u8]) -> (Vec<u16>, u32, u64) {
    let mut decoder = Decoder::new(Limits::default());

    let frame = decoder.decode(bytes).expect("a frame");
    let Levels::U16(levels) = frame.levels() else { panic!("16 bits") };
    (levels.clone(), frame.header().sequence, frame.header().timestamp_ns)
}

/// The image by plain lines, with the counts of what is kept and what collided.
fn image(config: &GridConfig<'_>, returns: &[Placed], layer: u8) -> (Vec<u16>, u32, u32) {
    let Scale::Step { step_m } = config.scale else { panic!("a step") };
    let quantizer = Quantizer::with_step(config.level_bits, step_m).expect("a quantizer");
    let columns = usize::from(config.columns);
    let mut levels = vec![0_u16; config.grid.beams.len() * columns];
    let (mut kept, mut collided) = (0, 0);
    for ours in returns.iter().filter(|ours| ours.layer == layer) {
        let exact = f64::from(ours.tick) * columns as f64 / f64::from(config.grid.ticks);
        let column = (exact + 0.5).floor() as usize % columns;
        let range = f64::from(ours.count) * f64::from(config.grid.range_unit_m);
        let level = (range / f64::from(quantizer.step_m()) + 0.5).floor();
        if level < 1.0 || level > f64::from(quantizer.max_level()) {
            continue;
        }
        let pixel = &mut levels[usize::from(ours.beam) * columns + column];
        (kept, collided) = if *pixel == 0 { (kept + 1, collided) } else { (kept, collided + 1) };
        *pixel = match config.collision {
            _ if *pixel == 0 => level as u16,
            Collision::Nearest => (*pixel).min(level as u16),
            Collision::Farthest => (*pixel).max(level as u16),
            Collision::First => *pixel,
            Collision::Last => level as u16,
        };
    }
    (levels, kept, collided)
}

fn check<const LAYERS: usize>(config: &GridConfig<'_>, sensor: Sensor, policy: ReturnPolicy, packets: &[Vec<u8>]) {
    let frames = encode::<LAYERS>(config, TurnAssembler::new(sensor, policy), packets);
    let stream = Stream::of(packets, sensor, policy);
    assert_eq!(frames.refused, stream.errors);
    assert_eq!(frames.turns.iter().map(|(turn, _)| turn.turn).collect::<Vec<_>>(), stream.turns);
    for ((turn, bytes), number) in frames.turns.iter().zip(0..) {
        let returns: Vec<Placed> = stream.returns.iter().filter(|ours| ours.turn == number).copied().collect();
        for (layer, bytes) in bytes.iter().enumerate() {
            let (levels, sequence, time_ns) = decode(bytes);
            let (expected, kept, collided) = image(config, &returns, layer as u8);
            assert!(levels == expected, "{sensor:?} {policy:?}: layer {layer} of turn {number}");
            let tally = turn.frames[layer].tally;
            assert_eq!((tally.kept(), tally.collided), (kept, collided));
            let columns = u32::from(turn.turn.columns - turn.turn.missing);
            let cells = columns * config.grid.beams.len() as u32;
            assert!(tally.points == cells || layer == 1 && tally.points == 0, "every cell is counted");
            assert_eq!(sequence, turn.turn.number);
            let first = returns.iter().map(|ours| ours.time_ns).min();
            assert!(first.is_none_or(|first| time_ns <= first && first - time_ns < 1_000_000));
        }
    }
}

fn packets_of(model: Model, dual: bool) -> Vec<Vec<u8>> {
    let plan = Plan { start_tick: 20_000, ..Plan::new(model, dual) };
    plan.packets(3 * 1800 / plan.firings_a_packet())
}

#[test]
fn images_are_the_returns_of_every_model_and_policy() {
    for model in MODELS {
        let facts = model.facts();
        let beams = beams(facts.rows());
        let grid = grid(&beams, facts.ticks_per_turn.into(), facts.range_unit_um);
        let config = GridConfig { table: true, ..GridConfig::new(grid, 1800) };
        for (dual, policy) in [false, true].into_iter().flat_map(|dual| POLICIES.map(|policy| (dual, policy))) {
            let packets = packets_of(model, dual);
            check::<1>(&config, Sensor::Auto, policy, &packets);
            check::<2>(&config, Sensor::Spinning(model), policy, &packets);
        }
    }
}

#[test]
fn images_are_the_returns_of_every_ouster_profile() {
    for profile in [OusterProfile::Legacy, OusterProfile::Single, OusterProfile::Dual, OusterProfile::LowRate] {
        let format = OusterFormat::new(profile, 16, 512);
        let packets: Vec<_> =
            (0..3).flat_map(|frame| (0..512).step_by(16).map(move |id| writer::ouster(&format, frame, id))).collect();
        let beams = beams(16);
        let config = GridConfig {
            table: true,
            scale: Scale::Step { step_m: 0.016 },
            ..GridConfig::new(grid(&beams, 512, profile.range_unit_um()), 512)
        };
        for policy in POLICIES {
            check::<2>(&config, Sensor::Ouster(format), policy, &packets);
        }
    }
}

#[test]
fn collisions_and_levels_are_settled_as_asked() {
    let packets = packets_of(Model::Vlp32c, true);
    let beams = beams(32);
    for collision in [Collision::Nearest, Collision::Farthest, Collision::First, Collision::Last] {
        // Fewer columns than firings; steps that divide the unit, are divided by it, and are neither, far from midways.
        for (columns, step_m) in [(360, 0.004), (256, 0.001), (700, 0.020_3), (1800, 1.0)] {
            let scale = Scale::Step { step_m };
            let grid = grid(&beams, 36_000, 4_000);
            let config = GridConfig { table: true, scale, collision, ..GridConfig::new(grid, columns) };
            check::<1>(&config, Sensor::Auto, ReturnPolicy::Last, &packets);
        }
    }
}

#[test]
fn a_bad_packet_changes_no_other_pixels() {
    let (model, beams) = (Model::Vlp32c, beams(32));
    let config = GridConfig { table: true, ..GridConfig::new(grid(&beams, 36_000, 4_000), 1800) };
    let packets = packets_of(model, false);
    let turns = || TurnAssembler::new(Sensor::Auto, ReturnPolicy::Strongest);
    let pixels = |packets: &[Vec<u8>]| -> Vec<Vec<u16>> {
        let frames = encode::<1>(&config, turns(), packets);
        frames.turns.iter().map(|(_, [bytes])| decode(bytes).0).collect()
    };
    let whole = pixels(&packets);
    for (nth, damage) in [(40, 0), (100, 3), (170, 1205), (171, 710), (290, 1204)] {
        let mut damaged = packets.clone();
        let packet = &mut damaged[nth];
        packet[damage] ^= 0x40;
        let outcome = encode::<1>(&config, turns(), &damaged);
        let refused = outcome.refused.iter().map(|&(nth, _)| nth).collect::<Vec<_>>();
        // A cell's own bits cannot be told from a measurement's.
        let counts = if refused.is_empty() { 1 } else { 12 * 32 };
        assert!(refused.is_empty() == (damage == 710) && refused.iter().all(|&refused| refused == nth));
        let after = pixels(&damaged);
        assert_eq!(whole.len(), after.len());
        let changed = whole.iter().flatten().zip(after.iter().flatten()).filter(|(a, b)| a != b).count();
        assert!(changed <= counts, "{changed} pixels changed by byte {damage} of packet {nth}");
    }
}

#[test]
fn a_frame_that_does_not_fit_costs_one_turn() {
    let beams = beams(32);
    let config = GridConfig { table: true, ..GridConfig::new(grid(&beams, 36_000, 4_000), 1800) };
    let mut levels = vec![0_u16; 32 * 1800];
    let image = ImageViewMut::new(&mut levels, 1800).expect("whole rows");
    let mut coder = Rle::new();
    let turns = TurnAssembler::new(Sensor::Auto, ReturnPolicy::Strongest);
    let mut encoder = PacketEncoder::new(&config, turns, [image], &mut coder).expect("a valid configuration");
    let (mut errors, mut turns) = (0, 0);
    let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
    for packet in packets_of(Model::Vlp32c, false) {
        let len = if errors == 0 { 1000 } else { out.len() };
        match encoder.push(&packet, &mut out[..len]) {
            Ok(ended) => turns += u32::from(ended.is_some()),
            Err(PushError::Encode(EncodeError::OutputTooSmall { have: 1000, worst_case })) => {
                assert_eq!(worst_case, config.worst_case_len::<u16, Rle>());
                errors += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert_eq!((errors, turns), (1, 2));
}

#[test]
fn images_of_the_wrong_size_are_refused() {
    let beams = beams(16);
    let config = GridConfig::new(grid(&beams, 36_000, 2_000), 1800);
    let mut levels = vec![0_u16; 32 * 1800];
    let image = ImageViewMut::new(&mut levels, 1800).expect("whole rows");
    let turns = TurnAssembler::new(Sensor::Auto, ReturnPolicy::Strongest);
    assert!(matches!(PacketEncoder::new(&config, turns, [image], &mut Rle::new()), Err(EncodeError::Config(_))));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever comes: no panic, and each turn's frame can be decoded.
    #[test]
    fn any_packets_make_frames_or_errors(
        flips in prop::collection::vec((0_usize..450, 0_usize..1206, any::<u8>()), 0..60),
        lost in prop::collection::vec(0_usize..450, 0..40),
        cut in any::<u16>(),
        columns in 1_u16..2000,
    ) {
        let beams = beams(32);
        let config = GridConfig { table: true, ..GridConfig::new(grid(&beams, 36_000, 4_000), columns) };
        let mut packets = packets_of(Model::Vlp32c, true);
        for (nth, at, flip) in flips {
            let count = packets.len();
            packets[nth % count][at] ^= flip;
        }
        for nth in lost {
            packets.remove(nth % packets.len());
        }
        let turns = TurnAssembler::new(Sensor::Auto, ReturnPolicy::Both).with_cut(cut);
        let frames = encode::<2>(&config, turns, &packets);
        for (turn, bytes) in &frames.turns {
            for (bytes, encoded) in bytes.iter().zip(&turn.frames) {
                let (levels, ..) = decode(bytes);
                let occupied = levels.iter().filter(|&&level| level != 0).count();
                prop_assert_eq!(occupied as u32, encoded.tally.kept());
            }
        }
    }
}
