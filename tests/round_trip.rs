//! Promise: what goes in comes out, within the bound that the frame states, and every point is accounted for.
#![allow(missing_docs)]

mod common;

use flicr::{
    Coder, Collision, Config, Decoder, DeflateSmall, Encoded, Encoder, FrameEncoder, ImageViewMut, Level, Levels,
    Limits, OutOfView, Placement, Policy, Quantizer, Rle, Scale, Stamp, Store, StridedPoints, encode,
};
use proptest::prelude::*;

const ROWS: usize = 64;

fn encoded<L: Level, C: Coder<L>>(
    config: &Config,
    columns: usize,
    points: &[[f32; 3]],
    mut coder: C,
) -> (Encoded, Vec<u8>) {
    let mut levels = vec![L::NONE; ROWS * columns];
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let mut out = vec![0; flicr::frame::worst_case_len::<L, C>(ROWS * columns)];
    let encoded = encode(config, points, Stamp { sequence: 9, timestamp_ns: 77 }, image, &mut coder, &mut out).unwrap();
    out.truncate(encoded.len);
    (encoded, out)
}

fn norm([x, y, z]: [f32; 3]) -> f64 {
    let [x, y, z] = [x, y, z].map(f64::from);
    (x * x + y * y + z * z).sqrt()
}

/// Every return lies in the pixel of some decoded point whose range is within the stated bound.
fn check_bound<L: Level>(config: &Config, points: &[[f32; 3]], columns: usize) {
    let (encoded, bytes) = encoded::<L, _>(config, columns, points, Store::new());
    let mut decoder = Decoder::new(Limits::default());
    let frame = decoder.decode(&bytes).unwrap();
    assert_eq!(frame.header().returns, encoded.tally.returns());
    assert_eq!(frame.header().quantizer.range_bound_m(), encoded.range_bound_m);
    let decoded = frame.points();
    assert_eq!(decoded.len(), encoded.tally.kept() as usize);
    // One point a frame leaves no doubt which decoded point is its own.
    for &point in points.iter().step_by(97) {
        let (alone, bytes) = self::encoded::<L, _>(&fixed(config, 100.0), columns, &[point], Store::new());
        let decoded = decoder.decode(&bytes).unwrap().points();
        assert_eq!(decoded.len(), 1, "{point:?} {:?}", alone.tally);
        let off = (norm(decoded[0]) - norm(point)).abs();
        assert!(off <= f64::from(alone.range_bound_m) + 1e-5, "{point:?}: {off} > {}", alone.range_bound_m);
    }
}

fn fixed(config: &Config, max_range_m: f32) -> Config {
    Config { scale: Scale::Fixed { max_range_m }, ..*config }
}

#[test]
fn ranges_come_back_within_the_bound_at_every_depth() {
    let points = common::spiral(5_000);
    for level_bits in [6, 8] {
        check_bound::<u8>(&Config { level_bits, ..Config::UNIFORM }, &points, 2048);
        check_bound::<u8>(&Config { level_bits, ..Config::PAPER }, &points, 256);
    }
    for level_bits in [9, 11, 16] {
        check_bound::<u16>(&Config { level_bits, ..Config::UNIFORM }, &points, 2048);
        check_bound::<u16>(&Config { level_bits, ..Config::PAPER }, &points, 256);
    }
}

#[test]
fn centers_are_within_half_a_pixel_of_the_point() {
    let config = Config { level_bits: 16, ..Config::UNIFORM };
    let view = config.view;
    let (row_rad, column_rad) = ((view.top_rad - view.bottom_rad) / 64.0, view.span_rad / 4500.0);
    for point in common::spiral(2_000) {
        let (_, bytes) = encoded::<u16, _>(&fixed(&config, 100.0), 4500, &[point], Rle::new());
        let decoded = Decoder::default().decode(&bytes).unwrap().points()[0];
        let (azimuth, elevation) = (decoded[1].atan2(decoded[0]), (f64::from(decoded[2]) / norm(decoded)).asin());
        let off = (azimuth - point[1].atan2(point[0])).abs();
        assert!(off.min(core::f32::consts::TAU - off) <= column_rad * 0.51, "{point:?}");
        // The spiral reaches 0.003 degrees further down than the paper's rows do.
        let off = (elevation - (f64::from(point[2]) / norm(point)).asin()).abs();
        assert!(off <= f64::from(row_rad) * 0.52, "{point:?}");
    }
}

#[test]
fn corners_are_the_low_azimuth_and_high_elevation_of_the_pixel() {
    let at = |placement| {
        let config = Config { placement, level_bits: 16, ..fixed(&Config::UNIFORM, 80.0) };
        let (_, bytes) = encoded::<u16, _>(&config, 256, &[[10.0, 4.0, -1.0]], Store::new());
        Decoder::default().decode(&bytes).unwrap().points()[0]
    };
    let (center, corner) = (at(Placement::Center), at(Placement::Corner));
    assert!(corner[1].atan2(corner[0]) < center[1].atan2(center[0]));
    assert!(corner[2] > center[2]);
}

