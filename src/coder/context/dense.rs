//! The dense tier: each decision's probability is the logistic function of a sum of two to six logits, one from each
//! of several small tables of contexts. Each decision moves all logits that it used.
//!
//! Source: the mixing of contexts in the logistic domain is that of PAQ (Mahoney, 2005), with all weights one, so that
//! the tables themselves are what is learned.

use core::cell::Cell;

use super::beam::{ABOVE, Beam};
use super::range_coder::BinaryCoder;
use super::step::{Residual, Step};
use super::surroundings::{
    CalmSurroundings, GroupSurroundings, SetSurroundings, Surroundings, bits, half_octave, octave,
};
use super::walk::Model;

/// Largest exponent of a residual: residuals have at most 16 bits.
const EXPONENT_MAX: usize = 15;

/// Classes of energy, and in tables that tell less apart.
const ENERGIES: usize = 20;
const FEW_ENERGIES: usize = ENERGIES / 2;
const LEAST_ENERGIES: usize = ENERGIES / 4;
/// Exponents that are told apart; larger ones count as the largest of these.
const EXPONENTS: usize = 12;
/// The same in the table that tells energies apart, too.
const ENERGY_EXPONENTS: usize = 10;
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
const ACTIVE: usize = OCCUPIED_ENERGY + 8 * 2;
const ACTIVE_AGES: usize = ACTIVE + 4 * 3;
const ACTIVE_SIDES: usize = ACTIVE_AGES + 8 * 8;
const ZERO: usize = ACTIVE_SIDES + 6 * 6;
const ZERO_APART: usize = ZERO + FEW_ENERGIES * 3;
const ZERO_FAR: usize = ZERO_APART + 8 * 8;
const ZERO_SIDES: usize = ZERO_FAR + 3 * 3 * 3 * 4;
const ZERO_SIZES: usize = ZERO_SIDES + 6 * 6 * 3;
const ZERO_AGES: usize = ZERO_SIZES + 5 * 5;
const SIGN: usize = ZERO_AGES + 8 * 8;
const SIGN_SIDES: usize = SIGN + 5 * 3;
const SIGN_FAR: usize = SIGN_SIDES + 6 * 6;
const SIGN_OTHER: usize = SIGN_FAR + 3 * 3 * 3;
const SIGN_LAST: usize = SIGN_OTHER + 6;
const EXPONENT: usize = SIGN_LAST + 3 * 3 * 8;
const EXPONENT_SOUTH_WEST: usize = EXPONENT + FEW_ENERGIES * ENERGY_EXPONENTS;
const EXPONENT_NORTH: usize = EXPONENT_SOUTH_WEST + RELATIONS * FEW_EXPONENTS;
const EXPONENT_OTHER: usize = EXPONENT_NORTH + RELATIONS * FEW_EXPONENTS;
const EXPONENT_SIZES: usize = EXPONENT_OTHER + RELATIONS * FEW_EXPONENTS;
const MANTISSA: usize = EXPONENT_SIZES + 6 * 6 * FEW_EXPONENTS;
const MANTISSA_SIDES: usize = MANTISSA + 4 * EXPONENTS;
const MANTISSA_ENERGY: usize = MANTISSA_SIDES + 3 * 3 * 3 * 4;

/// No other level has the bits so far.
const MANTISSA_NO_SIDE: usize = 26;

/// Logits in all.
pub(crate) const LOGITS: usize = MANTISSA_ENERGY + LEAST_ENERGIES * 3 * 4;

/// The same with those that no table has: so many that the masks of contexts lead to one.
const ROOM: usize = LOGITS + 8;

/// Logits before anything was coded, in 1/16 nats.
pub(crate) static PRIORS: [i8; LOGITS] = super::priors::DENSE;

/// Ages in eight classes.
const AGE_CLASSES: [u8; 16] = [0, 1, 2, 3, 3, 4, 4, 5, 5, 5, 6, 6, 6, 6, 6, 7];

