//! What is remembered of each beam: its last levels, what they predict, and how far predictions were off.

use super::column::GROUP_ROWS;
use super::step::{Residual, Step};

/// Residuals count as no more than this in energies.
const ENERGY_RESIDUAL_MAX: i32 = 1023;

/// Energy of a beam that has not been seen.
const ENERGY_START: u16 = 64;

/// Most that ages count.
const AGE_MAX: u8 = 15;

/// Rows that are walked together.
pub(crate) const QUAD_ROWS: usize = 4;
/// Rows above and below whose beams a row looks at.
pub(crate) const ABOVE: usize = 2;

/// Four rows' beams between the two above and the two below.
pub(crate) type NearQuad = [Beam; NEAR_ROWS];
pub(crate) const NEAR_ROWS: usize = ABOVE + QUAD_ROWS + ABOVE;
/// One row's beam between the two above and the two below.
pub(crate) type Near = [Beam; ABOVE + 1 + ABOVE];

/// One beam's past. Aligned, so that it is copied by words.
#[derive(Debug, Clone, Copy)]
#[repr(align(4))]
pub(crate) struct Beam {
    /// The last level as the decoder knows it; 0 = none yet.
    pub(crate) level: u16,
    /// What the next level is predicted to be: a level.
    pub(crate) predicted: u16,
    /// Sixteen times the mean distance of the last residuals from 0.
    pub(crate) energy: u16,
    /// How much levels grow from pixel to pixel, in eighths of a level.
    slope: i8,
    /// Bits of the last residual's distance from 0, with its sign.
    pub(crate) size: i8,
    /// The level before the last edge: that of what lies behind or before the thing now seen.
    pub(crate) other: u16,
    /// Sign of the last residual that was not 0.
    pub(crate) sign: i8,
    /// Pixels since then in the low four bits; in the high ones, pixels between it and the one before it.
    ages: u8,
}

impl Beam {
    /// Not seen yet.
    pub(crate) const NEW: Self =
        Self { level: 0, predicted: 0, energy: ENERGY_START, slope: 0, size: 0, other: 0, sign: 0, ages: 0 };

    /// All zeros: memory that has yet to be set up.
    const BLANK: Self = Self { energy: 0, ..Self::NEW };

    /// Pixels since the last residual that was not 0, at most 15.
    #[inline(always)]
    pub(crate) const fn age(&self) -> u8 {
        self.ages & AGE_MAX
    }

    /// Pixels between the last two residuals that were not 0, at most 15.
    #[inline(always)]
    pub(crate) const fn period(&self) -> u8 {
        self.ages >> 4
    }

    /// Is told what to predict next; what it would have predicted takes the place of the level that it may return to.
    pub(crate) const fn expect(&mut self, level: u16, filter: &Filter) {
        let level = filter.within(level as i32);
        if self.level == 0 {
            self.level = level;
        } else {
            self.other = self.predicted;
        }
        self.predicted = level;
    }

    /// After a pixel that it was told what to predict of: what `own`, itself before that, would have learned of levels; what
    /// it learned of residuals stays.
    pub(crate) fn learn_as(&mut self, own: Self, level: u16, residual: Residual, filter: &Filter) {
        let mut learned = own;
        if own.level == 0 {
            (learned.level, learned.predicted) = (level, level);
        } else {
            learned.update(true, residual, level, filter);
        }
        let Self { level, predicted, slope, other, .. } = learned;
        *self = Self { level, predicted, slope, other, ..*self };
    }

    /// Takes in a pixel that is as predicted. What only one that `remembers` asks for is kept only then.
    #[inline(always)]
    pub(crate) fn stay(&mut self, remembers: bool, follows_slopes: bool, filter: &Filter) {
        let level = self.predicted;
        self.level = level;
        if follows_slopes {
            self.predicted = filter.within(i32::from(level) + growth(self.slope, filter.least_slope));
        }
        self.energy = decayed(self.energy, 0);
        self.size = 0;
        if remembers {
            self.ages += u8::from(self.age() < AGE_MAX);
        }
    }

