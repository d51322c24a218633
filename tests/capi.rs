//! Promise: the C ABI makes the frames that Rust makes, refuses what it cannot use with the status that says so, and
//! its header is that of the source. `tests/c_client.rs` comes from the other side, with C compilers.
#![allow(unsafe_code, reason = "calls as C makes them")]

mod common;
#[path = "capi/grid.rs"]
mod grid;
#[path = "capi/planes.rs"]
mod planes;
#[path = "capi/stream.rs"]
mod stream;
#[path = "common/packet_writer.rs"]
mod writer;

use std::collections::BTreeSet;
use std::ffi::{CStr, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};

use flicr::capi::{flicr_status as Status, *};
use flicr::coder::{ContextSettings, Predictor, Step};
use flicr::{
    Coder, Collision, Config, DeflateDefault, DeflateDense, DeflateSmall, Dense, ImageViewMut, OutOfView, Placement,
    Policy, Rle, Scale, Small, Stamp, Store, UniformView,
};

const COLUMNS: u32 = 256;
const ROWS: u32 = 64;
const RLE: u32 = flicr_coder::Rle as u32;
const STAMP: flicr_stamp = flicr_stamp { timestamp_ns: 77, sequence: 9 };
const CODERS: [flicr_coder; 7] = [
    flicr_coder::Store,
    flicr_coder::Rle,
    flicr_coder::Deflate,
    flicr_coder::DeflateSmall,
    flicr_coder::DeflateDense,
    flicr_coder::Small,
    flicr_coder::Dense,
];
/// Settings of the context coders, in C and in Rust.
static CONTEXT: flicr_context = flicr_context { step_levels: 1, dead_zone: 1, noise_levels: 3, predictor: 0 };
const SETTINGS: ContextSettings = ContextSettings { noise: 3, ..ContextSettings::COARSE };
const WIDTHS: [u32; 6] = [4500, 4096, 2048, 1024, 512, 256];

/// The status of the largest number.
const LAST: Status = Status::Plane;

/// What stays in an out-parameter that is not written.
const UNTOUCHED: flicr_encoded = flicr_encoded {
    len: 0xA5A5,
    range_bound_m: -1.0,
    tally: flicr_tally {
        points: 1,
        kept: 2,
        no_return: 3,
        not_finite: 4,
        too_near: 5,
        beyond_range: 6,
        out_of_view: 7,
        collided: 8,
        clamped: 9,
    },
};

#[test]
fn header_is_made_from_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let builder = cbindgen::Builder::new().with_config(config).with_src(root.join("src/capi/mod.rs"));
    let mut fresh = Vec::new();
    builder.generate().unwrap().write(&mut fresh);
    let path = root.join("include/flicr.h");
    if std::env::var_os("FLICR_BLESS").is_some() {
        std::fs::write(&path, &fresh).unwrap();
    }
    let committed = std::fs::read_to_string(path).unwrap();
    assert!(committed.as_bytes() == fresh, "include/flicr.h is not that of src/capi: FLICR_BLESS=1 writes it anew");
}

#[test]
fn version_is_the_crates() {
    let version = format!("{FLICR_VERSION_MAJOR}.{FLICR_VERSION_MINOR}.{FLICR_VERSION_PATCH}");
    assert_eq!(version, env!("CARGO_PKG_VERSION"));
    let bytes = [FLICR_VERSION_MAJOR, FLICR_VERSION_MINOR, FLICR_VERSION_PATCH].map(|part| part as u8);
    assert_eq!(flicr_version().to_be_bytes(), [0, bytes[0], bytes[1], bytes[2]]);
}

/// An encoder's memory, full of what was there before.
struct Memory(Vec<u64>);

impl Memory {
    fn of(config: &flicr_config, coder: flicr_coder) -> Self {
        let len = flicr_encoder_size(config.columns, config.rows, coder as u32);
        Self(vec![0xA5A5_A5A5_A5A5_A5A5; len.div_ceil(8)])
    }

    fn start(&mut self) -> *mut c_void {
        self.0.as_mut_ptr().cast()
    }

