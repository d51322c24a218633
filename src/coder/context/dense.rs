//! The dense tier: each decision's probability is the logistic function of a sum of two to six logits, one from each
//! of several small tables of contexts. Each decision moves all logits that it used.
//!
//! Source: the mixing of contexts in the logistic domain is that of PAQ (Mahoney, 2005), with all weights one, so that
//! the tables themselves are what is learned.

use super::range_coder::BinaryCoder;
use super::step::Step;
use super::surroundings::{
    CalmSurroundings, GroupSurroundings, SetSurroundings, Surroundings, bits, half_octave, octave,
};
use super::walk::Model;

/// Largest exponent of a residual: residuals have at most 16 bits.
const EXPONENT_MAX: usize = 15;

/// Classes of energy.
const ENERGIES: usize = 20;
/// Exponents that are told apart; larger ones count as the largest of these.
const EXPONENTS: usize = 12;
/// The same in tables that tell less apart.
const FEW_EXPONENTS: usize = 8;
/// Classes of another level's exponent, seen from an exponent.
const RELATIONS: usize = 7;

// Where each table begins, and behind the last.
const SAME: usize = 0;
const SAME_PLACE: usize = SAME + 36;
const OCCUPIED: usize = SAME_PLACE + 8 * 8;
const OCCUPIED_FAR: usize = OCCUPIED + 32;
const OCCUPIED_ENERGY: usize = OCCUPIED_FAR + 16;
const ZERO: usize = OCCUPIED_ENERGY + 8 * 2;
const ZERO_APART: usize = ZERO + ENERGIES;
const ZERO_FAR: usize = ZERO_APART + 8 * 8;
const ZERO_SIDES: usize = ZERO_FAR + 3 * 3 * 3 * 4;
const ZERO_SIZES: usize = ZERO_SIDES + 6 * 6 * 3;
const ZERO_AGES: usize = ZERO_SIZES + 8 * 8;
const SIGN: usize = ZERO_AGES + 8 * 8;
const SIGN_SIDES: usize = SIGN + 5 * 3;
const SIGN_FAR: usize = SIGN_SIDES + 6 * 6;
const SIGN_OTHER: usize = SIGN_FAR + 3 * 3 * 3;
const SIGN_LAST: usize = SIGN_OTHER + 6;
const EXPONENT: usize = SIGN_LAST + 3 * 3 * 8;
const EXPONENT_SOUTH_WEST: usize = EXPONENT + ENERGIES * EXPONENTS;
const EXPONENT_NORTH: usize = EXPONENT_SOUTH_WEST + RELATIONS * FEW_EXPONENTS;
const EXPONENT_OTHER: usize = EXPONENT_NORTH + RELATIONS * FEW_EXPONENTS;
const EXPONENT_PLACE: usize = EXPONENT_OTHER + RELATIONS * FEW_EXPONENTS;
const EXPONENT_SIZES: usize = EXPONENT_PLACE + 4 * 4 * FEW_EXPONENTS;
const MANTISSA: usize = EXPONENT_SIZES + 6 * 6 * FEW_EXPONENTS;
const MANTISSA_SIDES: usize = MANTISSA + 4 * EXPONENTS;

/// Logits in all.
pub(crate) const LOGITS: usize = MANTISSA_SIDES + 3 * 3 * 3 * 4;

/// Logits before anything was coded, in 1/16 nats.
pub(crate) static PRIORS: [i8; LOGITS] = super::priors::DENSE;

/// Ages in eight classes.
const AGE_CLASSES: [u8; 16] = [0, 1, 2, 3, 3, 4, 4, 5, 5, 5, 6, 6, 6, 6, 6, 7];

/// The logistic function at the middles of 1024 intervals of 1/64 nat around 0, out of 2^16, and no nearer to 0 or 1
/// than 24.
static LOGISTIC: [u16; 1024] = logistic();

