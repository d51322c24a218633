//! The small tier: each decision has a class, and each class the probability that its last decisions had.
//!
//! Source: LZMA's adaptive binary probabilities (Pavlov), of 16 bits.

use super::range_coder::BinaryCoder;
use super::step::Step;
use super::surroundings::{
    CalmSurroundings, Flag, GroupSurroundings, SetSurroundings, Surroundings, bits, half_octave, trit,
};
use super::walk::Model;

/// Largest exponent of a residual: residuals have at most 16 bits.
const EXPONENT_MAX: usize = 15;

/// Classes of energy.
const ENERGIES: usize = 16;
/// Exponents that are told apart; larger ones count as the largest of these.
const EXPONENTS: usize = 10;

// Where each table begins, and behind the last.
const SAME: usize = 0;
const OCCUPIED: usize = SAME + 36;
const ACTIVE: usize = OCCUPIED + 32;
const ZERO: usize = ACTIVE + 4 * 12;
const SIGN: usize = ZERO + ENERGIES * 4;
const EXPONENT: usize = SIGN + 3 * 3 * 3;
const MANTISSA: usize = EXPONENT + ENERGIES * EXPONENTS;

/// Probabilities in all.
pub(crate) const PROBABILITIES: usize = MANTISSA + EXPONENTS;

/// Probabilities before anything was coded, out of 2^8, less one half.
pub(crate) static PRIORS: [u8; PROBABILITIES] = super::priors::SMALL;

/// The probabilities and how fast they learn.
#[derive(Debug, Clone)]
pub struct SmallModel {
    /// Of a 1, out of 2^16.
    pub(crate) probabilities: [u16; PROBABILITIES],
    /// Beyond so many levels from the prediction a level is far.
    far: i32,
    /// A decision moves its probability by 2^-rate of the way: zeros and signs, where noise makes them even, and all
    /// else.
    pub(crate) rates: [u8; 2],
}

/// Decisions that noise makes nearly even learn at the first rate.
const NOISY: usize = 0;
const STEADY: usize = 1;

impl SmallModel {
    pub(crate) const fn new() -> Self {
        Self { probabilities: [0; PROBABILITIES], far: 0, rates: [5, 5] }
    }

    /// Forgets all but the priors.
    pub(crate) fn start(&mut self, step: Step, noise: u8) {
        for (probability, &prior) in self.probabilities.iter_mut().zip(&PRIORS) {
            *probability = u16::from(prior) << 8 | 1 << 7;
        }
        self.prepare(step, noise);
    }

    /// Makes ready for a step, with the probabilities as they are.
    pub(crate) fn prepare(&mut self, step: Step, noise: u8) {
        self.far = 2 * i32::from(step.levels());
        self.rates = if 4 * u32::from(step.levels()) <= u32::from(noise) { [6, 5] } else { [5, 5] };
    }

    #[inline(always)]
    fn decide(&mut self, coder: &mut impl BinaryCoder, rate: usize, context: usize, decision: bool) -> bool {
        let Some(one) = self.probabilities.get_mut(context) else { return false };
        let decision = coder.decide(*one, decision);
        let rate = self.rates[rate];
        if decision {
            *one += (((1 << 16) - u32::from(*one)) >> rate) as u16;
        } else {
            *one -= *one >> rate;
        }
        decision
    }

    /// Whether `level` lies far below the prediction (0), far above (1), or neither (2).
    #[inline(always)]
    fn side(&self, level: u16, predicted: u16) -> usize {
        match i32::from(level) - i32::from(predicted) {
            off if off < -self.far => 0,
            off if off > self.far => 1,
            _ => 2,
        }
    }
}

impl Model for SmallModel {
    const CALM_ENERGY: u32 = 14;

    fn same(&mut self, coder: &mut impl BinaryCoder, at: &GroupSurroundings, decision: bool) -> bool {
        self.decide(coder, STEADY, SAME + at.class(), decision)
    }

    fn occupied(&mut self, coder: &mut impl BinaryCoder, at: &SetSurroundings, decision: bool) -> bool {
        self.decide(coder, STEADY, OCCUPIED + at.class(), decision)
    }

    fn active(&mut self, coder: &mut impl BinaryCoder, at: &CalmSurroundings, decision: bool) -> bool {
        let energy = 4 * at.energy / (Self::CALM_ENERGY * at.returns);
        let near = bits([at.north, at.south_west]) * 3 + trit(at.active_above);
        self.decide(coder, STEADY, ACTIVE + energy.min(3) as usize * 12 + near, decision)
    }

    #[inline(always)]
    fn residual(&mut self, coder: &mut impl BinaryCoder, at: &Surroundings, residual: i32) -> i32 {
        let energy = half_octave(at.energy()).min(ENERGIES - 1);
        let known = match at.flag {
            Flag::None | Flag::Calm => usize::from(at.own.age() > 3),
            Flag::Seen => 2,
            Flag::Open | Flag::Due => 3,
        };
        if at.flag != Flag::Due && !self.decide(coder, NOISY, ZERO + energy * 4 + known, residual != 0) {
            return 0;
        }
        let side = self.side(at.south_west.level, at.predicted);
        let signs = ((at.own.sign + 1) * 3 + at.north.size.signum() + 1) as usize;
        let is_negative = self.decide(coder, NOISY, SIGN + signs * 3 + side, residual < 0);
        let distance = residual.unsigned_abs().max(1);
        let exponent = self.exponent(coder, energy, distance.ilog2() as usize);
        let distance = self.mantissa(coder, exponent, distance).cast_signed();
        if is_negative { -distance } else { distance }
    }
}

impl SmallModel {
    /// The exponent in unary: at each, whether it is larger.
    #[inline(always)]
    fn exponent(&mut self, coder: &mut impl BinaryCoder, energy: usize, exponent: usize) -> usize {
        let mut found = 0;
        while found < EXPONENT_MAX {
            let context = EXPONENT + energy * EXPONENTS + found.min(EXPONENTS - 1);
            if !self.decide(coder, STEADY, context, exponent > found) {
                break;
            }
            found += 1;
        }
        found
    }

    /// The bits below the highest, of which the first is modelled.
    #[inline(always)]
    fn mantissa(&mut self, coder: &mut impl BinaryCoder, exponent: usize, distance: u32) -> u32 {
        let Some(left) = exponent.checked_sub(1) else { return 1 };
        let context = MANTISSA + exponent.min(EXPONENTS) - 1;
        let second = self.decide(coder, STEADY, context, distance >> left & 1 == 1);
        (2 | u32::from(second)) << left | coder.raw(left as u32, distance & ((1 << left) - 1))
    }
}
