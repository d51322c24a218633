//! Sensor files: exact for every number, and errors that say where.
#![cfg(feature = "std")]

use std::f64::consts::TAU;

use flicr::sensor::{Beam, Cell, Grid, Sensor, SensorFileError};

/// Bits from a linear congruence: every run sees the same numbers.
fn bits(state: &mut u64) -> u32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 32) as u32
}

/// Any `f32` pattern whose size is at most `limit`.
fn any_f32(state: &mut u64, limit: f32) -> f32 {
    loop {
        let value = f32::from_bits(bits(state));
        if value.abs() <= limit {
            return value;
        }
    }
}

fn any_sensor(state: &mut u64) -> Sensor {
    let mut slopes: Vec<f32> = (0..=bits(state) % 130).map(|_| any_f32(state, 57.0)).collect();
    slopes.sort_by(|a, b| b.total_cmp(a));
    slopes.dedup_by(|a, b| a == b);
    let beams = slopes.iter().map(|&slope| Beam {
        slope,
        z_offset_m: any_f32(state, 1.0),
        h_offset_m: any_f32(state, 0.25),
        azimuth_phase_rad: any_f32(state, std::f32::consts::TAU),
        range_phase_m: any_f32(state, 10.0),
    });
    Sensor {
        beams: beams.collect(),
        name: "made \"up\" \\ by\ta test, äöü \u{1F4A1}\u{7}\n".into(),
        ticks_per_turn: 1 + bits(state) % (1 << 20),
        range_unit_m: any_f32(state, 1.0).abs().max(f32::MIN_POSITIVE),
        range_from_axis: bits(state) % 2 == 1,
    }
}

fn all_bits(sensor: &Sensor) -> Vec<u32> {
    let fields = sensor
        .beams
        .iter()
        .flat_map(|beam| [beam.slope, beam.z_offset_m, beam.h_offset_m, beam.azimuth_phase_rad, beam.range_phase_m]);
    fields.chain([sensor.range_unit_m]).map(f32::to_bits).collect()
}

