//! Promise: levels by the square root come back within the bound of their own range, never more than the frame's.
#![allow(missing_docs)]

use flicr::coder::{Coder, ContextSettings, Step};
use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::simulate::Simulator;
use flicr::{
    Companding, Config, ConfigError, DecodeError, Decoder, Dense, Encoder, FrameEncoder, Geometry, GridReturn,
    HeaderField, ImageViewMut, LatticeConfig, Levels, OutOfScale, Quantizer, Rle, Scale, Small, Stamp, encode,
};
use proptest::prelude::*;

proptest! {
    #[test]
    fn a_range_is_within_its_levels_bound(bits in 1_u32..=8, max_m in 0.001_f32..1e6, share in 0.0_f32..1.001) {
        let quantizer = Quantizer::square_root(bits, max_m).unwrap();
        let range_m = max_m * share;
        match quantizer.level(range_m) {
            Ok(level) => {
                prop_assert!((1..=quantizer.max_level()).contains(&level));
                let off_m = (f64::from(quantizer.range_m(level)) - f64::from(range_m)).abs();
                prop_assert!(off_m <= f64::from(quantizer.range_bound_at_m(level, 0)), "{off_m}");
                prop_assert!(quantizer.range_bound_at_m(level, 0) <= quantizer.range_bound_m());
            }
            Err(OutOfScale::TooNear) => prop_assert!(range_m <= 0.501 * quantizer.step_m()),
            Err(OutOfScale::Beyond) => prop_assert!(range_m > max_m),
        }
    }
}

/// Of two levels that a coder made of one another, the bound knows too.
#[test]
fn the_bound_holds_for_changed_levels() {
    let quantizer = Quantizer::square_root(8, 80.0).unwrap();
    for error_max in [0_u16, 1, 2, 7, 100] {
        for level in 1..=255_u16 {
            let [nearest, farthest] = [f64::from(level), f64::from(level)].map(|l| (l * l - l + 0.5, l * l + l + 0.5));
            for decoded in level.saturating_sub(error_max).max(1)..=(level + error_max).min(255) {
                let steps = f64::from(decoded) * f64::from(decoded);
                let off = (steps - nearest.0).abs().max((steps - farthest.1).abs()) * f64::from(quantizer.step_m());
                let bound_m = quantizer.range_bound_at_m(decoded, error_max);
                assert!(off <= f64::from(bound_m), "{level} as {decoded}: {off} > {bound_m}");
                assert!(off <= f64::from(quantizer.range_bound_with_m(error_max)), "{level} as {decoded}: {off}");
            }
        }
    }
}

#[test]
fn every_level_is_its_own() {
    for bits in 1..=8 {
        let quantizer = Quantizer::square_root(bits, 120.0).unwrap();
        for level in 1..=quantizer.max_level() {
            assert_eq!(quantizer.level(quantizer.range_m(level)), Ok(level));
        }
        assert!((quantizer.range_m(quantizer.max_level()) - 120.0).abs() < 1e-4);
    }
    for bits in [0, 9, 16] {
        let refused = ConfigError::LevelBits { found: bits, min: 1, max: 8 };
        assert_eq!(Quantizer::square_root(bits, 120.0), Err(refused));
        assert_eq!(Quantizer::square_root_with_step(bits, 0.001), Err(refused));
    }
    assert!(Quantizer::square_root(8, f32::INFINITY).is_err());
}

fn street() -> Vec<[f32; 3]> {
    let turn = Simulator::hdl64e(1).next().unwrap();
    let record = |bytes: &[u8; 16]| [0, 4, 8].map(|at| f32::from_le_bytes([0, 1, 2, 3].map(|byte| bytes[at + byte])));
    turn.kitti_bytes().as_chunks::<16>().0.iter().map(record).filter(|point| *point != [0.0; 3]).collect()
}

fn range_m([x, y, z]: [f32; 3]) -> f32 {
    (x * x + y * y + z * z).sqrt()
}

/// Each point's own pixel is known: one point a frame of its own, so that nothing collides.
#[test]
fn every_point_of_a_scan_is_within_its_own_bound() {
    let config =
        Config { scale: Scale::Fixed { max_range_m: 80.0 }, companding: Companding::SquareRoot, ..Config::UNIFORM };
    let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
    let (mut out, mut decoder) = (vec![0; Encoder::<64, 256, u8, Rle>::WORST_CASE_LEN], Decoder::default());
    for point in street().into_iter().step_by(61).filter(|&point| range_m(point) <= 80.0) {
        let encoded = encoder.encode(&config, [point].as_slice(), Stamp::default(), &mut out).unwrap();
        let frame = decoder.decode(&out[..encoded.len]).unwrap();
        let quantizer = frame.header().quantizer;
        assert_eq!(
            (quantizer.companding(), encoded.range_bound_m),
            (Companding::SquareRoot, frame.header().range_bound_m())
        );
        let Levels::U8(levels) = frame.levels() else { panic!("8 bits") };
        let level = levels.iter().copied().max().unwrap().into();
        for decoded in [frame.points()[0], frame.smooth_points()[0]] {
            let off_m = (range_m(decoded) - range_m(point)).abs();
            assert!(off_m <= quantizer.range_bound_at_m(level, 0) + 1e-5, "{point:?}: {off_m}");
        }
    }
}