/// The logistic function at the middles of 256 intervals of 1/16 nat around 0, out of 2^16, and no nearer to 0 or 1
/// than 24.
static LOGISTIC: [u16; 256] = logistic();

const fn logistic() -> [u16; 256] {
    let (mut table, mut at) = ([0; 256], 0);
    while at < table.len() {
        let nats = (at as f64 - 127.5) / 16.0;
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
    logits: [i16; ROOM],
    /// 2^16 / step, for distances in steps without a division.
    steps_per_level: u32,
    /// By which errors move logits, in 2^-16: of zeros and signs, and of all else.
    pub(crate) rates: [i16; 2],
    /// Rows have a common flag where their mean energy is less than this.
    calm_energy: u16,
}

/// Decisions that noise makes nearly even learn at the first rate.
const NOISY: usize = 0;
const STEADY: usize = 1;

/// Rates by the step: where noise makes nearly all of a residual, where it is filtered well, a little, and not.
const RATES: [[i16; 2]; 4] = [[64, 128], [184, 184], [208, 208], [256, 256]];

impl DenseModel {
    /// All zeros: memory that has yet to be set up.
    pub(crate) const fn new() -> Self {
        Self { logits: [0; ROOM], steps_per_level: 0, rates: [0; 2], calm_energy: 0 }
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
        self.steps_per_level = (1 << 16) / step.divisor();
        let (step, noise) = (step.divisor(), u32::from(noise));
        let class = usize::from(4 * step > noise) + usize::from(4 * step > 3 * noise) + usize::from(step > 3 * noise);
        self.rates = RATES[class % 4];
        self.calm_energy = if step >= noise { 14 } else { 0 };
    }

    /// All logits, in the order of the priors.
    #[cfg(feature = "std")]
    pub(crate) fn logits(&mut self) -> &mut [i16] {
        &mut self.logits[..LOGITS]
    }

    #[inline(always)]
    fn decide<const N: usize>(
        &mut self,
        coder: &mut impl BinaryCoder,
        rate: usize,
        contexts: [Context; N],
        decision: bool,
    ) -> bool {
        let rate = self.rates[rate];
        decide_by(coder, rate, self.chosen(contexts), decision)
    }

    /// These contexts' logits.
    #[inline(always)]
    fn chosen<const N: usize>(&mut self, contexts: [Context; N]) -> [&Cell<i16>; N] {
        let logits = self.cells();
        contexts.map(|Context(at)| &logits[at])
    }

    /// All logits, to change some of them one by one.
    #[inline(always)]
    fn cells(&mut self) -> &[Cell<i16>; ROOM] {
        let logits: &mut [i16] = &mut self.logits;
        match Cell::from_mut(logits).as_slice_of_cells().first_chunk() {
            Some(cells) => cells,
            None => unreachable!("there are as many, which the compiler sees"),
        }
    }

    /// Where `level` lies, seen from `predicted`.
    #[inline(always)]
    fn apart(&self, level: u16, predicted: u16) -> Apart {
        apart(self.steps_per_level, level, predicted)
    }
}

/// A context of a table, counted from the first table's first.
#[derive(Clone, Copy)]
struct Context(usize);

/// Context `at` of a table that begins at `TABLE` and has no more than a power of two of them, `MOST` + 1: the mask lets the
/// compiler see that there is a logit, which a comparison takes three times as long for.
#[inline(always)]
fn context<const TABLE: usize, const MOST: usize>(at: usize) -> Context {
    const { assert!(TABLE + MOST < ROOM && (MOST + 1).is_power_of_two()) };
    Context(TABLE + (at & MOST))
}

/// The logits of row `at` of a table that begins at `TABLE` and has rows of `N`; `MOST` is as for [`context`].
#[inline(always)]
fn row<const TABLE: usize, const MOST: usize, const N: usize>(
    logits: &[Cell<i16>; ROOM],
    at: usize,
) -> &[Cell<i16>; N] {
    const { assert!(TABLE + (MOST + 1) * N <= ROOM && (MOST + 1).is_power_of_two()) };
    let Some(row) = logits[TABLE + (at & MOST) * N..].first_chunk() else { unreachable!() };
    row
}

#[inline(always)]
fn apart(steps_per_level: u32, level: u16, predicted: u16) -> Apart {
    let off = i32::from(level) - i32::from(predicted);
    // 2 x distance x steps a level, of 2^16: the product has 32 bits.
    Apart { below: off >> 31, half_steps: (off.unsigned_abs() * steps_per_level) >> 15 }
}

/// One decision of the sum of some logits, which it moves. A function of its own on a Cortex-M: it has too few registers to
/// have this in the midst of what finds the contexts.
#[cfg_attr(target_arch = "arm", inline(never))]
#[cfg_attr(not(target_arch = "arm"), inline(always))]
fn decide_by<const N: usize>(coder: &mut impl BinaryCoder, rate: i16, logits: [&Cell<i16>; N], decision: bool) -> bool {
    let one = logistic_of(logits.iter().map(|logit| i32::from(logit.get())).sum());
    let decision = coder.decide(one, decision);
    let by = moved(one, decision, rate);
    for logit in logits {
        logit.set(logit.get().saturating_add(by));
    }
    decision
}

/// The probability that a sum of logits stands for.
#[inline(always)]
pub(super) fn logistic_of(sum: i32) -> u16 {
    LOGISTIC[((sum + (1 << 15)) >> 8).clamp(0, 255) as usize]
}

/// By how much a decision moves its logits.
#[inline(always)]
fn moved(one: u16, decision: bool, rate: i16) -> i16 {
    let error = (i32::from(decision) << 16) - i32::from(one);
    ((error * i32::from(rate)) >> 16) as i16
}

/// On which side of the prediction another level lies, and how far.
#[derive(Debug, Clone, Copy)]
struct Apart {
    /// -1 below, else 0.
    below: i32,
    half_steps: u32,
}

impl Apart {
    /// Six classes: less than one step, less than six, more; below (2, 1, 0) and not (3, 4, 5).
    #[inline(always)]
    fn side(self) -> usize {
        let far = i32::from(self.half_steps >= 2) + i32::from(self.half_steps >= 12);
        // Exclusive or with -1: -1 - far.
        (3 + (far ^ self.below)) as usize
    }

    /// Whole steps, where it lies on the side of the residual; 0 on the other.
    #[inline(always)]
    fn steps(self, is_negative: bool) -> u32 {
        if (self.below != 0) == is_negative { self.half_steps / 2 } else { 0 }
    }
}

/// For the exponents of a level's distance (`size` bits, 12 for more), those that are asked for: the context of the one seen
/// from the other. A table, for it is looked up for three levels at each exponent.
static RELATION: [[u8; 16]; EXPONENTS + 1] = relation();

const fn relation() -> [[u8; 16]; EXPONENTS + 1] {
    let (mut table, mut size) = ([[0; 16]; EXPONENTS + 1], 0);
    while size < table.len() {
        let mut asked = 0;
        while asked < 16 {
            let few = if asked < FEW_EXPONENTS { asked } else { FEW_EXPONENTS - 1 };
            let most = if size < EXPONENTS { size } else { EXPONENTS - 1 };
            let off = (most + 2).saturating_sub(if asked < EXPONENTS { asked } else { EXPONENTS - 1 });
            let near = match off {
                _ if size == 0 => 0,
                0 | 1 => 1,
                2..=5 => off,
                _ => 6,
            };
            table[size][asked] = (near * FEW_EXPONENTS + few) as u8;
            asked += 1;
        }
        size += 1;
    }
    table
}

/// The contexts of a level's distance by the exponent that is asked for.
#[inline(always)]
fn relations(steps: u32) -> &'static [u8; 16] {
    &RELATION[octave(steps).min(EXPONENTS)]
}