#[test]
fn every_coder_gives_the_same_image() {
    let points = common::spiral(20_000);
    let mut decoder = Decoder::default();
    let mut levels = |bytes: &[u8]| decoder.decode(bytes).unwrap().levels().clone();
    let config = Config::UNIFORM;
    let stored = levels(&encoded::<u8, _>(&config, 512, &points, Store::new()).1);
    assert!(matches!(&stored, Levels::U8(levels) if levels.iter().any(|&l| l != 0)));
    assert_eq!(levels(&encoded::<u8, _>(&config, 512, &points, Rle::new()).1), stored);
    assert_eq!(levels(&encoded::<u8, _>(&config, 512, &points, DeflateSmall::new()).1), stored);
    let config = Config { level_bits: 14, ..config };
    let stored = levels(&encoded::<u16, _>(&config, 512, &points, Store::new()).1);
    assert_eq!(levels(&encoded::<u16, _>(&config, 512, &points, Rle::new()).1), stored);
    assert_eq!(levels(&encoded::<u16, _>(&config, 512, &points, DeflateSmall::new()).1), stored);
}

#[test]
fn stamp_comes_back() {
    let (_, bytes) = encoded::<u8, _>(&Config::UNIFORM, 256, &[[1.0, 2.0, 0.0]], Rle::new());
    let header = flicr::frame::parse_header(&bytes).unwrap();
    assert_eq!((header.sequence, header.timestamp_ns), (9, 77));
}

