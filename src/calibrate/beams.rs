//! Which beam each point belongs to, and each beam's line.

use std::vec;
use std::vec::Vec;

use super::cloud::{Cloud, Sample};
use super::hough::find_lines;
use super::line::{Line, rough_line, settle};

/// A point this far from every beam belongs to none, metres.
const GATE_M: f64 = 0.003;
/// A point is ambiguous where the second nearest beam is not this much farther.
const CLEARLY_M: f64 = 0.003;
/// Fewer points do not make a beam.
pub(super) const FEWEST_POINTS: usize = 16;

/// A beam on its way to being known, with its points.
#[derive(Debug, Clone)]
pub(super) struct BeamFit {
    pub(super) line: Line,
    pub(super) h_offset: f64,
    pub(super) range_from_axis: bool,
    pub(super) azimuth_phase: f64,
    pub(super) range_phase: f64,
    pub(super) samples: Vec<Sample>,
}

impl BeamFit {
    fn new(line: Line) -> Self {
        Self { line, h_offset: 0.0, range_from_axis: false, azimuth_phase: 0.0, range_phase: 0.0, samples: Vec::new() }
    }

    /// The distance that the beam's range gives, of a point so far from the axis.
    pub(super) fn reach(&self, rho: f64) -> f64 {
        let aside = if self.range_from_axis { 0.0 } else { self.h_offset };
        (rho * rho - aside * aside).max(0.0).sqrt()
    }

    pub(super) fn across(&self, sample: &Sample) -> f64 {
        self.line.across(self.reach(sample.rho), sample.z)
    }

    /// Range along the beam, metres.
    pub(super) fn along(&self, sample: &Sample) -> f64 {
        (self.reach(sample.rho) + sample.z * self.line.slope) * self.line.cos
    }

    /// Fits the line anew to the beam's points.
    pub(super) fn refit(&mut self) {
        let points: Vec<[f64; 2]> = self.samples.iter().map(|s| [self.reach(s.rho), s.z]).collect();
        if let Some((line, _)) = settle(&points, self.line, GATE_M) {
            self.line = line;
        }
    }
}

/// The beams of a cloud, highest first, each with its points.
pub(super) fn find_beams(cloud: &Cloud, progress: &mut dyn FnMut(f32)) -> Vec<BeamFit> {
    let mut beams = if cloud.hinted { hinted_beams(cloud) } else { voted_beams(cloud, progress) };
    beams.sort_by(|a, b| b.line.slope.total_cmp(&a.line.slope));
    beams
}

fn hinted_beams(cloud: &Cloud) -> Vec<BeamFit> {
    let most = cloud.samples.iter().map(|s| usize::from(s.hint) + 1).max().unwrap_or(0);
    let mut groups = vec![Vec::new(); most];
    for sample in &cloud.samples {
        groups[usize::from(sample.hint)].push(*sample);
    }
    let full = groups.into_iter().filter(|samples| samples.len() >= FEWEST_POINTS);
    full.filter_map(|samples| {
        let mut beam = BeamFit::new(rough_line(&samples.iter().collect::<Vec<_>>())?);
        beam.samples = samples;
        // The rough line may be off by much; let go of it in steps.
        for gate_m in [1.0, 0.1, 0.02] {
            let points: Vec<[f64; 2]> = beam.samples.iter().map(|s| [s.rho, s.z]).collect();
            beam.line = settle(&points, beam.line, gate_m)?.0;
        }
        Some(beam)
    })
    .collect()
}

fn voted_beams(cloud: &Cloud, progress: &mut dyn FnMut(f32)) -> Vec<BeamFit> {
    let mut beams = Vec::new();
    let mut left = cloud.samples.clone();
    // The first look sees a sample of the far points; beams seldom hit, or that see
    // only the ground close by, show among what it leaves.
    for nearest_m in [1.5, 0.3, 0.3] {
        if left.len() < FEWEST_POINTS {
            break;
        }
        let share = left.len() as f32 / cloud.samples.len() as f32;
        let lines = find_lines(&left, nearest_m, |found| progress(1.0 - share * (1.0 - found)));
        beams.extend(lines.into_iter().map(BeamFit::new));
        settle_beams(cloud, &mut beams);
        left = cloud.samples.iter().filter(|s| beams.iter().all(|b| b.across(s).abs() > GATE_M)).copied().collect();
    }
    beams
}

/// Shares the points out and fits again until beams that are the same have met.
fn settle_beams(cloud: &Cloud, beams: &mut Vec<BeamFit>) {
    for _ in 0..3 {
        share_out(cloud, beams);
        beams.retain(|beam| beam.samples.len() >= FEWEST_POINTS);
        beams.iter_mut().for_each(BeamFit::refit);
        drop_doubles(beams);
    }
}

/// Of two beams that lie in each other over all their points, keeps the fuller.
fn drop_doubles(beams: &mut Vec<BeamFit>) {
    beams.sort_by_key(|beam| core::cmp::Reverse(beam.samples.len()));
    let mut kept: Vec<BeamFit> = Vec::new();
    for beam in beams.drain(..) {
        let near = |other: &BeamFit, s: &Sample| other.across(s).abs() < GATE_M;
        let double = kept.iter().any(|other| {
            let shared = beam.samples.iter().filter(|s| near(other, s)).count();
            2 * shared > beam.samples.len()
        });
        if !double {
            kept.push(beam);
        }
    }
    *beams = kept;
}

/// Gives each point to the beam it clearly lies on; returns how many lie on none.
pub(super) fn share_out(cloud: &Cloud, beams: &mut [BeamFit]) -> usize {
    for beam in beams.iter_mut() {
        beam.samples.clear();
    }
    let mut stray = 0;
    for sample in &cloud.samples {
        let (nearest, first, second) = two_nearest(beams, sample);
        if first > GATE_M {
            stray += 1;
        } else if second - first > CLEARLY_M {
            beams[nearest].samples.push(*sample);
        }
    }
    stray
}

/// Index of the nearest beam, and the distances of the nearest two.
fn two_nearest(beams: &[BeamFit], sample: &Sample) -> (usize, f64, f64) {
    let (mut nearest, mut first, mut second) = (0, f64::INFINITY, f64::INFINITY);
    for (index, beam) in beams.iter().enumerate() {
        let across = beam.across(sample).abs();
        if across < first {
            (nearest, first, second) = (index, across, first);
        } else if across < second {
            second = across;
        }
    }
    (nearest, first, second)
}
