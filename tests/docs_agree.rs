//! Promise: what the documents say is what the code does.
#![allow(missing_docs)]

use flicr::geometry::{Beam, Firings, Lattice, SensorGrid};
use flicr::{Config, Decoder, Encoder, FiringsConfig, LatticeConfig, Levels, Rle, Scale, Stamp, UniformView};

const FORMAT: &str = include_str!("../docs/FORMAT.md");

/// The bytes of a block fenced as `frame`, numbered from 1: hexadecimal, each line up to a `|` or its end.
fn example(number: usize) -> Vec<u8> {
    let block = FORMAT.split("```frame\n").nth(number).and_then(|rest| rest.split("```").next()).expect("an example");
    let digits = block.lines().flat_map(|line| line.split('|').next().unwrap().split_whitespace());
    digits.map(|byte| u8::from_str_radix(byte, 16).expect("two hexadecimal digits")).collect()
}

#[test]
fn the_worked_example_decodes_as_it_says() {
    let bytes = example(1);
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&bytes).unwrap();
    let header = frame.header();
    assert_eq!((header.rows, header.columns, header.sequence, header.returns), (2, 8, 258, 3));
    let expected = [101, 102, 0, 0, 0, 0, 0, 0, 0, 42, 0, 0, 0, 0, 0, 0];
    let listed =
        FORMAT.split("and the levels are\n\n```text\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let listed: Vec<u8> = listed.split_whitespace().map(|level| level.parse().unwrap()).collect();
    assert_eq!(listed, expected);
    assert_eq!(*frame.levels(), Levels::U8(expected.into()));
}

#[test]
fn checksums_of_built_in_sensors_are_those_listed() {
    for grid in flicr::geometry::sensors::ALL {
        let line = format!("| {} | `{:08x}` |", grid.name, grid.checksum());
        assert!(FORMAT.contains(&line), "{line}");
    }
}

#[test]
fn the_worked_example_is_what_the_encoder_writes() {
    let config = Config {
        view: UniformView { top_rad: 0.5, bottom_rad: -0.5, start_rad: 0.0, span_rad: 1.0 },
        scale: Scale::Fixed { max_range_m: 25.5 },
        ..Config::UNIFORM
    };
    let points = [[10.0_f32, 0.6, 1.0], [10.0, 2.0, 1.0], [4.0, 0.8, -1.0], [0.0, 0.0, 0.0]];
    let mut encoder: Encoder<2, 8, u8, Rle> = Encoder::new(Rle::new());
    let stamp = Stamp { sequence: 258, timestamp_ns: 1 };
    let mut out = [0; Encoder::<2, 8, u8, Rle>::WORST_CASE_LEN];
    let len = encoder.encode(&config, points.as_slice(), stamp, &mut out).unwrap().len;
    assert_eq!(example(1), out[..len], "{:02x?}", &out[..len]);
}

/// The sensor of the second example.
const TWO_BEAMS: [Beam; 2] = [
    Beam { slope: 0.25, z_offset_m: 0.125, h_offset_m: 0.0, azimuth_phase_rad: 0.0, range_phase_m: 0.0 },
    Beam { slope: -0.25, z_offset_m: 0.0, h_offset_m: 0.0625, azimuth_phase_rad: 0.0, range_phase_m: 0.5 },
];
const TWO: SensorGrid<'_> = SensorGrid {
    name: "two beams",
    beams: &TWO_BEAMS,
    ticks: 16,
    clockwise: false,
    zero_rad: 0.0,
    range_unit_m: 0.125,
    range_from_axis: false,
};

/// Row, tick and level of its returns, in the order of its points.
const RETURNS: [(usize, u32, u32); 3] = [(0, 2, 80), (0, 8, 40), (1, 8, 36)];

#[test]
fn the_example_on_firings_is_what_the_encoder_writes_and_the_decoder_reads() {
    let points = RETURNS.map(|(row, tick, level)| TWO.position(row, tick, level).unwrap().map(|v| v as f32));
    let (lattice, firings) = (Lattice::<4>::new(TWO, 16).unwrap(), Firings::<1>::new(16, [2, 5, 8, 11]).unwrap());
    let every_tick = LatticeConfig { level_bits: 8, table: true, ..LatticeConfig::new(&lattice) };
    let config = FiringsConfig { every_tick, firings: &firings };
    let mut encoder: Encoder<2, 4, u8, Rle> = Encoder::new(Rle::new());
    let mut out = vec![0; config.worst_case_len::<u8, Rle>()];
    let stamp = Stamp { sequence: 7, timestamp_ns: 2 };
    let len = encoder.encode(&config, points.as_slice(), stamp, &mut out).unwrap().len;
    assert_eq!(example(2), out[..len], "{:02x?}", &out[..len]);
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&out[..len]).unwrap();
    assert_eq!(*frame.levels(), Levels::U8([80, 0, 40, 0, 0, 0, 36, 0].into()));
    // As the document has them, to the millimeter.
    let listed =
        FORMAT.split("and the points are\n\n```text\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let listed: Vec<f64> = listed.split_whitespace().map(|number| number.parse().unwrap()).collect();
    assert_eq!(listed.len(), 9);
    let decoded = frame.points();
    assert_eq!(decoded.len(), 3);
    for (found, listed) in decoded.as_flattened().iter().zip(listed) {
        assert!((f64::from(*found) - listed).abs() <= 0.000_51, "{found} for {listed}");
    }
}
