//! The datagrams' format by a second decoder, in Python, written from `docs/FORMAT.md`.

#[path = "common/small_sensor.rs"]
mod small_sensor;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use flicr::coder::{ContextSettings, DenseModel, Predictor, SmallModel, Step};
use flicr::geometry::SensorGrid;
use flicr::geometry::sensors::hdl64e;
use flicr::stream::{Aligned, AsFired, StreamConfig, StreamDecoder, StreamEncoder};
use small_sensor::{GRID, Place, tick};

const COLUMNS: usize = 200;

/// Datagrams of two turns, some columns missing, some of noise.
macro_rules! datagrams {
    ($model:ty, $line:ty, $len:literal, $settings:expr, $stride:expr, $id:expr) => {{
        let config = StreamConfig::new(&GRID, 2 - u8::from($id == 0), $settings).unwrap();
        let config = StreamConfig { columns_a_turn: COLUMNS as u16, id: $id, ..config };
        let mut stream: StreamEncoder<$model, 2, $len, $line> = StreamEncoder::new(config).unwrap();
        stream.set_stride($stride);
        let (mut place, mut sent) = (Place::new(3), Vec::new());
        for _ in 0..2 {
            for column in (0..COLUMNS).filter(|column| !(50..57).contains(column)) {
                let counts = match column {
                    100..104 => std::array::from_fn(|_| 1 + place.random(65_000) as u32),
                    _ => place.column(),
                };
                let (tick, time_ns) = (tick(column, COLUMNS), 500_000 * column as u64);
                stream.push_counts(column as u16, tick, time_ns, &counts, |datagram| sent.push(datagram.to_vec()));
            }
            stream.end_turn(|datagram| sent.push(datagram.to_vec()));
        }
        stream.finish(|datagram| sent.push(datagram.to_vec()));
        sent
    }};
}

/// Lines as the Python decoder writes them.
fn decoded(grid: &SensorGrid<'_>, datagrams: &[Vec<u8>]) -> BTreeSet<String> {
    let mut receiver = StreamDecoder::default();
    receiver.know(grid).unwrap();
    let mut lines = BTreeSet::new();
    for datagram in datagrams {
        let strip = receiver.push(datagram).unwrap();
        for (column, (_, levels)) in strip.columns().enumerate() {
            for (row, &level) in levels.iter().enumerate().filter(|(_, level)| **level != 0) {
                let number = usize::from(strip.first_column()) + column * usize::from(strip.stride());
                let tick = strip.tick(column, row).unwrap();
                lines.insert(format!("{} {number} {tick} {row} {level}", strip.turn()));
            }
        }
    }
    lines
}

fn decoded_by_python(name: &str, grid: &SensorGrid<'_>, datagrams: &[Vec<u8>]) -> BTreeSet<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let at = |suffix: &str| Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.{suffix}"));
    let mut bytes = Vec::new();
    for datagram in datagrams {
        bytes.extend((datagram.len() as u16).to_le_bytes());
        bytes.extend(datagram);
    }
    std::fs::write(at("datagrams"), bytes).unwrap();
    let mut sensor = format!("{} {} {}", grid.checksum(), grid.ticks, u8::from(grid.clockwise));
    grid.beams.iter().for_each(|beam| write!(sensor, " {:.17}", f64::from(beam.azimuth_phase_rad)).unwrap());
    std::fs::write(at("sensor"), sensor).unwrap();
    let mut python = Command::new("python3");
    python.arg(root.join("tests/reference/datagram_decoder.py")).args([at("datagrams"), at("sensor")]);
    python.args(["priors.rs", "strip_priors.rs"].map(|file| root.join("src/coder/context").join(file)));
    let output = python.output().expect("python3, which tools/setup.sh installs");
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(String::from).collect()
}

#[test]
fn a_second_decoder_finds_the_same() {
    let settings = |step| ContextSettings::FINE.with_step(Step::new(step).unwrap());
    let median = ContextSettings { predictor: Predictor::MedianEdge, ..settings(30) };
    let streams = [
        ("fired", datagrams!(SmallModel, AsFired, 300, settings(1), 1, 0)),
        ("fired-dense", datagrams!(DenseModel, AsFired, 300, settings(10), 1, 5)),
        ("fired-thinned", datagrams!(SmallModel, AsFired, 200, settings(30), 3, 0)),
        ("fired-median", datagrams!(SmallModel, AsFired, 200, median, 1, 0)),
        ("aligned", datagrams!(SmallModel, Aligned<512, 16>, 300, settings(1), 1, 0)),
        ("aligned-coarse", datagrams!(SmallModel, Aligned<512, 16>, 200, settings(157), 1, 9)),
        ("aligned-thinned", datagrams!(DenseModel, Aligned<512, 16>, 200, settings(5), 2, 0)),
    ];
    for (name, datagrams) in &streams {
        let found = decoded(&GRID, datagrams);
        assert!(found.len() > 900, "{name}: {}", found.len());
        assert!(decoded_by_python(name, &GRID, datagrams) == found, "{name} differs");
    }
}

/// Columns of noise, which no model makes shorter, stand as they are.
#[test]
fn stored_columns_too() {
    let grid = &hdl64e::FIRING_GRID;
    let config = StreamConfig::new(grid, 1, ContextSettings::FINE).unwrap();
    let mut stream: StreamEncoder<SmallModel, 8, 166> = StreamEncoder::new(config).unwrap();
    let (mut place, mut sent) = (Place::new(3), Vec::new());
    for column in 0..20 {
        let counts: [u32; 64] = std::array::from_fn(|_| 1 + place.random(65_000) as u32);
        stream.push_counts(column, 2 * column, 0, &counts, |datagram| sent.push(datagram.to_vec()));
    }
    stream.end_turn(|datagram| sent.push(datagram.to_vec()));
    assert!(sent.iter().any(|datagram| datagram[1] & 3 == 3));
    let found = decoded(grid, &sent);
    assert_eq!(found.len(), 20 * 64);
    assert!(decoded_by_python("stored", grid, &sent) == found);
}
