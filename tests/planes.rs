//! Promise: a frame's planes come back: intensities within half a step, of the return that each pixel kept; whatever the
//! bytes, they end in an error value or a plane.
#![allow(missing_docs)]

mod common;

use core::fmt::Write as _;

use flicr::coder::ContextSettings;
use flicr::geometry::sensors::hdl64e;
use flicr::geometry::{Firings, Lattice};
use flicr::plane::{IntensityCoder, IntensityPlane, IntensityScale, Planes, TimesPlane};
use flicr::simulate::Simulator;
use flicr::{
    Collision, Config, ConfigError, DecodeError, Decoder, EncodeError, Encoder, FiringsConfig, FrameEncoder,
    GridConfig, GridReturn, ImageViewMut, LatticeConfig, PayloadFault, Policy, Rle, Scale, Small, Stamp, Store, frame,
};
use proptest::prelude::*;

const COLUMNS: usize = 100;
const ROWS: usize = 64;

/// Returns in a made-up order, several of them in a pixel, with an intensity each.
fn returns(count: usize, seed: u32, mask: u8) -> Vec<(GridReturn, u8)> {
    let mut state = seed | 1;
    let mut next = move |below: u32| {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state % below
    };
    (0..count)
        .map(|_| {
            let (row, tick) = (next(64) as u16, next(4000));
            (GridReturn { row, tick, count: next(60_000) }, (next(256) as u8) & mask)
        })
        .collect()
}

fn encoded(returns: &[(GridReturn, u8)], scale: IntensityScale, collision: Collision) -> Vec<u8> {
    in_strips(returns, scale, collision, 1)
}

fn in_strips(returns: &[(GridReturn, u8)], scale: IntensityScale, collision: Collision, strips: u16) -> Vec<u8> {
    let config = GridConfig { collision, strips, ..GridConfig::new(hdl64e::GRID, COLUMNS as u16) };
    let mut encoder: Encoder<ROWS, COLUMNS, u16, Store> = Encoder::new(Store::new());
    let mut coder = IntensityCoder::<ROWS, 8>::new();
    let mut plane = vec![0; ROWS * COLUMNS];
    let mut frame = encoder.start(&config, Stamp::default()).unwrap();
    frame.insert_lit_returns(returns.iter().copied(), &mut plane);
    let most = config.worst_case_len::<u16, Store>() + IntensityPlane::worst_case_len(ROWS * COLUMNS, strips.into());
    let mut out = vec![0; most];
    let planes = Planes { intensity: Some(coder.plane(&plane, scale)), ..Planes::default() };
    let len = frame.finish_with(planes, &mut out).unwrap().len;
    out.truncate(len);
    out
}

/// The count and number that each pixel keeps, found one by one.
fn kept(returns: &[(GridReturn, u8)], collision: Collision) -> Vec<Option<(u32, u8)>> {
    let mut pixels: Vec<Option<(u32, u8)>> = vec![None; ROWS * COLUMNS];
    for &(GridReturn { row, tick, count }, number) in returns.iter().filter(|(found, _)| found.count > 0) {
        let column = (2 * tick as usize * COLUMNS + 4000) / 8000 % COLUMNS;
        let pixel = &mut pixels[usize::from(row) * COLUMNS + column];
        let is_better = match (*pixel, collision) {
            (None, _) => true,
            (Some((old, _)), Collision::Nearest) => count < old,
            (Some((old, _)), Collision::Farthest) => count > old,
            (Some(_), Collision::First) => false,
            (Some((old, _)), Collision::Last) => count != old,
        };
        if is_better {
            *pixel = Some((count, number));
        }
    }
    pixels
}

fn check(returns: &[(GridReturn, u8)], scale: IntensityScale, collision: Collision) {
    check_frame(&encoded(returns, scale, collision), returns, scale, collision);
    check_frame(&in_strips(returns, scale, collision, 7), returns, scale, collision);
}