/// What contexts ask of a size with its sign.
#[derive(Clone, Copy)]
struct Size(u16);

/// By the low six bits of a size: it without its sign but at most 2, 4, and 5 in three bits each, sign + 1 in two, and size + 2
/// between 0 and 4.
static SIZES: [u16; 64] = sizes();

const fn sizes() -> [u16; 64] {
    let (mut table, mut at) = ([0; 64], 0);
    while at < 64 {
        let is_negative = at >= 32;
        let distance = if is_negative { 64 - at } else { at } as u16;
        let [two, four, five] = [at_most(distance, 2), at_most(distance, 4), at_most(distance, 5)];
        let (near, sign) = if is_negative { (2 - two, 0) } else { (2 + two, 1 + at_most(distance, 1)) };
        table[at] = two | four << 3 | five << 6 | sign << 9 | near << 11;
        at += 1;
    }
    table
}

const fn at_most(value: u16, most: u16) -> u16 {
    if value < most { value } else { most }
}

impl Size {
    #[inline(always)]
    fn of(beam: &Beam) -> Self {
        Self(SIZES[usize::from(beam.size as u8 & 63)])
    }

    /// Without its sign, at most 2.
    #[inline(always)]
    fn two(self) -> usize {
        usize::from(self.0 & 3)
    }

