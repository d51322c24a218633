//! Where a point falls in the range image, and where a pixel lies in space.
//!
//! A geometry is a set of rows (elevations) by columns (azimuths). [`UniformGrid`] is the paper's: both evenly
//! spaced.

pub mod angles;
#[cfg(feature = "std")]
mod sphere;
mod uniform;

#[cfg(feature = "std")]
pub(crate) use sphere::Sphere;
pub use uniform::{Placement, UniformGrid, UniformView};

use crate::point::{BLOCK_LEN, Block};

/// Where the points of a [`Block`] fall: one lane each.
#[derive(Debug, Clone)]
pub struct Cells {
    /// Column, from 0; [`Cells::OUT_OF_VIEW`] where the azimuth is outside the view.
    pub column: [u32; BLOCK_LEN],
    /// Row plus one, from 1; 0 for a point above the view, more than the rows for one below it.
    pub row_from_one: [u32; BLOCK_LEN],
    /// Distance from the sensor, meters; not finite where a coordinate is not, or their squares overflow.
    pub range_m: [f32; BLOCK_LEN],
}

impl Cells {
    /// Column of a point whose azimuth is outside the view.
    pub const OUT_OF_VIEW: u32 = u32::MAX;

    /// Cells to be written by [`Projection::project`].
    #[must_use]
    pub const fn new() -> Self {
        Self { column: [0; BLOCK_LEN], row_from_one: [0; BLOCK_LEN], range_m: [0.0; BLOCK_LEN] }
    }
}

impl Default for Cells {
    fn default() -> Self {
        Self::new()
    }
}

/// The forward direction of a geometry: points to cells of the range image.
pub trait Projection {
    /// Rows of the image.
    fn rows(&self) -> u16;
    /// Columns of the image.
    fn columns(&self) -> u16;
    /// The cell of every lane of `block`. Lanes that hold no finite point get any cell and their range says so.
    fn project(&self, block: &Block, cells: &mut Cells);
}