fn check_frame(bytes: &[u8], returns: &[(GridReturn, u8)], scale: IntensityScale, collision: Collision) {
    let mut decoder = Decoder::default();
    let frame = decoder.decode(bytes).unwrap();
    let (numbers, found_scale) = frame.intensity_plane().unwrap();
    assert_eq!(found_scale, scale);
    for (&number, expected) in numbers.iter().zip(kept(returns, collision)) {
        let expected = expected.map_or(0, |(_, number)| number);
        assert!(number.abs_diff(expected) <= scale.error_max(), "{number} for {expected}");
    }
    let points = frame.points().len();
    assert_eq!(frame.intensities().unwrap().len(), points);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn pixels_keep_the_intensity_of_their_return(
        count in 0..9000_usize,
        seed in any::<u32>(),
        mask in any::<u8>(),
        step in 1..=255_u8,
        collision in prop_oneof![
            Just(Collision::Nearest), Just(Collision::Farthest), Just(Collision::First), Just(Collision::Last)
        ],
    ) {
        check(&returns(count, seed, mask), IntensityScale::new(1.0, step).unwrap(), collision);
    }

    #[test]
    fn any_file_of_a_frames_points_comes_back(count in 0..4000_usize, seed in any::<u32>()) {
        let (file, bytes) = with_original(count, seed);
        prop_assert!(Decoder::default().decode(&bytes).unwrap().original().unwrap() == Some(file));
    }

    #[test]
    fn damaged_originals_end_in_an_error_or_a_file(
        at in any::<proptest::sample::Index>(), byte in any::<u8>(), cut in 0..40_usize,
    ) {
        let mut bytes = ORIGINAL.1.clone();
        let begin = *section_places(&bytes).last().unwrap();
        let at = begin + at.index(bytes.len() - 4 - begin);
        bytes[at] = byte;
        if at < begin + 8 {
            // The section's head: as it comes.
            bytes.drain(bytes.len() - 4 - cut..bytes.len() - 4);
        }
        let bytes = sealed(bytes);
        let mut decoder = Decoder::default();
        if let Ok(frame) = decoder.decode(&bytes)
            && let Ok(Some(found)) = frame.original()
        {
            prop_assert!(found.len() % 16 == 0 && found.len() <= 16 * frame.points().len() + bytes.len());
        }
    }

    #[test]
    fn damaged_sections_never_panic(at in any::<proptest::sample::Index>(), byte in any::<u8>(), cut in 0..40_usize) {
        let mut bytes = encoded(&returns(3000, 5, 63), IntensityScale::RAW, Collision::Nearest);
        let begin = section_at(&bytes);
        let at = begin + at.index(bytes.len() - 4 - begin);
        bytes[at] = byte;
        bytes.drain(bytes.len() - 4 - cut.min(bytes.len() - 4 - begin)..bytes.len() - 4);
        let _ = Decoder::default().decode(&sealed(bytes));
    }
}

/// A file of the points that a frame gives, to the millimeter and in an order of its own, and the frame with what gives the
/// file back.
fn with_original(count: usize, seed: u32) -> (Vec<u8>, Vec<u8>) {
    let mut bytes = encoded(&returns(count, seed, 63), IntensityScale::RAW, Collision::Nearest);
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&bytes).unwrap();
    let points = frame.points().into_iter().zip(frame.intensities().unwrap());
    let rounded = |part: f32| (f64::from((part * 1000.0).round()) / 1000.0) as f32;
    let mut records: Vec<[f32; 4]> = points.map(|([x, y, z], i)| [rounded(x), rounded(y), rounded(z), i]).collect();
    records.sort_by(|a, b| b[2].total_cmp(&a[2]));
    records.insert(records.len() / 2, [0.0; 4]);
    let file: Vec<u8> = records.iter().flatten().flat_map(|part| part.to_le_bytes()).collect();
    flicr::original::append(&mut bytes, &file).unwrap();
    (file, bytes)
}

/// Where the sections of a frame begin.
fn section_at(bytes: &[u8]) -> usize {
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
    (0..u16_at(30))
        .fold(u16_at(6), |at, _| at + 8 + u32::from_le_bytes(bytes[at + 4..][..4].try_into().unwrap()) as usize)
}

/// Where each of them begins.
fn section_places(bytes: &[u8]) -> Vec<usize> {
    let (mut at, mut places) = (section_at(bytes), Vec::new());
    while at < bytes.len() - 4 {
        places.push(at);
        at += 8 + u32::from_le_bytes(bytes[at + 4..][..4].try_into().unwrap()) as usize;
    }
    places
}