    #[inline(always)]
    fn four(self) -> usize {
        usize::from(self.0 >> 3 & 7)
    }

    #[inline(always)]
    fn five(self) -> usize {
        usize::from(self.0 >> 6 & 7)
    }

    /// Its sign + 1.
    #[inline(always)]
    fn sign(self) -> usize {
        usize::from(self.0 >> 9 & 3)
    }

    /// With its sign, at most 2 from 0, + 2.
    #[inline(always)]
    fn near(self) -> usize {
        usize::from(self.0 >> 11 & 7)
    }
}

#[inline(always)]
fn sign(sign: i8) -> usize {
    (sign.signum() + 1) as usize
}

/// What the decisions of one residual share.
struct Pixel<'a> {
    at: &'a Surroundings<'a>,
    energy: usize,
    north: Apart,
    south_west: Apart,
    other: Apart,
    own_size: Size,
    north_size: Size,
    north2_size: Size,
}

impl Pixel<'_> {
    /// What the rows' flag says: 0 for nothing.
    #[inline(always)]
    fn known(&self) -> usize {
        let class = self.at.flag.class();
        class - class / 2
    }
}

#[inline(always)]
fn age_class(age: u8) -> usize {
    AGE_CLASSES[usize::from(age) % 16].into()
}

impl Model for DenseModel {
    const REMEMBERS: bool = true;

    fn calm_energy(&self) -> u32 {
        self.calm_energy.into()
    }

    fn same(&mut self, coder: &mut impl BinaryCoder, at: &GroupSurroundings<'_>, decision: bool) -> bool {
        let energy = octave(u32::from(at.energy()) / 8).min(7);
        // A third that brings nothing: one function less where they are functions of their own.
        let (rate, nothing) = (self.rates[STEADY], Cell::new(0));
        let [class, place] =
            self.chosen([context::<SAME, 63>(at.class()), context::<SAME_PLACE, 63>(at.eighth() * 8 + energy)]);
        decide_by(coder, rate, [class, place, &nothing], decision)
    }

    fn occupied(&mut self, coder: &mut impl BinaryCoder, at: &SetSurroundings<'_>, decision: bool) -> bool {
        let energy = octave(u32::from(at.beam.energy) / 8).min(7);
        let contexts = [
            context::<OCCUPIED, 31>(at.class()),
            context::<OCCUPIED_FAR, 15>(at.far_class()),
            context::<OCCUPIED_ENERGY, 15>(energy * 2 + usize::from(at.is_west())),
        ];
        self.decide(coder, STEADY, contexts, decision)
    }