    fn init(&mut self, config: &flicr_config, coder: flicr_coder) -> Result<*mut flicr_encoder, Status> {
        self.init_with(config, coder, &CONTEXT)
    }

    fn init_with(
        &mut self,
        config: &flicr_config,
        coder: flicr_coder,
        context: &flicr_context,
    ) -> Result<*mut flicr_encoder, Status> {
        let (start, len) = (self.start(), size_of_val(self.0.as_slice()));
        let mut encoder = null_mut();
        let init = match coder {
            flicr_coder::Store => flicr_encoder_init_store,
            flicr_coder::Rle => flicr_encoder_init_rle,
            flicr_coder::Deflate => flicr_encoder_init_deflate,
            flicr_coder::DeflateSmall => flicr_encoder_init_deflate_small,
            flicr_coder::DeflateDense => flicr_encoder_init_deflate_dense,
            flicr_coder::Small | flicr_coder::Dense => {
                let is_small = coder == flicr_coder::Small;
                let init = if is_small { flicr_encoder_init_small } else { flicr_encoder_init_dense };
                // SAFETY: the vector's own pointer and length.
                let status = unsafe { init(start, len, config, context, &raw mut encoder) };
                assert_eq!(encoder.is_null(), status != Status::Ok, "written only on success");
                return ok(status).map(|()| encoder);
            }
        };
        // SAFETY: the vector's own pointer and length.
        let status = unsafe { init(start, len, config, &raw mut encoder) };
        assert_eq!(encoder.is_null(), status != Status::Ok, "written only on success");
        ok(status).map(|()| encoder)
    }
}

fn ok(status: Status) -> Result<(), Status> {
    if status == Status::Ok { Ok(()) } else { Err(status) }
}

fn preset(preset: flicr_preset, columns: u32) -> flicr_config {
    let mut config = std::mem::MaybeUninit::uninit();
    // SAFETY: a place for a configuration, which success fills.
    unsafe {
        assert_eq!(flicr_config_init(preset as u32, columns, ROWS, config.as_mut_ptr()), Status::Ok);
        config.assume_init()
    }
}

fn fixed() -> flicr_config {
    flicr_config { max_range_m: 80.0, ..preset(flicr_preset::Uniform, COLUMNS) }
}

/// Encodes records of `stride` bytes and checks that nothing is written behind the frame, or at all on failure.
fn encode(
    encoder: *mut flicr_encoder,
    records: &[u8],
    count: usize,
    stride: usize,
    out: &mut [u8],
) -> Result<flicr_encoded, Status> {
    let mut encoded = UNTOUCHED;
    // SAFETY: the slices' own pointers and lengths; `count` and `stride` are the caller's to get right.
    let status = unsafe {
        let points = records.as_ptr().cast();
        let (start, len) = (out.as_mut_ptr().cast(), out.len());
        flicr_encode(encoder, points, count, stride, STAMP, start, len, &raw mut encoded)
    };
    assert_eq!(encoded == UNTOUCHED, status != Status::Ok, "written only on success");
    ok(status).map(|()| encoded)
}

fn encode_xyz(config: &flicr_config, coder: flicr_coder, points: &[[f32; 3]]) -> (flicr_encoded, Vec<u8>) {
    let mut memory = Memory::of(config, coder);
    let encoder = memory.init(config, coder).unwrap();
    let mut out = vec![0; flicr_worst_case_len_in_strips(config.columns, config.rows, coder as u32, config.strips)];
    let encoded = encode(encoder, bytemuck::cast_slice(points), points.len(), 12, &mut out).unwrap();
    out.truncate(encoded.len);
    (encoded, out)
}

