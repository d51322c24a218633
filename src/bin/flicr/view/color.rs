//! Colors of ranges and heights, and the scales that explain them.

use colorous::{Gradient, TURBO};

use crate::canvas::{Area, Canvas};

/// Where ranges have the first color and the last, meters; between them by the logarithm, for most points are near.
const NEAR_M: f32 = 2.0;
const FAR_M: f32 = 100.0;

/// Share of the points below and above the colored heights.
const HEIGHT_TAIL: f32 = 0.02;

const BAR_WIDTH: u32 = 300;
const BAR_HEIGHT: u32 = 12;

/// Red is near, blue is far.
pub fn of_range(range_m: f32) -> [u8; 3] {
    at(TURBO, 1.0 - range_share(range_m))
}

/// Where a range is between near (0) and far (1).
fn range_share(range_m: f32) -> f32 {
    (range_m / NEAR_M).ln() / (FAR_M / NEAR_M).ln()
}

/// The ends of the map are too dark to be told from the background.
fn at(gradient: Gradient, share: f32) -> [u8; 3] {
    gradient.eval_continuous(f64::from(0.1 + 0.84 * share.clamp(0.0, 1.0))).as_array()
}

/// The bar of [`of_range`], its right end at `right`; 28 pixels high with its ticks.
pub fn range_legend(canvas: &mut Canvas, right: u32, y: u32) {
    let ticks = [2.0, 5.0, 10.0, 20.0, 50.0, 100.0].map(|range_m| (range_share(range_m), format!("{range_m}")));
    bar(canvas, right, y, "range, m", |share| at(TURBO, 1.0 - share), &ticks);
}

/// Heights from blue to red.
#[derive(Debug, Clone, Copy)]
pub struct HeightScale {
    low_m: f32,
    high_m: f32,
}

impl HeightScale {
    /// From the low to the high points, but for the few lowest and highest.
    pub fn of(points: &[[f32; 3]]) -> Self {
        let mut heights: Vec<f32> = points.iter().map(|&[.., z]| z).collect();
        heights.sort_by(f32::total_cmp);
        let at = |share: f32| heights.get((heights.len() as f32 * share) as usize).copied().unwrap_or_default();
        let (low_m, high_m) = (at(HEIGHT_TAIL), at(1.0 - HEIGHT_TAIL));
        Self { low_m, high_m: high_m.max(low_m + 0.1) }
    }

    pub fn color(self, height_m: f32) -> [u8; 3] {
        at(TURBO, (height_m - self.low_m) / (self.high_m - self.low_m))
    }

    /// The bar of [`color`](Self::color), its right end at `right`.
    pub fn legend(self, canvas: &mut Canvas, right: u32, y: u32) {
        let ticks = [0.0, 0.5, 1.0].map(|share| {
            let height_m = self.low_m + share * (self.high_m - self.low_m);
            // What no sensor measures would not fit below the bar.
            let text = if height_m.abs() < 1e5 { format!("{height_m:+.1}") } else { format!("{height_m:+.0e}") };
            (share, text)
        });
        bar(canvas, right, y, "height, m", |share| at(TURBO, share), &ticks);
    }
}

/// A bar with its name to the left and ticks below.
fn bar(canvas: &mut Canvas, right: u32, y: u32, name: &str, color: impl Fn(f32) -> [u8; 3], ticks: &[(f32, String)]) {
    let left = right - BAR_WIDTH;
    canvas.text(left - 84, y, name);
    for x in 0..BAR_WIDTH {
        let column = Area { x: left + x, y, width: 1, height: BAR_HEIGHT };
        canvas.fill(column, color(x as f32 / BAR_WIDTH as f32));
    }
    for (share, text) in ticks {
        let half = (4 * text.len() as u32).min(BAR_WIDTH / 2);
        let x = left + (share * BAR_WIDTH as f32) as u32;
        canvas.centered_text(x.clamp(left + half, right - half), y + BAR_HEIGHT + 3, text);
    }
}
