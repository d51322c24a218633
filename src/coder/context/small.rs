//! The small tier: each decision has a class, and each class the probability that its last decisions had.
//!
//! Source: LZMA's adaptive binary probabilities (Pavlov), of 16 bits.

use super::range_coder::BinaryCoder;
use super::step::{Residual, Step};
use super::surroundings::{
    CalmSurroundings, Flag, GroupSurroundings, SetSurroundings, Surroundings, bits, half_octave_of_two,
};
use super::walk::Model;

/// Bits of the longest residual.
const LEN_MAX: u32 = 16;

/// Rows have a common flag where their mean energy is less than this.
const CALM_ENERGY: u32 = 14;

/// Classes of energy.
const ENERGIES: usize = 16;
/// Lengths that are told apart; larger ones count as the largest of these.
const LENS: usize = 16;

/// A decision moves its probability by 2^-this of the way.
const RATE: u32 = 5;

/// Tables of probabilities of a 1, out of 2^16, by what they are of.
#[derive(Debug, Clone)]
struct Tables {
    same: [u16; 36],
    occupied: [u16; 32],
    active: [[u16; 12]; 4],
    zero: [[u16; 4]; ENERGIES],
    sign: [[[u16; 3]; 4]; 4],
    /// Whether a residual is longer than so many bits and one.
    longer: [[u16; LENS]; ENERGIES],
    mantissa: [u16; LENS],
}

/// Probabilities in all.
pub(crate) const PROBABILITIES: usize = size_of::<Tables>() / size_of::<u16>();

/// Probabilities before anything was coded, out of 2^8, less one half.
pub(crate) static PRIORS: [u8; PROBABILITIES] = super::priors::SMALL;

impl Tables {
    /// All zeros: memory that has yet to be set up.
    const BLANK: Self = Self {
        same: [0; 36],
        occupied: [0; 32],
        active: [[0; 12]; 4],
        zero: [[0; 4]; ENERGIES],
        sign: [[[0; 3]; 4]; 4],
        longer: [[0; LENS]; ENERGIES],
        mantissa: [0; LENS],
    };

    /// All probabilities, in the order of the priors.
    fn each(&mut self) -> impl Iterator<Item = &mut u16> {
        let Self { same, occupied, active, zero, sign, longer, mantissa } = self;
        let tables = [
            same.as_mut_slice(),
            occupied,
            active.as_flattened_mut(),
            zero.as_flattened_mut(),
            sign.as_flattened_mut().as_flattened_mut(),
            longer.as_flattened_mut(),
            mantissa,
        ];
        tables.into_iter().flatten()
    }
}

/// The probabilities, and what a step makes of them. A `LEARNER` learns as slowly as it is told.
#[derive(Debug, Clone)]
pub struct Counts<const LEARNER: bool> {
    tables: Tables,
    /// Beyond so many levels from the prediction a level is far.
    far: i32,
    /// By class of energy, the bits that a residual most likely has.
    guesses: [u8; ENERGIES],
    slower: u32,
}

/// The small tier's model.
pub type SmallModel = Counts<false>;

impl<const LEARNER: bool> Counts<LEARNER> {
    /// All zeros: memory that has yet to be set up.
    pub(crate) const fn new() -> Self {
        Self { tables: Tables::BLANK, far: 0, guesses: [0; ENERGIES], slower: 0 }
    }

    /// Forgets all but the priors.
    pub(crate) fn start(&mut self, step: Step, noise: u8) {
        self.start_from(&PRIORS, step, noise);
    }

    /// The same with other priors.
    pub(crate) fn start_from(&mut self, priors: &[u8; PROBABILITIES], step: Step, noise: u8) {
        for (one, &prior) in self.probabilities().zip(priors) {
            *one = u16::from(prior) << 8 | 1 << 7;
        }
        self.prepare(step, noise);
    }

    /// Makes ready for a step, with the probabilities as they are.
    pub(crate) fn prepare(&mut self, step: Step, noise: u8) {
        self.far = 2 * i32::from(step.levels());
        // In steps finer than noise residuals are as long as that; in coarser ones most are 0.
        let is_fine = 4 * u32::from(step.levels()) <= u32::from(noise);
        for (guess, energy) in self.guesses.iter_mut().zip(0_u8..) {
            *guess = if is_fine { (energy / 2).saturating_sub(3) } else { 0 };
        }
    }

    /// All probabilities, in the order of the priors.
    pub(crate) fn probabilities(&mut self) -> impl Iterator<Item = &mut u16> {
        self.tables.each()
    }

    /// Each `slower` halves the rate of learning.
    #[cfg(feature = "std")]
    pub(crate) fn set_slower(&mut self, slower: u8) {
        self.slower = slower.into();
    }

