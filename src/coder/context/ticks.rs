//! When columns were fired: a sensor turns evenly, so that each tick is where the last ones say, rounded to a whole one; now
//! and then it is beside that.

use super::range_coder::BinaryCoder;

/// Fractions of a tick are of 10 bits.
const FRACTION_BITS: u32 = 10;
const HALF_TICK: i32 = 1 << (FRACTION_BITS - 1);
/// Where the turning must have been for a tick that was not the expected one: almost at the border.
const BORDER: i32 = 500;

/// Ticks so far, and which come next. Each is a number of ticks from the last, around the turn.
#[derive(Debug, Clone)]
pub(crate) struct TickTrack {
    /// Ticks from a column to the next.
    rate_q10: i32,
    /// How far the turning is beyond the last tick.
    beyond_q10: i32,
    /// By how near the expected place is to the border between two ticks.
    is_other: [u16; 3],
    /// By on which side of its tick it is.
    is_less: [u16; 2],
    is_far: u16,
}

impl TickTrack {
    /// Zeros: memory that has yet to be set up.
    pub(crate) const BLANK: Self = Self { rate_q10: 0, beyond_q10: 0, is_other: [0; 3], is_less: [0; 2], is_far: 0 };

    pub(crate) const fn new(rate_q10: u32) -> Self {
        Self {
            rate_q10: rate_q10.cast_signed(),
            beyond_q10: 0,
            is_other: [1311, 5243, 19_661],
            is_less: [57_344, 8192],
            is_far: 2048,
        }
    }

    /// In the inverse direction `step` is of no use, and what is given back counts; it may be any number.
    pub(crate) fn code(&mut self, coder: &mut impl BinaryCoder, step: u16) -> u16 {
        let due = self.beyond_q10 + self.rate_q10;
        let usual = ((due + HALF_TICK) >> FRACTION_BITS).clamp(0, u16::MAX.into()) as u16;
        let beyond = (due - (i32::from(usual) << FRACTION_BITS)).clamp(-HALF_TICK, HALF_TICK);
        let near_border = match beyond.unsigned_abs() {
            0..256 => 0,
            256..410 => 1,
            _ => 2,
        };
        if !learned(coder, &mut self.is_other[near_border], step != usual) {
            self.beyond_q10 = beyond;
            return usual;
        }
        let is_less = learned(coder, &mut self.is_less[usize::from(beyond >= 0)], step < usual);
        let mut distance = step.abs_diff(usual).max(1);
        distance = if learned(coder, &mut self.is_far, distance > 1) { raw_distance(coder, distance) } else { 1 };
        self.beyond_q10 = if is_less { BORDER } else { -BORDER };
        if is_less { usual.wrapping_sub(distance) } else { usual.wrapping_add(distance) }
    }
}

fn raw_distance(coder: &mut impl BinaryCoder, distance: u16) -> u16 {
    let places = coder.raw(4, distance.ilog2());
    (1 << places | coder.raw(places, u32::from(distance) & ((1 << places) - 1))) as u16
}

/// A decision whose probability follows what it was.
fn learned(coder: &mut impl BinaryCoder, one: &mut u16, decision: bool) -> bool {
    let decision = coder.decide(*one, decision);
    if decision {
        *one += (65_535 - *one) >> 4;
    } else {
        *one -= *one >> 4;
    }
    decision
}

/// Ticks from a column to the next, in the long run.
#[derive(Debug, Clone)]
pub(crate) struct TickRate {
    rate_q14: i32,
    /// Steps so far, up to as many as count.
    steps: i32,
}

/// So many of the last steps count.
const STEPS_MAX: i32 = 256;

impl TickRate {
    pub(crate) const NEW: Self = Self { rate_q14: 0, steps: 0 };

    pub(crate) fn take(&mut self, step: u16) {
        self.steps = (self.steps + 1).min(STEPS_MAX);
        let off = (i32::from(step) << 14) - self.rate_q14;
        self.rate_q14 += off.checked_div(self.steps).unwrap_or(0);
    }

    pub(crate) const fn q10(&self) -> u32 {
        self.rate_q14.unsigned_abs() >> 4
    }

    /// The nearest whole number of ticks.
    pub(crate) const fn ticks(&self) -> u16 {
        ((self.q10() + 512) >> FRACTION_BITS) as u16
    }
}
