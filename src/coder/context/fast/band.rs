//! Sixty-four rows of the image and what is remembered of each: the model that both directions walk. All of it is
//! lanes of `u16` in loops of fixed length, which compilers turn into vector code on every target with vectors.

use super::super::step::Step;
use super::noise::Filter;

/// Rows of a band.
pub(crate) const ROWS: usize = 64;
/// Rows of a group: what has one set of returns.
pub(crate) const GROUP_ROWS: usize = 8;
/// Groups of a band.
pub(crate) const GROUPS: usize = ROWS / GROUP_ROWS;

/// One number a row.
pub(crate) type Lanes = [u16; ROWS];
/// The same with room for the neighbors above row 0 and below the last.
type Fenced = [u16; ROWS + 2 * FENCE];
/// A vector's width, so that rows stay aligned.
const FENCE: usize = 8;
/// The rows of a [`Fenced`].
const INSIDE: core::ops::Range<usize> = FENCE..FENCE + ROWS;

/// Energy of a row that has not been seen, and of neighbors that there are not.
const ENERGY_START: u16 = 64;
/// Residuals count as no more than this in energies, so that five of them fit a lane.
const ENERGY_RESIDUAL_MAX: u16 = 800;
/// Residuals' sizes are remembered up to this.
const SIZE_MAX: u16 = 3;

/// Classes of energy, two an octave.
const ENERGIES: u16 = 20;
/// Half octaves below the first class: of floats' exponents, and of energies that are as good as none.
const ENERGY_FIRST: u16 = 259;
const ROW_CLASSES: u16 = 4;

const MISSED: u16 = 1;
const ROW: u16 = 2;
const NORTH: u16 = ROW * ROW_CLASSES;
const SOUTH: u16 = NORTH * 3;
const BEFORE: u16 = SOUTH * 3;
const SIZE: u16 = BEFORE * 3;
const ENERGY: u16 = SIZE * (SIZE_MAX + 1);
/// Contexts of a residual.
pub(crate) const CELLS: usize = (ENERGY * ENERGIES) as usize;

/// Residuals of a column: how many steps, and 1 where down.
#[derive(Debug, Clone)]
pub(crate) struct Residuals {
    pub(crate) steps: Lanes,
    pub(crate) negative: Lanes,
}

impl Residuals {
    pub(crate) const NONE: Self = Self { steps: [0; ROWS], negative: [0; ROWS] };
}

/// What is remembered of 64 rows.
#[derive(Debug, Clone)]
pub(crate) struct Band {
    /// What the next level is predicted to be; 0 where none was seen.
    predicted: Fenced,
    /// Sixteen times the mean distance of the last residuals from 0.
    energy: Fenced,
    /// 1 where the last residual that was not 0 was negative.
    pub(crate) flip: Lanes,
    /// Size of the last residual.
    size: Lanes,
    /// Of the last residual and the one before, 1 where it was not 0, and where it was negative.
    moved: Fenced,
    negative: Fenced,
    moved_before: Lanes,
    negative_before: Lanes,
    /// 1 where the last column had no return.
    missed: Lanes,
    /// The share of the row's place in its context.
    place: Lanes,
    /// Sets of returns of the last column, by groups.
    pub(crate) sets: [u8; GROUPS],
    /// Groups whose set was not that of the column before.
    pub(crate) changed: u8,
}

impl Band {
    /// Of an image of `rows` rows those from `first`; nothing seen yet.
    pub(crate) fn new(first: usize, rows: usize) -> Self {
        let mut band = Self::EMPTY;
        for (row, place) in (first..).zip(&mut band.place) {
            *place = ROW * (row * usize::from(ROW_CLASSES) / rows).min(usize::from(ROW_CLASSES) - 1) as u16;
        }
        band
    }

    /// A band to put others in the place of.
    pub(crate) const EMPTY: Self = Self {
        predicted: [0; _],
        energy: [ENERGY_START; _],
        flip: [0; ROWS],
        size: [0; ROWS],
        moved: [0; _],
        negative: [0; _],
        moved_before: [0; ROWS],
        negative_before: [0; ROWS],
        missed: [0; ROWS],
        place: [0; ROWS],
        sets: [0; GROUPS],
        changed: 0,
    };

    /// Lets the first row see the last of the band above, as it is now, and the other way round.
    pub(crate) fn meet(above: &mut Self, below: &mut Self) {
        let (last, first) = (INSIDE.end - 1, INSIDE.start);
        let edge = |band: &Self, at: usize| [band.predicted[at], band.energy[at], band.moved[at], band.negative[at]];
        let show = |band: &mut Self, at: usize, [predicted, energy, moved, negative]: [u16; 4]| {
            (band.predicted[at], band.energy[at]) = (predicted, energy);
            (band.moved[at], band.negative[at]) = (moved, negative);
        };
        let (from_above, from_below) = (edge(above, last), edge(below, first));
        show(below, first - 1, from_above);
        show(above, last + 1, from_below);
    }