const fn logistic() -> [u16; 1024] {
    let (mut table, mut at) = ([0; 1024], 0);
    while at < table.len() {
        let nats = (at as f64 - 511.5) / 64.0;
        let one = (65_536.0 / (1.0 + exp(-nats)) + 0.5) as u16;
        table[at] = if one < 24 {
            24
        } else if one > 65_512 {
            65_512
        } else {
            one
        };
        at += 1;
    }
    table
}

/// e^x for |x| up to 8, to 2^-40: core has none that is const. Six terms of the series at x / 1024, squared ten times.
const fn exp(x: f64) -> f64 {
    let y = x / 1024.0;
    let mut power = 1.0 + y * (1.0 + y / 2.0 * (1.0 + y / 3.0 * (1.0 + y / 4.0 * (1.0 + y / 5.0))));
    let mut squared = 0;
    while squared < 10 {
        power *= power;
        squared += 1;
    }
    power
}

/// The logits and how fast they learn.
#[derive(Debug, Clone)]
pub struct DenseModel {
    /// 1/4096 nats.
    pub(crate) logits: [i16; LOGITS],
    /// 2^16 / step, for distances in steps without a division.
    steps_per_level: u32,
    /// Shifts of the error: of zeros and signs, where noise makes them even, and of all else.
    pub(crate) rates: [u8; 2],
}

/// Decisions that noise makes nearly even learn at the first rate.
const NOISY: usize = 0;
const STEADY: usize = 1;

impl DenseModel {
    pub(crate) const fn new() -> Self {
        Self { logits: [0; LOGITS], steps_per_level: 0, rates: [8, 8] }
    }

    /// Forgets all but the priors.
    pub(crate) fn start(&mut self, step: Step, noise: u8) {
        for (logit, &prior) in self.logits.iter_mut().zip(&PRIORS) {
            *logit = i16::from(prior) << 8;
        }
        self.prepare(step, noise);
    }

    /// Makes ready for a step, with the logits as they are.
    pub(crate) fn prepare(&mut self, step: Step, noise: u8) {
        self.steps_per_level = (1 << 16) / u32::from(step.levels());
        self.rates = if 4 * u32::from(step.levels()) <= u32::from(noise) { [9, 8] } else { [8, 8] };
    }

    #[inline(always)]
    fn decide<const N: usize>(
        &mut self,
        coder: &mut impl BinaryCoder,
        rate: usize,
        contexts: [usize; N],
        decision: bool,
    ) -> bool {
        let logit = |at: usize| self.logits.get(at).map_or(0, |&logit| i32::from(logit));
        let sum = contexts.into_iter().map(logit).sum::<i32>();
        let one = LOGISTIC[((sum + (1 << 15)) >> 6).clamp(0, 1023) as usize];
        let decision = coder.decide(one, decision);
        let error = (i32::from(decision) << 16) - i32::from(one);
        let by = (error >> self.rates[rate]) as i16;
        for at in contexts {
            if let Some(logit) = self.logits.get_mut(at) {
                *logit = logit.saturating_add(by);
            }
        }
        decision
    }

    /// Where `level` lies, seen from `predicted`.
    #[inline(always)]
    fn apart(&self, level: u16, predicted: u16) -> Apart {
        let distance = u32::from(level.abs_diff(predicted));
        let half_steps = (u64::from(2 * distance) * u64::from(self.steps_per_level)) >> 16;
        Apart { is_below: level < predicted, half_steps: half_steps as u32 }
    }
}

/// On which side of the prediction another level lies, and how far.
#[derive(Debug, Clone, Copy)]
struct Apart {
    is_below: bool,
    half_steps: u32,
}

impl Apart {
    /// Six classes: less than one step, less than six, more; below (2, 1, 0) and not (3, 4, 5).
    #[inline(always)]
    fn side(self) -> usize {
        let far = usize::from(self.half_steps >= 2) + usize::from(self.half_steps >= 12);
        if self.is_below { 2 - far } else { 3 + far }
    }

