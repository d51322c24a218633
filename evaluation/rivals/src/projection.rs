//! Points to range image: the authors' way, and flicr's on one thread and on two. Built a second time without vector
//! instructions (tools/paper.sh), it gives the scalar times.

use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::{Config, DeflateDefault, FrameEncoder, ImageViewMut, LatticeConfig, Rle, Scale, Stamp};
use serde_json::json;

use crate::Outcome;
use crate::authors::baseline;
use crate::cost::measure;

/// Fixed, so that projection is one pass: as firmware does it.
const CONFIG: Config = Config { scale: Scale::Fixed { max_range_m: 120.0 }, ..Config::UNIFORM };

pub fn run(columns: usize, scan: &[[f32; 4]], runs: usize) -> Outcome {
    let scan: Vec<[f32; 4]> = scan.iter().copied().filter(|&[x, y, z, _]| x * x + y * y + z * z > 0.0).collect();
    let mut image = vec![0.0_f32; baseline::ROWS * columns];
    let ((), authors) = measure(runs, || baseline::project(&scan, columns, &mut image));
    let mut whole = Half::new(columns);
    let ((), one) = measure(runs, || whole.project(&scan));
    let (mut left, mut right) = (Half::new(columns), Half::new(columns));
    let (front, back) = scan.split_at(scan.len() / 2);
    let ((), two) = measure(runs, || {
        std::thread::scope(|threads| {
            threads.spawn(|| right.project(back));
            left.project(front);
        });
        left.merge(&right);
    });
    if left.levels != whole.levels {
        return Err("two threads made another image than one".into());
    }
    let lattice = Lattice::<66>::new(hdl64e::GRID, 4000)?;
    let (mut levels, mut coder) = (vec![0_u16; 64 * 4000], Rle::new());
    let (outcome, own_grid) = measure(runs, || -> Result<(), Box<dyn std::error::Error>> {
        let image = ImageViewMut::new(&mut levels, 4000).ok_or("no image")?;
        let config = LatticeConfig::new(&lattice);
        FrameEncoder::start(&config, Stamp::default(), image, &mut coder)?.insert(scan.as_slice());
        Ok(())
    });
    outcome?;
    Ok(json!({
        "points": scan.len(), "columns": columns,
        "authors": authors.json(), "one_thread": one.json(), "two_threads": two.json(), "own_grid": own_grid.json(),
    }))
}

/// An image and what fills it.
struct Half {
    levels: Vec<u8>,
    columns: usize,
    coder: Box<DeflateDefault>,
}

impl Half {
    fn new(columns: usize) -> Self {
        Self { levels: vec![0; baseline::ROWS * columns], columns, coder: Box::new(DeflateDefault::new()) }
    }

    fn project(&mut self, points: &[[f32; 4]]) {
        let image = ImageViewMut::new(&mut self.levels, self.columns).expect("a whole number of rows");
        let mut frame = FrameEncoder::start(&CONFIG, Stamp::default(), image, &mut *self.coder).expect("checked sizes");
        frame.insert(points);
        std::hint::black_box(frame.tally());
    }

    /// The nearest point wins, as within one image; 0 is no return.
    fn merge(&mut self, other: &Self) {
        for (own, &theirs) in self.levels.iter_mut().zip(&other.levels) {
            // One less, so that no return is the farthest of all.
            *own = own.wrapping_sub(1).min(theirs.wrapping_sub(1)).wrapping_add(1);
        }
    }
}
