//! The small and the dense tier on real scans, paired with zlib -6 in one run:
//! `cargo bench --features std --bench context`.
//! Nanoseconds a pixel, empty ones counted; the least of some rounds, medians over raw KITTI scans that the priors were not
//! made from, as shares of what zlib takes for a byte of the uniform 8-bit image of 4500 columns.
#![allow(missing_docs)]

#[path = "../tests/common/data.rs"]
mod data;
#[path = "../tests/common/firings.rs"]
mod firings;
#[path = "../tests/common/range_images.rs"]
mod range_images;

use std::time::{Duration, Instant};

use data::{Scan, median};
use firings::Turn;
use flicr::coder::fast_lab::decode;
use flicr::coder::{Coder, ContextSettings, Dense, Small, Step};

const COUNT_MM: u16 = 2;
const ROUNDS: usize = 9;
/// Every so manieth scan is timed.
const TIMED: usize = 7;
/// Most that encoding may take, as shares of zlib's time a byte.
const PROMISED_MM: [u16; 4] = [2, 20, 102, 314];
const SMALL: [f64; 4] = [1.4, 1.0, 0.6, 0.45];
const DENSE: [f64; 4] = [3.0, 2.0, 1.2, 0.9];

fn main() {
    if data::FOLDER.is_none() {
        println!("skipped: no shared data beside the crate or at FLICR_DATA");
        return;
    }
    let scans: Vec<&Scan> = data::KITTI.iter().filter(|scan| !scan.name.contains("object")).step_by(TIMED).collect();
    let turns = firings::turns(scans.iter().map(|scan| scan.points.as_slice()));
    let zlib: Vec<f64> = scans.iter().map(|scan| zlib_ns_a_byte(&scan.points)).collect();
    println!("zlib -6: {:.1} ns a byte", median(zlib.iter().copied()));
    println!(
        "{:>7} {:>7} {:>10} {:>10} {:>10} {:>10} {:>10}",
        "tier", "mm", "encode", "promised", "decode", "ns enc", "ns dec"
    );
    for (name, promised) in [("small", SMALL), ("dense", DENSE)] {
        for (mm, promised) in PROMISED_MM.into_iter().zip(promised) {
            let settings = ContextSettings::FINE.with_step(Step::new(mm / COUNT_MM).unwrap());
            let times: Vec<[f64; 2]> = turns
                .iter()
                .map(|turn| match name {
                    "small" => ns_a_pixel(&mut Small::<8>::new(settings), turn),
                    _ => ns_a_pixel(&mut Dense::<8>::new(settings), turn),
                })
                .collect();
            let share = |i: usize| median(times.iter().zip(&zlib).map(|(times, zlib)| times[i] / zlib));
            let ns = |i: usize| median(times.iter().map(|times| times[i]));
            print!("{name:>7} {mm:>7} {:>10.3} {promised:>10.2} {:>10.3}", share(0), share(1));
            println!(" {:>10.2} {:>10.2}", ns(0), ns(1));
        }
    }
}

fn zlib_ns_a_byte(points: &[[f32; 4]]) -> f64 {
    let image = range_images::image(points, 4500);
    let mut out = vec![0; 400_000];
    least(|| range_images::zlib(&image, 6, &mut out)).as_secs_f64() * 1e9 / image.len() as f64
}

fn ns_a_pixel(coder: &mut impl Coder<u16>, turn: &Turn) -> [f64; 2] {
    let mut out = vec![0; 400_000];
    let len = coder.encode(turn.view(), &mut out).unwrap();
    let encode = least(|| coder.encode(turn.view(), &mut out).unwrap());
    let mut levels = vec![1_u16; turn.levels.len()];
    let decode = least(|| {
        decode(&out[..len], firings::ROWS, &mut levels).unwrap();
        levels[0].into()
    });
    [encode, decode].map(|time| time.as_secs_f64() * 1e9 / turn.levels.len() as f64)
}

fn least(mut work: impl FnMut() -> usize) -> Duration {
    let once = |_| {
        let start = Instant::now();
        std::hint::black_box(work());
        start.elapsed()
    };
    (0..ROUNDS).map(once).min().expect("a round")
}
