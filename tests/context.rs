//! Promises of the context coders: returns come back where they were, none further off than the frame says, in no more
//! bytes than the worst case; whatever else is in a payload gives an error or an image.
#![allow(missing_docs)]

use std::fmt::Write;

use flicr::coder::{Coder, ContextSettings, Predictor, Step};
use flicr::frame::{self, UniformHeader};
use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::simulate::Simulator;
use flicr::{
    CoderId, ConfigError, DecodeError, Decoder, Dense, EncodeError, Encoder, Header, ImageView, ImageViewMut,
    LatticeConfig, Level, Levels, PayloadFault, Placement, Quantizer, Small, Stamp, UniformView, encode,
};
use proptest::prelude::*;

/// Room for 112 rows.
const GROUPS: usize = 14;

fn header<L: Level>(image: ImageView<'_, L>) -> Header<UniformHeader> {
    Header {
        sequence: 0,
        timestamp_ns: 0,
        rows: image.rows() as u16,
        columns: image.columns() as u16,
        quantizer: Quantizer::with_step(L::BITS, 0.002).unwrap(),
        coder: CoderId::Context,
        error_max: 0,
        returns: 0,
        geometry: UniformHeader { view: UniformView::all_around(0.1, -0.4), placement: Placement::Center },
    }
}

/// The frame of an image, in a buffer of the worst case's length.
fn framed<L: Level, C: Coder<L>>(image: ImageView<'_, L>, strips: u16, coder: &mut C) -> Vec<u8> {
    let mut out = vec![0; frame::worst_case_len_in_strips::<L, C>(image.rows(), image.columns(), strips)];
    let len = frame::write(header(image), image, strips, coder, &mut out).expect("the worst case is enough");
    out.truncate(len);
    out
}

fn tiers<L: Level>(image: ImageView<'_, L>, settings: ContextSettings) -> [Vec<u8>; 2] {
    tiers_in_strips(image, 1, settings)
}

fn tiers_in_strips<L: Level>(image: ImageView<'_, L>, strips: u16, settings: ContextSettings) -> [Vec<u8>; 2] {
    let small = framed(image, strips, &mut Small::<GROUPS>::new(settings));
    [small, framed(image, strips, &mut Dense::<GROUPS>::new(settings))]
}

fn levels(levels: &Levels) -> Vec<u16> {
    match levels {
        Levels::U8(levels) => levels.iter().map(|&level| level.into()).collect(),
        Levels::U16(levels) => levels.clone(),
    }
}

fn check<L: Level>(image: ImageView<'_, L>, settings: ContextSettings) {
    let error_max = settings.step.error_max();
    for frame in tiers(image, settings) {
        let mut decoder = Decoder::default();
        let decoded = decoder.decode(&frame).unwrap();
        assert_eq!(decoded.header().error_max, error_max);
        let bound = decoded.header().range_bound_m() / decoded.header().quantizer.step_m();
        assert!((bound - f32::from(error_max) - 0.5).abs() < 0.05, "{bound}");
        for (from, to) in image.levels().unwrap().iter().zip(levels(decoded.levels())) {
            assert_eq!(*from == L::NONE, to == 0);
            assert!(from.get().abs_diff(to) <= error_max, "{} became {to}", from.get());
        }
    }
}

/// Surfaces with noise, edges and gaps.
fn scenery(rows: usize, columns: usize, noise: u16, seed: u64) -> Vec<u16> {
    let mut state = seed | 1;
    let mut random = move |below: u16| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (((state >> 40) * u64::from(below)) >> 24) as u16
    };
    let mut range = 5000_u16;
    let mut pixels = vec![0; rows * columns];
    for column in 0..columns {
        for row in 0..rows {
            if random(40) == 0 {
                range = 1 + random(65_000);
            }
            let level = range.saturating_add(random(noise + 1)).max(1);
            pixels[row * columns + column] = if random(9) == 0 { 0 } else { level };
        }
    }
    pixels
}

