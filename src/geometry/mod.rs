//! Where a point falls in the range image, and where a pixel lies in space.
//!
//! A geometry is a set of rows (elevations) by columns (azimuths). [`UniformGrid`] is the paper's: both evenly
//! spaced. [`Lattice`] is the sensor's own: its beams by its encoder's ticks, on which it loses no point.

pub mod angles;
mod beam;
mod firings;
mod lattice;
pub mod sensors;
#[cfg(feature = "std")]
mod sphere;
#[cfg(feature = "std")]
mod turn;
mod uniform;

#[cfg(feature = "std")]
pub(crate) use beam::BeamLine;
pub use beam::{Beam, SensorGrid};
pub(crate) use firings::bitmap_len;
pub use firings::{FiringLattice, Firings};
#[cfg(feature = "std")]
pub use firings::{FoundFirings, find_firings};
#[cfg(feature = "std")]
pub(crate) use firings::{read as read_firings, shift_of};
#[cfg(not(target_arch = "arm"))]
pub(crate) use lattice::Edge;
pub use lattice::Lattice;
#[cfg(feature = "std")]
pub(crate) use lattice::azimuth_rad;
pub(crate) use lattice::{BINS, BINS_FROM_M, Line};
#[cfg(feature = "std")]
pub(crate) use sphere::Sphere;
#[cfg(feature = "std")]
pub(crate) use turn::{Spread, Turn};
#[cfg(feature = "capi")]
pub(crate) use uniform::check_size;
pub use uniform::{Placement, UniformGrid, UniformView};

use crate::point::{BLOCK_LEN, Block};
use crate::quantize::Quantizer;

/// Where the points of a [`Block`] fall: one lane each.
#[derive(Debug, Clone)]
#[repr(C)]
pub struct Pixels {
    /// Row times columns plus column; with [`Pixels::CLAMPED`] set where the elevation is outside the view and the
    /// edge row stands for it, [`Pixels::OUT_OF_VIEW`] where the azimuth is outside.
    pub pixel: [u32; BLOCK_LEN],
    /// Range in quantizer steps, rounded: 0 where the point is too near (or no return, or not finite), more than the
    /// quantizer's largest level where it is too far.
    pub level: [u32; BLOCK_LEN],
}

impl Pixels {
    /// Mark of a pixel in the first or last row that stands for an elevation outside the view.
    pub const CLAMPED: u32 = 1 << 31;
    /// Mark of a point whose azimuth is outside the view; the rest of the number means nothing then.
    pub const OUT_OF_VIEW: u32 = 1 << 30;

    /// Pixels to be written by [`Projection::project`].
    pub const fn new() -> Self {
        Self { pixel: [0; BLOCK_LEN], level: [0; BLOCK_LEN] }
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
    /// The pixel and level of every lane of `block`. A point on the axis of rotation has no azimuth and gets any
    /// column.
    fn project(&self, block: &Block, quantizer: &Quantizer, pixels: &mut Pixels);
}
