//! Promise: what the documents say is what the code does.
#![allow(missing_docs)]

use flicr::{Config, Decoder, Encoder, Levels, Rle, Scale, Stamp, UniformView};

const FORMAT: &str = include_str!("../docs/FORMAT.md");

/// The bytes of the first block fenced as `frame`: hexadecimal, each line up to a `|` or its end.
fn example() -> Vec<u8> {
    let block = FORMAT.split("```frame\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let digits = block.lines().flat_map(|line| line.split('|').next().unwrap().split_whitespace());
    digits.map(|byte| u8::from_str_radix(byte, 16).expect("two hexadecimal digits")).collect()
}

#[test]
fn the_worked_example_decodes_as_it_says() {
    let bytes = example();
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
    assert_eq!(example(), out[..len], "{:02x?}", &out[..len]);
}