fn encode_in_rust<C: Coder<u8>>(
    config: &Config,
    columns: u32,
    points: &[[f32; 3]],
    mut coder: C,
) -> (flicr::Encoded, Vec<u8>) {
    let (columns, rows) = (columns as usize, ROWS as usize);
    let mut levels = vec![0_u8; columns * rows];
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let mut out = vec![0; flicr::frame::worst_case_len_in_strips::<u8, C>(rows, columns, config.strips)];
    let stamp = Stamp { sequence: STAMP.sequence, timestamp_ns: STAMP.timestamp_ns };
    let encoded = flicr::encode(config, points, stamp, image, &mut coder, &mut out).unwrap();
    out.truncate(encoded.len);
    (encoded, out)
}

fn encode_with(coder: flicr_coder, config: &Config, columns: u32, points: &[[f32; 3]]) -> (flicr::Encoded, Vec<u8>) {
    match coder {
        flicr_coder::Store => encode_in_rust(config, columns, points, Store::new()),
        flicr_coder::Rle => encode_in_rust(config, columns, points, Rle::new()),
        flicr_coder::Deflate => encode_in_rust(config, columns, points, DeflateDefault::new()),
        flicr_coder::DeflateSmall => encode_in_rust(config, columns, points, DeflateSmall::new()),
        flicr_coder::DeflateDense => encode_in_rust(config, columns, points, DeflateDense::new()),
        flicr_coder::Small => encode_in_rust(config, columns, points, Small::<8>::new(SETTINGS)),
        flicr_coder::Dense => encode_in_rust(config, columns, points, Dense::<8>::new(SETTINGS)),
    }
}

fn check_same_frame(c: &flicr_config, rust: &Config, coder: flicr_coder, points: &[[f32; 3]]) {
    let (from_c, c_bytes) = encode_xyz(c, coder, points);
    let (from_rust, rust_bytes) = encode_with(coder, rust, c.columns, points);
    assert!(c_bytes == rust_bytes, "{c:?}");
    assert_eq!(from_c.range_bound_m, from_rust.range_bound_m);
    let tally = from_c.tally;
    let counts = [tally.points, tally.kept, tally.no_return, tally.not_finite, tally.too_near];
    let rust = from_rust.tally;
    assert_eq!(counts, [rust.points, rust.kept(), rust.no_return, rust.not_finite, rust.too_near]);
    let counts = [tally.beyond_range, tally.out_of_view, tally.collided, tally.clamped];
    assert_eq!(counts, [rust.beyond_range, rust.out_of_view, rust.collided, rust.clamped]);
}

/// The spiral, and one of everything that is not kept.
fn points() -> Vec<[f32; 3]> {
    let odd = [[0.0, 0.0, 0.0], [f32::NAN, 1.0, 1.0], [0.01, 0.0, 0.0], [70.0, 60.0, 0.0], [1.0, 0.0, 50.0]];
    common::spiral(20_000).into_iter().chain(odd).collect()
}

#[test]
fn frames_are_rusts_at_every_size_with_every_coder() {
    let points = points();
    for (c_preset, rust) in [(flicr_preset::Paper, Config::PAPER), (flicr_preset::Uniform, Config::UNIFORM)] {
        for (columns, coder) in WIDTHS.iter().flat_map(|&columns| CODERS.map(|coder| (columns, coder))) {
            check_same_frame(&preset(c_preset, columns), &rust, coder, &points);
        }
    }
}

#[test]
fn every_choice_is_rusts() {
    let (points, coder) = (points(), flicr_coder::Rle);
    let collisions = [
        (flicr_collision::Nearest, Collision::Nearest),
        (flicr_collision::Farthest, Collision::Farthest),
        (flicr_collision::First, Collision::First),
        (flicr_collision::Last, Collision::Last),
    ];
    let views = [(flicr_out_of_view::Drop, OutOfView::Drop), (flicr_out_of_view::Clamp, OutOfView::Clamp)];
    let placements = [(flicr_placement::Center, Placement::Center), (flicr_placement::Corner, Placement::Corner)];
    let view = UniformView { top_rad: 0.1, bottom_rad: -0.3, start_rad: -1.0, span_rad: 2.5 };
    for ((c_collision, collision), (c_view, out_of_view), (c_place, placement)) in
        collisions.iter().flat_map(|&c| views.map(|v| placements.map(|p| (c, v, p)))).flatten()
    {
        let c = flicr_config {
            level_bits: 7,
            max_range_m: 60.0,
            top_rad: view.top_rad,
            bottom_rad: view.bottom_rad,
            start_rad: view.start_rad,
            span_rad: view.span_rad,
            collision: c_collision as u32,
            out_of_view: c_view as u32,
            placement: c_place as u32,
            ..preset(flicr_preset::Paper, COLUMNS)
        };
        let policy = Policy { collision, out_of_view };
        let scale = Scale::Fixed { max_range_m: 60.0 };
        let rust = Config { view, placement, level_bits: 7, scale, policy, ..Config::PAPER };
        check_same_frame(&c, &rust, coder, &points);
    }
}

