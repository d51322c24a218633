//! The way through an image, the same for both tiers and both directions: column by column, first which pixels hold
//! returns, then their residuals from the top to the bottom. Which decisions there are stands here; how likely each is,
//! a [`Model`] says.

use super::beam::{Beam, Beams, Filter, decayed};
use super::column::{Column, GROUP_ROWS};
use super::range_coder::BinaryCoder;
use super::step::Step;
use super::surroundings::{CalmSurroundings, Flag, GroupSurroundings, SetSurroundings, Surroundings};

/// Rows that share a flag where the neighborhood is calm.
const CALM_ROWS: usize = 4;

/// What a strip says of its code besides the tier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walk {
    pub(crate) step: Step,
    pub(crate) filter: Filter,
    pub(crate) predictor: Predictor,
    pub(crate) rows: usize,
    pub(crate) max_level: u16,
}

/// What a level is predicted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Predictor {
    /// The beam's own last levels, filtered: best where columns are close together.
    #[default]
    West,
    /// The median of the beam's last level, the level above, and the plane through these and the one between them:
    /// best where columns are far apart or beams close together.
    ///
    /// Source: the median edge detector of JPEG-LS (ITU-T T.87).
    MedianEdge,
}

/// Probabilities of all decisions, adapted by each. Decisions are given in the forward direction, and found in the
/// inverse one.
pub(crate) trait Model {
    /// Rows have a common flag where their mean energy is less than this.
    const CALM_ENERGY: u32;

    /// Whether a group's set of returns is that of the column before.
    fn same(&mut self, coder: &mut impl BinaryCoder, at: &GroupSurroundings, decision: bool) -> bool;
    /// Whether a pixel holds a return.
    fn occupied(&mut self, coder: &mut impl BinaryCoder, at: &SetSurroundings, decision: bool) -> bool;
    /// Whether any residual of a few calm rows is not 0.
    fn active(&mut self, coder: &mut impl BinaryCoder, at: &CalmSurroundings, decision: bool) -> bool;
    /// The residual of a return.
    fn residual(&mut self, coder: &mut impl BinaryCoder, at: &Surroundings, residual: i32) -> i32;
}

/// What goes down a column.
struct Down {
    /// Energy of the residuals so far; `None` before the first.
    energy: Option<u16>,
    /// The last return's level; 0 before the first.
    level: u16,
    /// What the rows' flag said; `None` where they had none.
    active: Option<bool>,
    /// Where the row above is a return of this column: its beam's level before.
    north_west: Option<u16>,
}

impl Walk {
    /// One column: given, in the forward direction; filled in, in the inverse one. Its levels come out as the decoder
    /// knows them.
    #[inline]
    pub(crate) fn column<const GROUPS: usize>(
        &self,
        model: &mut impl Model,
        beams: &mut Beams<GROUPS>,
        coder: &mut impl BinaryCoder,
        column: &mut Column<GROUPS>,
    ) {
        self.sets(model, beams, coder, &mut column.sets);
        let mut down = Down { energy: None, level: 0, active: None, north_west: None };
        let rows = column.levels.as_flattened_mut().chunks_exact_mut(CALM_ROWS);
        let halves = column.sets.iter().flat_map(|set| [set & 15, set >> 4]);
        for (first, (levels, set)) in (0..self.rows).step_by(CALM_ROWS).zip(rows.zip(halves)) {
            self.rows(model, beams, coder, &mut down, (first, set), levels);
        }
    }

    fn sets<const GROUPS: usize>(
        &self,
        model: &mut impl Model,
        beams: &mut Beams<GROUPS>,
        coder: &mut impl BinaryCoder,
        sets: &mut [u8; GROUPS],
    ) {
        let groups = self.rows.div_ceil(GROUP_ROWS);
        let (mut above, mut above_west, mut same_above) = (0, 0, None);
        for (group, set) in sets.iter_mut().enumerate().take(groups) {
            let left = self.rows - group * GROUP_ROWS;
            let rows = if left >= GROUP_ROWS { u8::MAX } else { (1 << left) - 1 };
            let [west, ..] = beams.sets(group);
            let same_before = beams.same.get(group).copied().unwrap_or_default() & 3;
            let (eighth, energy) = (group * 8 / groups, beams.energy(group));
            let at = GroupSurroundings { eighth, west, rows, same_before, same_above, energy };
            let same = model.same(coder, &at, *set == west);
            *set = if same { west } else { changed_set(model, beams, coder, (group, rows), [above, above_west], *set) };
            (above, above_west, same_above) = (*set, west, Some(same));
            if let Some(before) = beams.same.get_mut(group) {
                *before = *before << 1 | u8::from(same);
            }
        }
        beams.shift_sets(sets);
    }

