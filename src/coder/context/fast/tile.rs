//! Columns out of an image and into one, a few at a time: row-major levels are read and written in runs.

use super::band::{Lanes, ROWS};
#[cfg(feature = "std")]
use crate::image::ImageViewMut;
use crate::image::{ImageView, Level};

/// Columns of a tile.
pub(crate) const COLUMNS: usize = 16;

/// Some columns of a band.
pub(crate) type Tile = [Lanes; COLUMNS];

/// Reads the columns from `column` of the band that begins at row `first`; rows beyond the image are empty.
pub(crate) fn load<L: Level>(image: ImageView<'_, L>, first: usize, column: usize, tile: &mut Tile) {
    let width = COLUMNS.min(image.columns() - column);
    let mut rows = image.row_levels().skip(first);
    for row in 0..ROWS {
        let levels = rows.next().and_then(|row| row.get(column..column + width)).unwrap_or(&[]);
        for (lanes, level) in tile.iter_mut().zip(levels) {
            lanes[row] = level.get();
        }
    }
}

/// Writes columns that [`load`] read.
#[cfg(feature = "std")]
pub(crate) fn store<L: Level>(image: &mut ImageViewMut<'_, L>, first: usize, column: usize, tile: &Tile) {
    let columns = image.columns();
    let rows = image.levels().chunks_exact_mut(columns).skip(first);
    for (row, levels) in rows.take(ROWS).enumerate() {
        for (level, lanes) in levels[column..].iter_mut().zip(tile) {
            *level = L::new(lanes[row]);
        }
    }
}