static ORIGINAL: std::sync::LazyLock<(Vec<u8>, Vec<u8>)> = std::sync::LazyLock::new(|| with_original(3000, 5));

/// With a length and a checksum that fit.
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

#[test]
fn every_number_is_within_half_a_step() {
    for step in 1..=255 {
        let scale = IntensityScale::new(1.0, step).unwrap();
        let returns: Vec<_> =
            (0..=255).map(|n| (GridReturn { row: 0, tick: n * 40 % 4000, count: 9 }, n as u8)).collect();
        check(&returns[..100], scale, Collision::Nearest);
        check(&returns[156..], scale, Collision::Nearest);
    }
}

#[test]
fn only_whole_sections_in_their_order_are_read() {
    let bytes = encoded(&returns(3000, 5, 63), IntensityScale::RAW, Collision::Nearest);
    let at = section_at(&bytes);
    let with = |at: usize, new: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + new.len()].copy_from_slice(new);
        Decoder::default().decode(&sealed(bytes)).unwrap_err()
    };
    let malformed = |kind| DecodeError::Section { kind, fault: PayloadFault::Malformed };
    assert_eq!(with(at, &[0]), malformed(0));
    assert_eq!(with(at, &[99]), malformed(99));
    assert_eq!(with(at + 1, &[1]), malformed(1));
    assert_eq!(with(at + 8, &[0]), malformed(1), "a step of 0");
    assert_eq!(with(at + 9, &[0]), malformed(1), "no classes");
    assert_eq!(with(at + 10, &[1]), malformed(1), "reserved");
    assert_eq!(with(at + 12, &f32::NAN.to_le_bytes()), malformed(1));
    assert_eq!(with(at + 20, &[2]), malformed(1), "a part of another kind");
    assert!(matches!(with(at + 4, &[255, 255, 255, 255]), DecodeError::Truncated { .. }));
    assert_eq!(with(at + 16, &[0, 0, 0, 0]), DecodeError::Section { kind: 1, fault: PayloadFault::TooShort });
    // Twice the same, none at all, and one that the flags do not tell of.
    let mut twice = bytes.clone();
    twice.truncate(bytes.len() - 4);
    twice.extend_from_slice(&bytes[at..]);
    assert_eq!(Decoder::default().decode(&sealed(twice)).unwrap_err(), malformed(1));
    let mut none = bytes[..at].to_vec();
    none.extend([0; 4]);
    assert!(matches!(Decoder::default().decode(&sealed(none)).unwrap_err(), DecodeError::Truncated { .. }));
    let mut untold = bytes.clone();
    untold[5] &= !2;
    assert!(matches!(Decoder::default().decode(&sealed(untold)).unwrap_err(), DecodeError::TrailingBytes { .. }));
    for len in 0..bytes.len() {
        assert!(Decoder::default().decode(&bytes[..len]).is_err());
    }
}

#[test]
fn planes_that_do_not_fit_the_image_are_refused() {
    let mut encoder: Encoder<ROWS, 256, u8, Rle> = Encoder::new(Rle::new());
    let config = Config { scale: Scale::Fixed { max_range_m: 80.0 }, ..Config::UNIFORM };
    let mut out = vec![0; 100_000];
    let mut coder = IntensityCoder::<ROWS, 8>::new();
    let planes = Planes { intensity: Some(coder.plane(&[0; 9], IntensityScale::RAW)), ..Planes::default() };
    let error = encoder.start(&config, Stamp::default()).unwrap().finish_with(planes, &mut out).unwrap_err();
    assert_eq!(error, EncodeError::Config(ConfigError::Plane { found: 9, expected: ROWS * 256 }));
    let mut coder = IntensityCoder::<9, 8>::new();
    let planes = Planes { intensity: Some(coder.plane(&[0; ROWS * 256], IntensityScale::RAW)), ..Planes::default() };
    let error = encoder.start(&config, Stamp::default()).unwrap().finish_with(planes, &mut out).unwrap_err();
    assert_eq!(error, EncodeError::Config(ConfigError::CoderRows { found: 64, max: 9 }));
    let mut coder = IntensityCoder::<ROWS, 8>::new();
    let planes = Planes { intensity: Some(coder.plane(&[0; ROWS * 256], IntensityScale::RAW)), ..Planes::default() };
    let empty = encoder.start(&config, Stamp::default()).unwrap().finish(&mut out).unwrap().len;
    let error = encoder.start(&config, Stamp::default()).unwrap().finish_with(planes, &mut out[..empty]).unwrap_err();
    assert!(matches!(error, EncodeError::OutputTooSmall { have, .. } if have == empty));
    assert!(IntensityScale::new(0.0, 1).is_none() && IntensityScale::new(f32::NAN, 1).is_none());
    assert!(IntensityScale::new(1.0, 0).is_none());
}

