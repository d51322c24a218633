//! How the priors of strips' begins are found: strips as a stream has them, coded by two models that go on from strip to
//! strip without forgetting, one for the first columns and one for the others. For `examples/train_strips.rs`, no promise is
//! made of it.

use std::vec;
use std::vec::Vec;

use super::ContextSettings;
use super::beam::Beams;
use super::column::Column;
use super::range_coder::RangeEncoder;
use super::step::Step;
use super::strip::{ENERGY, coarseness};
use super::train::{Learner, SmallLearner};
use crate::image::ImageView;

/// Bytes of a strip's code.
const STRIP_LEN: usize = 1375;
/// Rounds through all images, in pairs: each pair learns at half the rate of the one before.
const ROUNDS: u8 = 6;

/// Priors of first columns and of the others, from images of up to 64 rows, at steps of these levels, all of one coarseness.
#[must_use]
pub fn train_strips(images: &[ImageView<'_, u16>], steps: &[u16]) -> [Vec<i32>; 2] {
    // Contexts that never come up stay what they are in frames.
    let mut models = [0; 2].map(|_| SmallLearner::new());
    for model in &mut models {
        model.start(Step::LOSSLESS, 0);
    }
    let mut sums = models.each_mut().map(|model| vec![0_i64; model.values().len()]);
    let mut count = 0;
    for round in 0..ROUNDS {
        for step in steps.iter().filter_map(|&levels| Step::new(levels)) {
            for image in images {
                learn(&mut models, *image, step, round / 2);
                if round + 2 >= ROUNDS {
                    for (sums, model) in sums.iter_mut().zip(&mut models) {
                        sums.iter_mut().zip(model.values()).for_each(|(sum, value)| *sum += i64::from(value));
                    }
                    count += 1;
                }
            }
        }
    }
    sums.map(|sums| sums.into_iter().map(|sum| SmallLearner::prior((sum / count.max(1)) as i32)).collect())
}

fn learn([first, others]: &mut [SmallLearner; 2], image: ImageView<'_, u16>, step: Step, slower: u8) {
    let settings = ContextSettings::FINE.with_step(step);
    first.set(settings, slower);
    others.set(settings, slower);
    let walk = settings.walk::<SmallLearner>(image.rows(), u16::MAX);
    let mut out = vec![0; 1 << 16];
    let (mut beams, mut column) = (Beams::<8>::new(), Column::new());
    let mut coder = RangeEncoder::new(&mut out);
    for at in 0..image.columns() {
        column.load(image, at);
        if coder.mark().code_len() == 1 {
            walk.column(first, &mut beams, &mut coder, &mut column);
            beams.settle(ENERGY[coarseness(settings)]);
        } else {
            walk.column(others, &mut beams, &mut coder, &mut column);
        }
        if coder.mark().code_len() > STRIP_LEN {
            beams = Beams::new();
            coder = RangeEncoder::new(&mut out);
        }
    }
}
