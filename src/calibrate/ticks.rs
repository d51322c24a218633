//! The encoder: how many ticks a turn has, and where each beam stands on them.

use std::vec;
use std::vec::Vec;

use core::f64::consts::TAU;

use super::beams::BeamFit;
use super::cloud::Sample;
use super::fourier::{Circle, fundamental, transform, unit};
use super::line::{SHARPEST_M, Sums, median};

/// Fewer ticks than this no encoder has.
const FEWEST_TICKS: usize = 256;
/// More cannot be told apart in millimetres at the distances seen.
pub(super) const MOST_TICKS: usize = 1 << 17;
/// Widest horizontal offset looked for, metres.
const H_REACH_M: f64 = 0.2;
/// Pairs of points whose 1/rho differs by less see the same offset, whatever it is.
const SAME_NEARNESS: f64 = 1e-4;
/// Pairs closer than this say nothing about which whole number of ticks it is.
const APART_RAD: f64 = 0.2;
/// Weights stop growing here: beyond, rounding no longer matters.
const FAR_M: f64 = 20.0;

/// Multiples of the number of ticks are as good as the number itself, to this. More would be
/// unwise: steadily fired columns make the number less that of the columns a good second.
const TOLERANCE: f64 = 2e-4;

/// How many ticks a turn, and how well the pairs agree on it: 1 all, 0 none.
///
/// Two points of a beam at the same distance lie a whole number of ticks apart,
/// whatever the beam's phase and offset.
pub(super) fn find_ticks(beams: &[BeamFit]) -> (u32, f64) {
    let mut circle = Circle::new(8 * MOST_TICKS);
    for beam in beams {
        add_pairs(&mut circle, &beam.samples);
    }
    let coherence = circle.coherence(MOST_TICKS);
    let ticks = fundamental(&coherence, FEWEST_TICKS, TOLERANCE).unwrap_or(FEWEST_TICKS);
    (ticks as u32, coherence[ticks])
}

fn add_pairs(circle: &mut Circle, samples: &[Sample]) {
    let mut by_distance: Vec<&Sample> = samples.iter().collect();
    by_distance.sort_by(|a, b| a.rho.total_cmp(&b.rho));
    for (at, near) in by_distance.iter().enumerate() {
        for far in by_distance.iter().skip(at + 1).take(4) {
            let turn = far.azimuth - near.azimuth;
            let close = turn.abs() < APART_RAD && near.scan == far.scan;
            if !close && 1.0 / near.rho - 1.0 / far.rho < SAME_NEARNESS {
                circle.add(turn / TAU, near.rho.min(FAR_M).powi(2));
            }
        }
    }
}

/// Number of cells of 1/rho, and of the spectrum over horizontal offsets.
const NEARNESS_CELLS: usize = 1 << 12;
const OFFSET_CELLS: usize = 1 << 15;

/// Finds the beam's horizontal offset and azimuth phase from nothing.
///
/// Along a beam, the azimuth's place within its tick turns with `ticks * h / rho`:
/// a frequency in 1/rho, read from a spectrum.
pub(super) fn find_offset(beam: &mut BeamFit, ticks: u32) {
    let ticks = f64::from(ticks);
    let nearest = beam.samples.iter().map(|s| s.rho).fold(f64::INFINITY, f64::min).max(1.0);
    // Fine enough that the widest offset turns a cell by less than a third of a radian.
    let cell = (1.0 / nearest / NEARNESS_CELLS as f64).min(0.3 / (ticks * H_REACH_M));
    let mut spectrum = vec![[0.0; 2]; OFFSET_CELLS];
    for sample in &beam.samples {
        let at = (1.0 / sample.rho / cell) as usize;
        if let Some(sum) = spectrum.get_mut(at) {
            let [cos, sin] = unit(ticks * sample.azimuth);
            let weight = sample.rho.min(FAR_M);
            sum[0] += weight * cos;
            sum[1] += weight * sin;
        }
    }
    transform(&mut spectrum);
    let step = TAU / (ticks * cell * OFFSET_CELLS as f64);
    let widest = ((H_REACH_M / step) as usize).min(OFFSET_CELLS / 2 - 1);
    let strength = |k: &usize| spectrum[*k][0].hypot(spectrum[*k][1]);
    let offsets = (0..=widest).chain(OFFSET_CELLS - widest..OFFSET_CELLS);
    let best = offsets.max_by(|a, b| strength(a).total_cmp(&strength(b))).unwrap_or(0);
    let signed = if best > OFFSET_CELLS / 2 { best as f64 - OFFSET_CELLS as f64 } else { best as f64 };
    beam.h_offset = signed * step;
    // Points stand in the middle of their cell of 1/rho, half a cell up.
    let phase = spectrum[best][1].atan2(spectrum[best][0]) / ticks;
    beam.azimuth_phase = phase + beam.h_offset * cell / 2.0;
}

/// Snaps the beam's points to ticks and fits offset and phase to what remains.
pub(super) fn refine_offset(beam: &mut BeamFit, ticks: u32) {
    let tick = TAU / f64::from(ticks);
    for round in 0..8 {
        let mut misses: Vec<f64> = beam.samples.iter().map(|s| around(beam, tick, s).abs()).collect();
        let spread = 1.4826 * median(&mut misses);
        let gate = if round == 0 { f64::INFINITY } else { (4.0 * spread).max(SHARPEST_M) };
        let mut sums = Sums::default();
        for sample in &beam.samples {
            let miss = around(beam, tick, sample);
            if miss.abs() <= gate {
                sums.add(sample.rho, miss);
            }
        }
        if sums.n < 8.0 {
            return;
        }
        let change = sums.fit();
        beam.azimuth_phase += change.slope;
        beam.h_offset -= change.offset;
    }
    beam.azimuth_phase -= tick * (beam.azimuth_phase / tick).round();
}

/// How far along the turn the point lies from its tick, metres.
pub(super) fn around(beam: &BeamFit, tick: f64, sample: &Sample) -> f64 {
    let lag = (beam.h_offset / sample.rho).clamp(-1.0, 1.0).asin();
    let turn = sample.azimuth + lag - beam.azimuth_phase;
    (turn - tick * (turn / tick).round()) * sample.rho
}