    /// The flag's logit is the sum of what its rows bring, two each.
    fn active(&mut self, coder: &mut impl BinaryCoder, at: &CalmSurroundings<'_>, decision: bool) -> bool {
        let steps_per_level = self.steps_per_level;
        let rate = self.rates[STEADY];
        let logits = self.cells();
        let Context(flag) = context::<ACTIVE, 15>(bits([at.north, at.south_west]) * 3 + usize::from(at.active_above));
        // Rows that are no returns bring nothing.
        let nothing = Cell::new(0);
        let mut brought = [&nothing; 1 + 2 * 4];
        brought[0] = &logits[flag];
        for (row, near) in at.near.windows(3).skip(ABOVE - 1).take(4).enumerate() {
            let [north, own, south_west] = near else { continue };
            if at.set >> row & 1 == 1 {
                let side = |beam: &Beam| apart(steps_per_level, beam.level, own.predicted).side();
                let Context(sides) = context::<ACTIVE_SIDES, 63>(side(north) * 6 + side(south_west));
                let Context(ages) = context::<ACTIVE_AGES, 63>(age_class(own.age()) * 8 + age_class(own.period()));
                brought[1 + 2 * row] = &logits[ages];
                brought[2 + 2 * row] = &logits[sides];
            }
        }
        decide_by(coder, rate, brought, decision)
    }

    #[inline(always)]
    fn residual<C: BinaryCoder>(&mut self, coder: &mut C, at: &Surroundings<'_>, residual: Residual) -> Residual {
        let pixel = Pixel {
            at,
            energy: half_octave(at.energy()).min(ENERGIES - 1),
            north: self.apart(at.north().level, at.predicted()),
            south_west: self.apart(at.south_west().level, at.predicted()),
            other: self.apart(at.own().other, at.predicted()),
            own_size: Size::of(at.own()),
            north_size: Size::of(at.north()),
            north2_size: Size::of(at.north2()),
        };
        if !at.is_known() && !self.is_not_zero(coder, &pixel, residual.distance != 0) {
            return Residual::ZERO;
        }
        let is_negative = self.is_negative(coder, &pixel, residual.is_negative);
        let others = [pixel.north, pixel.south_west, pixel.other].map(|apart| apart.steps(is_negative));
        let distance = residual.distance.max(1);
        let exponent = self.exponent(coder, &pixel, others, distance.ilog2() as usize);
        let distance = self.mantissa(coder, pixel.energy, exponent, others, distance);
        Residual { distance, is_negative }
    }
}

impl DenseModel {
    #[inline(always)]
    fn is_not_zero(&mut self, coder: &mut impl BinaryCoder, pixel: &Pixel<'_>, decision: bool) -> bool {
        let (own, south_west2, quarter) = (pixel.at.own(), pixel.at.south_west2(), pixel.at.quarter());
        let steps = [pixel.north, pixel.south_west].map(|apart| octave(apart.half_steps).min(7));
        let far = [pixel.north2_size, pixel.own_size, Size::of(south_west2)].map(Size::two);
        let contexts = [
            context::<ZERO, 31>(pixel.energy / 2 * 3 + pixel.known()),
            context::<ZERO_APART, 63>(steps[0] * 8 + steps[1]),
            context::<ZERO_FAR, 127>(((far[0] * 3 + far[1]) * 3 + far[2]) * 4 + quarter),
            context::<ZERO_SIDES, 127>((pixel.north.side() * 6 + pixel.south_west.side()) * 3 + pixel.own_size.sign()),
            context::<ZERO_SIZES, 31>(pixel.north_size.four() * 5 + pixel.own_size.four()),
            context::<ZERO_AGES, 63>(age_class(own.age()) * 8 + age_class(own.period())),
        ];
        self.decide(coder, NOISY, contexts, decision)
    }

