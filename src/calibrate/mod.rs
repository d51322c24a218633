//! A sensor's grid, found from its point clouds alone.
//!
//! A spinning LiDAR measures on a grid of (beam, encoder tick, range count), and a
//! file of raw points is that grid, turned into x, y, z and rounded. [`calibrate`]
//! goes back: each step needs only what the steps before it found.
//!
//! 1. *Beams* (`hough`, `beams`): from the side, in height over distance from the
//!    axis, each beam is a line. Lines are voted for, fitted, and shared out again.
//! 2. *Ticks* (`ticks`): two points of a beam at one distance lie whole ticks apart,
//!    so a spectrum over such pairs peaks at the number of ticks a turn.
//! 3. *Offsets and phases*: along a beam the place within a tick turns with
//!    1/distance at a rate that is the horizontal offset.
//! 4. *Range unit and phases* (`unit`): two ranges of a beam lie whole counts apart.
//! 5. *Where ranges begin* (`axis`): at the spin axis, or where the beam passes it.
//! 6. *Rounding* (`rounding`): in files that are rounded, heights say more than their mean.
//! 7. *Residuals*: every point is put on the grid that came out and has to fit.
//!
//! The order of the points does not matter. Scans that are not on a grid are refused
//! with the statistic that says so ([`CalibrateError`]). Azimuth phases are given
//! within half a tick of 0 and range phases within half a unit: whole ticks and
//! counts say nothing about where points can lie.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "bins and counts: `as` saturates, which is wanted"
)]

mod axis;
mod beams;
mod cloud;
mod error;
mod fourier;
mod hough;
mod line;
mod residuals;
mod rounding;
mod ticks;
mod unit;

use std::borrow::ToOwned as _;
use std::vec::Vec;

pub use error::CalibrateError;
pub use residuals::{BeamResiduals, HISTOGRAM_BINS, HISTOGRAM_REACH_M, OFF_GRID_M, Residuals, Spread};

use crate::sensor::{Beam, Sensor};
use beams::BeamFit;
use cloud::Cloud;

/// Fewer returns than this are refused.
const FEWEST_RETURNS: usize = 500;
/// Least share of points on beams. Raw scans have all but a few stray points there.
const BEAM_SHARE: f64 = 0.95;
/// Least coherence of azimuths: an eighth of a tick of noise still passes.
const TICK_COHERENCE: f64 = 0.5;
/// Least coherence of ranges: files in millimetres leave 0.42 of counts of 2 mm.
const COUNT_COHERENCE: f64 = 0.2;

/// One scan: a turn of the sensor, or a piece of one, in the sensor's own frame.
#[derive(Debug, Clone, Copy)]
pub struct Scan<'a> {
    /// Points in metres: x and y in the plane of the turn, z along its axis. Points at
    /// the origin and points that are not finite are taken for 'no return'.
    pub points: &'a [[f32; 3]],
    /// Each point's beam, in any numbering, where the file has it (a 'ring' column):
    /// beams are then found without a vote, if all scans have it.
    pub beams: Option<&'a [u16]>,
}

/// What a calibration is busy with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Finding the beams.
    Beams,
    /// Finding the encoder's ticks.
    Ticks,
    /// Finding horizontal offsets and azimuth phases.
    Offsets,
    /// Finding the range unit and range phases.
    Unit,
    /// Putting every point on the grid.
    Residuals,
}

/// How far a calibration has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// What it is busy with.
    pub stage: Stage,
    /// How much of that is done, 0 to 1.
    pub fraction: f32,
}

/// A sensor found, and how well it fits.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The sensor; its name is the one given.
    pub sensor: Sensor,
    /// How far the points lie from the sensor's grid.
    pub residuals: Residuals,
    /// Share of the points within 3 mm of a beam, 0 to 1.
    pub beam_share: f64,
    /// How well azimuths agree on ticks, 0 to 1; see [`CalibrateError::NotOnTicks`].
    pub tick_coherence: f64,
    /// How well ranges agree on counts, 0 to 1; see [`CalibrateError::NotOnCounts`].
    pub count_coherence: f64,
}

