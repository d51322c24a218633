//! All scans' points in the coordinates that the fit works in.

use std::vec::Vec;

use super::Scan;

/// Nearer than this is the sensor's own housing, or no return at all.
const NEAREST_M: f64 = 0.3;

/// A point as the fit sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Distance from the spin axis, metres.
    pub(super) rho: f64,
    /// Height, metres.
    pub(super) z: f64,
    /// `atan2(y, x)`, radians.
    pub(super) azimuth: f64,
    /// Which scan it came from.
    pub(super) scan: u32,
    /// The caller's beam number, or 0.
    pub(super) hint: u16,
}

/// Every usable point of every scan, and whether the caller named the beams.
pub(super) struct Cloud {
    pub(super) samples: Vec<Sample>,
    pub(super) hinted: bool,
}

impl Cloud {
    pub(super) fn new(scans: &[Scan<'_>]) -> Self {
        let hinted = !scans.is_empty() && scans.iter().all(|scan| scan.beams.is_some());
        let samples = scans.iter().zip(0..).flat_map(|(scan, index)| samples_of(scan, index));
        Self { samples: samples.collect(), hinted }
    }
}

fn samples_of<'a>(scan: &'a Scan<'_>, index: u32) -> impl Iterator<Item = Sample> + 'a {
    let hint = move |at: usize| scan.beams.and_then(|beams| beams.get(at)).copied().unwrap_or(0);
    scan.points.iter().enumerate().filter_map(move |(at, &point)| {
        let [x, y, z] = point.map(f64::from);
        let rho = x.hypot(y);
        let usable = rho >= NEAREST_M && rho.is_finite() && z.is_finite();
        usable.then(|| Sample { rho, z, azimuth: y.atan2(x), scan: index, hint: hint(at) })
    })
}
