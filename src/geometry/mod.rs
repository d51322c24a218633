//! Where a point falls in the range image, and where a pixel lies in space.
//!
//! A geometry is a set of rows (elevations) by columns (azimuths). [`UniformGrid`] is the paper's: both evenly
//! spaced.

pub mod angles;
pub mod sensors;
#[cfg(feature = "std")]
mod sphere;
mod uniform;

#[cfg(feature = "std")]
pub(crate) use sphere::Sphere;
pub use uniform::{Placement, UniformGrid, UniformView};

use crate::point::{BLOCK_LEN, Block};

/// Where the points of a [`Block`] fall: one lane each.
#[derive(Debug, Clone)]
pub struct Pixels {
    /// Row times columns plus column; with [`Pixels::CLAMPED`] where the elevation is outside the view and the edge
    /// row stands for it, [`Pixels::OUT_OF_VIEW`] where the azimuth is outside.
    pub pixel: [u32; BLOCK_LEN],
    /// Distance from the sensor, meters; not finite where a coordinate is not, or their squares overflow.
    pub range_m: [f32; BLOCK_LEN],
}

impl Pixels {
    /// Mark of a pixel in the first or last row that stands for an elevation outside the view.
    pub const CLAMPED: u32 = 1 << 31;
    /// Pixel of a point whose azimuth is outside the view.
    pub const OUT_OF_VIEW: u32 = u32::MAX;

    /// Pixels to be written by [`Projection::project`].
    pub const fn new() -> Self {
        Self { pixel: [0; BLOCK_LEN], range_m: [0.0; BLOCK_LEN] }
    }
}

impl Default for Pixels {
    fn default() -> Self {
        Self::new()
    }
}

/// The forward direction of a geometry: points to pixels of the range image.
pub trait Projection {
    /// Rows of the image.
    fn rows(&self) -> u16;
    /// Columns of the image.
    fn columns(&self) -> u16;
    /// The pixel and range of every lane of `block`. Lanes that hold no finite point get any pixel and their range
    /// says so.
    fn project(&self, block: &Block, pixels: &mut Pixels);
}
