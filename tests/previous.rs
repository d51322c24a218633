//! Promise: frames that go on from the frame before come back as those that do not, are hardly ever longer, far shorter where
//! the sensor stands still, and are refused where the frame before is missing.
#![allow(missing_docs)]

use flicr::coder::{Coder, ContextSettings, Step};
use flicr::geometry::sensors::hdl64e;
use flicr::geometry::{Firings, Lattice};
use flicr::plane::Planes;
use flicr::simulate::{Simulator, Turn};
use flicr::{
    ConfigError, DecodeError, Decoder, Dense, EncodeError, Encoder, FiringsConfig, FrameEncoder, GridConfig,
    GridReturn, ImageViewMut, LatticeConfig, Levels, PayloadFault, Previous, Rle, Scale, Small, Stamp, frame,
};

const ROWS: usize = 64;
const COLUMNS: usize = 2300;
/// Bytes by which a frame in which nothing was gained may be longer.
const NO_GAIN_LEN: usize = 8;

/// A turn's frame without the frame before, and with it.
struct Pair {
    alone: Vec<u8>,
    after: Vec<u8>,
}

/// By firings, whose number and places are others in every turn.
fn by_firings<C: Coder<u16>>(
    mut coder: C,
    turns: impl Iterator<Item = Turn>,
    strips: u16,
    previous: &mut Previous<Vec<u16>>,
) -> Vec<Pair> {
    let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, 4000).unwrap();
    let every_tick = LatticeConfig { strips, ..LatticeConfig::new(&lattice) };
    let mut pair = |(sequence, turn): (u32, Turn)| {
        let points = turn.points.as_slice();
        let found = flicr::geometry::find_firings(points, &hdl64e::FIRING_GRID).unwrap().unwrap();
        let firings: Firings<125> = Firings::new(4000, found.ticks.iter().copied()).unwrap();
        let config = FiringsConfig { every_tick, firings: &firings };
        let columns = usize::from(firings.len());
        let mut encode = |previous: Option<&mut Previous<Vec<u16>>>| {
            let (mut levels, mut out) = (vec![0_u16; ROWS * columns], vec![0; 1 << 20]);
            let image = ImageViewMut::new(&mut levels, columns).unwrap();
            let stamp = Stamp { sequence, timestamp_ns: 0 };
            let mut frame = FrameEncoder::start(&config, stamp, image, &mut coder).unwrap();
            frame.insert(points);
            let encoded = match previous {
                Some(previous) => frame.finish_after(previous, Planes::default(), &mut out),
                None => frame.finish(&mut out),
            };
            out.truncate(encoded.unwrap().len);
            out
        };
        Pair { alone: encode(None), after: encode(Some(&mut *previous)) }
    };
    (0..).zip(turns).map(&mut pair).collect()
}

fn memory(every: u32) -> Previous<Vec<u16>> {
    Previous::new(vec![7; Previous::<Vec<u16>>::memory_len(ROWS, COLUMNS, true)], COLUMNS, every)
}

fn settings(levels: u16) -> ContextSettings {
    ContextSettings::FINE.with_step(Step::new(levels).unwrap())
}

fn levels(decoder: &mut Decoder, bytes: &[u8]) -> Vec<u16> {
    match decoder.decode(bytes).unwrap().levels() {
        Levels::U8(levels) => levels.iter().map(|&level| level.into()).collect(),
        Levels::U16(levels) => levels.clone(),
    }
}

fn distance(bytes: &[u8]) -> u32 {
    frame::parse(bytes).unwrap().link().unwrap().unwrap().distance
}

/// Checks what comes back of frames that each go on from the one before; gives the bytes of those that do for each of those
/// that do not.
fn check(frames: &[Pair], error_max: u16) -> f64 {
    let (mut decoder, mut other) = (Decoder::default(), Decoder::default());
    for Pair { alone, after } in frames {
        let (found, expected) = (levels(&mut decoder, after), levels(&mut other, alone));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((*found == 0) == (*expected == 0) && found.abs_diff(*expected) <= 2 * error_max);
        }
        assert!(after.len() <= alone.len() + NO_GAIN_LEN, "{} for {}", after.len(), alone.len());
    }
    let sum = |len: fn(&Pair) -> usize| frames.iter().skip(1).map(len).sum::<usize>() as f64;
    sum(|pair| pair.after.len()) / sum(|pair| pair.alone.len())
}

#[test]
fn a_sensor_that_stands_still_sends_far_less() {
    let turns = || Simulator::hdl64e(3).speed(0.0).take(4);
    for (step, share) in [(1, 0.97), (10, 0.97), (50, 0.92)] {
        let error_max = settings(step).step.error_max();
        for strips in [1, 5] {
            let dense = check(&by_firings(Dense::<8>::new(settings(step)), turns(), strips, &mut memory(9)), error_max);
            let small = check(&by_firings(Small::<8>::new(settings(step)), turns(), strips, &mut memory(9)), error_max);
            println!("step {step}, {strips} strips: dense {dense:.3}, small {small:.3}");
            assert!(dense < share && small < share, "step {step}: dense {dense}, small {small}");
        }
    }
}

#[test]
fn a_sensor_that_moves_sends_hardly_more() {
    let turns = Simulator::hdl64e(3).speed(10.0).take(4);
    let share =
        check(&by_firings(Dense::<8>::new(settings(10)), turns, 1, &mut memory(9)), settings(10).step.error_max());
    assert!(share < 1.001, "{share}");
}

