//! What is remembered of each beam: its last levels, what they predict, and how far predictions were off.

use super::column::GROUP_ROWS;
use super::step::Step;

/// Residuals count as no more than this in energies.
const ENERGY_RESIDUAL_MAX: u32 = 1023;

/// Energy of a beam that has not been seen.
const ENERGY_START: u16 = 64;

/// Most that ages count.
const AGE_MAX: u8 = 15;

/// One beam's past.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    /// The last level as the decoder knows it; 0 = none yet.
    pub(crate) level: u16,
    /// What the next level is predicted to be.
    pub(crate) predicted: u16,
    /// The level before the last edge: that of what lies behind or before the thing now seen.
    pub(crate) other: u16,
    /// Sixteen times the mean distance of the last residuals from 0.
    pub(crate) energy: u16,
    /// How much levels grow from pixel to pixel, in eighths of a level.
    slope: i8,
    /// Bits of the last residual's distance from 0, with its sign.
    pub(crate) size: i8,
    /// Sign of the last residual that was not 0.
    pub(crate) sign: i8,
    /// Pixels since then in the low four bits; in the high ones, pixels between it and the one before it.
    ages: u8,
}

impl Beam {
    /// Not seen yet.
    pub(crate) const NEW: Self =
        Self { level: 0, predicted: 0, other: 0, energy: ENERGY_START, slope: 0, size: 0, sign: 0, ages: 0 };

    /// Pixels since the last residual that was not 0, at most 15.
    #[inline(always)]
    pub(crate) const fn age(self) -> u8 {
        self.ages & AGE_MAX
    }

    /// Pixels between the last two residuals that were not 0, at most 15.
    #[inline(always)]
    pub(crate) const fn period(self) -> u8 {
        self.ages >> 4
    }

    /// All zeros: memory that has yet to be set up.
    const BLANK: Self = Self { energy: 0, ..Self::NEW };

    /// Takes in a pixel: its residual against `predicted`, and the level that makes.
    #[inline(always)]
    pub(crate) fn update(&mut self, residual: i32, predicted: u16, level: u16, filter: &Filter) {
        let distance = residual.unsigned_abs();
        if distance > filter.edge {
            if distance > 4 * filter.edge {
                self.other = self.level;
                self.slope = 0;
            }
            self.predicted = level;
        } else {
            self.predicted = filter.next(&mut self.slope, predicted, level);
        }
        self.level = level;
        self.energy = decayed(self.energy, residual);
        let bits = (u32::BITS - distance.leading_zeros()) as i8;
        self.size = if residual < 0 { -bits } else { bits };
        if residual == 0 {
            self.ages += u8::from(self.age() < AGE_MAX);
        } else {
            self.sign = residual.signum() as i8;
            self.ages <<= 4;
        }
    }
}

/// An energy after one more residual.
#[inline(always)]
pub(crate) fn decayed(energy: u16, residual: i32) -> u16 {
    ((3 * u32::from(energy) + 16 * residual.unsigned_abs().min(ENERGY_RESIDUAL_MAX)) / 4) as u16
}

/// How a beam's next level follows from its last ones: the sensor's noise is filtered out, edges are not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Filter {
    /// Sixteenths of the way from the prediction to the level.
    gain: i32,
    /// Residuals of more steps are edges.
    edge: u32,
    /// Slopes up to this are none, in eighths of a level; `None` where slopes are not followed.
    least_slope: Option<i32>,
}

impl Filter {
    /// For steps of `step` and noise of up to `noise` levels; 0 is without a filter.
    pub(crate) const fn new(step: Step, noise: u8) -> Self {
        let (step, noise) = (step.levels() as u32, noise as u32);
        let is_fine = 4 * step <= 3 * noise;
        let gain = if is_fine {
            11
        } else if step <= 3 * noise {
            14
        } else {
            16
        };
        let edge = if noise / step < 2 { 2 } else { noise / step };
        Self { gain, edge, least_slope: if is_fine { Some(step.cast_signed()) } else { None } }
    }

    #[inline(always)]
    fn next(&self, slope: &mut i8, predicted: u16, level: u16) -> u16 {
        let off = i32::from(level) - i32::from(predicted);
        let mut next = i32::from(predicted) + ((off * self.gain + 8) >> 4);
        if let Some(least) = self.least_slope {
            *slope = (i32::from(*slope) + off / 2).clamp(-127, 127) as i8;
            next += (i32::from(*slope) - i32::from(*slope).clamp(-least, least)) / 8;
        }
        next.clamp(1, i32::from(u16::MAX)) as u16
    }
}

/// The beams of an image of up to `8 * GROUPS` rows, and which of the last three columns' pixels were returns.
#[derive(Debug, Clone)]
pub(crate) struct Beams<const GROUPS: usize> {
    rows: [[Beam; GROUP_ROWS]; GROUPS],
    /// By group, the sets of returns of the last three columns, the last one first.
    pub(crate) sets: [[u8; 3]; GROUPS],
    /// By group, whether its set was that of the column before: bit 0 for the last column, bit 1 for the one before.
    pub(crate) same: [u8; GROUPS],
}

impl<const GROUPS: usize> Beams<GROUPS> {
    /// All zeros: memory that has yet to be set up.
    pub(crate) const BLANK: Self =
        Self { rows: [[Beam::BLANK; GROUP_ROWS]; GROUPS], sets: [[0; 3]; GROUPS], same: [0; GROUPS] };

    /// Beams that have not been seen.
    pub(crate) const fn new() -> Self {
        Self { rows: [[Beam::NEW; GROUP_ROWS]; GROUPS], sets: [[0; 3]; GROUPS], same: [0; GROUPS] }
    }

    /// A row's beam; one that was never seen beyond the edges.
    #[inline(always)]
    pub(crate) fn get(&self, row: usize) -> Beam {
        self.rows.as_flattened().get(row).copied().unwrap_or(Beam::NEW)
    }

    /// A row's beam, to change; `None` beyond the edges.
    #[inline(always)]
    pub(crate) fn get_mut(&mut self, row: usize) -> Option<&mut Beam> {
        self.rows.as_flattened_mut().get_mut(row)
    }

    /// Largest energy of a group's beams.
    pub(crate) fn energy(&self, group: usize) -> u16 {
        self.rows.get(group).map_or(0, |beams| beams.iter().map(|beam| beam.energy).fold(0, u16::max))
    }

    /// Sets of a group; empty ones beyond the edges.
    pub(crate) fn sets(&self, group: usize) -> [u8; 3] {
        self.sets.get(group).copied().unwrap_or_default()
    }

    /// Takes in a column's sets.
    pub(crate) fn shift_sets(&mut self, column: &[u8; GROUPS]) {
        for (sets, &set) in self.sets.iter_mut().zip(column) {
            let [west, west2, _] = *sets;
            *sets = [set, west, west2];
        }
    }
}