#[test]
fn companding_is_rusts() {
    let c = flicr_config { companding: flicr_companding::SquareRoot as u32, ..preset(flicr_preset::Uniform, COLUMNS) };
    let rust = Config { companding: flicr::Companding::SquareRoot, ..Config::UNIFORM };
    check_same_frame(&c, &rust, flicr_coder::Rle, &points());
}

#[test]
fn strips_are_rusts() {
    for coder in CODERS {
        let c = flicr_config { strips: 16, ..preset(flicr_preset::Uniform, COLUMNS) };
        check_same_frame(&c, &Config { strips: 16, ..Config::UNIFORM }, coder, &points());
    }
    for strips in [0, COLUMNS + 1, 65_536 + 1] {
        assert_eq!(flicr_worst_case_len_in_strips(COLUMNS, ROWS, RLE, strips), 0);
    }
}

#[test]
fn every_setting_of_the_context_coders_is_rusts() {
    let (points, config) = (points(), fixed());
    let rust = Config { scale: Scale::Fixed { max_range_m: 80.0 }, ..Config::UNIFORM };
    let settings = |step: Option<Step>, predictor| ContextSettings { step: step.unwrap(), noise: 9, predictor };
    for (dead_zone, step) in [(1, Step::new(6)), (0, Step::exact(6))] {
        for (predictor, in_rust) in [(0, Predictor::West), (1, Predictor::MedianEdge)] {
            let context = flicr_context { step_levels: 6, dead_zone, noise_levels: 9, predictor };
            let settings = settings(step, in_rust);
            let expected = [
                (flicr_coder::Small, encode_in_rust(&rust, COLUMNS, &points, Small::<8>::new(settings))),
                (flicr_coder::Dense, encode_in_rust(&rust, COLUMNS, &points, Dense::<8>::new(settings))),
            ];
            for (coder, (of_rust, expected)) in expected {
                let mut memory = Memory::of(&config, coder);
                let encoder = memory.init_with(&config, coder, &context).unwrap();
                let mut out = vec![0; flicr_worst_case_len(COLUMNS, ROWS, coder as u32)];
                // Twice: nothing is left of the frame before.
                for _ in 0..2 {
                    let found = encode(encoder, bytemuck::cast_slice(&points), points.len(), 12, &mut out).unwrap();
                    assert!(out[..found.len] == expected, "{coder:?}, {context:?}");
                    assert_eq!(found.range_bound_m, of_rust.range_bound_m);
                }
            }
        }
    }
}

/// The context coders' settings for levels and steps of so many meters.
fn context(level_m: f32, step_m: f32) -> Result<flicr_context, Status> {
    let mut context = flicr_context { step_levels: 77, ..CONTEXT };
    // SAFETY: a place for settings.
    let status = unsafe { flicr_context_init(level_m, step_m, &raw mut context) };
    assert_eq!(context.step_levels == 77, status != Status::Ok, "written only on success");
    ok(status).map(|()| context)
}

