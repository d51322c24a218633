//! Intensities and times through the C ABI.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use flicr::capi::{flicr_status as Status, *};
use flicr::geometry::sensors::hdl64e;
use flicr::plane::{IntensityCoder, IntensityScale, Planes, TimesPlane};
use flicr::{Config, Decoder, Encoder, GridConfig, GridReturn, Rle, Scale, Stamp};

use crate::{COLUMNS, RLE, ROWS, STAMP, UNTOUCHED};

const PIXELS: usize = (COLUMNS * ROWS) as usize;

/// What a client lends: the numbers' plane, the coder's memory, times.
struct Lent {
    numbers: Vec<u8>,
    state: Vec<u16>,
    times_ns: Vec<u64>,
}

impl Lent {
    fn new() -> Self {
        let times_ns =
            (0..u64::from(COLUMNS)).map(|column| STAMP.timestamp_ns + 46_080 * column + column % 3).collect();
        Self { numbers: vec![0; PIXELS], state: vec![0xA5A5; FLICR_INTENSITY_STATE_LEN / 2], times_ns }
    }

    fn planes(&mut self) -> flicr_planes {
        flicr_planes {
            intensities: self.numbers.as_mut_ptr(),
            intensity_state: self.state.as_mut_ptr().cast(),
            intensity_per_unit: 100.0,
            intensity_step: 1,
            times_ns: self.times_ns.as_ptr(),
            time_unit_ns: 1,
        }
    }
}

fn returns() -> Vec<flicr_return> {
    (0..9000).map(|n| flicr_return { tick: n * 7 % 4000, count: 500 + n * 13 % 40_000, row: n * 5 % 64 }).collect()
}

fn number(index: usize) -> u8 {
    (index * index / 50 % 100) as u8
}

fn stamp() -> Stamp {
    Stamp { sequence: STAMP.sequence, timestamp_ns: STAMP.timestamp_ns }
}

/// The frame that Rust makes of the returns.
fn returns_frame(times_ns: &[u64]) -> Vec<u8> {
    let mut encoder: Encoder<64, 256, u16, Rle> = Encoder::new(Rle::new());
    let (mut coder, mut plane) = (IntensityCoder::<64, 8>::new(), vec![0; PIXELS]);
    let mut frame = encoder.start(&GridConfig::new(hdl64e::GRID, 256), stamp()).unwrap();
    let found = returns().into_iter().enumerate();
    let found = found
        .map(|(index, flicr_return { tick, count, row })| (GridReturn { row: row as u16, tick, count }, number(index)));
    frame.insert_lit_returns(found, &mut plane);
    let planes =
        Planes { intensity: Some(coder.plane(&plane, IntensityScale::PERCENT)), times: TimesPlane::new(times_ns, 1) };
    let mut out = vec![0; 200_000];
    let len = frame.finish_with(planes, &mut out).unwrap().len;
    out.truncate(len);
    out
}

fn grid_encoder(memory: &mut Vec<u64>) -> *mut flicr_grid_encoder {
    let mut config = MaybeUninit::uninit();
    // SAFETY: a place for a configuration, which success fills; the vector's own pointer and length.
    unsafe {
        let sensor = flicr_sensor::Hdl64e as u32;
        assert_eq!(flicr_grid_config_init(sensor, COLUMNS, config.as_mut_ptr()), Status::Ok);
        let config = flicr_grid_config { table: 0, ..config.assume_init() };
        memory.resize(flicr_grid_encoder_size(COLUMNS, ROWS, config.level_bits, RLE).div_ceil(8), 0);
        let (mut encoder, len) = (null_mut(), 8 * memory.len());
        let status = flicr_grid_encoder_init_rle(memory.as_mut_ptr().cast(), len, &raw const config, &raw mut encoder);
        assert_eq!(status, Status::Ok);
        encoder
    }
}

fn insert_returns(encoder: *mut flicr_grid_encoder, planes: &flicr_planes) {
    let (returns, numbers) = (returns(), (0..9000).map(number).collect::<Vec<_>>());
    let (at, stride) = (returns.as_ptr().cast(), size_of::<flicr_return>());
    // SAFETY: the vectors' own pointers and lengths.
    let status = unsafe { flicr_insert_lit_returns(encoder, at, returns.len(), stride, numbers.as_ptr(), planes) };
    assert_eq!(status, Status::Ok);
}

fn finish_returns(
    encoder: *mut flicr_grid_encoder,
    planes: &flicr_planes,
    out: &mut [u8],
) -> Result<flicr_encoded, Status> {
    let mut encoded = UNTOUCHED;
    // SAFETY: the slice's own pointer and length.
    let status = unsafe {
        flicr_finish_returns_with(encoder, STAMP, planes, out.as_mut_ptr().cast(), out.len(), &raw mut encoded)
    };
    assert_eq!(encoded == UNTOUCHED, status != Status::Ok, "written only on success");
    if status == Status::Ok { Ok(encoded) } else { Err(status) }
}

#[test]
fn returns_with_planes_are_rusts_frames() {
    let (mut memory, mut lent) = (Vec::new(), Lent::new());
    let encoder = grid_encoder(&mut memory);
    let expected = returns_frame(&lent.times_ns);
    let mut out = vec![0; expected.len()];
    // Twice: what is in the coder's memory does not matter.
    for _ in 0..2 {
        lent.numbers.fill(9);
        let planes = lent.planes();
        insert_returns(encoder, &planes);
        assert_eq!(finish_returns(encoder, &planes, &mut out).unwrap().len, expected.len());
        assert!(out == expected);
    }
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&out).unwrap();
    assert_eq!(frame.column_times_ns().unwrap(), lent.times_ns);
    assert_eq!(frame.intensities().unwrap().len(), frame.points().len());
}

