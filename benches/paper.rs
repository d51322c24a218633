//! The paper's codec against the plain baseline, paired in one run: `cargo bench --features std --bench paper`.
#![allow(missing_docs)]

mod baseline;
#[path = "../tests/common/data.rs"]
mod data;

use std::time::{Duration, Instant};

use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::simulate::Simulator;
use flicr::{
    Config, Decoder, DeflateDefault, FrameEncoder, ImageViewMut, LatticeConfig, Limits, Rle, Scale, Stamp, encode,
};

const COLUMNS: usize = 4500;
const ROUNDS: usize = 40;

fn main() {
    let scan = scan();
    let mut ours = Ours::new();
    let mut theirs = Theirs::new();
    let mut lattice = OnGrid::new();
    theirs.encode(&scan);
    let rows = [
        ("projection", ratio(|| ours.project(&scan), || theirs.project(&scan))),
        ("lattice", ratio(|| lattice.project(&scan), || theirs.project(&scan))),
        ("  encode", ratio(|| lattice.encode(&scan), || theirs.encode(&scan))),
        ("  decode", ratio(|| lattice.decode(), || theirs.decode())),
        ("encode", ratio(|| ours.encode(&scan), || theirs.encode(&scan))),
        ("decode", ratio(|| ours.decode(), || theirs.decode())),
    ];
    println!("{} points, {COLUMNS} x 64, medians of {ROUNDS} pairs; least: ratio of the shortest times", scan.len());
    println!("{:12} {:>10} {:>12} {:>8} {:>8}", "stage", "flicr us", "baseline us", "ratio", "least");
    for (stage, Pairs { ours, theirs, ratio, least }) in rows {
        println!("{stage:12} {:10} {:12} {ratio:8.3} {least:8.3}", ours.as_micros(), theirs.as_micros());
    }
}

/// The scan that `docs/PERFORMANCE.md` speaks of, or a simulated one where that is not at hand.
fn scan() -> Vec<[f32; 4]> {
    if data::FOLDER.is_some() {
        return data::read_points(&data::path("kitti/drive/000003.bin"));
    }
    println!("no shared data beside the crate or at FLICR_DATA: a simulated scan in its place");
    Simulator::hdl64e(1).turn(0).points
}

/// Medians of our times, theirs, and their ratios; and the ratio of the shortest times, which what else the machine does
/// changes least.
struct Pairs {
    ours: Duration,
    theirs: Duration,
    ratio: f64,
    least: f64,
}

fn ratio(mut ours: impl FnMut(), mut theirs: impl FnMut()) -> Pairs {
    let pairs: Vec<_> = (0..ROUNDS).map(|_| (time(&mut ours), time(&mut theirs))).collect();
    let mut ratios: Vec<f64> = pairs.iter().map(|&(ours, theirs)| share(ours, theirs)).collect();
    ratios.sort_by(f64::total_cmp);
    let (mut ours, mut theirs): (Vec<_>, Vec<_>) = pairs.into_iter().unzip();
    ours.sort();
    theirs.sort();
    Pairs {
        ours: ours[ROUNDS / 2],
        theirs: theirs[ROUNDS / 2],
        ratio: ratios[ROUNDS / 2],
        least: share(ours[0], theirs[0]),
    }
}

fn share(ours: Duration, theirs: Duration) -> f64 {
    ours.as_secs_f64() / theirs.as_secs_f64()
}