fn simulated() -> Vec<[f32; 4]> {
    Simulator::hdl64e(3).turn(0).points
}

/// On every geometry, intensities are those of the points that come back.
#[test]
fn the_simulated_street_keeps_its_intensities() {
    let points = simulated();
    let number_of = |at: usize| IntensityScale::PERCENT.nearest(points[at][3]);
    let mut decoder = Decoder::default();
    // By firings nothing is lost, so that each point is found by its place.
    let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, 4000).unwrap();
    let found = flicr::geometry::find_firings(points.as_slice(), &hdl64e::FIRING_GRID).unwrap().unwrap();
    let firings: Firings<125> = Firings::new(4000, found.ticks.iter().copied()).unwrap();
    let config = FiringsConfig { every_tick: LatticeConfig::new(&lattice), firings: &firings };
    let columns = usize::from(firings.len());
    let (mut levels, mut plane) = (vec![0_u16; ROWS * columns], vec![0; ROWS * columns]);
    let (mut coder, mut intensity_coder) = (Small::<8>::new(ContextSettings::FINE), IntensityCoder::<ROWS, 64>::new());
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let mut frame = FrameEncoder::start(&config, Stamp::default(), image, &mut coder).unwrap();
    frame.insert_lit(points.as_slice(), number_of, &mut plane);
    let mut out = vec![0; 1 << 20];
    let planes =
        Planes { intensity: Some(intensity_coder.plane(&plane, IntensityScale::PERCENT)), ..Planes::default() };
    let len = frame.finish_with(planes, &mut out).unwrap().len;
    let plain_len = {
        let image = ImageViewMut::new(&mut levels, columns).unwrap();
        let mut out = vec![0; 1 << 20];
        flicr::encode(&config, points.as_slice(), Stamp::default(), image, &mut coder, &mut out).unwrap().len
    };
    // The street's intensities are noise around a mean that a surface has.
    assert!((len - plain_len) * 8 < points.len() * 5, "{} bytes", len - plain_len);
    let frame = decoder.decode(&out[..len]).unwrap();
    let decoded = frame.points();
    assert_eq!(decoded.len(), points.len());
    // Cells of 4 mm: a point within 1 mm of another is in one of eight that are as near.
    let cell = |point: [f32; 3], by: [f32; 3]| [0, 1, 2].map(|axis| ((point[axis] + by[axis]) * 250.0).floor() as i32);
    let mut expected: Vec<_> = points.iter().map(|&[x, y, z, i]| (cell([x, y, z], [0.0; 3]), i.to_bits())).collect();
    expected.sort_unstable();
    for (point, intensity) in decoded.into_iter().zip(frame.intensities().unwrap()) {
        let sides = (0..8).map(|side| [0, 1, 2].map(|axis| if side >> axis & 1 == 1 { 0.001 } else { -0.001 }));
        let mut cells = sides.map(|by| (cell(point, by), intensity.to_bits()));
        assert!(cells.any(|found| expected.binary_search(&found).is_ok()), "{point:?} {intensity}");
    }
}

