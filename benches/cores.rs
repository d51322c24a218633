//! Decoding on one core and on two, levels and points, in turn in one run: `cargo bench --features std,rayon --bench cores`.
//! A frame of 16 strips of a KITTI scan's firings (of a simulated one where there is no shared data), steps of 2 cm. The least
//! of many rounds: on a busy machine two cores are seldom free at once, which the first row tells: arithmetic in two halves
//! that share nothing.
#![allow(missing_docs)]

#[path = "../tests/common/data.rs"]
mod data;

use std::hint::black_box;
use std::time::{Duration, Instant};

use flicr::coder::{Coder, ContextSettings, Fast, Step};
use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::simulate::Simulator;
use flicr::{Decoder, Dense, FrameEncoder, ImageViewMut, LatticeConfig, Small, Stamp};

const TICKS: usize = 4000;
const STRIPS: u16 = 16;
/// For each row.
const TIME: Duration = Duration::from_secs(6);
/// Of arithmetic: some milliseconds.
const STEPS: u64 = 4_000_000;

fn main() {
    let settings = ContextSettings::FINE.with_step(Step::new(10).unwrap());
    let points = points();
    println!("{:<10} {:>10} {:>10} {:>8}", "tier", "1 core, us", "2 cores", "ratio");
    row("arithmetic", || {
        let half = || (0..STEPS / 2).fold(1_u64, |x, _| black_box(x.wrapping_mul(6_364_136_223_846_793_005) ^ x >> 31));
        black_box(rayon::join(half, half));
    });
    decode("small", &frame(&mut Small::<8>::new(settings), &points));
    decode("dense", &frame(&mut Dense::<8>::new(settings), &points));
    decode("fast", &frame(&mut *Box::new(Fast::<1>::new(settings)), &points));
}

fn points() -> Vec<[f32; 4]> {
    match &*data::FOLDER {
        Some(folder) => data::read_points(&folder.join("kitti/drive/000000.bin")),
        None => Simulator::hdl64e(1).turn(0).points,
    }
}

fn frame<C: Coder<u16>>(coder: &mut C, points: &[[f32; 4]]) -> Vec<u8> {
    let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, TICKS).unwrap();
    let config = LatticeConfig { strips: STRIPS, ..LatticeConfig::new(&lattice) };
    let (mut levels, mut out) = (vec![0_u16; 64 * TICKS], vec![0; config.worst_case_len::<u16, C>()]);
    let image = ImageViewMut::new(&mut levels, TICKS).unwrap();
    let mut frame = FrameEncoder::start(&config, Stamp::default(), image, coder).unwrap();
    frame.insert(points);
    let encoded = frame.finish_by_firings::<125>(&mut out).unwrap();
    out.truncate(encoded.len);
    out
}

fn decode(name: &str, frame: &[u8]) {
    let (mut decoder, mut points) = (Decoder::default(), Vec::new());
    row(name, || decoder.decode(frame).unwrap().points_into(&mut points));
}

fn row(name: &str, mut work: impl FnMut() + Send) {
    let pools = [1, 2].map(|cores| rayon::ThreadPoolBuilder::new().num_threads(cores).build().unwrap());
    let mut least = [Duration::MAX; 2];
    let start = Instant::now();
    while start.elapsed() < TIME {
        for (pool, least) in pools.iter().zip(&mut least) {
            let took = pool.install(|| {
                let start = Instant::now();
                work();
                start.elapsed()
            });
            *least = took.min(*least);
        }
    }
    let [one, two] = least.map(|time| time.as_secs_f64() * 1e6);
    println!("{name:<10} {one:>10.0} {two:>10.0} {:>8.2}", one / two);
}