#[test]
fn every_point_is_in_one_counter() {
    let far = 3e20;
    let points = [
        [10.0, 0.0, 0.0],
        [10.01, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [f32::NAN, 1.0, 1.0],
        [1.0, f32::INFINITY, 1.0],
        [1.0, 1.0, f32::NEG_INFINITY],
        [far, far, far],
        [90.0, 0.0, 0.0],
        [0.01, 0.0, 0.0],
        [0.0, 0.0, 5.0],
        [0.0, 0.0, -5.0],
    ];
    let config = fixed(&Config::UNIFORM, 80.0);
    let (drop, _) = encoded::<u8, _>(
        &Config { policy: Policy { out_of_view: OutOfView::Drop, ..config.policy }, ..config },
        256,
        &points,
        Rle::new(),
    );
    let tally = drop.tally;
    assert_eq!((tally.points, tally.no_return, tally.not_finite), (11, 1, 3));
    assert_eq!((tally.beyond_range, tally.too_near, tally.out_of_view), (2, 1, 2));
    assert_eq!((tally.collided, tally.clamped, tally.kept(), tally.lost()), (1, 0, 1, 6));
    let (clamp, _) = encoded::<u8, _>(&config, 256, &points, Rle::new());
    assert_eq!((clamp.tally.out_of_view, clamp.tally.clamped, clamp.tally.kept()), (0, 2, 3));
}

#[test]
fn an_empty_cloud_is_an_empty_frame() {
    for config in [Config::UNIFORM, Config::PAPER, fixed(&Config::PAPER, 50.0)] {
        for points in [vec![], vec![[0.0; 3]], vec![[f32::NAN; 3]; 3]] {
            let (encoded, bytes) = encoded::<u8, _>(&config, 256, &points, Rle::new());
            assert_eq!(encoded.tally.kept(), 0);
            assert_eq!(Decoder::default().decode(&bytes).unwrap().points(), Vec::<[f32; 3]>::new());
        }
    }
}

#[test]
fn collisions_go_by_the_policy() {
    let ranges = [30.0, 10.0, 40.0, 20.0];
    let kept = |collision| {
        let policy = Policy { collision, ..Policy::default() };
        let points = ranges.map(|range| [range, 0.0, 0.0]);
        let config = Config { policy, level_bits: 16, ..fixed(&Config::UNIFORM, 80.0) };
        let (encoded, bytes) = encoded::<u16, _>(&config, 256, &points, Rle::new());
        assert_eq!((encoded.tally.collided, encoded.tally.kept()), (3, 1));
        norm(Decoder::default().decode(&bytes).unwrap().points()[0]).round()
    };
    let all = [Collision::Nearest, Collision::Farthest, Collision::First, Collision::Last].map(kept);
    assert_eq!(all, [10.0, 40.0, 30.0, 20.0]);
}

#[test]
fn pieces_make_the_same_bytes_as_the_whole() {
    let points = common::spiral(3_001);
    let config = fixed(&Config::UNIFORM, 80.0);
    let (_, whole) = encoded::<u8, _>(&config, 256, &points, Rle::new());
    let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
    let mut frame = encoder.start(&config, Stamp { sequence: 9, timestamp_ns: 77 }).unwrap();
    for piece in points.chunks(37) {
        frame.insert(piece);
    }
    let mut out = vec![0; Encoder::<64, 256, u8, Rle>::WORST_CASE_LEN];
    let len = frame.finish(&mut out).unwrap().len;
    assert_eq!(out[..len], whole);
    // An encoder starts every frame afresh.
    let again = encoder.encode(&config, points.as_slice(), Stamp { sequence: 9, timestamp_ns: 77 }, &mut out).unwrap();
    assert_eq!(out[..again.len], whole);
}

#[test]
fn records_of_any_layout_make_the_same_bytes() {
    let points = common::spiral(500);
    let (_, whole) = encoded::<u8, _>(&Config::UNIFORM, 256, &points, Rle::new());
    for stride in [12, 13, 16, 22, 48] {
        let mut bytes = vec![0xaa; points.len() * stride];
        for (record, point) in bytes.chunks_exact_mut(stride).zip(&points) {
            record[..12].copy_from_slice(bytemuck::cast_slice(point));
        }
        let records = StridedPoints::new(&bytes, stride).unwrap();
        let mut levels = vec![0_u8; ROWS * 256];
        let image = ImageViewMut::new(&mut levels, 256).unwrap();
        let mut out = vec![0; 40_000];
        let stamp = Stamp { sequence: 9, timestamp_ns: 77 };
        let encoded = encode(&Config::UNIFORM, &records, stamp, image, &mut Rle::new(), &mut out).unwrap();
        assert_eq!(out[..encoded.len], whole);
    }
}

#[test]
fn configurations_that_cannot_be_are_refused() {
    use flicr::{ConfigError, EncodeError};
    let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
    let mut start = |config| encoder.start(&config, Stamp::default()).map(|_| ()).unwrap_err();
    assert_eq!(start(Config::UNIFORM), EncodeError::ScaleNeedsWholeScan);
    let with_bits = |level_bits| Config { level_bits, ..fixed(&Config::UNIFORM, 80.0) };
    let refused = |found| EncodeError::Config(ConfigError::LevelBits { found, min: 1, max: 8 });
    assert_eq!(start(with_bits(9)), refused(9));
    assert_eq!(start(with_bits(0)), refused(0));
    let mut wide: Encoder<8, 8, u16, Rle> = Encoder::new(Rle::new());
    let error = wide.start(&with_bits(8), Stamp::default()).map(|_| ()).unwrap_err();
    assert_eq!(error, EncodeError::Config(ConfigError::LevelBits { found: 8, min: 9, max: 16 }));
    for found_m in [0.0, -1.0, f32::INFINITY, 1e-44] {
        let error = start(fixed(&Config::UNIFORM, found_m));
        assert_eq!(error, EncodeError::Config(ConfigError::MaxRange { found_m }));
    }
    assert!(start(fixed(&Config::UNIFORM, f32::NAN)).to_string().contains("NaN"));
}

#[test]
fn one_byte_short_is_an_error_and_the_worst_case_is_enough() {
    let points = common::spiral(9_000);
    let (_, bytes) = encoded::<u8, _>(&Config::UNIFORM, 256, &points, Rle::new());
    let mut levels = vec![0_u8; ROWS * 256];
    for have in [0, 1, 63, 64, 71, 72, 75, 76, bytes.len() - 5, bytes.len() - 1] {
        let image = ImageViewMut::new(&mut levels, 256).unwrap();
        let mut out = vec![0; have];
        let stamp = Stamp { sequence: 9, timestamp_ns: 77 };
        let error = encode(&Config::UNIFORM, points.as_slice(), stamp, image, &mut Rle::new(), &mut out).unwrap_err();
        let worst_case = Encoder::<64, 256, u8, Rle>::WORST_CASE_LEN;
        assert_eq!(error, flicr::EncodeError::OutputTooSmall { have, worst_case });
    }
}

/// A frame of a named type comes back at its size and in no more than its worst case.
fn check_named<const COLS: usize>(mut encoder: Encoder<64, COLS, u8, Rle>) {
    let mut out = vec![0; Encoder::<64, COLS, u8, Rle>::WORST_CASE_LEN];
    let points = common::spiral(5_000);
    let len = encoder.encode(&Config::PAPER, points.as_slice(), Stamp::default(), &mut out).unwrap().len;
    let header = flicr::frame::parse_header(&out[..len]).unwrap();
    assert_eq!((header.rows, usize::from(header.columns)), (64, COLS));
}

#[test]
fn the_papers_six_frames_have_names() {
    check_named::<4500>(flicr::Encoder4500x64::new(Rle::new()));
    check_named::<4096>(flicr::Encoder4096x64::new(Rle::new()));
    check_named::<2048>(flicr::Encoder2048x64::new(Rle::new()));
    check_named::<1024>(flicr::Encoder1024x64::new(Rle::new()));
    check_named::<512>(flicr::Encoder512x64::new(Rle::new()));
    check_named::<256>(flicr::Encoder256x64::new(Rle::new()));
}

/// The plain decoder that `docs/FORMAT.md` describes, to check ours against.
fn rle_by_the_book(mut payload: &[u8]) -> Vec<u8> {
    let mut levels = Vec::new();
    while let [control, rest @ ..] = payload {
        let n = usize::from(control & 0x3f);
        payload = match control >> 6 {
            0b11 => {
                levels.extend(vec![0; n + 1]);
                rest
            }
            0b10 => {
                levels.extend(vec![rest[0]; n + 2]);
                &rest[1..]
            }
            _ => {
                let n = usize::from(*control) + 1;
                levels.extend_from_slice(&rest[..n]);
                &rest[n..]
            }
        };
    }
    levels
}

/// Runs and literals of all lengths around the limits of the code.
fn runs() -> impl Strategy<Value = Vec<u8>> {
    let run = (prop_oneof![Just(0_u8), 0_u8..4, any::<u8>()], prop_oneof![1_usize..4, 60_usize..70, 125_usize..132]);
    prop::collection::vec(run, 0..40).prop_map(|runs| runs.iter().flat_map(|&(level, n)| vec![level; n]).collect())
}

proptest! {
    #[test]
    fn run_lengths_of_all_kinds_come_back(mut levels in runs()) {
        levels.resize(levels.len().next_multiple_of(7).max(7), 0);
        let image = flicr::ImageView::new(&levels, 7).unwrap();
        let mut out = vec![0; <Rle as Coder<u8>>::WORST_CASE.len(levels.len())];
        let len = Rle::new().encode(image, &mut out).unwrap();
        prop_assert_eq!(rle_by_the_book(&out[..len]), levels);
    }

    #[test]
    fn quantized_ranges_are_within_the_bound(bits in 1_u32..=16, max in 0.5_f32..500.0, at in 0.0_f32..1.0) {
        let quantizer = Quantizer::new(bits, max).unwrap();
        let range_m = at * max;
        match quantizer.level(range_m) {
            Ok(level) => {
                let off = (f64::from(quantizer.range_m(level)) - f64::from(range_m)).abs();
                prop_assert!(off <= f64::from(quantizer.range_bound_m()));
                prop_assert!(level >= 1 && level <= quantizer.max_level());
            }
            Err(_) => prop_assert!(range_m <= 0.5001 * quantizer.step_m()),
        }
    }

    #[test]
    fn no_cloud_is_too_strange(
        points in prop::collection::vec(prop::array::uniform3(any::<f32>()), 0..200),
        paper in any::<bool>(),
    ) {
        let config = if paper { Config::PAPER } else { Config::UNIFORM };
        let (encoded, bytes) = encoded::<u8, _>(&config, 64, &points, Rle::new());
        prop_assert_eq!(encoded.tally.points as usize, points.len());
        let decoded = Decoder::default().decode(&bytes).unwrap().points();
        prop_assert_eq!(decoded.len(), encoded.tally.kept() as usize);
        prop_assert!(decoded.iter().flatten().all(|v| v.is_finite()));
    }
}

#[test]
fn the_builder_takes_any_borrowed_image() {
    let mut levels = [0_u8; 16 * 360];
    let image = ImageViewMut::new(&mut levels, 360).unwrap();
    let config = Config { view: flicr::UniformView::VLP16, ..fixed(&Config::UNIFORM, 100.0) };
    let mut coder = Rle::new();
    let mut frame = FrameEncoder::start(&config, Stamp::default(), image, &mut coder).unwrap();
    frame.insert([[5.0_f32, 0.0, 0.0]].as_slice());
    assert_eq!(frame.tally().kept(), 1);
    let mut out = [0; 200];
    let len = frame.finish(&mut out).unwrap().len;
    let header = flicr::frame::parse_header(&out[..len]).unwrap();
    assert_eq!((header.rows, header.columns), (16, 360));
}

#[test]
fn the_expected_psnr_is_within_a_hundredth_of_the_exact_one() {
    for bits in 3..=16 {
        for max_range_m in [0.5, 20.0, 80.0, 120.0, 300.0] {
            let quantizer = Quantizer::new(bits, max_range_m).unwrap();
            let step = f64::from(quantizer.step_m());
            let exact = 10.0 * (80.0_f64 * 80.0 / (step * step / 12.0)).log10();
            let off = (f64::from(quantizer.expected_psnr_db(80.0)) - exact).abs();
            assert!(off < 0.01, "{bits} bits over {max_range_m} m: {off} dB off");
        }
    }
}
