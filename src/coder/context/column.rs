//! The image column by column, as the sensor fires, and which pixels of a column hold a return: sets of eight rows.

use crate::image::{ImageView, ImageViewMut, Level};

/// Rows of a group: the bits of its set of returns.
pub(crate) const GROUP_ROWS: usize = 8;

/// One column of an image of up to `8 * GROUPS` rows. Rows that the image has not are empty.
#[derive(Debug, Clone)]
pub(crate) struct Column<const GROUPS: usize> {
    /// Levels by row, 0 = no return.
    pub(crate) levels: [[u16; GROUP_ROWS]; GROUPS],
    /// Bit n of a group's set: its row n holds a return.
    pub(crate) sets: [u8; GROUPS],
}

impl<const GROUPS: usize> Column<GROUPS> {
    /// Rows that fit.
    pub(crate) const ROWS_MAX: usize = GROUPS * GROUP_ROWS;

    /// A column without returns.
    pub(crate) const fn new() -> Self {
        Self { levels: [[0; GROUP_ROWS]; GROUPS], sets: [0; GROUPS] }
    }

    /// Finds the sets of the levels.
    pub(crate) fn find_sets(&mut self) {
        for (set, levels) in self.sets.iter_mut().zip(&self.levels) {
            *set = levels.iter().rev().fold(0, |set, &level| set << 1 | u8::from(level != 0));
        }
    }

    /// Takes all returns out.
    #[cfg(feature = "std")]
    pub(crate) fn clear(&mut self) {
        *self = Self::new();
    }

    /// Reads column `column`; rows beyond [`ROWS_MAX`](Self::ROWS_MAX) are left out.
    // Not inlined: it is a loop that needs all registers of a Cortex-M.
    #[inline(never)]
    pub(crate) fn load<L: Level>(&mut self, image: ImageView<'_, L>, column: usize) {
        let mut pixels = image.column(column);
        for (levels, set) in self.levels.iter_mut().zip(&mut self.sets) {
            let mut found = 0;
            for (row, level) in levels.iter_mut().enumerate() {
                *level = pixels.next().map_or(0, Level::get);
                found |= u8::from(*level != 0) << row;
            }
            *set = found;
        }
    }

    /// Writes column `column`, all rows of the image: those beyond [`ROWS_MAX`](Self::ROWS_MAX) stay as they are.
    pub(crate) fn store<L: Level>(&self, image: &mut ImageViewMut<'_, L>, column: usize) {
        let columns = image.columns();
        let pixels = image.levels().iter_mut().skip(column).step_by(columns);
        for (pixel, &level) in pixels.zip(self.levels.as_flattened()) {
            *pixel = L::new(level);
        }
    }
}