    #[inline(always)]
    fn is_negative(&mut self, coder: &mut impl BinaryCoder, pixel: &Pixel<'_>, decision: bool) -> bool {
        let (own, north) = (pixel.at.own(), pixel.at.north());
        let (south_west, south_west2) = (pixel.at.south_west(), pixel.at.south_west2());
        let far = [Size::of(south_west), Size::of(south_west2), pixel.north2_size].map(Size::sign);
        let contexts = [
            context::<SIGN, 15>(pixel.own_size.near() * 3 + pixel.north_size.sign()),
            context::<SIGN_SIDES, 63>(pixel.south_west.side() * 6 + pixel.north.side()),
            context::<SIGN_FAR, 31>((far[0] * 3 + far[1]) * 3 + far[2]),
            context::<SIGN_OTHER, 7>(pixel.other.side()),
            context::<SIGN_LAST, 127>((sign(own.sign) * 3 + sign(north.sign)) * 8 + usize::from(own.age().min(7))),
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
        let [north, south_west, other] = others.map(relations);
        let rate = self.rates[STEADY];
        let logits = self.cells();
        let energies: &[_; ENERGY_EXPONENTS] = row::<EXPONENT, 15, _>(logits, pixel.energy / 2);
        let sizes = pixel.north_size.five() * 6 + pixel.own_size.five();
        let sizes: &[_; FEW_EXPONENTS] = row::<EXPONENT_SIZES, 63, _>(logits, sizes);
        let mut found = 0;
        while found < EXPONENT_MAX {
            let few = found.min(FEW_EXPONENTS - 1);
            let contexts = [
                &energies[found.min(ENERGY_EXPONENTS - 1)],
                &logits[EXPONENT_SOUTH_WEST + usize::from(south_west[found % 16])],
                &logits[EXPONENT_NORTH + usize::from(north[found % 16])],
                &logits[EXPONENT_OTHER + usize::from(other[found % 16])],
                &sizes[few],
            ];
            if !decide_by(coder, rate, contexts, exponent > found) {
                break;
            }
            found += 1;
        }
        found
    }

    /// The bits below the highest: the first two modelled, and more as long as they are those of another level.
    #[inline(always)]
    fn mantissa(
        &mut self,
        coder: &mut impl BinaryCoder,
        energy: usize,
        exponent: usize,
        others: [u32; 3],
        distance: u32,
    ) -> u32 {
        let rate = self.rates[STEADY];
        let logits = self.cells();
        let own: &[_; 4] = row::<MANTISSA, 15, _>(logits, exponent.min(EXPONENTS - 1));
        let least: &[_; 4] = row::<MANTISSA_ENERGY, 15, _>(logits, energy / 4 * 3 + exponent.min(2));
        let mut matches = others.map(|other| octave(other) == exponent + 1);
        let (mut left, mut found, mut node) = (exponent as u32, 1, 0);
        while left > 0 {
            let mut sides = MANTISSA_NO_SIDE;
            let mut theirs = [2; 3];
            let any = matches != [false; 3];
            if any {
                let bit_of = |at: usize| if matches[at] { (others[at] >> (left - 1) & 1) as usize } else { 2 };
                theirs = [bit_of(0), bit_of(1), bit_of(2)];
                sides = (theirs[2] * 3 + theirs[0]) * 3 + theirs[1];
            } else if node == 3 {
                break;
            }
            left -= 1;
            let contexts = [&own[node], &logits[MANTISSA_SIDES + ((sides * 4 + node) & 127)], &least[node]];
            let bit = decide_by(coder, rate, contexts, distance >> left & 1 == 1);
            found = found << 1 | u32::from(bit);
            if any {
                for (matches, theirs) in matches.iter_mut().zip(theirs) {
                    *matches &= theirs == usize::from(bit);
                }
            }
            node = if node == 0 { 1 + usize::from(bit) } else { 3 };
        }
        found << left | coder.raw(left, distance & ((1 << left) - 1))
    }
}
