//! Arc tangent and arc cosine by table and linear interpolation, in flash, made at compile time.
//!
//! atan is tabulated over 0..=1 and asin over 0..=1/2; octants and the half-angle identity give the rest:
//! atan2(y, x) everywhere, acos(c) = pi/2 - asin(c) for |c| <= 1/2 and 2 asin(sqrt((1 - |c|) / 2)) beyond.
//!
//! | table | flash | largest error, atan / acos |
//! |---|---|---|
//! | [`FINE`] | 2,056 bytes | 0.00008 / 0.00006 degrees |
//! | [`COARSE`] | 520 bytes | 0.0012 / 0.0009 degrees |

use core::f32::consts::{FRAC_PI_2, PI};

use crate::kernel::{sqrt, to_index};

/// Both tables with `NODES - 1` intervals each; `8 * NODES` bytes.
#[derive(Debug)]
pub struct AngleTables<const NODES: usize> {
    atan: [f32; NODES],
    asin: [f32; NODES],
}

/// 256 intervals: what the projection uses unless told otherwise.
pub static FINE: AngleTables<257> = AngleTables::new();
/// 64 intervals, for parts that have no 2 KB of flash to spare: an error of a seventieth of a column at 4500.
pub static COARSE: AngleTables<65> = AngleTables::new();

impl<const NODES: usize> AngleTables<NODES> {
    /// Intervals of each table: a power of two.
    const INTERVALS: usize = NODES - 1;
    const NODE_MASK: usize = {
        assert!(Self::INTERVALS.is_power_of_two());
        Self::INTERVALS - 1
    };

    /// Computes both tables in double precision; meant for `static`s.
    #[must_use]
    pub const fn new() -> Self {
        let intervals = Self::INTERVALS as f64;
        let mut tables = Self { atan: [0.0; NODES], asin: [0.0; NODES] };
        let mut angle = 0.0;
        let mut node = 0;
        while node < NODES {
            let k = node as f64;
            tables.atan[node] = angle as f32;
            tables.asin[node] = asin_series(k / (2.0 * intervals)) as f32;
            // atan b - atan a = atan((b - a) / (1 + a b)), and the argument is at most one interval.
            angle += atan_series(intervals / (intervals * intervals + k * (k + 1.0)));
            node += 1;
        }
        tables
    }

    /// atan(t) for t in 0..=1; NaN for NaN.
    #[inline]
    pub(crate) fn atan_unit(&self, t: f32) -> f32 {
        let (node, beyond) = Self::atan_place(t);
        interpolate(self.atan_ends(node), beyond)
    }

    /// asin(t) for t in 0..=1/2, the last interval's line beyond (which is above asin(1/2) there); NaN for NaN.
    #[inline]
    pub(crate) fn asin_half(&self, t: f32) -> f32 {
        let (node, beyond) = Self::asin_place(t);
        interpolate(self.asin_ends(node), beyond)
    }

    /// Interval of t in atan's table, and how far into it.
    #[inline]
    pub(crate) fn atan_place(t: f32) -> (u32, f32) {
        // A hair less than the intervals, so that 1 is still in the last one and a mask replaces a comparison.
        let at = t * (Self::INTERVALS as f32).next_down();
        let node = to_index(at, Self::INTERVALS as u32 - 1);
        (node, at - node as f32)
    }

    /// Interval of t in asin's table, and how far into it.
    #[inline]
    pub(crate) fn asin_place(t: f32) -> (u32, f32) {
        let at = t * (2 * Self::INTERVALS) as f32;
        let last = Self::INTERVALS as u32 - 1;
        let node = to_index(at, last).min(last);
        (node, at - node as f32)
    }

    /// atan at both ends of an interval.
    #[inline]
    pub(crate) fn atan_ends(&self, node: u32) -> (f32, f32) {
        ends(&self.atan, node as usize & Self::NODE_MASK)
    }

    /// asin at both ends of an interval.
    #[inline]
    pub(crate) fn asin_ends(&self, node: u32) -> (f32, f32) {
        ends(&self.asin, node as usize & Self::NODE_MASK)
    }

    /// Azimuth of (x, y): radians from -pi to pi, counterclockwise from x; 0 (or pi, for -0) at the origin.
    #[must_use]
    #[inline]
    pub fn atan2(&self, y: f32, x: f32) -> f32 {
        let ratio = if x == 0.0 && y == 0.0 { 0.0 } else { octant_ratio(y, x) };
        unfold_octant(self.atan_unit(ratio), y, x)
    }

    /// acos(c) for c in -1..=1, radians from 0 to pi.
    #[must_use]
    #[inline]
    pub fn acos(&self, c: f32) -> f32 {
        FRAC_PI_2 - self.asin(c)
    }

    /// asin(c) for c in -1..=1, radians from -pi/2 to pi/2.
    #[must_use]
    #[inline]
    pub fn asin(&self, c: f32) -> f32 {
        let near = self.asin_half(half_angle_argument(c.abs()));
        unfold_half_angle(near, c)
    }
}

impl<const NODES: usize> Default for AngleTables<NODES> {
    fn default() -> Self {
        Self::new()
    }
}

/// The smaller of |x| and |y| over the larger; NaN at the origin.
#[inline]
pub(crate) fn octant_ratio(y: f32, x: f32) -> f32 {
    let (a, b) = (x.abs(), y.abs());
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    low / high
}

/// The angle of the octant ratio's arc tangent, put back into the octant of (x, y).
#[inline]
pub(crate) fn unfold_octant(angle: f32, y: f32, x: f32) -> f32 {
    let first_quadrant = if x.abs() < y.abs() { FRAC_PI_2 - angle } else { angle };
    let upper_half = if x < 0.0 { PI - first_quadrant } else { first_quadrant };
    upper_half.copysign(y)
}

/// c where asin's table has it, else sqrt((1 - c) / 2); c from 0 to 1.
#[inline]
pub(crate) fn half_angle_argument(c: f32) -> f32 {
    if c > 0.5 { sqrt((1.0 - c) * 0.5) } else { c }
}

/// asin(c), given the table's value at [`half_angle_argument`] of |c|.
#[inline]
pub(crate) fn unfold_half_angle(near: f32, c: f32) -> f32 {
    let angle = if c.abs() > 0.5 { FRAC_PI_2 - 2.0 * near } else { near };
    angle.copysign(c)
}

#[inline]
fn ends<const NODES: usize>(table: &[f32; NODES], node: usize) -> (f32, f32) {
    (table[node], table[node + 1])
}

/// The value `beyond` of the way from the first to the second.
#[inline]
pub(crate) fn interpolate((low, high): (f32, f32), beyond: f32) -> f32 {
    low + (high - low) * beyond
}

/// atan x for x of at most 1/64: the next term is below 2^-64.
const fn atan_series(x: f64) -> f64 {
    let q = x * x;
    x * (1.0 - q * (1.0 / 3.0 - q * (1.0 / 5.0 - q * (1.0 / 7.0 - q * (1.0 / 9.0)))))
}

/// asin x for x of at most 1/2, where each term is less than a quarter of the one before.
const fn asin_series(x: f64) -> f64 {
    let (mut sum, mut term, mut k) = (0.0, x, 1.0);
    while k < 60.0 {
        sum += term / k;
        term *= x * x * k / (k + 1.0);
        k += 2.0;
    }
    sum
}