    /// The context of each row's residual.
    #[inline]
    pub(crate) fn cells(&self, scale: &Scale) -> Lanes {
        match scale.edge {
            None => self.cells_by(|row, by| (self.moved[row + by], self.negative[row + by])),
            Some(far) => self.cells_by(|row, by| {
                let (own, other) = (self.predicted[row + FENCE], self.predicted[row + by]);
                let apart = u16::from(own.abs_diff(other) >= far) & u16::from(own != 0) & u16::from(other != 0);
                (apart, apart & u16::from(other < own))
            }),
        }
    }

    /// The same; `side` tells of the row at `row + by`, of a fenced one, whether it went elsewhere, and whether down.
    #[inline(always)]
    fn cells_by(&self, side: impl Fn(usize, usize) -> (u16, u16)) -> Lanes {
        let mut cells = [0; ROWS];
        for (row, cell) in cells.iter_mut().enumerate() {
            let at = row + FENCE;
            let energy = 3 * self.energy[at] + self.energy[at - 1] + self.energy[at + 1];
            let energy = (f32::from(energy).to_bits() >> 22) as u16;
            let energy = energy.saturating_sub(ENERGY_FIRST).min(ENERGIES - 1);
            let flip = self.flip[row];
            let turned = |(moved, negative): (u16, u16)| moved + (moved & (negative ^ flip));
            *cell = ENERGY * energy
                + SIZE * self.size[row]
                + BEFORE * turned((self.moved_before[row], self.negative_before[row]))
                + SOUTH * turned(side(row, FENCE + 1))
                + NORTH * turned(side(row, FENCE - 1))
                + self.place[row]
                + MISSED * self.missed[row];
        }
        cells
    }

    /// Whether a row that holds a return was never seen.
    #[inline]
    pub(crate) fn has_new(&self, levels: &Lanes) -> bool {
        let new = self.predicted[INSIDE]
            .iter()
            .zip(levels)
            .map(|(&predicted, &level)| u16::from(predicted == 0 && level != 0));
        new.fold(0, |any, new| any | new) != 0
    }

    /// Predicts rows that were never seen from the nearest return above; `residual` is asked from the first row to the
    /// last.
    #[cold]
    pub(crate) fn predict_new(
        &mut self,
        levels: &Lanes,
        scale: &Scale,
        mut residual: impl FnMut(usize, u16) -> (u16, u16),
    ) {
        let mut above = 1;
        for (row, predicted) in self.predicted[INSIDE].iter_mut().enumerate() {
            if levels[row] == 0 {
                continue;
            }
            if *predicted == 0 {
                *predicted = above;
            }
            let (steps, negative) = residual(row, *predicted);
            above = scale.level(*predicted, steps, negative);
        }
    }

    /// The residuals of the rows that hold returns.
    #[inline(never)]
    pub(crate) fn residuals(&self, levels: &Lanes, scale: &Scale, residuals: &mut Residuals) {
        let scale = *scale;
        for (row, &level) in levels.iter().enumerate() {
            let predicted = self.predicted[row + FENCE];
            let (steps, negative) = scale.residual(level, predicted);
            let occupied = u16::from(level != 0).wrapping_neg();
            residuals.steps[row] = steps & occupied;
            residuals.negative[row] = negative & occupied;
        }
    }

    /// Takes in a column: where `levels` is not 0 it becomes what the residual makes of the prediction.
    #[inline]
    pub(crate) fn advance(&mut self, levels: &mut Lanes, scale: &Scale, residuals: &Residuals) {
        let mut occupied = [0; ROWS];
        for (occupied, level) in occupied.iter_mut().zip(&*levels) {
            *occupied = u16::from(*level != 0).wrapping_neg();
        }
        reconstruct(levels, &mut self.predicted, residuals, *scale);
        self.remember_sizes(&occupied, &residuals.steps);
        self.remember_signs(&occupied, residuals);
    }

    #[inline(never)]
    fn remember_sizes(&mut self, occupied: &Lanes, steps: &Lanes) {
        let energies = self.energy[INSIDE].iter_mut();
        for (((energy, size), &occupied), &steps) in energies.zip(&mut self.size).zip(occupied).zip(steps) {
            let now = (3 * *energy + 16 * steps.min(ENERGY_RESIDUAL_MAX)) / 4;
            *energy = pick(occupied, now, *energy);
            *size = pick(occupied, steps.min(SIZE_MAX), *size);
        }
        for (missed, &occupied) in self.missed.iter_mut().zip(occupied) {
            *missed = !occupied & 1;
        }
    }