    /// Whole steps, where it lies on the side of the residual; 0 on the other.
    #[inline(always)]
    fn steps(self, is_negative: bool) -> u32 {
        if self.is_below == is_negative { self.half_steps / 2 } else { 0 }
    }
}

/// The exponent of a level's distance (`size` bits), seen from the exponent that is asked for.
#[inline(always)]
fn relation(size: usize, exponent: usize) -> usize {
    if size == 0 { 0 } else { (size.min(EXPONENTS - 1) + 2).saturating_sub(exponent).clamp(1, 6) }
}

#[inline(always)]
fn sign(sign: i8) -> usize {
    (sign.signum() + 1) as usize
}

#[inline(always)]
fn size(size: i8, max: u8) -> usize {
    size.unsigned_abs().min(max).into()
}

/// What the decisions of one residual share.
struct Pixel<'a> {
    at: &'a Surroundings,
    energy: usize,
    north: Apart,
    south_west: Apart,
    other: Apart,
}

impl Model for DenseModel {
    /// Zeros in all contexts cost less than a flag for four of them.
    const CALM_ENERGY: u32 = 0;

    fn same(&mut self, coder: &mut impl BinaryCoder, at: &GroupSurroundings, decision: bool) -> bool {
        let energy = octave(u32::from(at.energy) / 8).min(7);
        self.decide(coder, STEADY, [SAME + at.class(), SAME_PLACE + at.eighth * 8 + energy], decision)
    }

    fn occupied(&mut self, coder: &mut impl BinaryCoder, at: &SetSurroundings, decision: bool) -> bool {
        let energy = octave(u32::from(at.energy) / 8).min(7);
        let contexts = [
            OCCUPIED + at.class(),
            OCCUPIED_FAR + bits([at.west, at.north2, at.north_west, at.west3]),
            OCCUPIED_ENERGY + energy * 2 + usize::from(at.west),
        ];
        self.decide(coder, STEADY, contexts, decision)
    }

    fn active(&mut self, _: &mut impl BinaryCoder, _: &CalmSurroundings, _: bool) -> bool {
        true
    }

    #[inline(always)]
    fn residual(&mut self, coder: &mut impl BinaryCoder, at: &Surroundings, residual: i32) -> i32 {
        let pixel = Pixel {
            at,
            energy: half_octave(at.energy()).min(ENERGIES - 1),
            north: self.apart(at.north.level, at.predicted),
            south_west: self.apart(at.south_west.level, at.predicted),
            other: self.apart(at.own.other, at.predicted),
        };
        if !self.is_not_zero(coder, &pixel, residual != 0) {
            return 0;
        }
        let is_negative = self.is_negative(coder, &pixel, residual < 0);
        let others = [pixel.north, pixel.south_west, pixel.other].map(|apart| apart.steps(is_negative));
        let distance = residual.unsigned_abs().max(1);
        let exponent = self.exponent(coder, &pixel, others, distance.ilog2() as usize);
        let distance = self.mantissa(coder, exponent, others, distance).cast_signed();
        if is_negative { -distance } else { distance }
    }
}

impl DenseModel {
    #[inline(always)]
    fn is_not_zero(&mut self, coder: &mut impl BinaryCoder, pixel: &Pixel<'_>, decision: bool) -> bool {
        let Surroundings { own, north, north2, south_west2, quarter, .. } = *pixel.at;
        let class = |age: u8| usize::from(AGE_CLASSES[usize::from(age) % 16]);
        let steps = [pixel.north, pixel.south_west].map(|apart| octave(apart.half_steps).min(7));
        let far = [north2, own, south_west2].map(|beam| size(beam.size, 2));
        let contexts = [
            ZERO + pixel.energy,
            ZERO_APART + steps[0] * 8 + steps[1],
            ZERO_FAR + ((far[0] * 3 + far[1]) * 3 + far[2]) * 4 + quarter,
            ZERO_SIDES + (pixel.north.side() * 6 + pixel.south_west.side()) * 3 + sign(own.size),
            ZERO_SIZES + size(north.size, 7) * 8 + size(own.size, 7),
            ZERO_AGES + class(own.age()) * 8 + class(own.period()),
        ];
        self.decide(coder, NOISY, contexts, decision)
    }