    /// Takes in a pixel that is not: its residual against what was predicted, and the level that makes.
    #[inline(always)]
    pub(crate) fn update(&mut self, remembers: bool, residual: Residual, level: u16, filter: &Filter) {
        let Residual { distance, is_negative } = residual;
        if distance <= filter.edge {
            self.predicted = filter.next(&mut self.slope, self.predicted, level);
        } else {
            if distance > 4 * filter.edge {
                self.slope = 0;
                if remembers {
                    self.other = self.level;
                }
            }
            self.predicted = level;
        }
        self.level = level;
        self.energy = decayed(self.energy, distance);
        self.sign = if is_negative { -1 } else { 1 };
        // Others ask only whether it is 0.
        self.size = self.sign;
        if remembers {
            self.size *= residual.len() as i8;
            self.ages <<= 4;
        }
    }
}

/// An energy after one more residual.
#[inline(always)]
pub(super) fn decayed(energy: u16, distance: u32) -> u16 {
    ((3 * u32::from(energy) + 16 * distance.cast_signed().clamp(0, ENERGY_RESIDUAL_MAX) as u32) / 4) as u16
}

/// How a beam's next level follows from its last ones: the sensor's noise is filtered out, edges are not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Filter {
    /// Sixteenths of the way from the prediction to the level.
    gain: i32,
    /// Residuals of more steps are edges.
    edge: u32,
    /// Slopes up to this are none, in eighths of a level; 0 where slopes are not followed.
    least_slope: i32,
    /// Predictions are levels: from 1 to this.
    max_level: i32,
}

impl Filter {
    /// For steps of `step` and noise of up to `noise` levels; 0 is without a filter. A tier that does not `remember` follows
    /// slopes only in the finest steps: what they save in others takes it more time than it is worth.
    pub(crate) const fn new(step: Step, noise: u8, max_level: u16, remembers: bool) -> Self {
        let (step, noise) = (step.divisor(), noise as u32);
        let is_fine = 4 * step <= 3 * noise;
        let gain = if is_fine {
            11
        } else if step <= 3 * noise {
            14
        } else {
            16
        };
        let edge = if noise / step < 2 { 2 } else { noise / step };
        let least_slope = if is_fine && (remembers || 4 * step <= noise) { step.cast_signed() } else { 0 };
        Self { gain, edge, least_slope, max_level: max_level as i32 }
    }

    /// What comes after a level that was nearly as predicted.
    #[inline(always)]
    fn next(&self, slope: &mut i8, predicted: u16, level: u16) -> u16 {
        let off = i32::from(level) - i32::from(predicted);
        let next = i32::from(predicted) + ((off * self.gain + 8) >> 4);
        if !self.follows_slopes() {
            return self.within(next);
        }
        *slope = (i32::from(*slope) + off / 2).clamp(-127, 127) as i8;
        self.within(next + growth(*slope, self.least_slope))
    }

    #[inline(always)]
    pub(crate) const fn follows_slopes(&self) -> bool {
        self.least_slope != 0
    }

    #[inline(always)]
    const fn within(&self, next: i32) -> u16 {
        if next < 1 {
            1
        } else if next > self.max_level {
            self.max_level as u16
        } else {
            next as u16
        }
    }
}

/// Levels from one pixel to the next.
#[inline(always)]
fn growth(slope: i8, least: i32) -> i32 {
    let slope = i32::from(slope);
    (slope - slope.max(-least).min(least)) / 8
}

/// The beams of an image of up to `8 * GROUPS` rows, and which of the last three columns' pixels were returns.
#[derive(Debug, Clone)]
pub(crate) struct Beams<const GROUPS: usize> {
    rows: [[Beam; GROUP_ROWS]; GROUPS],
    pub(crate) sets: [Sets; GROUPS],
}

/// What is remembered of a group's sets of returns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sets {
    /// Those of the last three columns, the last one lowest; above them whether the last was that of the column before
    /// (bit 24), and the one before that (bit 25).
    past: u32,
}

impl Sets {
    pub(super) const NEW: Self = Self { past: 0 };

    /// The sets of the last three columns, the last one first.
    #[inline(always)]
    pub(crate) const fn last(self) -> [u8; 3] {
        let [west, west2, west3, _] = self.past.to_le_bytes();
        [west, west2, west3]
    }

