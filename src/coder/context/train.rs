//! How the priors are found: coders that go through image after image without forgetting, and the mean of what they
//! then know. For `examples/train_priors.rs`, no promise is made of it.

use std::vec;
use std::vec::Vec;

use super::beam::Beams;
use super::column::Column;
use super::dense::DenseModel;
use super::range_coder::RangeEncoder;
use super::small::Counts;
use super::walk::Model;
use super::{ContextSettings, Step};
use crate::image::ImageView;

/// A model that is trained.
#[allow(private_bounds, reason = "the models there are")]
pub trait Learner: Model {
    /// One that knows nothing.
    fn ignorant() -> Self;
    /// Makes ready for a step; each `slower` halves the rate of learning.
    fn set(&mut self, settings: ContextSettings, slower: u8);
    /// What it knows.
    fn values(&mut self) -> Vec<i32>;
    /// A mean of values as a prior.
    fn prior(value: i32) -> i32;
}

/// The small tier's.
pub type SmallLearner = Counts<true>;
/// The dense tier's.
pub type DenseLearner = DenseModel;

impl Learner for SmallLearner {
    fn ignorant() -> Self {
        let mut model = Self::new();
        model.probabilities().for_each(|one| *one = 1 << 15);
        model
    }

    fn set(&mut self, settings: ContextSettings, slower: u8) {
        self.prepare(settings.step, settings.noise);
        self.set_slower(slower);
    }

    fn values(&mut self) -> Vec<i32> {
        self.probabilities().map(|&mut one| one.into()).collect()
    }

    fn prior(value: i32) -> i32 {
        value >> 8
    }
}

impl Learner for DenseModel {
    fn ignorant() -> Self {
        let mut model = Self::new();
        model.logits().fill(0);
        model
    }

    fn set(&mut self, settings: ContextSettings, slower: u8) {
        self.prepare(settings.step, settings.noise);
        self.rates = [256 >> slower; 2];
    }

    fn values(&mut self) -> Vec<i32> {
        self.logits().iter().map(|&logit| logit.into()).collect()
    }

    fn prior(value: i32) -> i32 {
        ((value + 128) >> 8).clamp(-128, 127)
    }
}

/// Rounds through all images at all steps, in pairs: each pair learns at half the rate of the one before.
const ROUNDS: u8 = 6;

/// Priors from images of up to 64 rows, at steps of these levels: the mean of what is known behind each image in the last
/// pair of rounds.
pub fn train<M: Learner>(images: &[ImageView<'_, u16>], steps: &[u16]) -> Vec<i32> {
    let mut model = M::ignorant();
    let (mut sums, mut count) = (vec![0; model.values().len()], 0);
    let mut out = vec![0; 1 << 20];
    for round in 0..ROUNDS {
        for step in steps.iter().filter_map(|&levels| Step::new(levels)) {
            for image in images {
                learn(&mut model, *image, step, round / 2, &mut out);
                if round + 2 >= ROUNDS {
                    sums.iter_mut().zip(model.values()).for_each(|(sum, value)| *sum += i64::from(value));
                    count += 1;
                }
            }
        }
    }
    sums.iter().map(|sum| M::prior((sum / count.max(1)) as i32)).collect()
}

fn learn<M: Learner>(model: &mut M, image: ImageView<'_, u16>, step: Step, slower: u8, out: &mut [u8]) {
    let settings = ContextSettings::FINE.with_step(step);
    model.set(settings, slower);
    let (mut beams, mut column) = (Beams::<8>::new(), Column::new());
    let walk = settings.walk::<M>(image.rows(), u16::MAX);
    let mut coder = RangeEncoder::new(out);
    for at in 0..image.columns() {
        column.load(image, at);
        walk.column(model, &mut beams, &mut coder, &mut column);
    }
}