    #[inline(always)]
    fn is_negative(&mut self, coder: &mut impl BinaryCoder, pixel: &Pixel<'_>, decision: bool) -> bool {
        let Surroundings { own, north, north2, south_west, south_west2, .. } = *pixel.at;
        let contexts = [
            SIGN + (own.size.clamp(-2, 2) + 2) as usize * 3 + sign(north.size),
            SIGN_SIDES + pixel.south_west.side() * 6 + pixel.north.side(),
            SIGN_FAR + (sign(south_west.size) * 3 + sign(south_west2.size)) * 3 + sign(north2.size),
            SIGN_OTHER + pixel.other.side(),
            SIGN_LAST + (sign(own.sign) * 3 + sign(north.sign)) * 8 + usize::from(own.age().min(7)),
        ];
        self.decide(coder, NOISY, contexts, decision)
    }

    /// The exponent in unary: at each, whether it is larger.
    #[inline(always)]
    fn exponent(
        &mut self,
        coder: &mut impl BinaryCoder,
        pixel: &Pixel<'_>,
        others: [u32; 3],
        exponent: usize,
    ) -> usize {
        let [north, south_west, other] = others.map(octave);
        let place = EXPONENT_PLACE + (pixel.at.quarter * 4 + (pixel.energy / 4).min(3)) * FEW_EXPONENTS;
        let sizes = size(pixel.at.north.size, 5) * 6 + size(pixel.at.own.size, 5);
        let mut found = 0;
        while found < EXPONENT_MAX {
            let k = found.min(EXPONENTS - 1);
            let few = found.min(FEW_EXPONENTS - 1);
            let contexts = [
                EXPONENT + pixel.energy * EXPONENTS + k,
                EXPONENT_SOUTH_WEST + relation(south_west, k) * FEW_EXPONENTS + few,
                EXPONENT_NORTH + relation(north, k) * FEW_EXPONENTS + few,
                EXPONENT_OTHER + relation(other, k) * FEW_EXPONENTS + few,
                place + few,
                EXPONENT_SIZES + sizes * FEW_EXPONENTS + few,
            ];
            if !self.decide(coder, STEADY, contexts, exponent > found) {
                break;
            }
            found += 1;
        }
        found
    }

    /// The bits below the highest: the first two modelled, and more as long as they are those of another level.
    #[inline(always)]
    fn mantissa(&mut self, coder: &mut impl BinaryCoder, exponent: usize, others: [u32; 3], distance: u32) -> u32 {
        let k = exponent.min(EXPONENTS - 1);
        let mut matches = others.map(|other| octave(other) == exponent + 1);
        let (mut left, mut found, mut node) = (exponent as u32, 1, 0);
        while left > 0 && (node < 3 || matches.contains(&true)) {
            left -= 1;
            let bit_of = |at: usize| if matches[at] { (others[at] >> left & 1) as usize } else { 2 };
            let theirs = [bit_of(0), bit_of(1), bit_of(2)];
            let sides = (theirs[2] * 3 + theirs[0]) * 3 + theirs[1];
            let contexts = [MANTISSA + k * 4 + node, MANTISSA_SIDES + sides * 4 + node];
            let bit = self.decide(coder, STEADY, contexts, distance >> left & 1 == 1);
            found = found << 1 | u32::from(bit);
            for (matches, theirs) in matches.iter_mut().zip(theirs) {
                *matches &= theirs == usize::from(bit);
            }
            node = if node == 0 { 1 + usize::from(bit) } else { 3 };
        }
        found << left | coder.raw(left, distance & ((1 << left) - 1))
    }
}