fn time(work: &mut impl FnMut()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

struct Ours {
    levels: Vec<u8>,
    coder: Box<DeflateDefault>,
    out: Vec<u8>,
    decoder: Decoder,
    points: Vec<[f32; 3]>,
}

impl Ours {
    fn new() -> Self {
        Self {
            levels: vec![0; 64 * COLUMNS],
            coder: Box::new(DeflateDefault::new()),
            out: vec![0; 400_000],
            decoder: Decoder::new(Limits::default()),
            points: Vec::new(),
        }
    }

    fn project(&mut self, scan: &[[f32; 4]]) {
        let config = Config { scale: Scale::Fixed { max_range_m: 80.0 }, ..Config::PAPER };
        let image = ImageViewMut::new(&mut self.levels, COLUMNS).unwrap();
        let mut frame = FrameEncoder::start(&config, Stamp::default(), image, &mut *self.coder).unwrap();
        frame.insert(scan);
        std::hint::black_box(frame.tally());
    }

    fn encode(&mut self, scan: &[[f32; 4]]) {
        let image = ImageViewMut::new(&mut self.levels, COLUMNS).unwrap();
        let encoded = encode(&Config::PAPER, scan, Stamp::default(), image, &mut *self.coder, &mut self.out).unwrap();
        std::hint::black_box(encoded);
    }

    fn decode(&mut self) {
        let len = flicr::frame::frame_len(&self.out).unwrap();
        let frame = self.decoder.decode(&self.out[..len]).unwrap();
        frame.points_into(&mut self.points);
        std::hint::black_box(&self.points);
    }
}

/// The sensor's own grid, lossless.
struct OnGrid {
    levels: Vec<u16>,
    coder: Rle,
    out: Vec<u8>,
    decoder: Decoder,
    points: Vec<[f32; 3]>,
}

static EVERY_TICK: Lattice<66> = match Lattice::new(hdl64e::GRID, 4000) {
    Ok(lattice) => lattice,
    Err(_) => panic!("checked at compile time"),
};

impl OnGrid {
    fn new() -> Self {
        Self {
            levels: vec![0; 64 * 4000],
            coder: Rle::new(),
            out: vec![0; 600_000],
            decoder: Decoder::new(Limits::default()),
            points: Vec::new(),
        }
    }

    fn project(&mut self, scan: &[[f32; 4]]) {
        let image = ImageViewMut::new(&mut self.levels, 4000).unwrap();
        let config = LatticeConfig::new(&EVERY_TICK);
        let mut frame = FrameEncoder::start(&config, Stamp::default(), image, &mut self.coder).unwrap();
        frame.insert(scan);
        std::hint::black_box(frame.tally());
    }

    fn encode(&mut self, scan: &[[f32; 4]]) {
        let image = ImageViewMut::new(&mut self.levels, 4000).unwrap();
        let config = LatticeConfig::new(&EVERY_TICK);
        let encoded = encode(&config, scan, Stamp::default(), image, &mut self.coder, &mut self.out).unwrap();
        std::hint::black_box(encoded);
    }

    fn decode(&mut self) {
        let len = flicr::frame::frame_len(&self.out).unwrap();
        let frame = self.decoder.decode(&self.out[..len]).unwrap();
        frame.points_into(&mut self.points);
        std::hint::black_box(&self.points);
    }
}

struct Theirs {
    image: Vec<f32>,
    levels: Vec<u8>,
    max: f32,
    bytes: Vec<u8>,
    points: Vec<[f32; 3]>,
}

impl Theirs {
    fn new() -> Self {
        let pixels = baseline::ROWS * COLUMNS;
        Self { image: vec![0.0; pixels], levels: vec![0; pixels], max: 0.0, bytes: Vec::new(), points: Vec::new() }
    }

    fn project(&mut self, scan: &[[f32; 4]]) {
        baseline::project(scan, COLUMNS, &mut self.image);
        std::hint::black_box(&self.image);
    }

    fn encode(&mut self, scan: &[[f32; 4]]) {
        baseline::project(scan, COLUMNS, &mut self.image);
        self.max = baseline::quantize(&self.image, &mut self.levels);
        self.bytes = baseline::deflate(&self.levels, 1);
    }

    fn decode(&mut self) {
        baseline::inflate(&self.bytes, &mut self.levels);
        baseline::reconstruct(&self.levels, COLUMNS, self.max, &mut self.image, &mut self.points);
        std::hint::black_box(&self.points);
    }
}