fn settings() -> impl Strategy<Value = ContextSettings> {
    let step = (prop_oneof![Just(1_u16), 2_u16..300, any::<u16>()], any::<bool>())
        .prop_filter_map("no step", |(n, e)| if e { Step::exact(n) } else { Step::new(n) });
    (step, any::<u8>(), any::<bool>()).prop_map(|(step, noise, west)| ContextSettings {
        step,
        noise,
        predictor: if west { Predictor::West } else { Predictor::MedianEdge },
    })
}

proptest! {
    #[test]
    fn any_image_comes_back_within_the_bound(
        rows in 1_usize..=8 * GROUPS,
        columns in 1_usize..40,
        noise in 0_u16..3000,
        seed in any::<u64>(),
        settings in settings(),
    ) {
        let pixels = scenery(rows, columns, noise, seed);
        check(ImageView::new(&pixels, columns).unwrap(), settings);
        let bytes: Vec<u8> = pixels.iter().map(|&level| (level >> 8) as u8).collect();
        check(ImageView::new(&bytes, columns).unwrap(), settings);
    }

    #[test]
    fn random_levels_come_back_in_the_worst_case(
        pixels in proptest::collection::vec(any::<u16>(), 1..400),
        settings in settings(),
    ) {
        check(ImageView::new(&pixels, 1).filter(|image| image.rows() <= 8 * GROUPS).unwrap_or(ImageView::new(&pixels, pixels.len()).unwrap()), settings);
    }

    #[test]
    fn any_payload_gives_an_error_or_an_image(
        tier in 0_u8..4,
        noise in any::<u8>(),
        step in 1_u16..300,
        code in proptest::collection::vec(any::<u8>(), 0..600),
    ) {
        let pixels = scenery(64, 20, 50, 7);
        let settings = ContextSettings { noise, ..ContextSettings::FINE.with_step(Step::new(step).unwrap()) };
        let [frame, _] = tiers(ImageView::new(&pixels, 20).unwrap(), settings);
        let prefix = [frame[72] & !3 | tier, noise, frame[74], frame[75], frame[76], frame[77]];
        let _ = Decoder::default().decode(&with_payload(&frame, &[&prefix, code.as_slice()].concat()));
    }
}

/// The frame with another payload, sealed.
fn with_payload(frame: &[u8], payload: &[u8]) -> Vec<u8> {
    let mut frame = [&frame[..68], &(payload.len() as u32).to_le_bytes(), payload].concat();
    let frame_len = frame.len() as u32 + 4;
    frame[8..12].copy_from_slice(&frame_len.to_le_bytes());
    let checksum = crc32(&frame);
    frame.extend(checksum.to_le_bytes());
    frame
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    })
}

fn fault(frame: &[u8]) -> PayloadFault {
    match Decoder::default().decode(frame) {
        Err(DecodeError::Payload { strip: 0, fault }) => fault,
        other => panic!("{other:?}"),
    }
}

#[test]
fn payloads_that_no_encoder_makes() {
    let pixels = scenery(64, 50, 50, 3);
    let settings = ContextSettings::FINE.with_step(Step::new(10).unwrap());
    for frame in tiers(ImageView::new(&pixels, 50).unwrap(), settings) {
        let payload = &frame[72..frame.len() - 4];
        let with = |at: usize, bytes: &[u8]| {
            let mut payload = payload.to_vec();
            payload[at..at + bytes.len()].copy_from_slice(bytes);
            with_payload(&frame, &payload)
        };
        assert!(Decoder::default().decode(&with(0, &[])).is_ok());
        for len in 0..payload.len() {
            assert_eq!(fault(&with_payload(&frame, &payload[..len])), PayloadFault::TooShort, "{len}");
        }
        assert_eq!(fault(&with_payload(&frame, &[payload, &[0]].concat())), PayloadFault::TooLong);
        assert_eq!(fault(&with(0, &[payload[0] | 0x10])), PayloadFault::Malformed);
        assert_eq!(fault(&with(2, &[0, 0])), PayloadFault::Malformed);
        // A dead zone that is none, for a step of one level.
        assert_eq!(fault(&with(2, &[1, 0])), PayloadFault::Malformed);
        assert_eq!(fault(&with(4, &[0, 0])), PayloadFault::Malformed);
        assert_eq!(fault(&with(2, &[20, 0])), PayloadFault::Bound { found: 12, max: 6 });
    }
    let [frame, _] = tiers(ImageView::new(&[1_u8; 64], 8).unwrap(), ContextSettings::COARSE);
    let mut narrow = frame[..frame.len() - 4].to_vec();
    narrow[28] = 4;
    let quantizer = Quantizer::with_step(4, 0.002).unwrap();
    narrow[36..40].copy_from_slice(&quantizer.range_bound_m().to_le_bytes());
    let mut payload = frame[72..frame.len() - 4].to_vec();
    payload[4] = 16;
    assert_eq!(fault(&with_payload(&narrow, &payload)), PayloadFault::LevelRange { found: 16, max: 15 });
}