#[test]
fn settings_of_the_context_coders_come_from_meters() {
    let of = |step_levels, noise_levels| Ok(flicr_context { step_levels, dead_zone: 1, noise_levels, predictor: 0 });
    assert_eq!(context(0.002, 0.0), of(1, 20));
    assert_eq!(context(0.002, 0.02), of(10, 20));
    assert_eq!(context(0.004, 0.05), of(13, 10));
    assert_eq!(context(0.002, 131.07), of(65_535, 20));
    assert_eq!(context(0.31, 0.0), of(1, 0));
    assert_eq!(context(0.31, 0.1), of(1, 0));
    for (level_m, step_m) in [
        (0.0, 0.1),
        (-1.0, 0.1),
        (f32::NAN, 0.1),
        (f32::INFINITY, 0.1),
        (0.002, -0.1),
        (0.002, f32::NAN),
        (0.002, 131.09),
        (0.002, f32::INFINITY),
    ] {
        assert_eq!(context(level_m, step_m), Err(Status::Context), "{level_m} {step_m}");
    }
}

#[test]
fn records_are_read_at_any_stride_and_alignment() {
    let (config, points) = (fixed(), points());
    let (_, expected) = encode_xyz(&config, flicr_coder::Rle, &points);
    let mut memory = Memory::of(&config, flicr_coder::Rle);
    let encoder = memory.init(&config, flicr_coder::Rle).unwrap();
    let mut out = vec![0; flicr_worst_case_len(COLUMNS, ROWS, RLE)];
    for stride in [12, 13, 16, 20, 48] {
        // One byte before, so that floats are at odd addresses; not one behind the last record's x, y, z.
        let mut records = vec![0xFF; 1 + (points.len() - 1) * stride + 12];
        for (record, point) in records[1..].chunks_mut(stride).zip(&points) {
            record[..12].copy_from_slice(bytemuck::bytes_of(point));
        }
        let encoded = encode(encoder, &records[1..], points.len(), stride, &mut out).unwrap();
        assert!(out[..encoded.len] == expected, "stride {stride}");
    }
}

fn insert(encoder: *mut flicr_encoder, points: &[[f32; 3]]) -> Status {
    // SAFETY: the slice's own pointer and length.
    unsafe { flicr_insert(encoder, points.as_ptr().cast(), points.len(), 12) }
}

fn finish(encoder: *mut flicr_encoder, out: &mut [u8]) -> Result<flicr_encoded, Status> {
    let mut encoded = UNTOUCHED;
    // SAFETY: the slice's own pointer and length.
    let status = unsafe { flicr_finish(encoder, out.as_mut_ptr().cast(), out.len(), &raw mut encoded) };
    assert_eq!(encoded == UNTOUCHED, status != Status::Ok, "written only on success");
    ok(status).map(|()| encoded)
}

fn start(encoder: *mut flicr_encoder) -> Status {
    // SAFETY: an encoder of `Memory::init`'s, null, or what a test wants refused.
    unsafe { flicr_start(encoder, STAMP) }
}

#[test]
fn pieces_make_the_same_frame() {
    let (points, mut out) = (points(), vec![0; flicr_worst_case_len(COLUMNS, ROWS, 0) * 2]);
    for coder in CODERS {
        let (whole, expected) = encode_xyz(&fixed(), coder, &points);
        let mut memory = Memory::of(&fixed(), coder);
        let encoder = memory.init(&fixed(), coder).unwrap();
        for piece_len in [1, 31, 32, 33, 4_000, points.len()] {
            assert_eq!(start(encoder), Status::Ok);
            assert!(points.chunks(piece_len).all(|piece| insert(encoder, piece) == Status::Ok));
            assert_eq!(finish(encoder, &mut out), Ok(whole));
            assert!(out[..whole.len] == expected, "{coder:?} in pieces of {piece_len}");
        }
    }
}

#[test]
fn a_frame_that_does_not_fit_can_be_finished_elsewhere() {
    let (points, config) = (points(), fixed());
    let (whole, expected) = encode_xyz(&config, flicr_coder::Rle, &points);
    let mut memory = Memory::of(&config, flicr_coder::Rle);
    let encoder = memory.init(&config, flicr_coder::Rle).unwrap();
    assert_eq!(start(encoder), Status::Ok);
    assert_eq!(insert(encoder, &points), Status::Ok);
    let mut out = vec![0; whole.len];
    for short in [0, 1, 75, 76, whole.len / 2, whole.len - 4, whole.len - 1] {
        assert_eq!(finish(encoder, &mut out[..short]), Err(Status::OutputTooSmall), "{short} bytes");
    }
    assert_eq!(finish(encoder, &mut out), Ok(whole));
    assert!(out == expected);
    assert_eq!(finish(encoder, &mut out), Err(Status::NotStarted), "once only");
}

