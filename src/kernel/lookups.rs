//! Table look-ups of a block, taken apart: places and interpolation are arithmetic, for vectors; only the loads between
//! them go one by one.

use crate::geometry::angles::interpolate;
use crate::point::BLOCK_LEN;

/// One look-up a lane.
pub(crate) struct Lookups {
    node: [u32; BLOCK_LEN],
    beyond: [f32; BLOCK_LEN],
    low: [f32; BLOCK_LEN],
    high: [f32; BLOCK_LEN],
}

impl Lookups {
    pub(crate) const NEW: Self =
        Self { node: [0; BLOCK_LEN], beyond: [0.0; BLOCK_LEN], low: [0.0; BLOCK_LEN], high: [0.0; BLOCK_LEN] };

    /// What to look up: an interval and how far into it.
    #[inline(always)]
    pub(crate) fn put(&mut self, i: usize, place: (u32, f32)) {
        (self.node[i], self.beyond[i]) = place;
    }

    /// Loads the ends of the interval.
    #[inline(always)]
    pub(crate) fn look_up(&mut self, i: usize, ends: impl Fn(u32) -> (f32, f32)) {
        (self.low[i], self.high[i]) = ends(self.node[i]);
    }

    /// What was found.
    #[inline(always)]
    pub(crate) fn angle(&self, i: usize) -> f32 {
        interpolate((self.low[i], self.high[i]), self.beyond[i])
    }
}
