//! Coders made for range images: columns in the order in which the sensor fires, each pixel predicted from what its
//! beam saw last, every decision coded with the probability that its neighborhood gave it so far.
//!
//! ```text
//! image ──> column ──> residual ──> model ──────────> range coder ──> bytes
//!           levels,    steps off    small: counts      decisions
//!           sets of    prediction   dense: sums of
//!           returns                 logits
//! ```
//!
//! What they share stands here once: the column ([`column`]), closed-loop quantization ([`step`]), the arithmetic coder
//! of both adaptive tiers ([`range_coder`]).

pub(crate) mod column;
pub(crate) mod range_coder;
pub(crate) mod step;

pub use step::Step;
mod beam;
mod dense;
mod priors;
mod small;
mod surroundings;
mod walk;

pub use walk::Predictor;

/// Lab.
#[cfg(feature = "std")]
pub mod lab {
    use super::beam::{Beams, Filter};
    use super::column::Column;
    use super::dense::*;
    use super::range_coder::*;
    use super::small::SmallModel;
    use super::step::Step;
    use super::walk::*;
    use crate::image::{ImageView, ImageViewMut, Level};
    use std::vec::Vec;

    fn walk_of(step: Step, noise: u8, rows: usize, med: bool, max_level: u16) -> Walk {
        Walk { step, filter: Filter::new(step, noise), rows, max_level, predictor: if med { Predictor::MedianEdge } else { Predictor::West } }
    }
    pub struct M { d: DenseModel, s: SmallModel, pub dense: bool, pub med: bool }
    impl M {
        pub fn new(dense: bool) -> Self { Self { d: DenseModel::new(), s: SmallModel::new(), dense, med: false } }
        pub fn values(&self) -> Vec<i64> { if self.dense { self.d.logits.iter().map(|&v| v.into()).collect() } else { self.s.probabilities.iter().map(|&v| v.into()).collect() } }
        pub fn set(&mut self, v: &[i64]) { if self.dense { self.d.logits.iter_mut().zip(v).for_each(|(l, &v)| *l = v as i16); } else { self.s.probabilities.iter_mut().zip(v).for_each(|(l, &v)| *l = v as u16); } }
        pub fn slow(&mut self, by: u8) { self.d.rates = [8 + by, 8 + by]; self.s.rate = 5 + u32::from(by); }
        pub fn prepare(&mut self, step: Step, noise: u8) { self.d.prepare(step, noise); }
        pub fn encode<L: Level>(&mut self, image: ImageView<'_, L>, step: Step, noise: u8, out: &mut [u8]) -> usize {
            let walk = walk_of(step, noise, image.rows(), self.med, if L::BITS == 8 { 255 } else { 65535 });
            if self.dense { enc(&walk, &mut self.d, image, out) } else { enc(&walk, &mut self.s, image, out) }
        }
        pub fn decode(&mut self, code: &[u8], image: ImageViewMut<'_, u16>, step: Step, noise: u8) -> usize {
            let walk = walk_of(step, noise, image.as_view().rows(), self.med, 65535);
            if self.dense { dec(&walk, &mut self.d, code, image) } else { dec(&walk, &mut self.s, code, image) }
        }
    }
    fn enc<L: Level>(walk: &Walk, m: &mut impl Model, image: ImageView<'_, L>, out: &mut [u8]) -> usize {
        let mut coder = RangeEncoder::new(out);
        let mut beams = Beams::<8>::new();
        let mut column = Column::<8>::new();
        for c in 0..image.columns() {
            column.load(image, c);
            walk.column(m, &mut beams, &mut coder, &mut column);
        }
        coder.finish().unwrap()
    }
    fn dec(walk: &Walk, m: &mut impl Model, code: &[u8], mut image: ImageViewMut<'_, u16>) -> usize {
        let mut coder = RangeDecoder::new(code);
        let mut beams = Beams::<8>::new();
        let mut column = Column::<8>::new();
        for c in 0..image.columns() {
            walk.column(m, &mut beams, &mut coder, &mut column);
            column.store(&mut image, c);
        }
        coder.code_len()
    }
}
