//! Points into the range image: project, quantize, settle collisions, count.

use crate::geometry::{Pixels, Projection};
use crate::image::{ImageViewMut, Level};
use crate::point::{BLOCK_LEN, Block, Points};
use crate::quantize::{Companding, Quantizer};
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
    mut along: impl Along,
) {
    let edge = if policy.out_of_view == OutOfView::Clamp { !Pixels::CLAMPED } else { u32::MAX };
    let mut inserter = Inserter { quantizer, policy, edge, levels: image.levels(), tally };
    let mut pixels = Pixels::new();
    points.for_each_block(|block, len| {
        projection.project(block, quantizer, &mut pixels);
        // Not within the loop over points, where it would be asked for each.
        if quantizer.companding() != Companding::None {
            pixels.level.iter_mut().for_each(|level| *level = quantizer.level_of_steps(*level));
        }
        inserter.insert_block(block, &pixels, len, &mut along);
        along.block(len);
    });
}

/// What goes along with a point into its pixel.
pub(crate) trait Along {
    /// The pixel now keeps lane `lane` of the block. Of points with the same level, it keeps the first.
    fn keep(&mut self, lane: usize, pixel: usize);

    /// The block of `len` points is done.
    fn block(&mut self, len: usize);
}

/// Nothing does.
impl Along for () {
    #[inline(always)]
    fn keep(&mut self, _: usize, _: usize) {}

    #[inline(always)]
    fn block(&mut self, _: usize) {}
}

/// A number of each point, by its place among the points.
#[derive(Debug)]
pub(crate) struct Numbers<'a, F> {
    pub(crate) of: F,
    /// The place of the block's first point.
    pub(crate) first: usize,
    /// One for each pixel of the image.
    pub(crate) plane: &'a mut [u8],
}

impl<F: FnMut(usize) -> u8> Along for Numbers<'_, F> {
    fn keep(&mut self, lane: usize, pixel: usize) {
        if let Some(number) = self.plane.get_mut(pixel) {
            *number = (self.of)(self.first + lane);
        }
    }

    fn block(&mut self, len: usize) {
        self.first += len;
    }
}

struct Inserter<'a, L: Level> {
    quantizer: &'a Quantizer,
    policy: Policy,
    /// What makes an edge pixel of a mark: takes the mark off where the policy is to clamp, nothing elsewhere.
    edge: u32,
    levels: &'a mut [L],
    tally: &'a mut Tally,
}

impl<L: Level> Inserter<'_, L> {
    fn insert_block(&mut self, block: &Block, pixels: &Pixels, len: usize, along: &mut impl Along) {
        // One loop a policy, so that none of them asks for the policy at every point.
        match self.policy.collision {
            Collision::Nearest => self.insert_lanes(block, pixels, len, Ord::min, along),
            Collision::Farthest => self.insert_lanes(block, pixels, len, Ord::max, along),
            Collision::First => self.insert_lanes(block, pixels, len, |old, _| old, along),
            Collision::Last => self.insert_lanes(block, pixels, len, |_, new| new, along),
        }
    }

    // A function of its own: within the caller, its loop would have to share registers with everything around it.
    #[inline(never)]
    fn insert_lanes(
        &mut self,
        block: &Block,
        pixels: &Pixels,
        len: usize,
        settle: impl Fn(L, L) -> L,
        along: &mut impl Along,
    ) {
        let max_level = u32::from(self.quantizer.max_level());
        let len = len.min(BLOCK_LEN);
        let mut lanes = pixels.pixel[..len].iter().zip(&pixels.level[..len]);
        let mut collided = 0;
        while let Some((&pixel, &level)) = lanes.next() {
            if level.wrapping_sub(1) >= max_level {
                self.count_refused(block, len - 1 - lanes.len(), level);
                continue;
            }
            let lane = len - 1 - lanes.len();
            let mut put = |pixel: &mut L, at: u32| {
                let (old, new) = (*pixel, L::new(level as u16));
                // Most pixels are empty, and take a point with nothing more to be asked.
                if old != L::NONE {
                    collided += 1;
                    if settle(old, new) == old {
                        return;
                    }
                }
                *pixel = new;
                along.keep(lane, at as usize);
            };
            // No image has as many pixels as the marks stand for: one comparison finds both.
            if let Some(kept) = self.levels.get_mut(pixel as usize) {
                put(kept, pixel);
            } else if let Some(kept) = self.levels.get_mut((pixel & self.edge) as usize) {
                self.tally.clamped += 1;
                put(kept, pixel & self.edge);
            } else {
                self.tally.out_of_view += 1;
            }
        }
        self.tally.points += len as u32;
        self.tally.collided += collided;
    }

    #[cold]
    #[inline(never)]
    fn count_refused(&mut self, block: &Block, i: usize, level: u32) {
        // Never more than it was: without the remainder, a check would bring the panic machinery into firmware.
        let i = i % BLOCK_LEN;
        self.tally.count_refused_point([block.x[i], block.y[i], block.z[i]], level);
    }
}

/// The level that a pixel keeps of one that it holds and one that comes.
#[inline]
pub fn settle<L: Level>(collision: Collision, old: L, new: L) -> L {
    match collision {
        Collision::Nearest => old.min(new),
        Collision::Farthest => old.max(new),
        Collision::First => old,
        Collision::Last => new,
    }
}

/// Largest range among the points that are finite, meters; 0 where there is none.
pub fn farthest_m(points: &(impl Points + ?Sized)) -> f32 {
    // One maximum a lane, so that lanes go side by side. Lanes behind a block's points hold points seen before.
    let mut squares = [0.0_f32; BLOCK_LEN];
    points.for_each_block(|block, _| {
        for (i, square) in squares.iter_mut().enumerate() {
            let (x, y, z) = (block.x[i], block.y[i], block.z[i]);
            let sum = x * x + y * y + z * z;
            *square = if sum > *square && sum < f32::INFINITY { sum } else { *square };
        }
    });
    let square = squares.into_iter().fold(0.0, f32::max);
    crate::kernel::sqrt(square)
}
