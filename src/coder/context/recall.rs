//! What the frame before says of a strip: for a sensor that stands still, nearly all of it.
//!
//! The walk through the image knows nothing of this. Before each column, the beams' predictions are replaced by the levels that
//! were at the same place in the frame before, where these were the better predictions lately, and behind it the beams are
//! shown what they would have learned by themselves. What was the prediction else goes where a beam has the level that it may
//! return to ([`Beam::other`]), so that models see both.

use super::beam::{Beam, Beams, Filter, Sets, decayed};
use super::column::{Column, GROUP_ROWS};
use super::range_coder::BinaryCoder;
use super::step::Step;
use super::walk::{Model, Walk};
use crate::image::{ImageViewMut, Level};

/// The levels of the frame before at the places of this one's pixels, 0 where there was no return; they become this one's.
#[derive(Debug)]
pub struct Recall<'a> {
    memory: ImageViewMut<'a, u16>,
    /// Column of the memory that is the strip's first.
    pub(crate) first: usize,
    /// Whether strips may be coded by what was before.
    pub(crate) is_tried: bool,
    /// Whether one was.
    pub(crate) is_used: bool,
}

impl<'a> Recall<'a> {
    pub(crate) const fn new(memory: ImageViewMut<'a, u16>, is_tried: bool) -> Self {
        Self { memory, first: 0, is_tried, is_used: false }
    }

    /// Reads what was at a column of the strip.
    pub(super) fn load<const GROUPS: usize>(&self, at: usize, column: &mut Column<GROUPS>) {
        column.load(self.memory.as_view(), self.first + at);
    }

    /// Keeps a column of the strip.
    pub(super) fn store<const GROUPS: usize>(&mut self, at: usize, column: &Column<GROUPS>) {
        column.store(&mut self.memory, self.first + at);
    }

    /// Keeps all levels of a strip, row-major.
    pub(crate) fn store_all<L: Level>(&mut self, levels: impl Iterator<Item = L>, columns: usize) {
        let stride = self.memory.columns().max(1);
        for (at, level) in levels.enumerate() {
            let (row, column) = (at / columns.max(1), at % columns.max(1));
            if let Some(kept) = self.memory.levels().get_mut(row * stride + self.first + column) {
                *kept = level.get();
            }
        }
    }
}

/// Which of two predictions was nearer lately, of each row; and of each group, which of two sets of returns.
#[derive(Debug)]
pub(super) struct Judge<const GROUPS: usize> {
    /// The beams as they were before the column.
    beams: [[Beam; GROUP_ROWS]; GROUPS],
    /// Mean distance of the levels from the beams' own predictions, and from what was before.
    own: [[u16; GROUP_ROWS]; GROUPS],
    before: [[u16; GROUP_ROWS]; GROUPS],
    /// The same of sets, by the pixels that differ.
    own_sets: [u16; GROUPS],
    before_sets: [u16; GROUPS],
    /// Which rows' beams were told what was before.
    told: [u8; GROUPS],
    sets: [Sets; GROUPS],
    /// Most levels that a level and what was kept are apart if they are the same thing's.
    noise: u8,
}

impl<const GROUPS: usize> Judge<GROUPS> {
    pub(super) const fn new(noise: u8) -> Self {
        Self {
            noise,
            beams: [[Beam::NEW; GROUP_ROWS]; GROUPS],
            own: [[16; GROUP_ROWS]; GROUPS],
            before: [[0; GROUP_ROWS]; GROUPS],
            own_sets: [16; GROUPS],
            before_sets: [0; GROUPS],
            told: [0; GROUPS],
            sets: [Sets::NEW; GROUPS],
        }
    }

    /// One column, as [`Walk::column`] goes through it, with what was before.
    pub(super) fn column(
        &mut self,
        walk: &Walk,
        (model, beams): (&mut impl Model, &mut Beams<GROUPS>),
        coder: &mut impl BinaryCoder,
        (column, at): (&mut Column<GROUPS>, usize),
        recall: &mut Recall<'_>,
    ) {
        let mut before = Column::new();
        recall.load(at, &mut before);
        self.tell(beams, &before, &walk.filter);
        walk.column(model, beams, coder, column);
        self.learn(beams, (&before, column), walk.step, &walk.filter);
        recall.store(at, &merged(&before, column, self.noise));
    }

    /// Tells the beams what was before at a column that is about to be coded.
    fn tell(&mut self, beams: &mut Beams<GROUPS>, before: &Column<GROUPS>, filter: &Filter) {
        self.sets = beams.sets;
        let rows = beams.rows().iter_mut().zip(&before.levels).enumerate();
        for (group, (beams, levels)) in rows {
            self.beams[group] = *beams;
            self.told[group] = 0;
            for (row, (beam, &level)) in beams.iter_mut().zip(levels).enumerate() {
                if level != 0 && (beam.level == 0 || self.before[group][row] <= self.own[group][row]) {
                    self.told[group] |= 1 << row;
                    beam.expect(level, filter);
                }
            }
        }
        for (group, sets) in beams.sets.iter_mut().enumerate() {
            if self.before_sets[group] <= self.own_sets[group] {
                *sets = sets.told(before.sets[group]);
            }
        }
    }

    /// Shows the beams the column as it came out, and judges.
    fn learn(
        &mut self,
        beams: &mut Beams<GROUPS>,
        (before, column): (&Column<GROUPS>, &Column<GROUPS>),
        step: Step,
        filter: &Filter,
    ) {
        for (group, beams) in beams.rows().iter_mut().enumerate() {
            for (row, beam) in beams.iter_mut().enumerate() {
                let (level, was, own) = (column.levels[group][row], before.levels[group][row], self.beams[group][row]);
                let is_told = self.told[group] >> row & 1 == 1;
                if level == 0 {
                    *beam = if is_told { own } else { *beam };
                    continue;
                }
                if was != 0 && own.level != 0 {
                    let off = |from: u16| u32::from(level.abs_diff(from));
                    self.own[group][row] = decayed(self.own[group][row], off(own.predicted));
                    self.before[group][row] = decayed(self.before[group][row], off(was));
                }
                if is_told {
                    beam.learn_as(own, level, step.residual(level, own.predicted), filter);
                }
            }
        }
        for (group, sets) in beams.sets.iter_mut().enumerate() {
            let own = self.sets[group];
            let off = |set: u8| (column.sets[group] ^ set).count_ones();
            self.own_sets[group] = decayed(self.own_sets[group], off(own.west()));
            self.before_sets[group] = decayed(self.before_sets[group], off(before.sets[group]));
            *sets = sets.learned(own, column.sets[group]);
        }
    }
}

/// What is kept of a column: levels, each half way from what was kept, which smooths out the noise of the last frames.
fn merged<const GROUPS: usize>(before: &Column<GROUPS>, column: &Column<GROUPS>, noise: u8) -> Column<GROUPS> {
    let mut merged = Column::new();
    let rows = before.levels.as_flattened().iter().zip(column.levels.as_flattened());
    for (merged, (&before, &level)) in merged.levels.as_flattened_mut().iter_mut().zip(rows) {
        let is_same = before != 0 && level != 0 && level.abs_diff(before) <= u16::from(noise);
        *merged = if is_same { (u32::from(before) + u32::from(level)).div_ceil(2) as u16 } else { level };
    }
    merged
}