    #[inline(always)]
    fn rate(&self) -> u32 {
        if LEARNER { RATE + self.slower } else { RATE }
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

impl<const LEARNER: bool> Model for Counts<LEARNER> {
    const REMEMBERS: bool = false;

    #[inline(always)]
    fn calm_energy(&self) -> u32 {
        CALM_ENERGY
    }

    #[inline(always)]
    fn same(&mut self, coder: &mut impl BinaryCoder, at: &GroupSurroundings<'_>, decision: bool) -> bool {
        let rate = self.rate();
        coder.learn(&mut self.tables.same[at.class()], rate, decision)
    }

    #[inline(always)]
    fn occupied(&mut self, coder: &mut impl BinaryCoder, at: &SetSurroundings<'_>, decision: bool) -> bool {
        let rate = self.rate();
        coder.learn(&mut self.tables.occupied[at.class()], rate, decision)
    }

    #[inline(always)]
    fn active(&mut self, coder: &mut impl BinaryCoder, at: &CalmSurroundings<'_>, decision: bool) -> bool {
        let rate = self.rate();
        // No more than 11 as it is; said, since the compiler does not see it and would keep a panic for more.
        let near = (bits([at.north, at.south_west]) * 3 + usize::from(at.active_above).min(2)).min(11);
        coder.learn(&mut self.tables.active[(at.energy / 4).min(3) as usize][near], rate, decision)
    }

    #[inline(always)]
    fn residual<C: BinaryCoder>(&mut self, coder: &mut C, at: &Surroundings<'_>, residual: Residual) -> Residual {
        let energy = half_octave_of_two(at.energy() + 1).min(ENERGIES - 1);
        let found = self.len(coder, at, energy, residual.len());
        let len = if C::DECODES { found } else { residual.len() };
        if len == 0 {
            return Residual::ZERO;
        }
        let side = self.side(at.south_west().level, at.predicted());
        let (own, north) = (at.own().sign as usize & 3, at.north().sign as usize & 3);
        let rate = self.rate();
        let one = &mut self.tables.sign[own][north][side];
        let is_negative = coder.learn(one, rate, residual.is_negative);
        let distance = self.mantissa(coder, len, residual.distance);
        // What was told is what is known; the compiler does not see it.
        if C::DECODES { Residual { distance, is_negative } } else { residual }
    }
}

impl<const LEARNER: bool> Counts<LEARNER> {
    /// Bits of a residual's distance from 0: from a guess, up or down by one as long as it is more or less.
    #[inline(always)]
    fn len<C: BinaryCoder>(&mut self, coder: &mut C, at: &Surroundings<'_>, energy: usize, len: u32) -> u32 {
        let guess = u32::from(self.guesses[energy]);
        if guess < 2 && !self.is_not_zero(coder, at, energy, len != 0) {
            return 0;
        }
        let found = if C::DECODES {
            self.find_len(coder, energy, guess)
        } else {
            self.tell_len(coder, energy, guess, len);
            len
        };
        if guess < 2 || found > 1 {
            return found;
        }
        u32::from(self.is_not_zero(coder, at, energy, len != 0))
    }

    /// The decisions of a `len`; 0 is told as 1. All are known here: loops of equal ones, where the inverse direction asks
    /// at each step.
    #[inline(always)]
    fn tell_len(&mut self, coder: &mut impl BinaryCoder, energy: usize, guess: u32, len: u32) {
        let rate = self.rate();
        let longer = &mut self.tables.longer[energy];
        let mut at = guess.max(1);
        if len > at {
            while at < len {
                coder.learn(&mut longer[(at as usize - 1) % LENS], rate, true);
                at += 1;
            }
            coder.learn(&mut longer[(at as usize - 1) % LENS], rate, false);
            return;
        }
        let least = len.max(1);
        while at >= least {
            coder.learn(&mut longer[(at as usize - 1) % LENS], rate, false);
            at -= 1;
        }
        if at != 0 {
            coder.learn(&mut longer[(at as usize - 1) % LENS], rate, true);
        }
    }

    #[inline(always)]
    fn find_len(&mut self, coder: &mut impl BinaryCoder, energy: usize, guess: u32) -> u32 {
        let rate = self.rate();
        let longer = &mut self.tables.longer[energy];
        let mut is_longer = |than: u32| coder.learn(&mut longer[(than as usize - 1) % LENS], rate, false);
        let mut len = guess.max(1);
        if is_longer(len) {
            len += 1;
            // That of a code that no encoder makes may have no end.
            while is_longer(len) && len < LEN_MAX {
                len += 1;
            }
            return len;
        }
        while len > 1 && !is_longer(len - 1) {
            len -= 1;
        }
        len
    }

    #[inline(always)]
    fn is_not_zero(
        &mut self,
        coder: &mut impl BinaryCoder,
        at: &Surroundings<'_>,
        energy: usize,
        decision: bool,
    ) -> bool {
        let known = match at.flag {
            Flag::NONE => usize::from(at.own().size == 0),
            _ if at.is_known() => return true,
            flag => flag.class(),
        };
        let rate = self.rate();
        coder.learn(&mut self.tables.zero[energy][known], rate, decision)
    }

    /// The bits below the highest, of which the first is modelled.
    #[inline(always)]
    fn mantissa(&mut self, coder: &mut impl BinaryCoder, len: u32, distance: u32) -> u32 {
        let rate = self.rate();
        let Some(left) = len.checked_sub(2) else { return 1 };
        let one = &mut self.tables.mantissa[left as usize % LENS];
        let second = coder.learn(one, rate, distance >> left & 1 == 1);
        (2 | u32::from(second)) << left | coder.raw(left, distance & ((1 << left) - 1))
    }
}
