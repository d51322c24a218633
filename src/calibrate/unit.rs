//! The range counter: the length of one count, and where each beam's count 0 lies.

use std::vec::Vec;

use core::f64::consts::TAU;

use super::beams::BeamFit;
use super::cloud::Sample;
use super::fourier::{Circle, fundamental};
use super::line::Sums;

/// Length that the spectrum's frequencies are whole parts of, metres: ten times the
/// differences used, so that no unit falls between two.
const SPAN_M: f64 = 20.0;
/// Differences used lie between these, metres: below, all ranges agree.
const CLOSEST_M: f64 = 0.1;
const FARTHEST_M: f64 = 2.0;
/// A unit that falls between two frequencies loses up to this.
const TOLERANCE: f64 = 0.03;
/// Shortest unit looked for, metres; millimetre files hide anything shorter.
const SHORTEST_M: f64 = 0.0004;
/// Longest, metres.
const LONGEST_M: f64 = 0.08;
/// Points a beam that the search looks at.
const MOST_PAIRS: usize = 4000;

/// Length of a range count, and how well the pairs agree on it: 1 all, 0 none.
///
/// Two points of a beam lie a whole number of counts apart, whatever its phase.
pub(super) fn find_unit(beams: &[BeamFit]) -> (f64, f64) {
    let ranges: Vec<Vec<f64>> = beams.iter().map(sorted_ranges).collect();
    let mut circle = Circle::new(1 << 19);
    for difference in differences(&ranges, FARTHEST_M) {
        circle.add(difference / SPAN_M, 1.0);
    }
    let coherence = circle.coherence((SPAN_M / SHORTEST_M) as usize);
    let from = (SPAN_M / LONGEST_M) as usize;
    let Some(peak) = fundamental(&coherence, from, TOLERANCE) else {
        return (SHORTEST_M, 0.0);
    };
    let mut frequency = peak as f64 / SPAN_M;
    for reach_m in [FARTHEST_M, 6.0, 20.0, 60.0] {
        frequency = sharpen(&ranges, frequency, reach_m);
    }
    (1.0 / frequency, coherence[peak])
}

fn sorted_ranges(beam: &BeamFit) -> Vec<f64> {
    let stride = beam.samples.len().div_ceil(MOST_PAIRS).max(1);
    let mut ranges: Vec<f64> = beam.samples.iter().step_by(stride).map(|s| beam.along(s)).collect();
    ranges.sort_by(f64::total_cmp);
    ranges
}

/// For each range the next one that is at least a pseudo-random distance farther.
fn differences(ranges: &[Vec<f64>], reach_m: f64) -> Vec<f64> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut pairs = Vec::new();
    for beam in ranges {
        for &near in beam {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let share = (state >> 11) as f64 / (1_u64 << 53) as f64;
            let target = near + CLOSEST_M + share * (reach_m - CLOSEST_M);
            let far = beam.get(beam.partition_point(|&range| range < target));
            pairs.extend(far.map(|far| far - near).filter(|&difference| difference < reach_m));
        }
    }
    pairs
}

/// The frequency near this one on which differences up to `reach_m` agree best.
fn sharpen(ranges: &[Vec<f64>], frequency: f64, reach_m: f64) -> f64 {
    let pairs = differences(ranges, reach_m);
    let stride = pairs.len().div_ceil(40_000).max(1);
    let agreement = |f: f64| -> f64 { pairs.iter().step_by(stride).map(|d| (TAU * f * d).cos()).sum() };
    let step = 0.02 / reach_m;
    let values: Vec<f64> = (-30..=30).map(|k| agreement(frequency + f64::from(k) * step)).collect();
    let best = (1..values.len() - 1).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(30);
    let (before, here, after) = (values[best - 1], values[best], values[best + 1]);
    let bend = before - 2.0 * here + after;
    let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    frequency + (best as f64 - 30.0 + shift.clamp(-1.0, 1.0)) * step
}

/// Each beam's range phase: the circular mean, then the mean of what is near it.
fn fit_phase(beam: &mut BeamFit, unit: f64) {
    let ranges: Vec<f64> = beam.samples.iter().map(|s| beam.along(s)).collect();
    let (mut cos, mut sin) = (0.0, 0.0);
    for range in &ranges {
        let angle = TAU * range / unit;
        cos += angle.cos();
        sin += angle.sin();
    }
    let mut phase = sin.atan2(cos) / TAU * unit;
    for _ in 0..3 {
        let rests: Vec<f64> = ranges.iter().map(|range| rest(range - phase, unit)).collect();
        phase += rests.iter().sum::<f64>() / rests.len().max(1) as f64;
    }
    beam.range_phase = rest(phase, unit);
}

/// Fits unit and phases in turn, and rounds the unit if it is as good as round.
pub(super) fn settle_unit(beams: &mut [BeamFit], rough_m: f64) -> f64 {
    let mut unit = rough_m;
    for _ in 0..3 {
        fit_phases(beams, unit);
        unit = refine_unit(beams, unit);
    }
    unit = rounded(unit);
    fit_phases(beams, unit);
    unit
}

fn fit_phases(beams: &mut [BeamFit], unit: f64) {
    for beam in beams {
        fit_phase(beam, unit);
    }
}

/// Whole micrometres, if that moves no point by a fifth of a millimetre. (The unit of KITTI's
/// files comes out a millionth too long, on all beams alike: 0.02 mm at 20 m.)
fn rounded(unit_m: f64) -> f64 {
    let round_m = (unit_m * 1e6).round() / 1e6;
    let counts = 100.0 / unit_m;
    if (round_m - unit_m).abs() * counts < 2e-4 { round_m } else { unit_m }
}

/// Fits the unit to all beams' counts at once.
fn refine_unit(beams: &[BeamFit], unit: f64) -> f64 {
    let mut sums = Sums::default();
    for beam in beams {
        let counts = beam.samples.iter().map(|s| {
            let range = beam.along(s) - beam.range_phase;
            [(range / unit).round(), rest(range, unit)]
        });
        let counts: Vec<[f64; 2]> = counts.collect();
        // About each beam's own mean: its phase is fitted elsewhere.
        let mut means = Sums::default();
        for &[count, rest] in &counts {
            means.add(count, rest);
        }
        let [mean_count, mean_rest] = means.mean();
        for [count, rest] in counts {
            sums.add(count - mean_count, rest - mean_rest);
        }
    }
    unit + sums.fit().slope
}

/// How far a point lies behind the middle of its count.
pub(super) fn off_count(beam: &BeamFit, unit_m: f64, sample: &Sample) -> f64 {
    rest(beam.along(sample) - beam.range_phase, unit_m)
}

/// What is left of a length after whole units, -unit/2 to unit/2.
fn rest(length: f64, unit: f64) -> f64 {
    length - unit * (length / unit).round()
}