/// Finds a sensor's beams, ticks and range unit from scans.
///
/// Eight KITTI scans (a million points) take a few seconds on one core. Memory is
/// about 100 bytes a point. The same scans give the same sensor.
///
/// ```
/// use flicr::calibrate::{CalibrateError, Scan, calibrate};
///
/// let points = [[1.0, 2.0, 3.0]; 10];
/// let scans = [Scan { points: &points, beams: None }];
/// let refused = calibrate("mine", &scans, &mut |_| ()).unwrap_err();
/// assert_eq!(refused, CalibrateError::TooFewPoints { found: 10, needed: 500 });
/// ```
///
/// # Errors
/// [`CalibrateError`]: beam numbers that do not match the points, too few points, or
/// points that are not on beams, on ticks or on range counts.
pub fn calibrate(
    name: &str,
    scans: &[Scan<'_>],
    progress: &mut dyn FnMut(Progress),
) -> Result<Calibration, CalibrateError> {
    let cloud = cloud_of(scans)?;
    let (mut beams, beam_share) = fit_beams(&cloud, progress)?;
    let (ticks_per_turn, tick_coherence) = fit_ticks(&mut beams, progress)?;
    let (mut unit_m, count_coherence) = fit_unit(&mut beams, progress)?;
    let range_from_axis = axis::ranges_begin_there(&beams, unit_m);
    if range_from_axis {
        for beam in &mut beams {
            beam.range_from_axis = true;
            beam.refit();
        }
        unit_m = unit::settle_unit(&mut beams, unit_m);
    }
    if let Some(step_m) = rounding::step_of(&cloud) {
        for beam in &mut beams {
            rounding::sharpen(beam, unit_m, step_m);
        }
    }
    let sensor = Sensor {
        name: name.to_owned(),
        beams: beams.iter().map(rounded).collect(),
        ticks_per_turn,
        range_unit_m: unit_m as f32,
        range_from_axis,
    };
    progress(Progress { stage: Stage::Residuals, fraction: 0.0 });
    let mut residuals = Residuals::of(&sensor, scans);
    for (fit, beam) in beams.iter().zip(&mut residuals.beams) {
        beam.deviation = deviation(fit, beam);
    }
    progress(Progress { stage: Stage::Residuals, fraction: 1.0 });
    Ok(Calibration { sensor, residuals, beam_share, tick_coherence, count_coherence })
}

fn cloud_of(scans: &[Scan<'_>]) -> Result<Cloud, CalibrateError> {
    for (index, scan) in scans.iter().enumerate() {
        let hints = scan.beams.map_or(scan.points.len(), <[u16]>::len);
        if hints != scan.points.len() {
            return Err(CalibrateError::BeamHints { scan: index, points: scan.points.len(), hints });
        }
    }
    let cloud = Cloud::new(scans);
    let found = cloud.samples.len();
    if found < FEWEST_RETURNS {
        return Err(CalibrateError::TooFewPoints { found, needed: FEWEST_RETURNS });
    }
    Ok(cloud)
}

fn fit_beams(cloud: &Cloud, progress: &mut dyn FnMut(Progress)) -> Result<(Vec<BeamFit>, f64), CalibrateError> {
    let mut report = |fraction| progress(Progress { stage: Stage::Beams, fraction });
    report(0.0);
    let mut beams = beams::find_beams(cloud, &mut report);
    let stray = beams::share_out(cloud, &mut beams);
    let share = 1.0 - stray as f64 / cloud.samples.len() as f64;
    if share < BEAM_SHARE {
        return Err(CalibrateError::NotOnBeams { share, limit: BEAM_SHARE, beams: beams.len() });
    }
    report(1.0);
    Ok((beams, share))
}

fn fit_ticks(beams: &mut [BeamFit], progress: &mut dyn FnMut(Progress)) -> Result<(u32, f64), CalibrateError> {
    progress(Progress { stage: Stage::Ticks, fraction: 0.0 });
    let (ticks_per_turn, coherence) = ticks::find_ticks(beams);
    if coherence < TICK_COHERENCE {
        return Err(CalibrateError::NotOnTicks { coherence, limit: TICK_COHERENCE, ticks_per_turn });
    }
    let count = beams.len() as f32;
    for (beam, done) in beams.iter_mut().zip(0_u16..) {
        progress(Progress { stage: Stage::Offsets, fraction: f32::from(done) / count });
        ticks::find_offset(beam, ticks_per_turn);
        ticks::refine_offset(beam, ticks_per_turn);
        // The line was fitted as if the beam met the axis.
        beam.refit();
    }
    Ok((ticks_per_turn, coherence))
}

fn fit_unit(beams: &mut [BeamFit], progress: &mut dyn FnMut(Progress)) -> Result<(f64, f64), CalibrateError> {
    progress(Progress { stage: Stage::Unit, fraction: 0.0 });
    let (rough_m, coherence) = unit::find_unit(beams);
    if coherence < COUNT_COHERENCE {
        return Err(CalibrateError::NotOnCounts { coherence, limit: COUNT_COHERENCE, unit_m: rough_m });
    }
    progress(Progress { stage: Stage::Unit, fraction: 0.5 });
    Ok((unit::settle_unit(beams, rough_m), coherence))
}

/// The beam in single precision: 0.01 mm at 100 m, a hundredth of what files are rounded to.
fn rounded(fit: &BeamFit) -> Beam {
    Beam {
        slope: fit.line.slope as f32,
        z_offset_m: fit.line.offset as f32,
        h_offset_m: fit.h_offset as f32,
        azimuth_phase_rad: fit.azimuth_phase as f32,
        range_phase_m: fit.range_phase as f32,
    }
}

/// About one standard deviation of the beam's numbers, from the misses and where the points lie.
fn deviation(fit: &BeamFit, residuals: &BeamResiduals) -> Beam {
    let mut sums = line::Sums::default();
    fit.samples.iter().for_each(|sample| sums.add(sample.rho, 0.0));
    let [slope, z_offset] = sums.deviation(residuals.across.rms_m / fit.line.cos);
    let [azimuth_phase, h_offset] = sums.deviation(residuals.around.rms_m);
    let range_phase = residuals.along.rms_m / sums.n.sqrt();
    Beam {
        slope: slope as f32,
        z_offset_m: z_offset as f32,
        h_offset_m: h_offset as f32,
        azimuth_phase_rad: azimuth_phase as f32,
        range_phase_m: range_phase as f32,
    }
}
