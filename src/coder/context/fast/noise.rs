//! The sensor's noise: predictions follow it only part of the way.

use super::super::step::Step;

/// How a row's next level follows from its last ones: noise is filtered out, edges are not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Filter {
    /// Sixteenths of the way from the prediction to the level.
    gain: i16,
    /// Larger residuals are edges.
    edge: u16,
}

impl Filter {
    /// For steps of `step` and noise of up to `noise` levels; 0 is without a filter.
    pub(crate) const fn new(step: Step, noise: u8) -> Self {
        let (step, noise) = (step.levels(), noise as u16);
        let gain = match noise {
            0 => 16,
            _ if step as u32 * 4 <= 3 * noise as u32 => 11,
            _ if step as u32 <= 3 * noise as u32 => 14,
            _ => 16,
        };
        // Without a filter all are edges but residuals of 0, which leave no more to follow.
        let edge = if gain == 16 { 0 } else { noise / step };
        Self { gain, edge: if edge < 2 && gain < 16 { 2 } else { edge } }
    }

    /// What is predicted after a residual of `steps` from `predicted` to `level`.
    #[inline(always)]
    pub(crate) fn next(self, steps: u16, predicted: u16, level: u16) -> u16 {
        // Two steps with a filter or the noise are at most 1530 levels: sixteen times that fits.
        let off = level.wrapping_sub(predicted).cast_signed();
        let part = off.wrapping_mul(self.gain).wrapping_add(8) >> 4;
        let near = predicted.wrapping_add(part.cast_unsigned());
        let edge = u16::from(steps > self.edge).wrapping_neg();
        (level & edge) | (near & !edge)
    }
}
