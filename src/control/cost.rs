//! What steps and strides do to what a turn takes.

use super::Budget;

/// What a turn takes beside one in steps of one level with all its columns: 2^-n of it, n in 1/256.
///
/// Measured on KITTI's HDL-64E (small tier, 2 mm to 31 cm): bytes go with the step to the power of -0.35, instructions with
/// that to the power of -0.2. Where that is not quite so, the next turn tells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Relative {
    halvings_q8: u32,
}

impl Relative {
    pub(super) fn of(budget: Budget, levels: u16, stride: u8) -> Self {
        let by_step_q8 = if matches!(budget, Budget::InstructionsATurn(_)) { 51 } else { 90 };
        // Columns farther apart are worth more each: half of them take 0.6 of the bytes.
        let by_stride_q8 = 190;
        let halvings = log2_q8(levels.into()) * by_step_q8 + log2_q8(stride.into()) * by_stride_q8;
        Self { halvings_q8: halvings >> 8 }
    }

    /// What this takes, of a turn that takes so much in the finest steps.
    pub(super) fn of_finest(self, fine_cost: u32) -> u32 {
        let (whole, part) = (self.halvings_q8 >> 8, self.halvings_q8 & 255);
        let halved = u64::from(fine_cost).checked_shr(whole).unwrap_or(0);
        // 2^-x between 0 and 1, by a straight line.
        (halved - ((halved * u64::from(part)) >> 9)) as u32
    }

    /// What a turn takes in the finest steps, of which this takes so much.
    pub(super) fn finest_of(self, cost: u32) -> u32 {
        let (whole, part) = (self.halvings_q8 >> 8, self.halvings_q8 & 255);
        let doubled = u64::from(cost).checked_shl(whole).unwrap_or(u64::MAX).min(u64::from(u32::MAX) << 8);
        (doubled * 512).checked_div(u64::from(512 - part)).map_or(0, |cost| cost.min(u32::MAX.into()) as u32)
    }
}

/// Logarithm of a number, x 256, between powers of two by a straight line; 0 for 0.
fn log2_q8(number: u32) -> u32 {
    let Some(whole) = number.checked_ilog2() else { return 0 };
    let part = (u64::from(number) << 8 >> whole) as u32 & 255;
    whole << 8 | part
}
