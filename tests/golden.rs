//! Promise: frames of every tier, of 8 and 16 bits, evenly spread and companded, by both predictors, in one strip and in
//! many, are the same bytes on every machine and in every version of the format (`tests/golden.out`; `make bless` renews it),
//! and `docs/FORMAT.md` says enough to decode each: a decoder in Python, written from it alone, finds the same levels.
#![cfg(feature = "std")]
#![allow(missing_docs)]

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use flicr::coder::{Coder, ContextSettings, Fast, Predictor, Step};
use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::simulate::Simulator;
use flicr::{Companding, Decoder, Dense, ImageViewMut, LatticeConfig, Level, Levels, Scale, Small, Stamp, encode};

const COLUMNS: usize = 240;
const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// A frame's name and bytes.
type Golden = (String, Vec<u8>);

fn street() -> Vec<[f32; 3]> {
    Simulator::hdl64e(1).turn(0).points.iter().map(|&[x, y, z, _]| [x, y, z]).collect()
}

fn frames() -> Vec<Golden> {
    let (points, lattice) = (street(), Lattice::<66>::new(hdl64e::GRID, COLUMNS).unwrap());
    let native = LatticeConfig::new(&lattice);
    let even = LatticeConfig { scale: Scale::Fixed { max_range_m: 80.0 }, level_bits: 8, ..native };
    let companded = LatticeConfig { companding: Companding::SquareRoot, ..even };
    let mut frames = Vec::new();
    for strips in [1, 16] {
        let [native, even, companded] = [native, even, companded].map(|config| LatticeConfig { strips, ..config });
        let settings = |step| ContextSettings::FINE.with_step(Step::new(step).unwrap());
        of_tiers::<u16>("u16", &native, settings(10), &points, &mut frames);
        of_tiers::<u8>("u8", &even, ContextSettings::COARSE, &points, &mut frames);
        of_tiers::<u8>("u8-companded", &companded, settings(3), &points, &mut frames);
    }
    frames
}

fn of_tiers<L: Level>(
    levels: &str,
    config: &LatticeConfig<'_, 66>,
    settings: ContextSettings,
    points: &[[f32; 3]],
    frames: &mut Vec<Golden>,
) {
    let name = |tier: &str, by: &str| format!("tier={tier} levels={levels} predictor={by} strips={}", config.strips);
    for (by, predictor) in [("west", Predictor::West), ("median-edge", Predictor::MedianEdge)] {
        let settings = ContextSettings { predictor, ..settings };
        frames.push((name("small", by), encoded::<L, _>(config, points, &mut Small::<8>::new(settings))));
        frames.push((name("dense", by), encoded::<L, _>(config, points, &mut Dense::<8>::new(settings))));
    }
    // It has one predictor.
    let settings = ContextSettings { predictor: Predictor::West, ..settings };
    let mut fast: Box<Fast<1>> = Box::new(Fast::new(settings));
    frames.push((name("fast", "west"), encoded::<L, _>(config, points, &mut *fast)));
}

fn encoded<L: Level, C: Coder<L>>(config: &LatticeConfig<'_, 66>, points: &[[f32; 3]], coder: &mut C) -> Vec<u8> {
    let mut levels = vec![L::NONE; 64 * COLUMNS];
    let mut out = vec![0; config.worst_case_len::<L, C>()];
    let image = ImageViewMut::new(&mut levels, COLUMNS).unwrap();
    let encoded = encode(config, points, Stamp::default(), image, coder, &mut out).unwrap();
    out.truncate(encoded.len);
    out
}

#[test]
fn the_bytes_are_those_of_the_format() {
    let mut found = String::new();
    for (name, frame) in frames() {
        let crc = CRC.checksum(&frame[..frame.len() - 4]);
        writeln!(found, "{name} bytes={} crc={crc:08x}", frame.len()).unwrap();
    }
    if std::env::var_os("FLICR_BLESS").is_some() {
        std::fs::write("tests/golden.out", &found).unwrap();
    }
    assert_eq!(found, std::fs::read_to_string("tests/golden.out").unwrap());
}

#[test]
fn a_decoder_written_from_the_format_alone_finds_the_same_levels() {
    let mut decoder = Decoder::default();
    for (name, frame) in frames() {
        let levels = match decoder.decode(&frame).unwrap().levels() {
            Levels::U8(levels) => levels.iter().map(|&level| level.into()).collect(),
            Levels::U16(levels) => levels.clone(),
        };
        assert!(levels.iter().filter(|&&level| level != 0).count() > 10_000, "{name}: hardly a return");
        assert!(decoded_by_python(&frame) == levels, "{name}");
    }
}

fn decoded_by_python(frame: &[u8]) -> Vec<u16> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden.flicr");
    std::fs::write(&path, frame).unwrap();
    let files =
        ["tests/reference/context_decoder.py", "src/coder/context/priors.rs", "src/coder/context/fast/priors.bin"];
    let [program, priors, fast_priors] = files.map(|file| root.join(file));
    let output = Command::new("python3").arg(program).arg(&path).arg(priors).arg(fast_priors).output();
    let output = output.expect("python3, which tools/setup.sh installs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout.as_chunks::<2>().0.iter().map(|bytes| u16::from_le_bytes(*bytes)).collect()
}