#[test]
fn every_bit_comes_back() {
    let mut state = 1;
    for _ in 0..300 {
        let sensor = any_sensor(&mut state);
        let text = sensor.to_toml();
        let back = Sensor::from_toml(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(back.grid().check(), Ok(()), "what is read can be encoded with");
        assert_eq!(all_bits(&back), all_bits(&sensor));
        assert_eq!((back.name, back.ticks_per_turn), (sensor.name, sensor.ticks_per_turn));
        assert_eq!(back.range_from_axis, sensor.range_from_axis);
    }
}

#[test]
fn numbers_are_written_short() {
    let beam = Beam { slope: 0.033_814_6, z_offset_m: 0.209_126, h_offset_m: -0.026, ..Beam::default() };
    let sensor = Sensor { beams: vec![beam], ticks_per_turn: 4000, range_unit_m: 0.002, ..Sensor::default() };
    let text = sensor.to_toml();
    assert!(text.contains("range_unit_m = 0.002\n"), "{text}");
    let line = "{ slope = 0.0338146, z_offset_m = 0.209126, h_offset_m = -0.026, \
                azimuth_phase_rad = 0.0, range_phase_m = 0.0 },";
    assert!(text.contains(line), "{text}");
}

/// A file of two beams, line by line.
const LINES: [&str; 9] = [
    "# comment",
    "format = 1",
    "name = \"two\"",
    "ticks_per_turn = 4000",
    "range_unit_m = 0.002",
    "beams = [",
    "  { slope = 0.1, z_offset_m = 0.2, h_offset_m = 0.026, azimuth_phase_rad = 0, range_phase_m = 0 },",
    "  { slope = 0.0, z_offset_m = 0.2, h_offset_m = -0.026, azimuth_phase_rad = 0, range_phase_m = 0 },",
    "]",
];

/// The error of the file with one line replaced.
fn error_with(line: usize, replacement: &str) -> SensorFileError {
    let mut lines = LINES;
    lines[line - 1] = replacement;
    Sensor::from_toml(&lines.join("\n")).expect_err("a file with a mistake")
}

#[test]
fn the_file_without_a_mistake_is_read() {
    assert_eq!(Sensor::from_toml(&LINES.join("\n")).unwrap().beams.len(), 2);
    assert_eq!(Sensor::from_toml(&LINES.join("\r\n")).unwrap().beams.len(), 2);
}

#[test]
fn numbers_out_of_range_are_named_with_their_line() {
    let beam = "{ slope = 0, z_offset_m = 11, h_offset_m = 0, azimuth_phase_rad = 0, range_phase_m = 0 },";
    let not_below = LINES[6];
    let cases = [
        (2, "format = 2", "line 2: format is 2, expected 1"),
        (4, "ticks_per_turn = 0", "line 4: ticks_per_turn is 0, expected 1 to 1048576"),
        (4, "ticks_per_turn = 5000000", "line 4: ticks_per_turn is 5000000, expected 1 to 1048576"),
        (5, "range_unit_m = 0", "line 5: range_unit_m is 0, expected over 0, up to 1"),
        (5, "range_unit_m = nan", "line 5: range_unit_m is NaN, expected over 0, up to 1"),
        (5, "range_unit_m = -0.002", "line 5: range_unit_m is -0.0020000000949949026, expected over 0, up to 1"),
        (
            8,
            not_below,
            "line 8: slope of beam 1 is 0.10000000149011612, expected less than 0.1, the slope of the beam before",
        ),
        (8, beam, "line 8: z_offset_m of beam 1 is 11, expected -1 to 1"),
    ];
    for (line, replacement, message) in cases {
        assert_eq!(error_with(line, replacement).to_string(), message);
    }
    for field in ["slope", "z_offset_m", "h_offset_m", "azimuth_phase_rad", "range_phase_m"] {
        for bad in ["nan", "inf", "-inf", "1e9", "-100.0"] {
            let old = LINES[7].split(field).nth(1).unwrap().split([',', '}']).next().unwrap();
            let replaced = LINES[7].replace(&format!("{field}{old}"), &format!("{field} = {bad} "));
            let error = error_with(8, &replaced);
            let SensorFileError::Value { line: 8, field: named, beam: Some(1), .. } = error else { panic!("{error}") };
            assert_eq!(named, field);
        }
    }
}

#[test]
fn what_is_not_a_sensor_file_is_named_with_its_line() {
    let cases = [
        (3, "name = ", 3, ""),
        (3, "name = 5", 3, "string"),
        (4, "ticks_per_turn = -4", 4, ""),
        (4, "ticks_per_turn = 4000.5", 4, "u32"),
        (4, "tiks_per_turn = 4000", 4, "tiks_per_turn"),
        (8, "  { slope = 0.0, z_offset_m = 0.2 },", 8, "h_offset_m"),
        (8, "  { slope = \"flat\" },", 8, "f32"),
        (9, "", 8, ""),
    ];
    for (line, replacement, found_line, mention) in cases {
        let error = error_with(line, replacement);
        let SensorFileError::Syntax { line, column, message } = &error else { panic!("{error}") };
        assert!(*line >= found_line && *column > 0, "{error}");
        assert!(message.contains(mention), "{error}");
    }
    for missing in 2..=6 {
        assert!(matches!(error_with(missing, ""), SensorFileError::Syntax { .. }));
    }
    let none = "format = 1\nname = \"\"\nticks_per_turn = 1\nrange_unit_m = 1\nbeams = []\n";
    let error = Sensor::from_toml(none).unwrap_err();
    assert_eq!(error.to_string(), "line 5: number of beams is 0, expected 1 to 1024");
}

#[test]
fn no_text_panics() {
    let mut state = 3;
    let whole = any_sensor(&mut state).to_toml();
    for _ in 0..2000 {
        let mut text = whole.clone().into_bytes();
        text.truncate(bits(&mut state) as usize % text.len());
        for _ in 0..bits(&mut state) % 4 {
            let at = bits(&mut state) as usize % text.len().max(1);
            if let Some(byte) = text.get_mut(at) {
                *byte = bits(&mut state) as u8;
            }
        }
        let _ = Sensor::from_toml(&String::from_utf8_lossy(&text));
    }
}

/// Thirty-two beams with every kind of offset.
fn sensor() -> Sensor {
    let beam = |row: u16| {
        let row = f32::from(row);
        Beam {
            slope: 0.2 - 0.025 * row,
            z_offset_m: 0.2 - 0.002 * row,
            h_offset_m: 0.026 - 0.0016 * row,
            azimuth_phase_rad: 0.0007 - 0.000_04 * row,
            range_phase_m: 0.001 - 0.000_06 * row,
        }
    };
    Sensor { beams: (0..32).map(beam).collect(), ticks_per_turn: 4000, range_unit_m: 0.002, ..Sensor::default() }
}

#[test]
fn cells_and_positions_are_inverse() {
    let sensor = sensor();
    let grid = Grid::new(&sensor);
    for beam in 0..32 {
        for tick in (0..4000).step_by(37).chain([3999]) {
            for count in [400, 1234, 60_000] {
                let cell = Cell { beam, tick, count };
                // The coordinates of a file: single precision, here without rounding to millimetres.
                let position = grid.position(cell).map(|value| f64::from(value as f32));
                let (found, miss) = grid.locate(position).unwrap();
                assert_eq!(found, cell);
                assert!(miss.norm_m() < 2e-5, "{miss:?}");
                assert_eq!(grid.locate_on_beam(beam, position).unwrap().0, cell);
            }
        }
    }
}

#[test]
fn misses_are_measured_along_their_axes() {
    let sensor = sensor();
    let grid = Grid::new(&sensor);
    let cell = Cell { beam: 3, tick: 500, count: 10_000 };
    let tick_rad = TAU / 4000.0;
    let [x, y, z] = grid.position(cell);
    let turned = 0.3 * tick_rad;
    let (_, miss) = grid.locate([x * turned.cos() - y * turned.sin(), x * turned.sin() + y * turned.cos(), z]).unwrap();
    assert!((miss.around_m - turned * x.hypot(y)).abs() < 1e-9 && miss.across_m.abs() < 1e-9, "{miss:?}");
    let range = x.hypot(y).hypot(z);
    let (_, miss) = grid.locate([x, y, z].map(|value| value * (1.0 + 0.0005 / range))).unwrap();
    assert!((miss.along_m - 0.0005).abs() < 1e-6 && miss.around_m.abs() < 1e-5, "{miss:?}");
}

#[test]
fn what_is_no_return_has_no_cell() {
    let grid = Grid::new(&sensor());
    for point in [[0.0; 3], [f64::NAN, 1.0, 1.0], [1.0, 1.0, f64::INFINITY], [f64::INFINITY, 0.0, 0.0]] {
        assert_eq!(grid.locate(point), None);
        assert_eq!(grid.locate_on_beam(0, point), None);
    }
    assert_eq!(grid.locate_on_beam(32, [1.0, 1.0, 0.0]), None);
    assert_eq!(grid.position(Cell { beam: 32, tick: 0, count: 1000 }), [0.0; 3]);
    assert_eq!(Grid::new(&Sensor::default()).locate([1.0, 1.0, 1.0]), None);
}