    /// A few rows, of which `set` are returns.
    #[inline(always)]
    fn rows<M: Model, const GROUPS: usize>(
        &self,
        model: &mut M,
        beams: &mut Beams<GROUPS>,
        coder: &mut impl BinaryCoder,
        down: &mut Down,
        (first, set): (usize, u8),
        levels: &mut [u16],
    ) {
        let active_above = down.active.take();
        if set == 0 {
            down.north_west = None;
            levels.fill(0);
            return;
        }
        let mut flag = Flag::None;
        // What a median predicts is known only when the rows above are.
        let may_be_calm = self.predictor == Predictor::West && M::CALM_ENERGY > 0;
        if let Some(at) = calm(beams, may_be_calm.then_some(M::CALM_ENERGY), active_above, (first, set)) {
            let is_active = |(row, &level): (usize, &u16)| {
                level != 0 && self.step.residual(level, beams.get(first + row).predicted) != 0
            };
            let active = model.active(coder, &at, levels.iter().enumerate().any(is_active));
            down.active = Some(active);
            flag = if active { Flag::Open } else { Flag::Calm };
        }
        for (row, level) in levels.iter_mut().enumerate() {
            if set >> row & 1 == 0 {
                *level = 0;
                down.north_west = None;
                continue;
            }
            if flag == Flag::Open && set >> row == 1 {
                flag = Flag::Due;
            }
            let residual = self.pixel(model, beams, coder, down, (first + row, flag), level);
            if flag == Flag::Open && residual != 0 {
                flag = Flag::Seen;
            }
        }
    }

    /// A return.
    #[inline(always)]
    fn pixel<const GROUPS: usize>(
        &self,
        model: &mut impl Model,
        beams: &mut Beams<GROUPS>,
        coder: &mut impl BinaryCoder,
        down: &mut Down,
        (row, flag): (usize, Flag),
        level: &mut u16,
    ) -> i32 {
        let (own, north) = (beams.get(row), beams.get(row.wrapping_sub(1)));
        let predicted = self.predicted(own, north, down);
        let column_energy = down.energy.unwrap_or(own.energy);
        let residual = if flag == Flag::Calm {
            0
        } else {
            let at = Surroundings {
                quarter: row * 4 / self.rows,
                predicted,
                own,
                north,
                north2: beams.get(row.wrapping_sub(2)),
                south_west: beams.get(row + 1),
                south_west2: beams.get(row + 2),
                column_energy,
                flag,
            };
            model.residual(coder, &at, self.step.residual(*level, predicted))
        };
        *level = self.step.level(residual, predicted, self.max_level);
        if let Some(beam) = beams.get_mut(row) {
            beam.update(residual, predicted, *level, &self.filter);
        }
        down.energy = Some(decayed(column_energy, residual));
        down.level = *level;
        down.north_west = Some(own.level);
        residual
    }

    #[inline(always)]
    fn predicted(&self, own: Beam, north: Beam, down: &Down) -> u16 {
        if own.level == 0 {
            return down.level.max(1);
        }
        match (self.predictor, down.north_west) {
            (Predictor::MedianEdge, Some(north_west)) if north_west != 0 => {
                median_edge(own.level, north.level, north_west)
            }
            _ => own.predicted,
        }
    }
}

fn median_edge(west: u16, north: u16, north_west: u16) -> u16 {
    let plane = i32::from(west) + i32::from(north) - i32::from(north_west);
    plane.clamp(i32::from(west.min(north)), i32::from(west.max(north))) as u16
}

/// What surrounds the flag of a few rows; `None` where they have none: those that are not calm, and those that would
/// not be predicted from themselves.
#[inline(always)]
fn calm<const GROUPS: usize>(
    beams: &Beams<GROUPS>,
    most_energy: Option<u32>,
    active_above: Option<bool>,
    (first, set): (usize, u8),
) -> Option<CalmSurroundings> {
    let returns = set.count_ones();
    let most_energy = most_energy.filter(|_| returns >= 2)?;
    let mut energy = 0;
    for row in 0..CALM_ROWS {
        let beam = beams.get(first + row);
        if set >> row & 1 == 1 {
            if beam.level == 0 {
                return None;
            }
            energy += u32::from(beam.energy);
        }
    }
    let calm = energy < most_energy * returns;
    let moved = |row: usize| beams.get(row).size != 0;
    calm.then(|| CalmSurroundings {
        energy,
        returns,
        active_above,
        north: moved(first.wrapping_sub(1)),
        south_west: moved(first + CALM_ROWS),
    })
}

/// The set of a group, known not to be that of the column before. `above` are the sets of the group above in this
/// column and the last.
fn changed_set<const GROUPS: usize>(
    model: &mut impl Model,
    beams: &Beams<GROUPS>,
    coder: &mut impl BinaryCoder,
    (group, rows): (usize, u8),
    above: [u8; 2],
    set: u8,
) -> u8 {
    let [west, west2, west3] = beams.sets(group);
    let [below_west, ..] = beams.sets(group + 1);
    let [north, north_west] = above.map(u16::from);
    // Eight rows and the two above them, the highest in bit 0; eight rows and the one below.
    let north_west = u16::from(west) << 2 | north_west >> 6;
    let south_west = u16::from(below_west) << 8 | u16::from(west);
    let (mut found, mut changed) = (0, false);
    for row in 0..rows.count_ones() {
        let bit = |set: u8| set >> row & 1 == 1;
        let down = u16::from(found) << 2 | north >> 6;
        let at = SetSurroundings {
            west: bit(west),
            west2: bit(west2),
            west3: bit(west3),
            north: down >> (row + 1) & 1 == 1,
            north2: down >> row & 1 == 1,
            north_west: north_west >> (row + 1) & 1 == 1,
            south_west: south_west >> (row + 1) & 1 == 1,
            changed,
            energy: beams.get(group * GROUP_ROWS + row as usize).energy,
        };
        // Where only the last pixel can have changed, it has.
        let is_known = rows >> row == 1 && !changed;
        let occupied = if is_known { !at.west } else { model.occupied(coder, &at, bit(set)) };
        found |= u8::from(occupied) << row;
        changed |= at.west != occupied;
    }
    found
}
