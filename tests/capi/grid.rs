//! Returns and packets through the C ABI.

use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use flicr::capi::{flicr_status as Status, *};
use flicr::geometry::sensors::{SensorGeometry, hdl64e, hesai, velodyne};
use flicr::geometry::{Beam, SensorGrid};
use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::{
    Coder, Collision, DeflateDefault, DeflateDense, DeflateSmall, Dense, EncodedTurn, FrameEncoder, GridConfig,
    GridReturn, ImageViewMut, Level, PacketEncoder, Rle, Scale, Small, Stamp, Store,
};

use crate::writer::Plan;
use crate::{CODERS, CONTEXT, SETTINGS, STAMP, UNTOUCHED};

const RETURN: usize = size_of::<flicr_return>();

fn preset(sensor: flicr_sensor, columns: u32) -> flicr_grid_config {
    let mut config = MaybeUninit::uninit();
    // SAFETY: a place for a configuration, which success fills.
    unsafe {
        assert_eq!(flicr_grid_config_init(sensor as u32, columns, config.as_mut_ptr()), Status::Ok);
        config.assume_init()
    }
}

/// An encoder's memory, full of what was there before.
struct Memory(Vec<u64>);

impl Memory {
    fn of(config: &flicr_grid_config, coder: flicr_coder) -> Self {
        let len = flicr_grid_encoder_size(config.columns, config.beam_count, config.level_bits, coder as u32);
        Self(vec![0xA5A5_A5A5_A5A5_A5A5; len.div_ceil(8)])
    }

    fn init(&mut self, config: &flicr_grid_config, coder: flicr_coder) -> Result<*mut flicr_grid_encoder, Status> {
        let (start, len) = (self.0.as_mut_ptr().cast(), size_of_val(self.0.as_slice()));
        let mut encoder = null_mut();
        let init = match coder {
            flicr_coder::Store => flicr_grid_encoder_init_store,
            flicr_coder::Rle => flicr_grid_encoder_init_rle,
            flicr_coder::Deflate => flicr_grid_encoder_init_deflate,
            flicr_coder::DeflateSmall => flicr_grid_encoder_init_deflate_small,
            flicr_coder::DeflateDense => flicr_grid_encoder_init_deflate_dense,
            flicr_coder::Small | flicr_coder::Dense => {
                let is_small = coder == flicr_coder::Small;
                let init = if is_small { flicr_grid_encoder_init_small } else { flicr_grid_encoder_init_dense };
                // SAFETY: the vector's own pointer and length.
                let status = unsafe { init(start, len, config, &raw const CONTEXT, &raw mut encoder) };
                assert_eq!(encoder.is_null(), status != Status::Ok, "written only on success");
                return if status == Status::Ok { Ok(encoder) } else { Err(status) };
            }
        };
        // SAFETY: the vector's own pointer and length.
        let status = unsafe { init(start, len, config, &raw mut encoder) };
        assert_eq!(encoder.is_null(), status != Status::Ok, "written only on success");
        if status == Status::Ok { Ok(encoder) } else { Err(status) }
    }
}

fn finish(encoder: *mut flicr_grid_encoder, out: &mut [u8]) -> Result<flicr_encoded, Status> {
    let mut encoded = UNTOUCHED;
    // SAFETY: the slice's own pointer and length.
    let status = unsafe { flicr_finish_returns(encoder, STAMP, out.as_mut_ptr().cast(), out.len(), &raw mut encoded) };
    assert_eq!(encoded == UNTOUCHED, status != Status::Ok, "written only on success");
    if status == Status::Ok { Ok(encoded) } else { Err(status) }
}

fn insert(encoder: *mut flicr_grid_encoder, records: &[u8], count: usize, stride: usize) -> Status {
    // SAFETY: `count` and `stride` are the caller's to get right.
    unsafe { flicr_insert_returns(encoder, records.as_ptr().cast(), count, stride) }
}

