//! The small tier: each decision has a class, and each class the probability that its last decisions had.

use super::range_coder::BinaryCoder;
use super::surroundings::{CalmSurroundings, Flag, GroupSurroundings, SetSurroundings, Surroundings, bits, trit};
use super::surroundings::half_octave;
use super::walk::Model;

const EXPONENT_MAX: usize = 15;
const ENERGIES: usize = 16;
const EXPONENTS: usize = 10;

const SAME: usize = 0;
const OCCUPIED: usize = SAME + 36;
const ACTIVE: usize = OCCUPIED + 32;
const ZERO: usize = ACTIVE + 4 * 12;
const SIGN: usize = ZERO + ENERGIES * 4;
const EXPONENT: usize = SIGN + 3 * 3;
const MANTISSA: usize = EXPONENT + ENERGIES * EXPONENTS;

/// Probabilities in all.
pub(crate) const PROBABILITIES: usize = MANTISSA + EXPONENTS;

/// Probabilities before anything was coded, out of 2^8, less one half.
pub(crate) static PRIORS: [u8; PROBABILITIES] = *super::priors::SMALL;

/// Each decision moves its probability by 1/2^5 of the way.
const RATE: u32 = 5;

#[derive(Debug, Clone)]
pub(crate) struct SmallModel {
    /// Out of 2^16.
    pub(crate) probabilities: [u16; PROBABILITIES],
    pub(crate) rate: u32,
}

impl SmallModel {
    pub(crate) const fn new() -> Self {
        Self { probabilities: [1 << 15; PROBABILITIES], rate: RATE }
    }

    /// Forgets all but the priors.
    pub(crate) fn start(&mut self) {
        for (probability, &prior) in self.probabilities.iter_mut().zip(&PRIORS) {
            *probability = u16::from(prior) << 8 | 1 << 7;
        }
    }

    #[inline(always)]
    fn decide(&mut self, coder: &mut impl BinaryCoder, context: usize, decision: bool) -> bool {
        let Some(one) = self.probabilities.get_mut(context) else { return false };
        let decision = coder.decide(*one, decision);
        if decision {
            *one += ((1 << 16) - u32::from(*one) >> self.rate) as u16;
        } else {
            *one -= *one >> self.rate;
        }
        decision
    }
}

impl Model for SmallModel {
    const CALM_ENERGY: u32 = 14;

    fn same(&mut self, coder: &mut impl BinaryCoder, at: &GroupSurroundings, decision: bool) -> bool {
        self.decide(coder, SAME + at.class(), decision)
    }

    fn occupied(&mut self, coder: &mut impl BinaryCoder, at: &SetSurroundings, decision: bool) -> bool {
        self.decide(coder, OCCUPIED + at.class(), decision)
    }

    fn active(&mut self, coder: &mut impl BinaryCoder, at: &CalmSurroundings, decision: bool) -> bool {
        let energy = (4 * at.energy / (Self::CALM_ENERGY * at.returns)) as usize;
        let near = bits([at.north, at.south_west]) * 3 + trit(at.active_above);
        self.decide(coder, ACTIVE + energy.min(3) * 12 + near, decision)
    }

    #[inline(always)]
    fn residual(&mut self, coder: &mut impl BinaryCoder, at: &Surroundings, residual: i32) -> i32 {
        let energy = half_octave(at.energy()).min(ENERGIES - 1);
        let known = match at.flag {
            Flag::None | Flag::Calm => usize::from(at.own.age() > 3),
            Flag::Seen => 2,
            Flag::Open | Flag::Due => 3,
        };
        if at.flag != Flag::Due && !self.decide(coder, ZERO + energy * 4 + known, residual != 0) {
            return 0;
        }
        let signs = (at.own.sign + 1) * 3 + at.north.size.signum() + 1;
        let is_negative = self.decide(coder, SIGN + signs as usize, residual < 0);
        let distance = residual.unsigned_abs().max(1);
        let exponent = distance.ilog2() as usize;
        let mut found = 0;
        while found < EXPONENT_MAX {
            let context = EXPONENT + energy * EXPONENTS + found.min(EXPONENTS - 1);
            if !self.decide(coder, context, exponent > found) {
                break;
            }
            found += 1;
        }
        let mut distance = distance;
        if found > 0 {
            let mut left = found as u32 - 1;
            let high = self.decide(coder, MANTISSA + found.min(EXPONENTS) - 1, distance >> left & 1 == 1);
            let low = coder.raw(left, distance & ((1 << left) - 1));
            distance = (2 | u32::from(high)) << left | low;
            left = 0;
            let _ = left;
        } else {
            distance = 1;
        }
        if is_negative { -(distance as i32) } else { distance as i32 }
    }
}
