//! How the context coders go about an image.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use super::memory::{Outcome, choose, deliver};
use super::status::flicr_status;
use crate::coder::{ContextCoder, ContextSettings, Dense, Predictor, Small, Step};

/// A `flicr_predictor` as it comes from C.
pub type PredictorCode = u32;

/// What FLICR_CODER_SMALL and FLICR_CODER_DENSE predict a level from.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_predictor {
    /// The same beam's pixel before.
    West = 0,
    /// The median of what three neighbors say: sometimes a few percent less where columns are few.
    MedianEdge = 1,
}

/// How FLICR_CODER_SMALL and FLICR_CODER_DENSE go about an image. Filled by flicr_context_init; then change what you
/// like.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct flicr_context {
    /// Levels a step, 1 to 65535. 1: nothing is lost.
    pub step_levels: u32,
    /// 1: what is within 0.6 steps of its prediction takes its value, which saves a tenth of the bytes. 0: no point is
    /// more than half a step off.
    pub dead_zone: u32,
    /// Levels that are a beam's noise, not a surface, 0 to 255: about 4 cm, 0 where levels are as coarse as that. No
    /// level is lost by a wrong one, but bytes are.
    pub noise_levels: u32,
    /// What a level is predicted from.
    pub predictor: PredictorCode,
}

/// Most rows of an image that FLICR_CODER_SMALL and FLICR_CODER_DENSE take.
pub const FLICR_CONTEXT_ROWS_MAX: usize = 128;
/// Bytes of the state of FLICR_CODER_SMALL.
pub const FLICR_SMALL_STATE_LEN: usize = 2688;
/// Bytes of the state of FLICR_CODER_DENSE.
pub const FLICR_DENSE_STATE_LEN: usize = 5376;
/// Bytes that a payload of FLICR_CODER_SMALL or FLICR_CODER_DENSE takes at most besides its levels, once for each
/// FLICR_CONTEXT_BLOCK_LEN bytes of these.
pub const FLICR_CONTEXT_BLOCK_COST: usize = 6;
/// See FLICR_CONTEXT_BLOCK_COST.
pub const FLICR_CONTEXT_BLOCK_LEN: usize = 1_073_741_824;

/// Groups of eight rows.
const GROUPS: usize = FLICR_CONTEXT_ROWS_MAX / 8;
pub(super) type CSmall = Small<GROUPS>;
pub(super) type CDense = Dense<GROUPS>;

/// Fills a context coder's settings, for levels `level_m` meters apart that are to be kept in steps of `step_m` meters:
/// rounded to levels, one at least; 0 loses nothing.
///
/// With 8 bits, levels are max_range_m / 255 apart; on a grid, the configuration's step_m.
///
/// FLICR_STATUS_CONTEXT where level_m is not positive and finite, step_m is negative, or is more than 65535 levels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_context_init(
    level_m: f32,
    step_m: f32,
    out_context: *mut flicr_context,
) -> flicr_status {
    // SAFETY: the caller's promise about `out_context`.
    unsafe { deliver(out_context, |_| context(level_m, step_m)) }
}

fn context(level_m: f32, step_m: f32) -> Outcome<flicr_context> {
    let steps = step_m / level_m;
    // Neither holds for NaN.
    let is_sound = level_m > 0.0 && level_m < f32::INFINITY && step_m >= 0.0 && steps < 65_535.5;
    if !is_sound {
        return Err(flicr_status::Context);
    }
    let noise_levels = ContextSettings::of_levels(level_m).noise.into();
    // Levels as coarse as the noise have none.
    let noise_levels = if noise_levels > 1 { noise_levels } else { 0 };
    let step_levels = crate::kernel::to_index(steps + 0.5, 65_535).max(1);
    Ok(flicr_context { step_levels, dead_zone: 1, noise_levels, predictor: flicr_predictor::West as u32 })
}

impl flicr_context {
    pub(super) fn to_settings(self) -> Outcome<ContextSettings> {
        let otherwise = flicr_status::Context;
        let levels = u16::try_from(self.step_levels).map_err(|_| otherwise)?;
        let step = if self.dead_zone == 0 { Step::exact(levels) } else { Step::new(levels) };
        Ok(ContextSettings {
            step: step.ok_or(otherwise)?,
            noise: u8::try_from(self.noise_levels).map_err(|_| otherwise)?,
            predictor: choose(&[Predictor::West, Predictor::MedianEdge], self.predictor, otherwise)?,
        })
    }
}

/// A coder that is told its settings where it lies.
pub(super) trait SetsContext {
    fn set_context(&mut self, settings: ContextSettings);
}

impl<M, const N: usize> SetsContext for ContextCoder<M, N> {
    fn set_context(&mut self, settings: ContextSettings) {
        self.set(settings);
    }
}