/// What a push gives: the turn and its frame, or the status.
fn push(
    encoder: *mut flicr_grid_encoder,
    packet: Option<&[u8]>,
    out: &mut [u8],
) -> Result<(flicr_turn, Vec<u8>), Status> {
    let mut turn = MaybeUninit::uninit();
    // SAFETY: the slices' own pointers and lengths; success fills the turn.
    unsafe {
        let (start, len) = (out.as_mut_ptr().cast(), out.len());
        let status = match packet {
            Some(packet) => {
                flicr_push_packet(encoder, packet.as_ptr().cast(), packet.len(), start, len, turn.as_mut_ptr())
            }
            None => flicr_finish_packets(encoder, start, len, turn.as_mut_ptr()),
        };
        if status != Status::Ok {
            return Err(status);
        }
        let turn = turn.assume_init();
        Ok((turn, out[..turn.encoded.len].to_vec()))
    }
}

fn out_for(config: &flicr_grid_config, coder: flicr_coder) -> Vec<u8> {
    vec![0; flicr_grid_worst_case_len(config.columns, config.beam_count, config.level_bits, coder as u32)]
}

/// The configuration in Rust.
fn in_rust<'a>(config: &flicr_grid_config, grid: SensorGrid<'a>) -> GridConfig<'a> {
    let collision =
        [Collision::Nearest, Collision::Farthest, Collision::First, Collision::Last][config.collision as usize];
    GridConfig {
        grid,
        columns: config.columns as u16,
        level_bits: config.level_bits,
        scale: Scale::Step { step_m: config.step_m },
        collision,
        table: config.table != 0,
        companding: [flicr::Companding::None, flicr::Companding::SquareRoot][config.companding as usize],
        strips: config.strips as u16,
    }
}

fn returns_in_rust<L: Level, C: Coder<L>>(config: &GridConfig<'_>, returns: &[GridReturn], mut coder: C) -> Vec<u8> {
    let columns = usize::from(config.columns);
    let mut levels = vec![L::NONE; config.grid.beams.len() * columns];
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let stamp = Stamp { sequence: STAMP.sequence, timestamp_ns: STAMP.timestamp_ns };
    let mut frame = FrameEncoder::start(config, stamp, image, &mut coder).unwrap();
    frame.insert_returns(returns.iter().copied());
    let mut out = vec![0; config.worst_case_len::<L, C>()];
    let encoded = frame.finish(&mut out).unwrap();
    out.truncate(encoded.len);
    out
}

fn with_coder<L: Level>(coder: flicr_coder, config: &GridConfig<'_>, returns: &[GridReturn]) -> Vec<u8> {
    match coder {
        flicr_coder::Store => returns_in_rust::<L, _>(config, returns, Store::new()),
        flicr_coder::Rle => returns_in_rust::<L, _>(config, returns, Rle::new()),
        flicr_coder::Deflate => returns_in_rust::<L, _>(config, returns, DeflateDefault::new()),
        flicr_coder::DeflateSmall => returns_in_rust::<L, _>(config, returns, DeflateSmall::new()),
        flicr_coder::DeflateDense => returns_in_rust::<L, _>(config, returns, DeflateDense::new()),
        flicr_coder::Small => returns_in_rust::<L, _>(config, returns, Small::<8>::new(SETTINGS)),
        flicr_coder::Dense => returns_in_rust::<L, _>(config, returns, Dense::<8>::new(SETTINGS)),
    }
}

/// Returns all over the HDL-64E's grid, some that are none, some that it does not have.
fn returns() -> Vec<GridReturn> {
    let mut scramble = 7_u32;
    let mut next = || {
        scramble = scramble.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        scramble >> 8
    };
    (0..30_000)
        .map(|_| GridReturn {
            row: (next() % 66) as u16,
            tick: next() % 4010,
            count: (next() % 70_000).max(9_000) - 9_000,
        })
        .collect()
}

fn records(returns: &[GridReturn], stride: usize) -> Vec<u8> {
    let mut records = vec![0xFF; 1 + (returns.len() - 1) * stride + RETURN];
    for (record, found) in records[1..].chunks_mut(stride).zip(returns) {
        let fields = [found.tick, found.count, found.row.into()];
        record[..RETURN].copy_from_slice(bytemuck::bytes_of(&fields));
    }
    records
}

