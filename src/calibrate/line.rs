//! A beam seen from the side: a line of height over distance from the axis.

use std::vec::Vec;

use super::cloud::Sample;

/// `z = slope * reach + offset`, where `reach` is the distance from the axis in the firing plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub(super) slope: f64,
    pub(super) offset: f64,
    /// Cosine of the elevation, kept because every point asks for it.
    pub(super) cos: f64,
}

impl Line {
    pub(super) fn new(slope: f64, offset: f64) -> Self {
        Self { slope, offset, cos: 1.0 / slope.hypot(1.0) }
    }

    /// Signed distance of a point from the line, metres.
    pub(super) fn across(&self, reach: f64, z: f64) -> f64 {
        (z - self.offset - self.slope * reach) * self.cos
    }
}

/// Sums for a straight line through weighted points.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub(super) n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl Sums {
    pub(super) fn add(&mut self, x: f64, y: f64) {
        self.n += 1.0;
        // Running means: the spread may be a thousandth of the distance.
        let (dx, dy) = (x - self.x, y - self.y);
        self.x += dx / self.n;
        self.y += dy / self.n;
        self.xx += dx * (x - self.x);
        self.xy += dx * (y - self.y);
    }

    pub(super) fn mean(&self) -> [f64; 2] {
        [self.x, self.y]
    }

    /// Slope and value at x = 0; a level line where the x do not differ.
    pub(super) fn fit(&self) -> Line {
        let slope = if self.xx > 1e-12 * self.n { self.xy / self.xx } else { 0.0 };
        Line::new(slope, self.y - slope * self.x)
    }

    /// Standard deviations of slope and of the value at 0, for points off by `noise`.
    pub(super) fn deviation(&self, noise: f64) -> [f64; 2] {
        let slope = noise / self.xx.sqrt();
        [slope, (noise * noise / self.n + (slope * self.x).powi(2)).sqrt()]
    }
}

/// Least squares without what lies off: fits, keeps what is near, and narrows.
///
/// `points` are (reach, z); `start` says which line to begin at and `gate_m` how far
/// from it a point may lie at first. Returns the line and the spread (one sigma) about it.
pub(super) fn settle(points: &[[f64; 2]], start: Line, gate_m: f64) -> Option<(Line, f64)> {
    let (mut line, mut gate) = (start, gate_m);
    let mut spread = gate_m;
    for _ in 0..12 {
        let mut sums = Sums::default();
        let mut distances = Vec::new();
        for &[reach, z] in points {
            let across = line.across(reach, z);
            if across.abs() <= gate {
                sums.add(reach, z);
                distances.push(across.abs());
            }
        }
        if distances.len() < 8 {
            return None;
        }
        line = sums.fit();
        spread = 1.4826 * median(&mut distances);
        gate = (4.0 * spread).clamp(SHARPEST_M, gate_m);
    }
    Some((line, spread))
}

/// No coordinate in an `f32` file is truer than this at the distances seen.
pub(super) const SHARPEST_M: f64 = 2e-5;

/// The middle value; 0 of none. Reorders its input.
pub(super) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// A line through most of the points by the median slope of pairs, when nothing is known.
pub(super) fn rough_line(samples: &[&Sample]) -> Option<Line> {
    let mut order: Vec<&Sample> = samples.to_vec();
    order.sort_by(|a, b| a.rho.total_cmp(&b.rho));
    let half = order.len() / 2;
    let pairs = order.iter().zip(order.get(half..)?);
    let mut slopes: Vec<f64> =
        pairs.filter(|(a, b)| b.rho - a.rho > 0.01).map(|(a, b)| (b.z - a.z) / (b.rho - a.rho)).collect();
    if slopes.is_empty() {
        return None;
    }
    let slope = median(&mut slopes);
    let mut offsets: Vec<f64> = order.iter().map(|s| s.z - slope * s.rho).collect();
    Some(Line::new(slope, median(&mut offsets)))
}