#[test]
fn points_with_intensities_are_rusts_frames() {
    let points: Vec<[f32; 4]> =
        (0..5000).map(|n| n as f32 * 0.01).map(|a| [20.0 * a.cos(), 20.0 * a.sin(), -1.0, a % 1.0]).collect();
    let numbers: Vec<u8> = (0..5000).map(number).collect();
    let scale = Scale::Fixed { max_range_m: 120.0 };
    let mut rust: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
    let (mut coder, mut plane) = (IntensityCoder::<64, 8>::new(), vec![0; PIXELS]);
    let mut frame = rust.start(&Config { scale, ..Config::UNIFORM }, stamp()).unwrap();
    frame.insert_lit(points.as_slice(), |index| numbers[index], &mut plane);
    let planes = Planes { intensity: Some(coder.plane(&plane, IntensityScale::PERCENT)), ..Planes::default() };
    let mut expected = vec![0; 200_000];
    let len = frame.finish_with(planes, &mut expected).unwrap().len;
    expected.truncate(len);

    let mut lent = Lent::new();
    let planes = flicr_planes { times_ns: null(), ..lent.planes() };
    let mut memory = vec![0_u64; flicr_encoder_size(COLUMNS, ROWS, RLE).div_ceil(8)];
    let (mut config, mut encoder, mut encoded) = (MaybeUninit::uninit(), null_mut(), UNTOUCHED);
    let mut out = vec![0; flicr_worst_case_len(COLUMNS, ROWS, RLE) + flicr_planes_worst_case_len(COLUMNS, ROWS, 1)];
    // SAFETY: places for what success fills; the vectors' own pointers and lengths.
    unsafe {
        let preset = flicr_preset::Uniform as u32;
        assert_eq!(flicr_config_init(preset, COLUMNS, ROWS, config.as_mut_ptr()), Status::Ok);
        let config = flicr_config { max_range_m: 120.0, ..config.assume_init() };
        let (start, len) = (memory.as_mut_ptr().cast(), 8 * memory.len());
        assert_eq!(flicr_encoder_init_rle(start, len, &raw const config, &raw mut encoder), Status::Ok);
        assert_eq!(flicr_start(encoder, STAMP), Status::Ok);
        let at = points.as_ptr().cast();
        assert_eq!(flicr_insert_lit(encoder, at, points.len(), 16, numbers.as_ptr(), &raw const planes), Status::Ok);
        let (at, len) = (out.as_mut_ptr().cast(), out.len());
        assert_eq!(flicr_finish_with(encoder, &raw const planes, at, len, &raw mut encoded), Status::Ok);
    }
    assert!(out[..encoded.len] == expected);
}

#[test]
fn what_planes_cannot_be_is_refused_and_the_frame_stays_open() {
    let (mut memory, mut lent) = (Vec::new(), Lent::new());
    let encoder = grid_encoder(&mut memory);
    let expected = returns_frame(&lent.times_ns);
    let planes = lent.planes();
    insert_returns(encoder, &planes);
    let mut out = vec![0; expected.len()];
    let mut refused =
        |planes: flicr_planes, status| assert_eq!(finish_returns(encoder, &planes, &mut out), Err(status));
    refused(flicr_planes { intensity_step: 0, ..planes }, Status::Plane);
    refused(flicr_planes { intensity_step: 256, ..planes }, Status::Plane);
    refused(flicr_planes { intensity_per_unit: f32::NAN, ..planes }, Status::Plane);
    refused(flicr_planes { time_unit_ns: 0, ..planes }, Status::Plane);
    refused(flicr_planes { intensity_state: null_mut(), ..planes }, Status::NullPointer);
    refused(
        flicr_planes { intensity_state: planes.intensity_state.wrapping_byte_add(1), ..planes },
        Status::Misaligned,
    );
    refused(flicr_planes { intensity_state: planes.intensities.cast(), ..planes }, Status::Overlap);
    let in_encoder = encoder.cast::<u8>();
    refused(flicr_planes { intensities: in_encoder, ..planes }, Status::Overlap);
    let short = out.len() - 1;
    assert_eq!(finish_returns(encoder, &planes, &mut out[..short]), Err(Status::OutputTooSmall));
    // SAFETY: null pointers are found.
    let insert = |planes: &flicr_planes| unsafe {
        flicr_insert_lit_returns(encoder, [0_u8; 12].as_ptr().cast(), 1, 12, null(), planes)
    };
    assert_eq!(insert(&planes), Status::NullPointer);
    assert_eq!(finish_returns(encoder, &planes, &mut out).unwrap().len, expected.len());
    assert!(out == expected);
}

/// Statuses that only planes bring.
pub fn refused(expect: &mut impl FnMut(Status, Status)) {
    let (mut memory, mut lent, mut out) = (Vec::new(), Lent::new(), vec![0; 200_000]);
    let planes = flicr_planes { intensity_step: 0, ..lent.planes() };
    expect(finish_returns(grid_encoder(&mut memory), &planes, &mut out).unwrap_err(), Status::Plane);
}
