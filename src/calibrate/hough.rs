//! Finding beams with nothing known: a vote over all slopes and offsets.
//!
//! Each point votes, at every offset, for the slope of the line through it. The
//! fullest cell is a beam; it is fitted, its points take their votes back, and the
//! next fullest is looked for. Order, count and spacing of the beams do not matter.

use std::vec;
use std::vec::Vec;

use super::beams::FEWEST_POINTS;
use super::cloud::Sample;
use super::line::{Line, settle};

/// Votes are counted in cells of this many metres of offset...
const OFFSET_STEP_M: f64 = 0.004;
/// ...by this much slope: what half an offset step makes at 5 m.
const SLOPE_STEP: f64 = 0.0004;
/// Steepest beam looked for: 56 degrees.
const STEEPEST: f64 = 1.5;
/// Offsets looked at, either way, metres.
const OFFSET_REACH_M: f64 = 0.4;
/// A beam's points lie this near the fullest cell's line, metres.
const GATE_M: f64 = 0.006;
/// More points than this add time and nothing else.
const MOST_VOTERS: usize = 200_000;
/// A cell with fewer votes is chance, or a beam too seldom hit to be known.
const FEWEST_VOTES: usize = 8;
/// So many looks in a row that find no beam end the search.
const MOST_MISSES: usize = 64;
/// No sensor has more beams.
const MOST_BEAMS: usize = 256;

const OFFSETS: usize = (2.0 * OFFSET_REACH_M / OFFSET_STEP_M) as usize + 1;
const SLOPES: usize = (2.0 * STEEPEST / SLOPE_STEP) as usize + 1;

/// The votes, offset by offset.
struct Votes {
    counts: Vec<u32>,
}

impl Votes {
    fn new() -> Self {
        Self { counts: vec![0; OFFSETS * SLOPES] }
    }

    fn change(&mut self, sample: &Sample, change: impl Fn(&mut u32)) {
        for (index, slopes) in self.counts.chunks_exact_mut(SLOPES).enumerate() {
            let slope = (sample.z - offset_at(index)) / sample.rho;
            let bin = (slope + STEEPEST) / SLOPE_STEP + 0.5;
            if let Some(count) = slopes.get_mut(bin as usize).filter(|_| bin >= 0.0) {
                change(count);
            }
        }
    }

    fn fullest(&self) -> (Line, u32) {
        let best = self.counts.iter().enumerate().max_by_key(|(_, count)| **count);
        let (at, count) = best.map_or((0, 0), |(at, count)| (at, *count));
        let slope = (at % SLOPES) as f64 * SLOPE_STEP - STEEPEST;
        (Line::new(slope, offset_at(at / SLOPES)), count)
    }

    fn clear(&mut self, line: Line) {
        let bin = ((line.slope + STEEPEST) / SLOPE_STEP).round() as usize;
        let row = ((line.offset + OFFSET_REACH_M) / OFFSET_STEP_M).round() as usize;
        self.counts[row * SLOPES + bin] = 0;
    }
}

fn offset_at(index: usize) -> f64 {
    index as f64 * OFFSET_STEP_M - OFFSET_REACH_M
}

/// Looks for beams among points that belong to none so far.
///
/// Points nearer than `nearest_m` do not vote: all slopes pass them by.
/// `progress` hears what share of the voters has found its beam.
pub(super) fn find_lines(samples: &[Sample], nearest_m: f64, mut progress: impl FnMut(f32)) -> Vec<Line> {
    let stride = samples.len().div_ceil(MOST_VOTERS).max(1);
    let far = samples.iter().step_by(stride).filter(|sample| sample.rho >= nearest_m);
    let mut left: Vec<Sample> = far.copied().collect();
    let all = left.len() as f32;
    let mut votes = Votes::new();
    for sample in &left {
        votes.change(sample, |count| *count += 1);
    }
    let mut lines = Vec::new();
    let mut misses = 0;
    while misses < MOST_MISSES && lines.len() < MOST_BEAMS {
        let (start, count) = votes.fullest();
        if (count as usize) < FEWEST_VOTES {
            break;
        }
        let Some((line, near_m)) = sharp_line(&left, start) else {
            misses += 1;
            votes.clear(start);
            continue;
        };
        misses = 0;
        take_back(&mut votes, &mut left, line, near_m);
        lines.push(line);
        progress(1.0 - left.len() as f32 / all);
    }
    lines
}

/// Fits the line and says how far its points lie from it; `None` if they are spread like any points.
fn sharp_line(samples: &[Sample], start: Line) -> Option<(Line, f64)> {
    let reach = 4.0 * GATE_M;
    let near: Vec<[f64; 2]> =
        samples.iter().map(|s| [s.rho, s.z]).filter(|&[r, z]| start.across(r, z).abs() < reach).collect();
    let (line, spread) = settle(&near, start, GATE_M)?;
    let near_m = (5.0 * spread).clamp(5e-4, GATE_M / 2.0);
    let within = |limit: f64| near.iter().filter(|&&[r, z]| line.across(r, z).abs() <= limit).count();
    let (inside, around) = (within(near_m), within(3.0 * near_m));
    (inside >= FEWEST_POINTS && inside * 3 > around * 2).then_some((line, near_m))
}

fn take_back(votes: &mut Votes, left: &mut Vec<Sample>, line: Line, near_m: f64) {
    left.retain(|sample| {
        let mine = line.across(sample.rho, sample.z).abs() <= near_m;
        if mine {
            votes.change(sample, |count| *count = count.saturating_sub(1));
        }
        !mine
    });
}
