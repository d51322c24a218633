//! The DEFLATE profiles against zlib -6 and -1 on the 8-bit images of real scans, paired, in one run:
//! `cargo bench --bench deflate`. Times are the least of some rounds, so that what else the machine does counts less.
#![allow(missing_docs)]

#[path = "../tests/common/data.rs"]
mod data;
#[path = "../tests/common/range_images.rs"]
mod range_images;

use std::time::{Duration, Instant};

use data::median;
use flicr::{DeflateDefault, DeflateDense, DeflateSmall};
use range_images::{WIDTHS, image, zlib};

const ROUNDS: usize = 7;
/// Every so manieth scan.
const STEP: usize = 3;

fn main() {
    if data::FOLDER.is_none() {
        println!("skipped: no shared data beside the crate or at FLICR_DATA");
        return;
    }
    println!("medians: ms of default and zlib -1, then ratios of times (and bytes)");
    let titles = ["columns", "default", "zlib -1", "default/-6", "small/-6", "dense/-6", "default/-1"];
    println!("{}", titles.map(|title| format!("{title:>15}")).concat());
    for columns in WIDTHS {
        let images: Vec<_> = data::KITTI.iter().step_by(STEP).map(|scan| image(&scan.points, columns)).collect();
        println!("{columns:>15}{}", row(&images, columns));
    }
}

fn row(images: &[Vec<u8>], columns: usize) -> String {
    let mut out = vec![0; DeflateSmall::worst_case_len(64 * columns) + 1000];
    let (mut default, mut small) = (Box::new(DeflateDefault::new()), Box::new(DeflateSmall::new()));
    let mut dense = Box::new(DeflateDense::new());
    let per_image: Vec<[(Duration, usize); 5]> = images
        .iter()
        .map(|image| {
            [
                least(|| default.encode_bytes(image, columns, &mut out).unwrap()),
                least(|| small.encode_bytes(image, columns, &mut out).unwrap()),
                least(|| dense.encode_bytes(image, columns, &mut out).unwrap()),
                least(|| zlib(image, 6, &mut out)),
                least(|| zlib(image, 1, &mut out)),
            ]
        })
        .collect();
    let ms = |i: usize| 1e3 * median(per_image.iter().map(|coders| coders[i].0.as_secs_f64()));
    let bytes = |i: usize| median(per_image.iter().map(|coders| coders[i].1 as f64));
    let ratio = |ours: usize, theirs: usize| {
        let time = median(per_image.iter().map(|c| c[ours].0.as_secs_f64() / c[theirs].0.as_secs_f64()));
        format!("{time:.2} ({:.3})", bytes(ours) / bytes(theirs))
    };
    let cells = [format!("{:.2}", ms(0)), format!("{:.2}", ms(4)), ratio(0, 3), ratio(1, 3), ratio(2, 3), ratio(0, 4)];
    cells.map(|cell| format!("{cell:>15}")).concat()
}

fn least(mut work: impl FnMut() -> usize) -> (Duration, usize) {
    let once = |_| {
        let start = Instant::now();
        let len = std::hint::black_box(work());
        (start.elapsed(), len)
    };
    (0..ROUNDS).map(once).min().expect("a round")
}
