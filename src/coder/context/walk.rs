//! The way through an image, the same for both tiers and both directions: column by column, first which pixels hold
//! returns, then their residuals from the top to the bottom. Which decisions there are stands here; how likely each is,
//! a [`Model`] says.

use super::beam::{ABOVE, Beam, Beams, Filter, NEAR_ROWS, Near, NearQuad, QUAD_ROWS};
use super::column::{Column, GROUP_ROWS};
use super::range_coder::BinaryCoder;
use super::step::{Residual, Step};
use super::surroundings::{CalmSurroundings, Flag, GroupSurroundings, SetSurroundings, Surroundings};

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
    /// Whether it looks at ages and at what lies beside an edge.
    const REMEMBERS: bool;

    /// Rows have a common flag where their mean energy is less than this.
    fn calm_energy(&self) -> u32;

    /// Whether a group's set of returns is that of the column before.
    fn same(&mut self, coder: &mut impl BinaryCoder, at: &GroupSurroundings<'_>, decision: bool) -> bool;
    /// Whether a pixel holds a return.
    fn occupied(&mut self, coder: &mut impl BinaryCoder, at: &SetSurroundings<'_>, decision: bool) -> bool;
    /// Whether any residual of a few calm rows is not 0.
    fn active(&mut self, coder: &mut impl BinaryCoder, at: &CalmSurroundings<'_>, decision: bool) -> bool;
    /// The residual of a return.
    fn residual<C: BinaryCoder>(&mut self, coder: &mut C, at: &Surroundings<'_>, residual: Residual) -> Residual;
}

/// What goes down a column.
struct Down {
    /// The last return's level; 0 before the first.
    level: u16,
    /// What the level of the row above was before, if it is a return; 0 if it is not, or had not been seen.
    north_west: u16,
    /// What the flag of the four rows above said; 2 where they had none.
    active: u8,
    /// What is known by that of these rows.
    flag: Flag,
}

/// For four rows without a flag.
const NO_FLAG: u8 = 2;

impl Walk {
    /// One column: given, in the forward direction; filled in, in the inverse one, where it must be empty. Its levels come
    /// out as the decoder knows them.
    #[inline(always)]
    pub(crate) fn column<const GROUPS: usize>(
        &self,
        model: &mut impl Model,
        beams: &mut Beams<GROUPS>,
        coder: &mut impl BinaryCoder,
        column: &mut Column<GROUPS>,
    ) {
        self.sets(model, beams, coder, &mut column.sets);
        let mut first = 0;
        let mut down = Down { level: 0, north_west: 0, active: NO_FLAG, flag: Flag::NONE };
        let mut edge = [Beam::NEW; NEAR_ROWS];
        for (levels, &set) in column.levels.iter_mut().zip(&column.sets) {
            let mut set = set;
            for levels in levels.as_chunks_mut().0 {
                let returns = set & 15;
                if returns == 0 {
                    (down.active, down.north_west) = (NO_FLAG, 0);
                } else {
                    let is_edge = first == 0 || first + QUAD_ROWS == GROUPS * GROUP_ROWS;
                    let near = if is_edge {
                        beams.at_edge(first, &mut edge);
                        Some(&mut edge)
                    } else {
                        beams.near(first)
                    };
                    let Some(near) = near else { return };
                    self.quad(model, coder, near, &mut down, (first, returns), levels);
                    if is_edge {
                        beams.set_at_edge(first, &edge);
                    }
                }
                set >>= QUAD_ROWS;
                first += QUAD_ROWS;
            }
        }
    }

    #[inline(always)]
    fn sets<const GROUPS: usize>(
        &self,
        model: &mut impl Model,
        beams: &mut Beams<GROUPS>,
        coder: &mut impl BinaryCoder,
        sets: &mut [u8; GROUPS],
    ) {
        let groups = self.rows.div_ceil(GROUP_ROWS);
        let (mut above, mut above_west, mut same_above) = (0, 0, 2);
        for (group, set) in sets.iter_mut().enumerate() {
            if group * GROUP_ROWS >= self.rows {
                break;
            }
            let past = beams.sets[group];
            let west = past.west();
            let at = GroupSurroundings { group, groups, sets: past, same_above, beams: beams.group(group) };
            if model.same(coder, &at, *set == west) {
                *set = west;
                beams.sets[group] = past.then(west, 1);
                same_above = 1;
            } else {
                let below_west = beams.sets.get(group + 1).map_or(0, |below| below.west());
                let rows = (self.rows - group * GROUP_ROWS).min(GROUP_ROWS);
                *set = changed_set(model, coder, &at, [above, above_west, below_west], rows, *set);
                beams.sets[group] = past.then(*set, 0);
                same_above = 0;
            }
            (above, above_west) = (*set, west);
        }
    }

    /// Four rows from `first` on, of which those in `set` are returns.
    #[inline(always)]
    fn quad<M: Model>(
        &self,
        model: &mut M,
        coder: &mut impl BinaryCoder,
        near: &mut NearQuad,
        down: &mut Down,
        (first, set): (usize, u8),
        levels: &mut [u16; QUAD_ROWS],
    ) {
        let active_above = core::mem::replace(&mut down.active, NO_FLAG);
        down.flag = Flag::NONE;
        // What a median predicts is known only when the rows above are.
        if self.predictor == Predictor::West
            && let Some(at) = calm(near, model.calm_energy(), active_above, set)
        {
            let active = model.active(coder, &at, self.is_active(near, set, *levels));
            down.active = u8::from(active);
            if !active {
                return self.calm_rows::<M>(near, down, set, levels);
            }
            down.flag = Flag::OPEN;
        }
        let (mut set, mut rows, mut row) = (set, near.as_mut_slice(), first);
        for level in levels {
            let Some(near) = rows.first_chunk_mut() else { return };
            if set & 1 == 0 {
                down.north_west = 0;
            } else {
                self.pixel(model, coder, near, down, (row, set == 1), level);
            }
            let Some(rest) = rows.get_mut(1..) else { return };
            (set, rows, row) = (set >> 1, rest, row + 1);
        }
    }

    /// Whether a residual of four rows, each predicted by its own beam, is not 0.
    #[inline(always)]
    fn is_active(&self, near: &NearQuad, set: u8, levels: [u16; QUAD_ROWS]) -> bool {
        let is_off = |lane: usize| self.step.is_off(levels[lane], near[ABOVE + lane].predicted);
        if set == 15 {
            return is_off(0) || is_off(1) || is_off(2) || is_off(3);
        }
        (0..QUAD_ROWS).any(|lane| set >> lane & 1 == 1 && is_off(lane))
    }

    /// Four rows whose residuals are 0.
    #[inline(always)]
    fn calm_rows<M: Model>(&self, near: &mut NearQuad, down: &mut Down, set: u8, levels: &mut [u16; QUAD_ROWS]) {
        let follows_slopes = self.filter.follows_slopes();
        let stay = |lane: usize| {
            let beam = &mut near[ABOVE + lane];
            beam.stay(M::REMEMBERS, follows_slopes, &self.filter);
            down.level = beam.level;
            levels[lane] = beam.level;
        };
        if set == 15 && !follows_slopes {
            (0..QUAD_ROWS).for_each(stay);
        } else {
            (0..QUAD_ROWS).filter(|lane| set >> lane & 1 == 1).for_each(stay);
        }
    }

    /// A return.
    #[inline(always)]
    fn pixel<M: Model>(
        &self,
        model: &mut M,
        coder: &mut impl BinaryCoder,
        near: &mut Near,
        down: &mut Down,
        (row, is_last): (usize, bool),
        level: &mut u16,
    ) {
        let west = near[ABOVE].level;
        if near[ABOVE].predicted == 0 || self.predictor == Predictor::MedianEdge {
            near[ABOVE].predicted = predicted(&near[ABOVE], &near[ABOVE - 1], down.level, down.north_west);
        }
        let at = Surroundings { row, rows: self.rows, near, flag: down.flag, is_last };
        let residual = model.residual(coder, &at, self.step.residual(*level, at.predicted()));
        let own = &mut near[ABOVE];
        if residual.distance == 0 {
            own.stay(M::REMEMBERS, self.filter.follows_slopes(), &self.filter);
        } else {
            down.flag.see();
            let level = self.step.level(residual, own.predicted, self.max_level);
            own.update(M::REMEMBERS, residual, level, &self.filter);
        }
        *level = own.level;
        (down.level, down.north_west) = (own.level, west);
    }
}

/// The prediction where it is not just the beam's own: a level.
#[cold]
#[inline(never)]
fn predicted(own: &Beam, north: &Beam, last: u16, north_west: u16) -> u16 {
    if own.level == 0 {
        last.max(1)
    } else if north_west == 0 {
        own.predicted
    } else {
        median_edge(own.level, north.level, north_west)
    }
}

fn median_edge(west: u16, north: u16, north_west: u16) -> u16 {
    let plane = i32::from(west) + i32::from(north) - i32::from(north_west);
    plane.max(west.min(north).into()).min(west.max(north).into()) as u16
}

/// What surrounds the flag of a few rows; `None` where they have none: those that are not calm. Those that were never
/// seen are not, for their energy is the one that beams start with.
#[inline(always)]
fn calm(near: &NearQuad, most_energy: u32, active_above: u8, set: u8) -> Option<CalmSurroundings<'_>> {
    let energy_of = |lane: usize| u32::from(near[ABOVE + lane].energy);
    let energy = if set == 15 {
        (energy_of(0) + energy_of(1) + energy_of(2) + energy_of(3)) / 4
    } else {
        // More than one of four bits.
        if set & set.wrapping_sub(1) == 0 {
            return None;
        }
        let energies = (0..QUAD_ROWS).filter(|lane| set >> lane & 1 == 1).map(energy_of);
        energies.sum::<u32>().checked_div(set.count_ones())?
    };
    (energy < most_energy).then(|| CalmSurroundings {
        near,
        set,
        energy,
        active_above,
        north: near[ABOVE - 1].size != 0,
        south_west: near[ABOVE + QUAD_ROWS].size != 0,
    })
}

/// The set of a group, known not to be that of the column before. `around` are the sets of the group above in this
/// column and the last, and that of the group below in the last.
#[inline(always)]
fn changed_set(
    model: &mut impl Model,
    coder: &mut impl BinaryCoder,
    group: &GroupSurroundings<'_>,
    [above, above_west, below_west]: [u8; 3],
    rows: usize,
    set: u8,
) -> u8 {
    let [west, west2, west3] = group.sets.last().map(u32::from);
    let below = u32::from(below_west) << 8 | west;
    // Of each, what is behind the row; of this column, what was before it.
    let mut at = SetSurroundings {
        west,
        west2,
        west3,
        south_west: below >> 1,
        north: u32::from(above >> 7) | u32::from(above >> 6 & 1) << 1,
        north_west: west << 1 | u32::from(above_west) >> 7,
        changed: false,
        beam: &Beam::NEW,
    };
    let (mut found, mut set) = (0, u32::from(set));
    for row in 0..rows {
        at.beam = group.beams.get(row).unwrap_or(&Beam::NEW);
        // Where only the last pixel can have changed, it has.
        let is_known = row + 1 == rows && !at.changed;
        let occupied = if is_known { !at.is_west() } else { model.occupied(coder, &at, set & 1 == 1) };
        at.changed |= at.is_west() != occupied;
        found |= u32::from(occupied) << row;
        at.go_down(occupied);
        set >>= 1;
    }
    found as u8
}