#[test]
fn noise_is_stored() {
    // Two rounds of multiply and shift: one leaves steps that are all alike.
    let mixed = |i: u32| (i ^ i >> 15).wrapping_mul(0x2c1b_3c6d);
    let noise = |i: u32| (mixed(mixed(i.wrapping_mul(2_654_435_761))) >> 16) as u16;
    let pixels: Vec<u16> = (0..1000).map(|i| noise(i).max(1)).collect();
    let image = ImageView::new(&pixels, 50).unwrap();
    for frame in tiers(image, ContextSettings::FINE) {
        assert_eq!(frame.len(), frame::OVERHEAD_LEN + 1 + 2000);
        assert_eq!(frame[72], 3);
    }
    check(image, ContextSettings::FINE);
}

#[test]
fn more_rows_than_there_is_room_for() {
    let config = flicr::Config { level_bits: 16, ..flicr::Config::UNIFORM };
    let mut encoder: Encoder<65, 4, u16, Small> = Encoder::new(Small::new(ContextSettings::FINE));
    let found = encoder.encode(&config, [[1.0_f32; 3]].as_slice(), Stamp::default(), &mut [0; 4000]);
    assert_eq!(found.unwrap_err(), EncodeError::Config(ConfigError::CoderRows { found: 65, max: 64 }));
    let mut out = [0; 4000];
    assert!(Small::<8>::new(ContextSettings::FINE).encode(ImageView::new(&[1_u8; 65], 1).unwrap(), &mut out).is_err());
}

#[test]
fn states_are_as_small_as_documented() {
    assert!(size_of::<Small>() <= 1840, "{}", size_of::<Small>());
    assert!(size_of::<Dense>() <= 4300, "{}", size_of::<Dense>());
}

/// Length and checksum of the simulated scan's frames are those of `tests/context.out`, the same on every machine; `make
/// bless` renews it.
#[test]
fn simulated_scan_gives_the_same_bytes_as_ever() {
    let points = simulated();
    let lattice = Lattice::<66>::new(hdl64e::GRID, 4000).unwrap();
    let config = LatticeConfig { measure: true, ..LatticeConfig::new(&lattice) };
    let mut pixels = vec![0_u16; 64 * 4000];
    let mut found = String::new();
    for step in [1, 10, 51, 157] {
        let settings = ContextSettings::FINE.with_step(Step::new(step).unwrap());
        let mut frames = [vec![], vec![]];
        let [small, dense] = &mut frames;
        encode_scan(&config, &points, &mut pixels, &mut Small::<8>::new(settings), small);
        encode_scan(&config, &points, &mut pixels, &mut Dense::<8>::new(settings), dense);
        for (coder, frame) in ["small", "dense"].iter().zip(frames) {
            let crc = crc32(&frame[..frame.len() - 4]);
            writeln!(found, "step={step} coder={coder} bytes={} crc={crc:08x}", frame.len()).unwrap();
        }
    }
    if std::env::var_os("FLICR_BLESS").is_some() {
        std::fs::write("tests/context.out", &found).unwrap();
    }
    assert_eq!(found, std::fs::read_to_string("tests/context.out").unwrap());
}

