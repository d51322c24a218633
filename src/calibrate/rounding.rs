//! What a file's rounding gives away.
//!
//! Once a point's count is known its range is exact, and its height is then a whole
//! number of the file's steps, never more than half a step from the truth. A beam that
//! sees only the ground close by has a few hundred different counts, and each always
//! the same height: thousands of points average nothing out. But of all lines that
//! come within half a step of every one of these heights, none is far from the truth.
//! Among those, the distances from the axis choose: their rounding differs from point
//! to point, as each looks another way.

use std::vec::Vec;

use super::beams::BeamFit;
use super::cloud::{Cloud, Sample};
use super::line::{Line, Sums};

/// Steps that files are written in, metres: as few decimals as fit are meant.
const STEPS_M: [f64; 4] = [1e-2, 5e-3, 2e-3, 1e-3];
/// Single precision moves heights this much on top of their rounding, metres.
const SLACK_M: f64 = 2e-6;
/// The sine of the elevation is looked for this far from what least squares found.
const REACH: f64 = 1e-3;
/// Fewer different counts leave the extremes to chance.
const FEWEST_COUNTS: usize = 50;
/// Of so many heights, one may be a mistake (a point given to the wrong beam or count).
const HEIGHTS_A_MISTAKE: usize = 50;
/// How exactly the unit is known: a beam's cosine can be read no better.
const UNIT_DOUBT: f64 = 2e-6;
/// Lines looked at between the steepest and the flattest that fit.
const SLICES: i32 = 200;

/// The step that all heights are whole numbers of, if there is one.
pub(super) fn step_of(cloud: &Cloud) -> Option<f64> {
    let whole = |z: f64, step: f64| (z - step * (z / step).round()).abs() < 1e-6 + z.abs() * 1e-7;
    STEPS_M.into_iter().find(|&step| cloud.samples.iter().all(|sample| whole(sample.z, step)))
}

/// Fits the beam's line again by the heights' rounding, given its counts.
pub(super) fn sharpen(beam: &mut BeamFit, unit_m: f64, step_m: f64) {
    let mut heights = heights_of(beam, unit_m, step_m);
    // About the middle, where slope and height do not pull at each other.
    let middle = heights.iter().map(|height| height.range).sum::<f64>() / heights.len() as f64;
    for height in &mut heights {
        height.range -= middle;
    }
    let sin = beam.line.slope * beam.line.cos;
    let half_m = step_m / 2.0 + SLACK_M;
    let Some(best) = widest(&mut heights, sin, half_m) else { return };
    let (sin, lift) = middle_line(&heights, half_m, best, &sine_from_reach(beam, unit_m));
    let cos = (1.0 - sin * sin).sqrt();
    beam.line = Line::new(sin / cos, (lift - sin * middle) / (cos * cos));
}

/// The height that a count's points agree on.
#[derive(Debug, Clone, Copy)]
struct Height {
    range: f64,
    z: f64,
    /// Points that have it.
    points: usize,
}

fn count_of(beam: &BeamFit, unit_m: f64, sample: &Sample) -> f64 {
    ((beam.along(sample) - beam.range_phase) / unit_m).round()
}

fn heights_of(beam: &BeamFit, unit_m: f64, step_m: f64) -> Vec<Height> {
    let place = |sample| (count_of(beam, unit_m, sample) as i64, (sample.z / step_m).round() as i64);
    let mut places: Vec<(i64, i64)> = beam.samples.iter().map(place).collect();
    places.sort_unstable();
    let of_one_count = places.chunk_by(|a, b| a.0 == b.0);
    let agreed = of_one_count.filter_map(|same| same.chunk_by(|a, b| a.1 == b.1).max_by_key(|same| same.len()));
    let height = |same: &[(i64, i64)]| Height {
        range: same[0].0 as f64 * unit_m + beam.range_phase,
        z: same[0].1 as f64 * step_m,
        points: same.len(),
    };
    agreed.map(height).collect()
}