    #[inline(never)]
    fn remember_signs(&mut self, occupied: &Lanes, residuals: &Residuals) {
        for row in 0..ROWS {
            let (at, occupied) = (row + FENCE, occupied[row]);
            let moved = u16::from(residuals.steps[row] != 0);
            let negative = residuals.negative[row] & moved;
            self.flip[row] = pick(occupied, negative | (self.flip[row] & (moved ^ 1)), self.flip[row]);
            self.moved_before[row] = pick(occupied, self.moved[at], self.moved_before[row]);
            self.negative_before[row] = pick(occupied, self.negative[at], self.negative_before[row]);
            self.moved[at] = pick(occupied, moved, self.moved[at]);
            self.negative[at] = pick(occupied, negative, self.negative[at]);
        }
    }
}

/// `new` where all bits of `mask` are set, `old` where none is.
#[inline(always)]
const fn pick(mask: u16, new: u16, old: u16) -> u16 {
    (new & mask) | (old & !mask)
}

#[inline(never)]
fn reconstruct(levels: &mut Lanes, predicted: &mut Fenced, residuals: &Residuals, scale: Scale) {
    let mut decoded = [0; ROWS];
    for row in 0..ROWS {
        decoded[row] = scale.level(predicted[row + FENCE], residuals.steps[row], residuals.negative[row]);
    }
    for row in 0..ROWS {
        let occupied = u16::from(levels[row] != 0).wrapping_neg();
        let predicted = &mut predicted[row + FENCE];
        let next = scale.filter.next(residuals.steps[row], *predicted, decoded[row]);
        levels[row] = decoded[row] & occupied;
        *predicted = pick(occupied, next, *predicted);
    }
}

/// Steps in the arithmetic of lanes: the same results as [`Step`]'s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    levels: u16,
    dead: u16,
    /// 2^16 / levels, rounded down: with it quotients are right or one too small.
    inverse: u16,
    /// Remainders from which a residual is one step, or two steps, more.
    round: [u16; 2],
    /// Most steps whose levels fit a lane.
    most: u16,
    max_level: u16,
    filter: Filter,
    /// Where set, contexts look at whether neighbors are predicted this far off, not at how they moved.
    edge: Option<u16>,
}

/// From so many levels a step on, edges say more than what neighbors did.
pub(crate) const EDGES_FROM: u16 = 80;

impl Scale {
    pub(crate) const fn new(step: Step, noise: u8, max_level: u16) -> Self {
        let levels = step.levels();
        let half_up = levels - levels / 2;
        Self {
            levels,
            dead: step.error_max(),
            inverse: if levels == 1 { u16::MAX } else { ((1 << 16) / levels as u32) as u16 },
            round: [half_up, half_up.saturating_add(levels)],
            most: u16::MAX / levels,
            max_level,
            filter: Filter::new(step, noise),
            edge: if levels < EDGES_FROM { None } else { Some(half_up) },
        }
    }

    /// Steps from `predicted` to `level`, rounded, and 1 where down.
    #[inline(always)]
    pub(crate) fn residual(&self, level: u16, predicted: u16) -> (u16, u16) {
        let distance = level.abs_diff(predicted);
        let quotient = ((u32::from(distance) * u32::from(self.inverse)) >> 16) as u16;
        let rest = distance.wrapping_sub(quotient.wrapping_mul(self.levels));
        let steps = quotient + u16::from(rest >= self.round[0]) + u16::from(rest >= self.round[1]);
        let alive = u16::from(distance > self.dead).wrapping_neg();
        (steps & alive, u16::from(level < predicted))
    }

    /// The level that is so many steps from `predicted`, or the nearest that there is.
    #[inline(always)]
    pub(crate) fn level(&self, predicted: u16, steps: u16, negative: u16) -> u16 {
        let beyond = u16::from(steps > self.most).wrapping_neg();
        let distance = steps.wrapping_mul(self.levels) | beyond;
        let up = predicted.saturating_add(distance).min(self.max_level);
        let down = predicted.saturating_sub(distance).max(1);
        let negative = negative.wrapping_neg();
        pick(negative, down, up)
    }
}

#[cfg(test)]
mod tests {
    use super::{Scale, Step};

    /// Lanes compute what the scalar code computes, for levels and predictions spread over all there are.
    #[test]
    fn scale_agrees_with_step() {
        let spread = |by: usize| (1..=u16::MAX).step_by(by).chain([2, 3, u16::MAX - 1, u16::MAX]);
        for levels in (1..300).chain(spread(2111)) {
            for step in [Step::new(levels), Step::exact(levels)].map(Option::unwrap) {
                let scale = Scale::new(step, 20, u16::MAX);
                for level in spread(397) {
                    for predicted in spread(1009) {
                        let (steps, negative) = scale.residual(level, predicted);
                        let residual = step.residual(level, predicted);
                        assert_eq!(u32::from(steps), residual.distance, "{step:?} {level} {predicted}");
                        assert!(steps == 0 || (negative == 1) == residual.is_negative, "{step:?} {level} {predicted}");
                        let decoded = scale.level(predicted, steps, negative);
                        assert_eq!(decoded, step.level(residual, predicted, u16::MAX), "{step:?} {level} {predicted}");
                        assert!(decoded.abs_diff(level) <= step.error_max());
                    }
                }
            }
        }
    }
}
