//! What a frame is to be like: the choices of every stage in one place, and the presets.

use crate::geometry::angles::{self, AngleTables};
use crate::geometry::{Placement, UniformView};
use crate::insert::{Collision, OutOfView, Policy};

/// Where the quantizer's largest range comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// This many meters, for every frame.
    Fixed {
        /// The largest range that has a level; points beyond are dropped and counted.
        max_range_m: f32,
    },
    /// The farthest point of each frame, which takes a pass of its own over the points.
    PerFrame,
}

/// The choices of every stage. `NODES` follows from `tables`.
///
/// ```
/// use flicr::{Config, Scale};
/// const CONFIG: Config = Config { scale: Scale::Fixed { max_range_m: 120.0 }, ..Config::UNIFORM };
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Config<const NODES: usize = 257> {
    /// The part of the sphere that rows and columns divide.
    pub view: UniformView,
    /// Where in its pixel a decoded point is put.
    pub placement: Placement,
    /// Bits of a level: 1 to 8 in an image of `u8`, 9 to 16 in one of `u16`.
    pub level_bits: u32,
    /// Range of the largest level.
    pub scale: Scale,
    /// Collisions and points out of view.
    pub policy: Policy,
    /// The angle tables: [`angles::FINE`] or [`angles::COARSE`].
    pub tables: &'static AngleTables<NODES>,
}

impl Config {
    /// As the code that made the paper's tables: rows of 0.4187 degrees from +2 degrees, the last point wins, points
    /// above or below are clamped into the edge rows, the scale follows the frame, points come back at the corner.
    pub const PAPER: Self = Self {
        view: UniformView::all_around(2.0, 2.0 - 64.0 * 0.4187),
        placement: Placement::Corner,
        level_bits: 8,
        scale: Scale::PerFrame,
        policy: Policy { collision: Collision::Last, out_of_view: OutOfView::Clamp },
        tables: &angles::FINE,
    };

    /// The best that evenly spaced rows and columns can do on an HDL-64E: the nearest point wins and comes back in
    /// the middle of its pixel, and the rows lie a tenth of a degree higher, where its beams fit them better (0.04 to
    /// 0.14 dB on KITTI).
    pub const UNIFORM: Self = Self {
        view: UniformView::all_around(2.1, -24.7),
        placement: Placement::Center,
        policy: Policy { collision: Collision::Nearest, out_of_view: OutOfView::Clamp },
        ..Self::PAPER
    };
}
