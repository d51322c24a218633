//! Points off a sensor's grid into its image: one whose pixel is taken goes into the free one beside it.
//!
//! A sensor's own returns are a column apart, moved ones need not be: where the sensor's motion pushes points together,
//! several share a column while those beside it are empty. In one of
//! them a point is at most six and a half columns off.

use crate::fit::GridFit;
use crate::geometry::{Lattice, Pixels};
use crate::image::Level;
use crate::insert::{OutOfView, Policy, settle};
use crate::kernel::{miss_lattice, place_on_row};
use crate::quantize::Quantizer;
use crate::tally::Tally;

/// Most columns by which a point is displaced.
const REACH: i8 = 6;

/// Where points of known rows go.
#[derive(Debug)]
pub(crate) struct Beside<'a, L, const LINES: usize, const NODES: usize> {
    pub(crate) lattice: &'a Lattice<'a, LINES, NODES>,
    pub(crate) quantizer: &'a Quantizer,
    pub(crate) policy: Policy,
    /// The image.
    pub(crate) levels: &'a mut [L],
    pub(crate) tally: &'a mut Tally,
    /// Where points are to be measured.
    pub(crate) fit: Option<&'a mut GridFit>,
}

impl<L: Level, const LINES: usize, const NODES: usize> Beside<'_, L, LINES, NODES> {
    /// Puts a point into its row; gives the pixel, if that keeps it.
    pub(crate) fn insert(&mut self, point: [f32; 3], row: u16) -> Option<usize> {
        self.tally.points += 1;
        let (pixel, steps) = place_on_row(self.lattice, self.quantizer, point, row);
        let level = self.quantizer.level_of_steps(steps);
        // `None` exactly where there is no such level.
        let Some(miss) = miss_lattice(self.lattice, self.quantizer, point, Some(row)) else {
            self.tally.count_refused_point(point, level);
            return None;
        };
        let Some(own) = self.in_view(pixel) else {
            self.tally.out_of_view += 1;
            return None;
        };
        let columns = self.free_beside(own, miss.columns_off);
        if let Some(fit) = &mut self.fit {
            fit.add_displaced(self.lattice, &miss, columns.unwrap_or(0));
        }
        self.put(own, columns, L::new(level as u16))
    }

    /// The pixel in the image, which that of a row beyond the edge is where points are clamped.
    fn in_view(&mut self, pixel: u32) -> Option<usize> {
        let is_beyond = pixel & Pixels::CLAMPED != 0;
        if is_beyond && self.policy.out_of_view == OutOfView::Drop {
            return None;
        }
        let pixel = (pixel & !Pixels::CLAMPED) as usize;
        let is_there = pixel < self.levels.len();
        self.tally.clamped += u32::from(is_beyond && is_there);
        is_there.then_some(pixel)
    }

    /// Columns to go to the nearest free pixel; `None` where there is none within reach.
    fn free_beside(&self, own: usize, columns_off: f32) -> Option<i8> {
        let toward = if columns_off < 0.0 { -1 } else { 1 };
        let is_free = |&columns: &i8| self.levels.get(self.beside(own, columns)) == Some(&L::NONE);
        (0..=REACH).flat_map(|columns| [columns * toward, -columns * toward]).find(is_free)
    }

    /// The pixel so many columns away in the same row, which is a turn.
    fn beside(&self, own: usize, columns: i8) -> usize {
        let in_turn = usize::from(self.lattice.columns_in_turn()).max(1);
        let column = own % in_turn;
        let moved = column.cast_signed() + isize::from(columns);
        own - column + moved.rem_euclid(in_turn.cast_signed()).cast_unsigned()
    }

    fn put(&mut self, own: usize, columns: Option<i8>, level: L) -> Option<usize> {
        let pixel = self.beside(own, columns.unwrap_or(0));
        let kept = self.levels.get_mut(pixel)?;
        let old = *kept;
        match columns {
            None => {
                self.tally.collided += 1;
                *kept = settle(self.policy.collision, *kept, level);
            }
            Some(columns) => {
                self.tally.displaced += u32::from(columns != 0);
                *kept = level;
            }
        }
        (*kept != old).then_some(pixel)
    }
}