#[test]
fn a_missing_frame_is_told_and_the_next_key_frame_needs_none() {
    let frames = by_firings(Small::<8>::new(settings(10)), Simulator::hdl64e(3).speed(0.0).take(6), 2, &mut memory(3));
    assert_eq!(frames.iter().map(|pair| distance(&pair.after)).collect::<Vec<_>>(), [0, 1, 2, 0, 1, 2]);
    let checksum = |bytes: &[u8]| u32::from_le_bytes(*bytes.last_chunk().unwrap());
    let [first, second, third, key, ..] = frames.as_slice() else { unreachable!() };
    let mut decoder = Decoder::default();
    let need = checksum(&first.after);
    let missing = |need, distance, have| DecodeError::PreviousMissing { key: 0, distance, need, have };
    assert_eq!(decoder.decode(&second.after).unwrap_err(), missing(need, 1, None));
    decoder.decode(&first.after).unwrap();
    let have = Some(checksum(&first.after));
    assert_eq!(decoder.decode(&third.after).unwrap_err(), missing(checksum(&second.after), 2, have));
    let text = decoder.decode(&third.after).unwrap_err().to_string();
    assert!(text.contains("frame before this one is missing") && text.contains("2 since key frame 0"), "{text}");
    // A frame that was refused changes nothing, nor do frames of their own.
    levels(&mut decoder, &third.alone);
    levels(&mut decoder, &second.after);
    levels(&mut decoder, &third.after);
    levels(&mut decoder, &key.after);
    // One that is damaged behind its header may have.
    let mut damaged = frames[4].after.clone();
    let at = damaged.len() / 2;
    damaged[at] ^= 1;
    assert!(decoder.decode(&damaged).is_err());
    levels(&mut decoder, &frames[4].after);
}

/// With the lengths and the checksum that fit.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let len = bytes.len();
    bytes[8..12].copy_from_slice(&(len as u32).to_le_bytes());
    let mut crc = u32::MAX;
    for &byte in &bytes[..len - 4] {
        crc ^= u32::from(byte);
        (0..8).for_each(|_| crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()));
    }
    bytes[len - 4..].copy_from_slice(&(!crc).to_le_bytes());
    bytes
}

fn grid_frames(rows: u16, count: usize) -> Vec<Vec<u8>> {
    let mut encoder: Encoder<64, 100, u8, Small> = Encoder::new(Small::new(ContextSettings::COARSE));
    let scale = Scale::Step { step_m: 0.3 };
    let config = GridConfig { scale, level_bits: 8, ..GridConfig::new(hdl64e::GRID, 100) };
    let mut previous = Previous::new([0; 64 * 100], 100, 50);
    let frame = |number: usize| {
        let mut frame = encoder.start(&config, Stamp { sequence: number as u32, timestamp_ns: 0 }).unwrap();
        let pixels = (0..rows).flat_map(|row| (0..100).map(move |column| (row, column)));
        frame.insert_returns(pixels.map(|(row, column)| {
            let count = 1500 + u32::from(row) * 7919 % 1301 * (column * 31 % 17);
            GridReturn { row, tick: column * 40, count: count + number as u32 % 3 }
        }));
        let mut out = vec![0; 20_000];
        let len = frame.finish_after(&mut previous, Planes::default(), &mut out).unwrap().len;
        out.truncate(len);
        out
    };
    (0..count).map(frame).collect()
}

#[test]
fn damaged_frames_end_in_an_error_or_an_image() {
    let frames = grid_frames(64, 2);
    assert_eq!(distance(&frames[1]), 1);
    for at in 64..frames[1].len() - 4 {
        for bit in [0, 3, 7] {
            let mut bytes = frames[1].clone();
            bytes[at] ^= 1 << bit;
            let mut decoder = Decoder::default();
            decoder.decode(&frames[0]).unwrap();
            if let Ok(frame) = decoder.decode(&sealed(bytes)) {
                assert!(frame.points().len() <= 6400);
            }
        }
    }
    let malformed = DecodeError::Section { kind: 4, fault: PayloadFault::Malformed };
    let body_at = frames[1].len() - 4 - 12;
    let error = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = frames[1].clone();
        change(&mut bytes);
        let mut decoder = Decoder::default();
        decoder.decode(&frames[0]).unwrap();
        decoder.decode(&sealed(bytes)).unwrap_err()
    };
    assert_eq!(error(&|bytes| bytes[body_at] = 0), malformed, "a distance of 0");
    let cut = |bytes: &mut Vec<u8>| {
        bytes[body_at - 4] = 11;
        bytes.remove(body_at);
    };
    assert_eq!(error(&cut), malformed, "not twelve bytes");
    assert!(matches!(error(&|bytes| bytes[body_at + 8] ^= 1), DecodeError::PreviousMissing { .. }));
    // A strip by the frame before, in a frame that has none.
    let alone = |bytes: &mut Vec<u8>| {
        bytes[5] &= !2;
        bytes.truncate(body_at - 8 + 4);
    };
    assert_eq!(error(&alone), DecodeError::Payload { strip: 0, fault: PayloadFault::Malformed });
}

#[test]
fn memory_that_is_too_small_is_refused() {
    let mut encoder: Encoder<64, 100, u16, Rle> = Encoder::new(Rle::new());
    let mut out = vec![0; 30_000];
    let mut finish = |len: usize, columns_max: usize| {
        let mut previous = Previous::new(vec![0; len], columns_max, 5);
        let frame = encoder.start(&GridConfig::new(hdl64e::GRID, 100), Stamp::default()).unwrap();
        frame.finish_after(&mut previous, Planes::default(), &mut out).map(|encoded| encoded.len)
    };
    let refused = |found, expected| Err(EncodeError::Config(ConfigError::Plane { found, expected }));
    assert_eq!(finish(6399, 100), refused(6399, 6400));
    assert_eq!(finish(9000, 99), refused(9000, 6400));
    // Coders that know no frame before make key frames.
    assert!(finish(6400, 100).is_ok());
}
