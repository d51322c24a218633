//! Points into the range image: project, quantize, settle collisions, count.

use crate::geometry::{Cells, Projection};
use crate::image::{ImageViewMut, Level};
use crate::point::{Block, Points};
use crate::quantize::{OutOfScale, Quantizer};
use crate::tally::Tally;

/// Which point a pixel keeps where several fall into it. Points whose levels are equal are the same to all but
/// `First` and `Last`, and to those too once they are in the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Collision {
    /// The nearest: what a sensor that sees only the first surface would report.
    #[default]
    Nearest,
    /// The farthest.
    Farthest,
    /// The first inserted.
    First,
    /// The last inserted, as in the code that made the paper's tables.
    Last,
}

/// What is done with points above the first row or below the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OutOfView {
    /// Dropped and counted.
    #[default]
    Drop,
    /// Moved into the first or last row, and counted.
    Clamp,
}

/// How points are put into pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Policy {
    /// Several points in one pixel.
    pub collision: Collision,
    /// Points outside the elevations.
    pub out_of_view: OutOfView,
}

/// Inserts `points` into `image` and counts in `tally` what became of each.
///
/// `image` must have `projection`'s size; pixels behind a smaller image are counted as out of view.
pub fn insert<L: Level>(
    points: &(impl Points + ?Sized),
    projection: &impl Projection,
    quantizer: &Quantizer,
    policy: Policy,
    image: &mut ImageViewMut<'_, L>,
    tally: &mut Tally,
) {
    let rows = u32::from(projection.rows());
    let mut inserter = Inserter { quantizer, policy, rows, image, tally };
    let mut cells = Cells::new();
    points.for_each_block(|block, len| {
        projection.project(block, &mut cells);
        inserter.insert_block(block, &cells, len);
    });
}

struct Inserter<'a, 'i, L: Level> {
    quantizer: &'a Quantizer,
    policy: Policy,
    rows: u32,
    image: &'a mut ImageViewMut<'i, L>,
    tally: &'a mut Tally,
}

impl<L: Level> Inserter<'_, '_, L> {
    #[inline]
    fn insert_block(&mut self, block: &Block, cells: &Cells, len: usize) {
        let xyz = block.x.iter().zip(&block.y).zip(&block.z);
        let lanes = cells.column.iter().zip(&cells.row_from_one).zip(&cells.range_m);
        for (((&column, &row_from_one), &range_m), ((x, y), z)) in lanes.zip(xyz).take(len) {
            self.tally.points += 1;
            match self.quantizer.level(range_m) {
                Ok(level) => self.insert_one(column, row_from_one, L::new(level)),
                Err(out_of_scale) => self.count_refused(out_of_scale, range_m, [*x, *y, *z]),
            }
        }
    }

    #[inline]
    fn insert_one(&mut self, column: u32, row_from_one: u32, level: L) {
        let row_from_one = self.settle_row(row_from_one);
        let columns = self.image.columns();
        let pixel = (row_from_one.wrapping_sub(1) as usize).wrapping_mul(columns).wrapping_add(column as usize);
        let in_view = row_from_one.wrapping_sub(1) < self.rows && column != Cells::OUT_OF_VIEW;
        match self.image.levels().get_mut(pixel) {
            Some(pixel) if in_view => {
                self.tally.collided += u32::from(*pixel != L::NONE);
                *pixel = self.policy.collision.settle(*pixel, level);
            }
            _ => self.tally.out_of_view += 1,
        }
    }

    #[inline]
    fn settle_row(&mut self, row_from_one: u32) -> u32 {
        match self.policy.out_of_view {
            OutOfView::Drop => row_from_one,
            OutOfView::Clamp => {
                let clamped = row_from_one.clamp(1, self.rows);
                self.tally.clamped += u32::from(clamped != row_from_one);
                clamped
            }
        }
    }

    #[cold]
    fn count_refused(&mut self, out_of_scale: OutOfScale, range_m: f32, xyz: [f32; 3]) {
        let counter = match out_of_scale {
            // A NaN range is refused as too near (it rounds to 0), an infinite one as beyond.
            _ if !xyz.iter().all(|c| c.is_finite()) => &mut self.tally.not_finite,
            OutOfScale::TooNear if range_m == 0.0 => &mut self.tally.no_return,
            OutOfScale::TooNear => &mut self.tally.too_near,
            OutOfScale::Beyond => &mut self.tally.beyond_range,
        };
        *counter += 1;
    }
}

impl Collision {
    #[inline]
    fn settle<L: Level>(self, old: L, new: L) -> L {
        match self {
            Self::Nearest if old != L::NONE => old.min(new),
            Self::Farthest => old.max(new),
            Self::First if old != L::NONE => old,
            _ => new,
        }
    }
}

/// Largest range among the points that are finite, meters; 0 where there is none.
pub fn farthest_m(points: &(impl Points + ?Sized)) -> f32 {
    let mut square = 0.0_f32;
    points.for_each_block(|block, len| {
        let xyz = block.x.iter().zip(&block.y).zip(&block.z);
        for ((x, y), z) in xyz.take(len) {
            let sum = x * x + y * y + z * z;
            square = if sum > square && sum.is_finite() { sum } else { square };
        }
    });
    crate::kernel::sqrt(square)
}