#[test]
fn whole_scans_drop_a_frame_that_was_started() {
    let (points, config) = (points(), fixed());
    let (whole, expected) = encode_xyz(&config, flicr_coder::Rle, &points);
    let mut memory = Memory::of(&config, flicr_coder::Rle);
    let encoder = memory.init(&config, flicr_coder::Rle).unwrap();
    assert_eq!(start(encoder), Status::Ok);
    assert_eq!(insert(encoder, &[[1.0, 2.0, 0.0]]), Status::Ok);
    let mut out = vec![0; whole.len];
    assert_eq!(encode(encoder, bytemuck::cast_slice(&points), points.len(), 12, &mut out), Ok(whole));
    assert!(out == expected, "nothing is left of the frame before");
    assert_eq!(insert(encoder, &points), Status::NotStarted);
}

#[test]
fn no_points_are_a_frame_too() {
    let mut memory = Memory::of(&fixed(), flicr_coder::Rle);
    let encoder = memory.init(&fixed(), flicr_coder::Rle).unwrap();
    let (mut out, mut encoded) = (vec![0_u8; 1_000], UNTOUCHED);
    // SAFETY: no points need no pointer.
    let status = unsafe {
        let start = out.as_mut_ptr().cast();
        flicr_encode(encoder, null(), 0, 12, STAMP, start, out.len(), &raw mut encoded)
    };
    assert_eq!((status, encoded.tally.points), (Status::Ok, 0));
    let frame = flicr::Decoder::default().decode(&out[..encoded.len]).unwrap().points();
    assert!(frame.is_empty());
}

#[test]
fn sizes_of_what_cannot_be_are_zero() {
    for (columns, rows, coder) in
        [(0, 64, RLE), (256, 0, RLE), (65_536, 1, RLE), (1, 65_536, RLE), (65_535, 65_535, RLE), (1, 1, 99)]
    {
        assert_eq!(flicr_encoder_size(columns, rows, coder), 0);
        assert_eq!(flicr_worst_case_len(columns, rows, coder), 0);
    }
    assert!(flicr_encoder_size(65_535, 16_384, RLE) > 0);
}

#[test]
fn every_status_has_a_text_of_its_own() {
    let text = |status| {
        // SAFETY: what the header promises of the text.
        unsafe { CStr::from_ptr(flicr_status_text(status)) }.to_str().unwrap()
    };
    let known: BTreeSet<&str> = (0..=LAST as i32).map(text).collect();
    assert_eq!(known.len(), LAST as usize + 1);
    for unknown in [-1, LAST as i32 + 1, i32::MAX, i32::MIN] {
        assert!(!known.contains(text(unknown)) && text(unknown).contains("no status"));
    }
}

/// What every status takes to be returned; the numbers in between must all be there.
#[test]
fn every_status_is_returned() {
    let mut seen = BTreeSet::from([Status::Ok as i32]);
    let mut expect = |found: Status, expected: Status| {
        assert_eq!(found, expected);
        seen.insert(expected as i32);
    };
    refused_configs(&mut expect);
    refused_memory(&mut expect);
    refused_calls(&mut expect);
    grid::refused(&mut expect);
    stream::refused(&mut expect);
    planes::refused(&mut expect);
    assert!(seen.into_iter().eq(0..=LAST as i32));
}