/// What a line of this sine leaves its height at range 0: the lowest and highest that fit all
/// heights (crossed if none does), and which heights set these.
fn leeway(heights: &[Height], sin: f64, half_m: f64) -> ([f64; 2], [usize; 2]) {
    let (mut top, mut bottom) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
    for (index, height) in heights.iter().enumerate() {
        let rest = height.z - sin * height.range;
        if rest > top.0 {
            top = (rest, index);
        }
        if rest < bottom.0 {
            bottom = (rest, index);
        }
    }
    ([top.0 - half_m, bottom.0 + half_m], [top.1, bottom.1])
}

fn width(heights: &[Height], sin: f64, half_m: f64) -> f64 {
    let ([low, high], _) = leeway(heights, sin, half_m);
    high - low
}

/// The sine that leaves the most leeway, after taking out heights that contradict all others.
fn widest(heights: &mut Vec<Height>, near: f64, half_m: f64) -> Option<f64> {
    for _ in 0..=heights.len() / HEIGHTS_A_MISTAKE {
        if heights.len() < FEWEST_COUNTS {
            return None;
        }
        let best = peak(|sin| width(heights, sin, half_m), near - REACH, near + REACH);
        let ([low, high], extremes) = leeway(heights, best, half_m);
        if low < high {
            return Some(best);
        }
        let [top, bottom] = extremes;
        let rarer = if heights[top].points < heights[bottom].points { top } else { bottom };
        heights.swap_remove(rarer);
    }
    None
}

/// Where a concave function is highest.
fn peak(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..50 {
        let third = (high - low) / 3.0;
        if function(low + third) < function(high - third) { low += third } else { high -= third }
    }
    f64::midpoint(low, high)
}

/// Where a concave function that is positive at `inside` falls to 0 on the way to `outside`.
fn edge(function: impl Fn(f64) -> f64, mut inside: f64, mut outside: f64) -> f64 {
    for _ in 0..40 {
        let middle = f64::midpoint(inside, outside);
        if function(middle) > 0.0 { inside = middle } else { outside = middle }
    }
    inside
}

/// The beam's sine as distances from the axis tell it, and its deviation.
struct Sine {
    value: f64,
    deviation: f64,
}

/// Along the beam, distance from the axis grows with the cosine of the elevation.
fn sine_from_reach(beam: &BeamFit, unit_m: f64) -> Sine {
    let mut sums = Sums::default();
    let mut square = 0.0;
    for sample in &beam.samples {
        let range = count_of(beam, unit_m, sample) * unit_m + beam.range_phase;
        // What the line so far leaves: small numbers keep their digits.
        let rest = beam.reach(sample.rho) - range * beam.line.cos;
        sums.add(range, rest);
        square += rest * rest;
    }
    let [_, mean] = sums.mean();
    let noise = (square / sums.n - mean * mean).max(0.0).sqrt();
    let doubt = sums.deviation(noise)[0].hypot(UNIT_DOUBT);
    let sin = beam.line.slope * beam.line.cos;
    // d cos = - tan * d sin
    Sine { value: sin - sums.fit().slope / beam.line.slope, deviation: doubt / beam.line.slope.abs() }
}

/// The mean of all lines that fit, as sine and height at range 0, weighted by what the distances say.
fn middle_line(heights: &[Height], half_m: f64, best: f64, told: &Sine) -> (f64, f64) {
    let room = |sin: f64| width(heights, sin, half_m);
    let ends = [edge(room, best, best - REACH), edge(room, best, best + REACH)];
    let slice = |k: i32| ends[0] + (ends[1] - ends[0]) * (f64::from(k) + 0.5) / f64::from(SLICES);
    let unlikely = |sin: f64| {
        let square = ((sin - told.value) / told.deviation).powi(2) / 2.0;
        if square.is_finite() { square } else { 0.0 }
    };
    let likeliest = (0..SLICES).map(|k| unlikely(slice(k))).fold(f64::INFINITY, f64::min);
    let (mut all, mut sine, mut lift) = (0.0, 0.0, 0.0);
    for sin in (0..SLICES).map(slice) {
        let ([low, high], _) = leeway(heights, sin, half_m);
        let weight = (high - low).max(0.0) * (likeliest - unlikely(sin)).exp();
        all += weight;
        sine += weight * (sin - best);
        lift += weight * f64::midpoint(low, high);
    }
    if all > 0.0 {
        return (best + sine / all, lift / all);
    }
    let ([low, high], _) = leeway(heights, best, half_m);
    (best, f64::midpoint(low, high))
}
