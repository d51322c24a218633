//! Least times of a coder, and of zlib beside it.

use std::time::{Duration, Instant};

use flicr::coder::Coder;
use flicr::coder::fast_lab::decode;

use crate::firings::{self, Turn};
use crate::range_images;

const ROUNDS: usize = 9;

/// Of zlib-6 on the uniform 8-bit image of 4500 columns.
pub fn zlib_ns_a_byte(points: &[[f32; 4]]) -> f64 {
    let image = range_images::image(points, 4500);
    let mut out = vec![0; 400_000];
    least(|| range_images::zlib(&image, 6, &mut out)).as_secs_f64() * 1e9 / image.len() as f64
}

/// Encoding and decoding; empty pixels are counted.
pub fn ns_a_pixel(coder: &mut impl Coder<u16>, turn: &Turn) -> [f64; 2] {
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