fn refused_configs(expect: &mut impl FnMut(Status, Status)) {
    let mut config = fixed();
    let mut init = |preset, columns, rows| {
        // SAFETY: a place for a configuration.
        unsafe { flicr_config_init(preset, columns, rows, &raw mut config) }
    };
    expect(init(2, COLUMNS, ROWS), Status::Preset);
    expect(init(0, 0, ROWS), Status::Size);
    // SAFETY: null is to be found.
    expect(unsafe { flicr_config_init(0, COLUMNS, ROWS, null_mut()) }, Status::NullPointer);
    let good = fixed();
    assert_eq!(config, good, "written only on success");
    let nan = f32::NAN;
    let refused = [
        (flicr_config { columns: 65_536, ..good }, Status::Size),
        (flicr_config { rows: 0, ..good }, Status::Size),
        (flicr_config { level_bits: 0, ..good }, Status::LevelBits),
        (flicr_config { level_bits: 9, ..good }, Status::LevelBits),
        (flicr_config { max_range_m: -1.0, ..good }, Status::MaxRange),
        (flicr_config { max_range_m: nan, ..good }, Status::MaxRange),
        (flicr_config { max_range_m: f32::INFINITY, ..good }, Status::MaxRange),
        (flicr_config { top_rad: good.bottom_rad, ..good }, Status::ElevationView),
        (flicr_config { bottom_rad: nan, ..good }, Status::ElevationView),
        (flicr_config { start_rad: 4.0, ..good }, Status::AzimuthView),
        (flicr_config { span_rad: 0.0, ..good }, Status::AzimuthView),
        (flicr_config { collision: 4, ..good }, Status::Collision),
        (flicr_config { out_of_view: 2, ..good }, Status::OutOfView),
        (flicr_config { placement: 2, ..good }, Status::Placement),
        (flicr_config { companding: 2, ..good }, Status::Companding),
        (flicr_config { strips: 0, ..good }, Status::Strips),
        (flicr_config { strips: COLUMNS + 1, ..good }, Status::Strips),
        (flicr_config { strips: 65_537, ..good }, Status::Strips),
    ];
    for (config, status) in refused {
        expect(Memory::of(&good, flicr_coder::Rle).init(&config, flicr_coder::Rle).unwrap_err(), status);
    }
    let refused = [
        flicr_context { step_levels: 0, ..CONTEXT },
        flicr_context { step_levels: 65_536, ..CONTEXT },
        flicr_context { noise_levels: 256, ..CONTEXT },
        flicr_context { predictor: 2, ..CONTEXT },
    ];
    for (context, coder) in refused.iter().flat_map(|context| CODERS[5..].iter().map(move |&coder| (context, coder))) {
        let mut memory = Memory::of(&good, coder);
        expect(memory.init_with(&good, coder, context).unwrap_err(), Status::Context);
        let tall = flicr_config { rows: 129, columns: 1, ..good };
        expect(memory.init(&tall, coder).unwrap_err(), Status::Size);
        assert!(memory.0.iter().all(|&word| word == 0xA5A5_A5A5_A5A5_A5A5), "nothing is written before all is checked");
    }
}

fn refused_memory(expect: &mut impl FnMut(Status, Status)) {
    let config = fixed();
    let size = flicr_encoder_size(COLUMNS, ROWS, RLE);
    let mut memory = Memory::of(&config, flicr_coder::Rle);
    let memory_start = memory.start();
    let mut encoder = null_mut();
    let mut init = |start, len, config| {
        // SAFETY: the memory's own pointer and at most its length, or what is to be found.
        unsafe { flicr_encoder_init_rle(start, len, config, &raw mut encoder) }
    };
    expect(init(memory_start, size - 1, &raw const config), Status::StateTooSmall);
    expect(init(memory_start.wrapping_byte_add(4), size - 4, &raw const config), Status::Misaligned);
    expect(init(null_mut(), size, &raw const config), Status::NullPointer);
    expect(init(memory_start, size, null()), Status::NullPointer);
    let odd = (&raw const config).wrapping_byte_add(1);
    expect(init(memory_start, size, odd), Status::Misaligned);
    assert!(encoder.is_null());
    // SAFETY: null is to be found.
    expect(unsafe { flicr_encoder_init_rle(memory_start, size, &raw const config, null_mut()) }, Status::NullPointer);
    assert!(memory.0.iter().all(|&word| word == 0xA5A5_A5A5_A5A5_A5A5), "nothing is written before all is checked");

    let zeros = vec![0_u64; size.div_ceil(8)];
    expect(start(zeros.as_ptr().cast_mut().cast()), Status::NotInitialized);
    expect(start(memory_start.cast()), Status::NotInitialized);
    expect(start(memory_start.wrapping_byte_add(2).cast()), Status::Misaligned);
    expect(start(null_mut()), Status::NullPointer);
}

