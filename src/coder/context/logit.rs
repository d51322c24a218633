//! Decisions by summed logits: the logistic function of a sum of a few numbers, one from each table of contexts, each
//! moved by how wrong the decision's probability was.

use super::dense::logistic_of;
use super::range_coder::BinaryCoder;

/// One decision, with a logit of each table that it looks at; `rate` is the shift of its error.
#[inline(always)]
pub(crate) fn decide<const N: usize>(
    coder: &mut impl BinaryCoder,
    logits: [&mut i16; N],
    rate: u32,
    decision: bool,
) -> bool {
    let one = logistic_of(logits.iter().map(|logit| i32::from(**logit)).sum());
    let decision = coder.decide(one, decision);
    let error = (i32::from(decision) << 16) - i32::from(one);
    let by = (error >> rate) as i16;
    for logit in logits {
        *logit = logit.saturating_add(by);
    }
    decision
}