/// Where rows are known, and points go beside their pixels.
#[test]
fn displaced_points_take_their_intensity_along() {
    let lattice = Lattice::<66>::new(hdl64e::GRID, 400).unwrap();
    let config = LatticeConfig { policy: Policy::default(), ..LatticeConfig::new(&lattice) };
    let (mut levels, mut plane) = (vec![0_u16; ROWS * 400], vec![0; ROWS * 400]);
    let (mut store, mut coder) = (Store::new(), IntensityCoder::<ROWS, 8>::new());
    let image = ImageViewMut::new(&mut levels, 400).unwrap();
    let mut frame = FrameEncoder::start(&config, Stamp::default(), image, &mut store).unwrap();
    let points = [[10.0, 0.0, -0.5], [20.0, 0.0, -1.0], [30.0, 0.0, -1.5]];
    frame.insert_lit_on_rows(&points, &[10, 10, 10], |at| [7, 8, 9][at], &mut plane);
    let mut out = vec![0; 200_000];
    let planes = Planes { intensity: Some(coder.plane(&plane, IntensityScale::RAW)), ..Planes::default() };
    let len = frame.finish_with(planes, &mut out).unwrap().len;
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&out[..len]).unwrap();
    let mut found: Vec<_> =
        frame.points().iter().map(|[x, ..]| (*x / 10.0).round()).zip(frame.intensities().unwrap()).collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    assert_eq!(found, [(1.0, 7.0), (2.0, 8.0), (3.0, 9.0)]);
}

/// What the decoder that was written from FORMAT.md alone finds of a plane.
fn by_python(name: &str, plane: &str, bytes: &[u8]) -> Vec<u8> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    let mut python = std::process::Command::new("python3");
    let python = python.arg(root.join("tests/reference/plane_decoder.py")).arg(&path).arg(plane);
    let output = python.output().expect("python3, which tools/setup.sh installs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn check_with_python(name: &str, bytes: &[u8]) {
    let mut decoder = Decoder::default();
    let frame = decoder.decode(bytes).unwrap();
    assert!(by_python(name, "intensity", bytes) == frame.intensity_plane().unwrap().0, "{name} differs");
}

#[test]
fn the_format_is_described_completely() {
    for (number, (count, mask, step)) in
        [(9000, 255, 1), (2000, 99, 1), (9000, 255, 16), (50, 255, 1), (500, 0, 1)].into_iter().enumerate()
    {
        let scale = IntensityScale::new(1.0, step).unwrap();
        let bytes = encoded(&returns(count, 77, mask), scale, Collision::Nearest);
        check_with_python(&format!("plane-{number}.flicr"), &bytes);
    }
    // Intensities that depend on their neighbors, as those of a sensor do.
    let pixels = (0..4000).flat_map(|tick| (0..64).map(move |row| (row, tick)));
    let steady = pixels.filter(|(row, tick)| (row * tick) % 7 > 0);
    let steady: Vec<_> = steady
        .map(|(row, tick)| (GridReturn { row: row as u16, tick, count: 500 }, (40 + row / 4 + (tick / 40) % 9) as u8))
        .collect();
    let bytes = encoded(&steady, IntensityScale::PERCENT, Collision::Nearest);
    assert!(bytes.len() < frame::HEADER_LEN + 2 * ROWS * COLUMNS + 3000, "{} bytes", bytes.len());
    check_with_python("plane-steady.flicr", &bytes);
    check_with_python("plane-strips.flicr", &in_strips(&steady, IntensityScale::PERCENT, Collision::Nearest, 9));
}

