//! What it costs to cut a turn of real scans into strips that decode alone.

use flicr::coder::{Coder, ContextSettings, Fast, Step};
use flicr::{Dense, ImageView, Small};

use crate::common::data::{self, median};
use crate::firing_turns::turns;

const STRIPS: usize = 16;
const STRIP_HEAD_LEN: usize = 8;
/// Header, strip, checksum and the list of firings.
const OTHER_BYTES: usize = 84 + 48;

/// Steps in counts of 2 mm, and how much longer small, dense and fast frames may be. Promised are 1.04, 1.04 and 1.07: small and
/// dense miss that from 10 cm on, where there are few bytes and a strip's first columns take a larger share of them.
const MOST: [(u16, [f64; 3]); 4] =
    [(1, [1.02, 1.022, 1.02]), (10, [1.031, 1.03, 1.04]), (51, [1.047, 1.046, 1.05]), (157, [1.065, 1.06, 1.06])];

pub fn sixteen_strips_cost_little() {
    let scans = data::KITTI.iter().filter(|scan| !scan.name.contains("object")).step_by(3);
    let turns = turns(scans.map(|scan| scan.points.as_slice()));
    let mut out = vec![0; 1 << 20];
    println!("{:>8} {:>8} {:>8} {:>8}", "step mm", "small", "dense", "fast");
    let mut broken = Vec::new();
    for (counts, most) in MOST {
        let settings = ContextSettings::FINE.with_step(Step::new(counts).unwrap());
        let (mut small, mut dense) = (Small::<8>::new(settings), Dense::<8>::new(settings));
        let mut fast = Box::new(Fast::<1>::new(settings));
        let mut longer = |coder: &mut dyn FnMut(ImageView<'_, u16>, &mut [u8]) -> usize| {
            median(turns.iter().map(|turn| {
                let image = turn.view();
                let first = |strip: usize| turn.columns * strip / STRIPS;
                let strips = (0..STRIPS).map(|at| image.strip(first(at), first(at + 1) - first(at)).unwrap());
                let strips_len: usize = strips.map(|strip| STRIP_HEAD_LEN + coder(strip, &mut out)).sum();
                (OTHER_BYTES - STRIP_HEAD_LEN + strips_len) as f64 / (OTHER_BYTES + coder(image, &mut out)) as f64
            }))
        };
        let found = [
            longer(&mut |image, out| small.encode(image, out).unwrap()),
            longer(&mut |image, out| dense.encode(image, out).unwrap()),
            longer(&mut |image, out| fast.encode(image, out).unwrap()),
        ];
        println!("{:8} {:8.4} {:8.4} {:8.4}", 2 * counts, found[0], found[1], found[2]);
        broken.extend(
            found
                .iter()
                .zip(most)
                .filter(|(found, most)| **found > *most)
                .map(|(found, most)| format!("{counts}: {found} > {most}")),
        );
    }
    assert!(broken.is_empty(), "{broken:?}");
}