#[test]
fn frames_of_returns_are_rusts() {
    let returns = returns();
    for coder in CODERS {
        for (level_bits, step_m) in [(16, 0.002), (8, 0.5), (12, 0.03)] {
            let mut config = preset(flicr_sensor::Hdl64e, 2000);
            (config.level_bits, config.step_m, config.collision) = (level_bits, step_m, 1 + level_bits % 3);
            let mut memory = Memory::of(&config, coder);
            let encoder = memory.init(&config, coder).unwrap();
            let rust = in_rust(&config, hdl64e::GRID);
            let expected = match level_bits {
                8 => with_coder::<u8>(coder, &rust, &returns),
                _ => with_coder::<u16>(coder, &rust, &returns),
            };
            let mut out = out_for(&config, coder);
            // Twice: nothing is left of the frame before.
            for stride in [RETURN, 17] {
                let records = records(&returns, stride);
                for (at, piece) in returns.chunks(7_001).enumerate() {
                    let records = &records[1 + at * 7_001 * stride..];
                    assert_eq!(insert(encoder, records, piece.len(), stride), Status::Ok);
                }
                assert_eq!(finish(encoder, &mut out[..expected.len() - 1]), Err(Status::OutputTooSmall));
                let encoded = finish(encoder, &mut out).unwrap();
                assert!(out[..encoded.len] == expected, "{coder:?}, {level_bits} bits");
                assert_eq!(encoded.tally.points as usize, returns.len());
            }
        }
    }
}

