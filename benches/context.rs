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
mod timing;

use data::{Scan, median};
use flicr::coder::{ContextSettings, Dense, Small, Step};
use timing::{ns_a_pixel, zlib_ns_a_byte};

const COUNT_MM: u16 = 2;
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
