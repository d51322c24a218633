//! The fast tier on real scans, paired with zlib -6 in one run: `cargo bench --features std --bench fast`.
//! Ratios are of 16 bytes a point, medians over the raw KITTI scans that the priors were not made from; times are the
//! least of some rounds, as shares of what zlib takes for a byte of the uniform 8-bit image of 4500 columns.
#![allow(missing_docs)]

#[path = "../tests/common/data.rs"]
mod data;
#[path = "../tests/common/firings.rs"]
mod firings;
#[path = "../tests/common/range_images.rs"]
mod range_images;
mod timing;

use data::{Scan, median};
use firings::Turn;
use flicr::coder::fast_lab::decode;
use flicr::coder::{Coder, ContextSettings, Fast, Step};
use timing::{ns_a_pixel, zlib_ns_a_byte};

const STEPS_MM: [u16; 7] = [2, 10, 20, 50, 102, 202, 314];
const COUNT_MM: u16 = 2;
/// Every so manieth scan is timed.
const TIMED: usize = 5;
const STRIPS: usize = 16;
const STRIP_HEAD_LEN: usize = 8;
/// What a frame has besides the payload, firings included.
const FRAME_LEN: usize = 45 + 48;

fn main() {
    if data::FOLDER.is_none() {
        println!("skipped: no shared data beside the crate or at FLICR_DATA");
        return;
    }
    let scans: Vec<&Scan> = data::KITTI.iter().filter(|scan| !scan.name.contains("object")).collect();
    let turns = firings::turns(scans.iter().map(|scan| scan.points.as_slice()));
    let zlib: Vec<f64> = scans.iter().step_by(TIMED).map(|scan| zlib_ns_a_byte(&scan.points)).collect();
    println!("zlib -6: {:.1} ns a byte", median(zlib.iter().copied()));
    println!(
        "{:>7} {:>7} {:>10} {:>10} {:>10} {:>10} {:>10}",
        "mm", "ratio", "encode", "decode", "ns enc", "ns dec", "16 strips"
    );
    for mm in STEPS_MM {
        let step = Step::new(mm / COUNT_MM).unwrap();
        let ratio = median(
            scans
                .iter()
                .zip(&turns)
                .map(|(scan, turn)| 16.0 * scan.points.len() as f64 / (FRAME_LEN + len_checked(turn, step)) as f64),
        );
        let times: Vec<[f64; 2]> =
            turns.iter().step_by(TIMED).map(|turn| ns_a_pixel(&mut *coder(step), turn)).collect();
        let share = |i: usize| median(times.iter().zip(&zlib).map(|(times, zlib)| times[i] / zlib));
        let ns = |i: usize| median(times.iter().map(|times| times[i]));
        let strips = median(turns.iter().step_by(TIMED).map(|turn| in_strips(turn, step)));
        let [shares, ns] = [[share(0), share(1)], [ns(0), ns(1)]];
        print!("{mm:>7} {ratio:>7.2} {:>10.3} {:>10.3} {:>10.2} {:>10.2}", shares[0], shares[1], ns[0], ns[1]);
        println!(" {strips:>10.4}");
    }
}

fn coder(step: Step) -> Box<Fast> {
    Box::new(Fast::new(ContextSettings::FINE.with_step(step)))
}

/// Length of the payload, which must decode to levels within the bound.
fn len_checked(turn: &Turn, step: Step) -> usize {
    let mut out = vec![0; 400_000];
    let len = coder(step).encode(turn.view(), &mut out).unwrap();
    let mut levels = vec![1_u16; turn.levels.len()];
    decode(&out[..len], firings::ROWS, &mut levels).unwrap();
    for (&there, &back) in turn.levels.iter().zip(&levels) {
        assert_eq!(there == 0, back == 0);
        assert!(there.abs_diff(back) <= step.error_max());
    }
    len
}

/// How much longer the frame is in strips that decode alone.
fn in_strips(turn: &Turn, step: Step) -> f64 {
    let width = turn.columns.div_ceil(STRIPS);
    let mut len = FRAME_LEN;
    for first in (0..turn.columns).step_by(width) {
        let columns = width.min(turn.columns - first);
        let rows = turn.levels.chunks(turn.columns).flat_map(|row| &row[first..first + columns]);
        let levels = rows.copied().collect();
        len += STRIP_HEAD_LEN + len_checked(&Turn { levels, columns }, step);
    }
    len as f64 / (FRAME_LEN + STRIP_HEAD_LEN + len_checked(turn, step)) as f64
}