fn simulated() -> Vec<[f32; 4]> {
    let turn = Simulator::hdl64e(1).next().unwrap();
    turn.kitti_bytes().as_chunks::<16>().0.iter().map(point_of).collect()
}

fn point_of(bytes: &[u8; 16]) -> [f32; 4] {
    [0, 4, 8, 12].map(|at| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
}

/// Encodes a scan, and checks that each point is where the frame says.
fn encode_scan<C: Coder<u16>>(
    config: &LatticeConfig<'_, 66>,
    points: &[[f32; 4]],
    pixels: &mut [u16],
    coder: &mut C,
    out: &mut Vec<u8>,
) {
    out.resize(config.worst_case_len::<u16, C>(), 0);
    let image = ImageViewMut::new(pixels, 4000).unwrap();
    let encoded = encode(config, points, Stamp::default(), image, coder, out).unwrap();
    out.truncate(encoded.len);
    let mut decoder = Decoder::default();
    let frame = decoder.decode(out).unwrap();
    let header = frame.header();
    assert_eq!(encoded.range_bound_m, header.range_bound_m());
    let flicr::Geometry::Beams(beams) = header.geometry else { panic!("another geometry") };
    // Every point's own pixel is among those decoded, so that none is farther from the nearest than the bound.
    let returns: Vec<[f32; 3]> = points.iter().map(|&[x, y, z, _]| [x, y, z]).filter(|p| *p != [0.0; 3]).collect();
    let quality = flicr::metrics::compare(&returns, &frame.points(), 80.0).unwrap();
    assert!(quality.max_error_m <= f64::from(beams.point_bound_m), "{} > {}", quality.max_error_m, beams.point_bound_m);
    assert!(beams.point_bound_m < header.range_bound_m() + 0.002);
}

/// What the decoder written from FORMAT.md alone makes of a frame; `None` where there is no Python.
fn decoded_by_python(name: &str, frame: &[u8]) -> Vec<u16> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, frame).unwrap();
    let mut python = std::process::Command::new("python3");
    let python = python.arg(root.join("tests/reference/context_decoder.py")).arg(&path);
    let output = python.arg(root.join("src/coder/context/priors.rs")).output();
    let output = output.expect("python3, which tools/setup.sh installs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout.as_chunks::<2>().0.iter().map(|bytes| u16::from_le_bytes(*bytes)).collect()
}

fn check_with_python(name: &str, frame: &[u8]) {
    let found = decoded_by_python(name, frame);
    let mut decoder = Decoder::default();
    assert!(found == levels(decoder.decode(frame).unwrap().levels()), "{name} differs");
}

#[test]
fn the_format_is_described_completely() {
    let step = |levels| Step::new(levels).unwrap();
    let coarse = ContextSettings { predictor: Predictor::MedianEdge, ..ContextSettings::COARSE.with_step(step(30)) };
    let cases = [ContextSettings::FINE, ContextSettings::FINE.with_step(step(7)), coarse];
    for (number, settings) in cases.into_iter().enumerate() {
        let pixels = scenery(69, 60, 40, 11);
        let strips = [1, 7, 16][number];
        let frames = tiers_in_strips(ImageView::new(&pixels, 60).unwrap(), strips, settings);
        frames.iter().zip(["small", "dense"]).for_each(|(frame, tier)| {
            check_with_python(&format!("context-{tier}-{number}.flicr"), frame);
        });
    }
    let lattice = Lattice::<66>::new(hdl64e::GRID, 4000).unwrap();
    let (config, mut pixels) = (LatticeConfig { measure: true, ..LatticeConfig::new(&lattice) }, vec![0; 64 * 4000]);
    let settings = ContextSettings::FINE.with_step(step(157));
    let (mut small, mut dense) = (vec![], vec![]);
    encode_scan(&config, &simulated(), &mut pixels, &mut Small::<8>::new(settings), &mut small);
    encode_scan(&config, &simulated(), &mut pixels, &mut Dense::<8>::new(settings), &mut dense);
    check_with_python("context-small.flicr", &small);
    check_with_python("context-dense.flicr", &dense);
}