    #[inline(always)]
    pub(crate) const fn west(self) -> u8 {
        self.past as u8
    }

    /// With another set before the last two.
    pub(crate) const fn told(self, west: u8) -> Self {
        Self { past: self.past & 0xff00_0000 | (self.past << 8 | west as u32) & 0x00ff_ffff }
    }

    /// After a column of this set, which was found by what was told after `own`.
    pub(crate) const fn learned(self, own: Self, set: u8) -> Self {
        Self { past: self.past & 0xff00_0000 | (own.past << 8 | set as u32) & 0x00ff_ffff }
    }

    /// Whether the set stayed the same in the last column (bit 0) and the one before (bit 1).
    #[inline(always)]
    pub(crate) const fn same_before(self) -> usize {
        (self.past >> 24) as usize & 3
    }

    /// What is remembered after a column more: its set, and 1 where that stayed the same.
    #[inline(always)]
    pub(crate) const fn then(self, set: u8, same: u32) -> Self {
        let sets = (self.past << 8 | set as u32) & 0x00ff_ffff;
        Self { past: sets | (self.past >> 24 << 1 | same) << 24 }
    }
}

impl<const GROUPS: usize> Beams<GROUPS> {
    /// All zeros: memory that has yet to be set up.
    pub(crate) const BLANK: Self = Self { rows: [[Beam::BLANK; GROUP_ROWS]; GROUPS], sets: [Sets::NEW; GROUPS] };

    /// Beams that have not been seen.
    #[cfg(feature = "std")]
    pub(crate) const fn new() -> Self {
        Self { rows: [[Beam::NEW; GROUP_ROWS]; GROUPS], sets: [Sets::NEW; GROUPS] }
    }

    /// Forgets all beams, in place: on a device's stack there is no room for more.
    pub(crate) fn start(&mut self) {
        self.rows.as_flattened_mut().fill(Beam::NEW);
        self.sets.fill(Sets::NEW);
    }

    /// All beams, by group.
    pub(crate) const fn rows(&mut self) -> &mut [[Beam; GROUP_ROWS]; GROUPS] {
        &mut self.rows
    }

    /// Gives all beams that were seen the same energy.
    pub(crate) fn settle(&mut self, energy: u16) {
        for beam in self.rows.as_flattened_mut().iter_mut().filter(|beam| beam.level != 0) {
            beam.energy = energy;
        }
    }

    /// The beams of a group.
    #[inline(always)]
    pub(crate) fn group(&self, group: usize) -> &[Beam] {
        self.rows.get(group).map_or(&[], |beams| beams.as_slice())
    }

    /// Four rows from `first` on with those around them; `None` at the edges, where there are none to one side.
    #[inline(always)]
    pub(crate) fn near(&mut self, first: usize) -> Option<&mut NearQuad> {
        self.rows.as_flattened_mut().get_mut(first.checked_sub(ABOVE)?..)?.first_chunk_mut()
    }

    /// Copies them at an edge, beyond which beams were never seen.
    #[inline(always)]
    pub(crate) fn at_edge(&self, first: usize, near: &mut NearQuad) {
        let (pairs, _) = self.rows.as_flattened().as_chunks::<ABOVE>();
        let (to, _) = near.as_chunks_mut::<ABOVE>();
        // Pairs of beams: one above, four rows, one below.
        for (at, to) in to.iter_mut().enumerate() {
            let from = (first / ABOVE + at).checked_sub(1).and_then(|at| pairs.get(at));
            *to = *from.unwrap_or(&[Beam::NEW; ABOVE]);
        }
    }

    /// Takes the four rows of such a copy in.
    #[inline(always)]
    pub(crate) fn set_at_edge(&mut self, first: usize, near: &NearQuad) {
        let to = self.rows.as_flattened_mut().get_mut(first..).and_then(|rows| rows.first_chunk_mut::<QUAD_ROWS>());
        if let (Some(to), Some((_, from))) = (to, near.split_first_chunk::<ABOVE>())
            && let Some(from) = from.first_chunk()
        {
            *to = *from;
        }
    }
}