fn with_times(times_ns: &[u64], unit_ns: u32, timestamp_ns: u64) -> Vec<u8> {
    let mut encoder: Encoder<ROWS, COLUMNS, u16, Store> = Encoder::new(Store::new());
    let config = GridConfig { strips: 3, ..GridConfig::new(hdl64e::GRID, COLUMNS as u16) };
    let frame = encoder.start(&config, Stamp { sequence: 0, timestamp_ns }).unwrap();
    let planes = Planes { times: TimesPlane::new(times_ns, unit_ns), ..Planes::default() };
    let mut out = vec![0; config.worst_case_len::<u16, Store>() + planes.worst_case_len(ROWS, COLUMNS, 3)];
    let len = frame.finish_with(planes, &mut out).unwrap().len;
    out.truncate(len);
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn times_come_back_within_half_a_unit(
        first in 1_u64..1 << 62,
        before in 0_u64..1 << 30,
        step in 0_u64..1 << 32,
        jitter in prop::collection::vec(prop_oneof![6 => Just(0_u64), 2 => 0_u64..2000, 1 => 0_u64..1 << 28], COLUMNS),
        unit_ns in prop_oneof![Just(1_u32), Just(1000), 1..u32::MAX],
    ) {
        let times_ns: Vec<u64> = (0..).zip(&jitter).map(|(at, jitter)| first + at * step + jitter).collect();
        let bytes = with_times(&times_ns, unit_ns, first.saturating_sub(before));
        let mut decoder = Decoder::default();
        let frame = decoder.decode(&bytes).unwrap();
        for (found, expected) in frame.column_times_ns().unwrap().iter().zip(&times_ns) {
            prop_assert!(found.abs_diff(*expected) <= u64::from(unit_ns) / 2, "{} {}", found, expected);
        }
    }

    #[test]
    fn damaged_times_never_panic(at in 0..60_usize, byte in any::<u8>(), cut in 0..30_usize) {
        let times_ns: Vec<u64> = (0..100).map(|at| 5_000_000 + at * 55_296 + at % 7).collect();
        let mut bytes = with_times(&times_ns, 1, 5_000_000);
        let begin = section_at(&bytes);
        let at = begin + at % (bytes.len() - 4 - begin);
        bytes[at] = byte;
        bytes.drain(bytes.len() - 4 - cut.min(bytes.len() - 4 - begin)..bytes.len() - 4);
        let _ = Decoder::default().decode(&sealed(bytes));
    }
}

#[test]
fn regular_times_take_a_few_bytes() {
    let times_ns: Vec<u64> = (0..100).map(|at| 77_000_000 + at * 46_083).collect();
    let bytes = with_times(&times_ns, 1, 77_000_000);
    let of_times = bytes.len() - 4 - section_at(&bytes);
    assert!(of_times <= 8 + 4 + 3 * (4 + 16 + 4), "{of_times} bytes");
    // What is not known is put on the line.
    let mut gaps = times_ns.clone();
    for at in [0, 5, 6, 7, 99] {
        gaps[at] = 0;
    }
    let mut decoder = Decoder::default();
    assert_eq!(decoder.decode(&with_times(&gaps, 1, 77_000_000)).unwrap().column_times_ns().unwrap(), times_ns);
    assert_eq!(decoder.decode(&with_times(&[0; COLUMNS], 1, 9)).unwrap().column_times_ns().unwrap(), [9; COLUMNS]);
    for (name, times_ns) in [("even", &times_ns), ("gaps", &gaps)] {
        check_times_with_python(name, &with_times(times_ns, 1, 77_000_000));
    }
    let uneven: Vec<u64> =
        (0..100).map(|at| 77_000_000 + at * 46_083 + (at * at * 977) % 3000 + at / 50 * 90_000).collect();
    check_times_with_python("uneven", &with_times(&uneven, 10, 80_000_000));
}

fn check_times_with_python(name: &str, bytes: &[u8]) {
    let mut decoder = Decoder::default();
    let frame = decoder.decode(bytes).unwrap();
    let expected: Vec<u8> = frame.column_times_ns().unwrap().iter().flat_map(|time| time.to_le_bytes()).collect();
    assert!(by_python(&format!("times-{name}.flicr"), "times", bytes) == expected, "{name} differs");
}

/// The same bytes on every target.
#[test]
fn planes_are_what_they_were() {
    let mut found = String::new();
    for (count, mask, step) in [(9000, 255, 1), (2000, 99, 1), (9000, 255, 16)] {
        let bytes = encoded(&returns(count, 77, mask), IntensityScale::new(100.0, step).unwrap(), Collision::Nearest);
        let crc = &bytes[bytes.len() - 4..];
        writeln!(found, "returns={count} step={step} bytes={} crc={crc:02x?}", bytes.len()).unwrap();
    }
    if std::env::var_os("FLICR_BLESS").is_some() {
        std::fs::write("tests/planes.out", &found).unwrap();
    }
    assert_eq!(found, std::fs::read_to_string("tests/planes.out").unwrap());
}