/// On the sensor's own grid a frame says how far any point is off, and none is farther.
#[test]
fn a_grids_frame_is_better_than_even_levels_and_within_its_bound() {
    let points: Vec<_> = street().into_iter().filter(|&point| range_m(point) < 79.0).collect();
    let lattice = Lattice::<66>::new(hdl64e::GRID, 4000).unwrap();
    let scale = Scale::Fixed { max_range_m: 80.0 };
    let even = LatticeConfig { scale, level_bits: 8, measure: true, ..LatticeConfig::new(&lattice) };
    let settings = ContextSettings::COARSE;
    let [even_db, ..] = quality(&even, &points, &mut Dense::<8>::new(settings));
    let squares = LatticeConfig { companding: Companding::SquareRoot, ..even };
    let [square_db, ..] = quality(&squares, &points, &mut Dense::<8>::new(settings));
    // The made-up street is mostly near; tests/real/companding.rs has real ones.
    assert!(square_db > even_db + 0.5, "{square_db} dB, {even_db} evenly");
    let lossy = settings.with_step(Step::new(3).unwrap());
    let [_, max_error_m, bound_m] = quality(&squares, &points, &mut Small::<8>::new(lossy));
    assert!(max_error_m <= bound_m);
}

fn quality<C: Coder<u8>>(config: &LatticeConfig<'_, 66>, points: &[[f32; 3]], coder: &mut C) -> [f64; 3] {
    let mut levels = vec![0_u8; 64 * 4000];
    let mut out = vec![0; config.worst_case_len::<u8, C>()];
    let image = ImageViewMut::new(&mut levels, 4000).unwrap();
    let encoded = encode(config, points, Stamp::default(), image, coder, &mut out).unwrap();
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&out[..encoded.len]).unwrap();
    let Geometry::Beams(beams) = frame.header().geometry else { panic!("beams") };
    let quality = flicr::metrics::compare(points, &frame.points(), 80.0).unwrap();
    assert!(quality.max_error_m <= f64::from(beams.point_bound_m), "{} m", quality.max_error_m);
    [quality.psnr_db, quality.max_error_m, beams.point_bound_m.into()]
}

/// Returns get the levels of the points that they are.
#[test]
fn returns_are_companded_too() {
    let lattice = Lattice::<66>::new(hdl64e::GRID, 4000).unwrap();
    let config = LatticeConfig {
        scale: Scale::Fixed { max_range_m: 120.0 },
        companding: Companding::SquareRoot,
        level_bits: 8,
        ..LatticeConfig::new(&lattice)
    };
    let quantizer = Quantizer::square_root(8, 120.0).unwrap();
    let mut levels = vec![0_u8; 64 * 4000];
    let mut coder = Rle::new();
    let image = ImageViewMut::new(&mut levels, 4000).unwrap();
    let mut frame = FrameEncoder::start(&config, Stamp::default(), image, &mut coder).unwrap();
    let returns = (0..4000_u32).map(|tick| GridReturn { row: (tick % 64) as u16, tick, count: 1 + tick * 15 });
    frame.insert_returns(returns.clone());
    let mut out = vec![0; config.worst_case_len::<u8, Rle>()];
    let encoded = frame.finish(&mut out).unwrap();
    assert_eq!(encoded.tally.lost(), u32::from(quantizer.level(0.002).is_err()));
    for found in returns {
        let range_m = found.count as f32 * 0.002;
        let level = levels[usize::from(found.row) * 4000 + found.tick as usize];
        let expected = quantizer.level(range_m).unwrap_or(0);
        // A count midway between two levels gets either.
        let off_m = (quantizer.range_m(level.into()) - range_m).abs();
        assert!(u16::from(level) == expected || off_m <= quantizer.range_bound_at_m(level.into(), 0), "{found:?}");
    }
}

#[test]
fn a_frame_of_more_bits_is_refused() {
    let config =
        Config { scale: Scale::Fixed { max_range_m: 80.0 }, companding: Companding::SquareRoot, ..Config::UNIFORM };
    let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
    let mut out = vec![0; Encoder::<64, 256, u8, Rle>::WORST_CASE_LEN];
    encoder.encode(&config, [[9.0_f32, 0.0, -1.0]].as_slice(), Stamp::default(), &mut out).unwrap();
    assert_eq!(out[5] & 4, 4);
    out[28] = 9;
    let refused = DecodeError::Header { field: HeaderField::LevelBits, found: 9 };
    assert_eq!(flicr::frame::parse_header(&out).map(|_| ()), Err(refused));
    let config = Config { level_bits: 12, ..config };
    let mut encoder: Encoder<64, 256, u16, Rle> = Encoder::new(Rle::new());
    let refused = encoder.encode(&config, [[9.0_f32, 0.0, -1.0]].as_slice(), Stamp::default(), &mut out);
    assert_eq!(refused, Err(ConfigError::LevelBits { found: 12, min: 1, max: 8 }.into()));
}