fn refused_calls(expect: &mut impl FnMut(Status, Status)) {
    let config = fixed();
    let mut memory = Memory::of(&config, flicr_coder::Rle);
    let encoder = memory.init(&config, flicr_coder::Rle).unwrap();
    let (points, mut out, mut encoded) = (points(), vec![0_u8; 20_000], UNTOUCHED);
    let (records, out_start) = (points.as_ptr().cast::<c_void>(), out.as_mut_ptr().cast::<c_void>());
    let mut call = |records, count, stride, out: *mut c_void, len| {
        // SAFETY: the slices' own pointers, or what is to be found before anything is read or written.
        unsafe { flicr_encode(encoder, records, count, stride, STAMP, out, len, &raw mut encoded) }
    };
    expect(call(null(), 1, 12, out_start, 20_000), Status::NullPointer);
    expect(call(records, 1, 12, null_mut(), 20_000), Status::NullPointer);
    expect(call(records, 1, 0, out_start, 20_000), Status::Stride);
    expect(call(records, 1, 11, out_start, 20_000), Status::Stride);
    expect(call(records, usize::MAX / 16 + 2, 16, out_start, 20_000), Status::TooManyPoints);
    expect(call(records, 2, usize::MAX, out_start, 20_000), Status::TooManyPoints);
    expect(call(records, usize::MAX, 12, out_start, 20_000), Status::TooManyPoints);
    expect(call(records, 1, 12, out_start, 75), Status::OutputTooSmall);
    expect(call(records, 1, 12, records.cast_mut(), 12), Status::Overlap);
    expect(call(out_start, 2, 19_988, out_start.wrapping_byte_add(19_999), 1), Status::Overlap);
    expect(call(encoder.cast(), 1, 12, out_start, 20_000), Status::Overlap);
    expect(call(records, 1, 12, encoder.cast::<c_void>().wrapping_byte_add(300), 12), Status::Overlap);
    assert_eq!(encoded, UNTOUCHED);
    // Where the result is to go counts among what must be apart.
    for within in [encoder.cast(), out_start, records.cast_mut()] {
        // SAFETY: this is to be found before anything is read or written.
        let status = unsafe { flicr_encode(encoder, records, 1, 12, STAMP, out_start, 20_000, within.cast()) };
        expect(status, Status::Overlap);
    }
    // SAFETY: null is to be found.
    expect(unsafe { flicr_encode(encoder, records, 1, 12, STAMP, out_start, 1, null_mut()) }, Status::NullPointer);
    expect(insert(encoder, &points), Status::NotStarted);
    expect(finish(encoder, &mut out).unwrap_err(), Status::NotStarted);
    assert_eq!(start(encoder), Status::Ok);
    // SAFETY: each is to be found before anything is read.
    unsafe {
        expect(flicr_insert(encoder, null(), 1, 12), Status::NullPointer);
        expect(flicr_insert(encoder, records, 1, 4), Status::Stride);
        expect(flicr_insert(encoder, encoder.cast(), 1, 12), Status::Overlap);
        expect(flicr_finish(encoder, encoder.cast(), 12, &raw mut encoded), Status::Overlap);
        expect(flicr_finish(encoder, null_mut(), 12, &raw mut encoded), Status::NullPointer);
    }
    let per_frame = flicr_config { max_range_m: 0.0, ..config };
    expect(start(memory.init(&per_frame, flicr_coder::Rle).unwrap()), Status::ScaleNeedsWholeScan);
}