fn sensors() -> [(flicr_sensor, Model, &'static SensorGeometry); 8] {
    [
        (flicr_sensor::Vlp16, Model::Vlp16, &velodyne::VLP16),
        (flicr_sensor::PuckHiRes, Model::PuckHiRes, &velodyne::PUCK_HI_RES),
        (flicr_sensor::Vlp32c, Model::Vlp32c, &velodyne::VLP32C),
        (flicr_sensor::Hdl32e, Model::Hdl32e, &velodyne::HDL32E),
        (flicr_sensor::Vls128, Model::Vls128, &velodyne::VLS128),
        (flicr_sensor::Pandar40p, Model::Pandar40p, &hesai::PANDAR40P),
        (flicr_sensor::Pandar64, Model::Pandar64, &hesai::PANDAR64),
        (flicr_sensor::PandarXt32, Model::PandarXt32, &hesai::PANDAR_XT32),
    ]
}

fn packets_in_rust(config: &GridConfig<'_>, model: Model, policy: ReturnPolicy, packets: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let columns = usize::from(config.columns);
    let mut levels = vec![0_u16; config.grid.beams.len() * columns];
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let (mut coder, turns) = (Rle::new(), TurnAssembler::new(Sensor::Spinning(model), policy));
    let mut encoder = PacketEncoder::new(config, turns, [image], &mut coder).unwrap();
    let (mut out, mut frames) = (vec![0; config.worst_case_len::<u16, Rle>()], Vec::new());
    for packet in packets {
        if let Ok(Some(turn)) = encoder.push(packet, &mut out) {
            frames.push(out[..turn.frames[0].len].to_vec());
        }
    }
    if let Ok(Some(turn)) = encoder.finish(&mut out) {
        frames.push(out[..turn.frames[0].len].to_vec());
    }
    frames
}

#[test]
fn frames_of_packets_are_rusts() {
    let coder = flicr_coder::Rle;
    for (sensor, model, geometry) in sensors() {
        for (dual, policy) in [(false, ReturnPolicy::Strongest), (true, ReturnPolicy::Last)] {
            let mut config = preset(sensor, 1800);
            config.returns = policy as u32;
            config.turns_per_minute = 1200;
            let mut beams = vec![Beam::default(); geometry.beams.len()];
            let beams = geometry.fill_beams_at(1200, &mut beams).unwrap();
            let plan = Plan { start_tick: 30_000, ..Plan::new(model, dual) };
            let mut packets = plan.packets(4000 / plan.firings_a_packet());
            packets[5][3] ^= 0x80;
            let expected = packets_in_rust(&in_rust(&config, geometry.grid_of(beams)), model, policy, &packets);
            assert!(expected.len() >= 3);
            let mut memory = Memory::of(&config, coder);
            let encoder = memory.init(&config, coder).unwrap();
            let (mut out, mut frames) = (out_for(&config, coder), Vec::new());
            for (nth, packet) in packets.iter().enumerate() {
                match push(encoder, Some(packet), &mut out) {
                    Ok((turn, frame)) => {
                        assert_eq!(turn.number as usize, frames.len());
                        frames.push(frame);
                    }
                    Err(Status::TurnOpen) => {}
                    Err(status) => assert_eq!((status, nth), (Status::PacketRefused, 5)),
                }
            }
            frames.push(push(encoder, None, &mut out).unwrap().1);
            assert!(frames == expected, "{model:?} dual {dual}");
            assert_eq!(push(encoder, None, &mut out).unwrap_err(), Status::TurnOpen);
            let mut stats = MaybeUninit::uninit();
            // SAFETY: a place for the counts, which success fills.
            let stats = unsafe {
                assert_eq!(flicr_get_packet_stats(encoder, stats.as_mut_ptr()), Status::Ok);
                stats.assume_init()
            };
            assert_eq!((stats.used + stats.refused, stats.refused), (packets.len() as u32, 1));
            assert_eq!(stats.lost_columns, plan.firings_a_packet() as u32);
        }
    }
}

/// One encoder of the strongest and one of the others, of the same packets: Rust's two frames a turn.
#[test]
fn both_returns_are_rusts_two_layers() {
    let coder = flicr_coder::Rle;
    for (sensor, model, geometry) in sensors() {
        for dual in [false, true] {
            let strongest = flicr_grid_config { turns_per_minute: 1200, ..preset(sensor, 1800) };
            let other = flicr_grid_config { returns: flicr_return_policy::Other as u32, ..strongest };
            let mut beams = vec![Beam::default(); geometry.beams.len()];
            let beams = geometry.fill_beams_at(1200, &mut beams).unwrap();
            let plan = Plan { start_tick: 30_000, ..Plan::new(model, dual) };
            let packets = plan.packets(4000 / plan.firings_a_packet());
            let expected = layers_in_rust(&in_rust(&strongest, geometry.grid_of(beams)), model, &packets);
            for (config, layer) in [(strongest, 0), (other, 1)] {
                let mut memory = Memory::of(&config, coder);
                let encoder = memory.init(&config, coder).unwrap();
                let (mut out, mut turns) = (out_for(&config, coder), Vec::new());
                turns.extend(packets.iter().filter_map(|packet| push(encoder, Some(packet), &mut out).ok()));
                turns.push(push(encoder, None, &mut out).unwrap());
                assert_eq!(turns.len(), expected.len());
                for ((turn, frame), expected) in turns.iter().zip(&expected) {
                    // A layer without columns holds nothing, and has no time either.
                    let is_there = layer == 0 || dual;
                    assert_eq!(turn.encoded.tally.kept > 0, is_there, "{model:?} dual {dual} layer {layer}");
                    assert!(!is_there || frame == &expected[layer], "{model:?} dual {dual} layer {layer}");
                }
            }
        }
    }
}

/// Both layers' frames of every turn.
fn layers_in_rust(config: &GridConfig<'_>, model: Model, packets: &[Vec<u8>]) -> Vec<[Vec<u8>; 2]> {
    let columns = usize::from(config.columns);
    let mut levels = [(); 2].map(|()| vec![0_u16; config.grid.beams.len() * columns]);
    let images = levels.each_mut().map(|levels| ImageViewMut::new(levels, columns).unwrap());
    let (mut coder, turns) = (Rle::new(), TurnAssembler::new(Sensor::Spinning(model), ReturnPolicy::Both));
    let mut encoder = PacketEncoder::new(config, turns, images, &mut coder).unwrap();
    let mut out = vec![0; 2 * config.worst_case_len::<u16, Rle>()];
    let mut frames = Vec::new();
    let mut take = |turn: EncodedTurn<2>, out: &[u8]| {
        let [first, second] = turn.frames.map(|frame| frame.len);
        frames.push([out[..first].to_vec(), out[first..first + second].to_vec()]);
    };
    for packet in packets {
        if let Some(turn) = encoder.push(packet, &mut out).unwrap() {
            take(turn, &out);
        }
    }
    take(encoder.finish(&mut out).unwrap().unwrap(), &out);
    frames
}

#[test]
fn beams_of_a_unit_are_taken() {
    let beams: Vec<flicr_beam> = hdl64e::BEAMS
        .iter()
        .map(|&Beam { slope, z_offset_m, h_offset_m, azimuth_phase_rad, range_phase_m }| flicr_beam {
            slope,
            z_offset_m,
            h_offset_m,
            azimuth_phase_rad,
            range_phase_m,
        })
        .collect();
    let (known, returns) = (preset(flicr_sensor::Hdl64e, 500), returns());
    let own = flicr_grid_config { beams: beams.as_ptr(), sensor: flicr_sensor::Custom as u32, ..known };
    let frame = |config: &flicr_grid_config| {
        let mut memory = Memory::of(config, flicr_coder::Rle);
        let encoder = memory.init(config, flicr_coder::Rle).unwrap();
        assert_eq!(insert(encoder, &records(&returns, RETURN)[1..], returns.len(), RETURN), Status::Ok);
        let mut out = out_for(config, flicr_coder::Rle);
        let encoded = finish(encoder, &mut out).unwrap();
        out.truncate(encoded.len);
        out
    };
    assert!(frame(&known) == frame(&own));
    drop(beams);
}

#[test]
fn sizes_of_what_cannot_be_are_zero() {
    for (columns, beams, level_bits, coder) in [
        (0, 64, 8, 1),
        (256, 0, 8, 1),
        (256, 129, 8, 1),
        (65_536, 1, 8, 1),
        (256, 64, 0, 1),
        (256, 64, 17, 1),
        (256, 64, 8, 9),
    ] {
        assert_eq!(flicr_grid_encoder_size(columns, beams, level_bits, coder), 0);
        assert_eq!(flicr_grid_worst_case_len(columns, beams, level_bits, coder), 0);
    }
}

pub fn refused(expect: &mut impl FnMut(Status, Status)) {
    refused_configs(expect);
    let rle = flicr_coder::Rle;
    let config = preset(flicr_sensor::Hdl64e, 100);
    let mut memory = Memory::of(&config, rle);
    let encoder = memory.init(&config, rle).unwrap();
    let mut out = vec![0_u8; 70_000];
    let start = out.as_ptr();
    expect(insert(encoder, &out, 1, 11), Status::Stride);
    expect(insert(encoder, &out, usize::MAX, 12), Status::TooManyPoints);
    expect(push(encoder, Some(&[0; 1206]), &mut out).unwrap_err(), Status::Sensor);
    expect(push(encoder, None, &mut out).unwrap_err(), Status::Sensor);
    expect(push(null_mut(), Some(&[0; 1206]), &mut out).unwrap_err(), Status::NullPointer);
    expect(push(start.wrapping_add(1).cast_mut().cast(), None, &mut [0; 9]).unwrap_err(), Status::Misaligned);
    let zeros = vec![0_u64; 200];
    expect(push(zeros.as_ptr().cast_mut().cast(), None, &mut out).unwrap_err(), Status::NotInitialized);
    expect(finish(encoder, &mut out[..83]).unwrap_err(), Status::OutputTooSmall);
    let config = preset(flicr_sensor::Vlp16, 100);
    let mut memory = Memory::of(&config, rle);
    let encoder = memory.init(&config, rle).unwrap();
    expect(push(encoder, Some(&[0; 1206]), &mut out).unwrap_err(), Status::PacketRefused);
    expect(push(encoder, Some(&[]), &mut out).unwrap_err(), Status::PacketRefused);
    expect(push(encoder, None, &mut out).unwrap_err(), Status::TurnOpen);
    let mut turn = MaybeUninit::uninit();
    let mut push_raw = |packet: *const c_void, out: *mut c_void| {
        // SAFETY: each is to be found before anything is read or written.
        unsafe { flicr_push_packet(encoder, packet, 1206, out, 1206, turn.as_mut_ptr()) }
    };
    expect(push_raw(null(), out.as_mut_ptr().cast()), Status::NullPointer);
    expect(push_raw(start.cast(), null_mut()), Status::NullPointer);
    expect(push_raw(start.cast(), start.wrapping_add(1205).cast_mut().cast()), Status::Overlap);
    expect(push_raw(encoder.cast(), start.cast_mut().cast()), Status::Overlap);
    // SAFETY: null is to be found.
    expect(unsafe { flicr_get_packet_stats(encoder, null_mut()) }, Status::NullPointer);
}

fn refused_configs(expect: &mut impl FnMut(Status, Status)) {
    let good = preset(flicr_sensor::Hdl64e, 100);
    let mut config = good;
    let mut init = |sensor: u32, columns| {
        // SAFETY: a place for a configuration.
        unsafe { flicr_grid_config_init(sensor, columns, &raw mut config) }
    };
    expect(init(flicr_sensor::Custom as u32, 100), Status::Sensor);
    expect(init(11, 100), Status::Sensor);
    expect(init(flicr_sensor::Vlp16 as u32, 0), Status::Size);
    expect(init(flicr_sensor::Vlp16 as u32, 65_536), Status::Size);
    assert_eq!(config, good, "written only on success");
    let rising =
        vec![
            flicr_beam { slope: 0.0, z_offset_m: 0.0, h_offset_m: 0.0, azimuth_phase_rad: 0.0, range_phase_m: 0.0 };
            64
        ];
    let odd = rising.as_ptr().wrapping_byte_add(1);
    let refused = [
        (flicr_grid_config { sensor: 11, ..good }, Status::Sensor),
        (flicr_grid_config { sensor: 0, ..good }, Status::Sensor),
        (flicr_grid_config { beam_count: 63, ..good }, Status::Sensor),
        (flicr_grid_config { beam_count: 0, ..good }, Status::Size),
        (flicr_grid_config { beam_count: 129, ..good }, Status::Size),
        (flicr_grid_config { columns: 0, ..good }, Status::Size),
        (flicr_grid_config { beams: rising.as_ptr(), ..good }, Status::Beam),
        (flicr_grid_config { beams: odd, ..good }, Status::Misaligned),
        (flicr_grid_config { ticks: 0, ..good }, Status::Ticks),
        (flicr_grid_config { zero_rad: 4.0, ..good }, Status::AzimuthView),
        (flicr_grid_config { range_unit_m: f32::NAN, ..good }, Status::RangeUnit),
        (flicr_grid_config { level_bits: 0, ..good }, Status::LevelBits),
        (flicr_grid_config { level_bits: 17, ..good }, Status::LevelBits),
        (flicr_grid_config { step_m: 0.0, ..good }, Status::MaxRange),
        (flicr_grid_config { step_m: f32::NAN, ..good }, Status::MaxRange),
        (flicr_grid_config { collision: 4, ..good }, Status::Collision),
        (flicr_grid_config { returns: 3, ..good }, Status::ReturnPolicy),
    ];
    for (config, status) in refused {
        let mut memory = Memory(vec![0xA5; 200_000]);
        expect(memory.init(&config, flicr_coder::Rle).unwrap_err(), status);
        assert!(memory.0.iter().all(|&word| word == 0xA5), "nothing is written before all is checked");
    }
    let mut small = Memory(vec![0; 100]);
    expect(small.init(&good, flicr_coder::Rle).unwrap_err(), Status::StateTooSmall);
}
