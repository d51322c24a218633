//! Points into the range image: project, quantize, settle collisions, count.

use crate::geometry::{Pixels, Projection};
use crate::image::{ImageViewMut, Level};
use crate::point::{BLOCK_LEN, Block, Points};
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
    let mut inserter = Inserter { quantizer, policy, levels: image.levels(), tally };
    let mut pixels = Pixels::new();
    points.for_each_block(|block, len| {
        projection.project(block, &mut pixels);
        inserter.insert_block(block, &pixels, len);
    });
}

struct Inserter<'a, L: Level> {
    quantizer: &'a Quantizer,
    policy: Policy,
    levels: &'a mut [L],
    tally: &'a mut Tally,
}

impl<L: Level> Inserter<'_, L> {
    #[inline]
    fn insert_block(&mut self, block: &Block, pixels: &Pixels, len: usize) {
        let mut levels = [0_u32; BLOCK_LEN];
        for (level, &range_m) in levels.iter_mut().zip(&pixels.range_m) {
            *level = self.quantizer.rounded(range_m);
        }
        let max_level = u32::from(self.quantizer.max_level());
        let len = len.min(BLOCK_LEN);
        self.tally.points += len as u32;
        for (i, &level) in levels.iter().enumerate().take(len) {
            if level.wrapping_sub(1) < max_level {
                self.insert_one(pixels.pixel[i], level as u16);
            } else {
                self.count_refused(pixels.range_m[i], [block.x[i], block.y[i], block.z[i]]);
            }
        }
    }

    #[inline]
    fn insert_one(&mut self, pixel: u32, level: u16) {
        let pixel = if pixel < Pixels::CLAMPED { pixel } else { self.settle_view(pixel) };
        match self.levels.get_mut(pixel as usize) {
            Some(pixel) => {
                self.tally.collided += u32::from(*pixel != L::NONE);
                *pixel = self.policy.collision.settle(*pixel, L::new(level));
            }
            None => self.tally.out_of_view += 1,
        }
    }

    /// A pixel outside the elevations: clamped and counted, or out of the image.
    #[cold]
    fn settle_view(&mut self, pixel: u32) -> u32 {
        if pixel == Pixels::OUT_OF_VIEW || self.policy.out_of_view == OutOfView::Drop {
            return Pixels::OUT_OF_VIEW;
        }
        self.tally.clamped += 1;
        pixel & !Pixels::CLAMPED
    }

    #[cold]
    fn count_refused(&mut self, range_m: f32, xyz: [f32; 3]) {
        let counter = match self.quantizer.level(range_m) {
            _ if !xyz.iter().all(|c| c.is_finite()) => &mut self.tally.not_finite,
            Err(OutOfScale::TooNear) if range_m == 0.0 => &mut self.tally.no_return,
            Err(OutOfScale::TooNear) => &mut self.tally.too_near,
            _ => &mut self.tally.beyond_range,
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
