//! Where ranges begin: at the spin axis, or where the beam passes it.
//!
//! A beam that passes the axis `h` beside it sees a point `sqrt(a^2 + h^2)` from the axis, if `a` is what its range
//! gives; some sensors' data have it at `a` itself. The two differ by `h^2 / 2a`: of a few centimeters of offset that is
//! a tenth of what files are rounded to, but a million points have it.

use super::beams::BeamFit;
use super::line::Sums;
use super::unit;

/// One standard deviation of the share of `h^2 / 2a` that is seen must be less than this to be believed.
const DOUBT: f64 = 0.125;

/// Whether ranges count from the axis, judged by beams fitted as if they did not; `false` where offsets are too small
/// to tell.
pub(super) fn ranges_begin_there(beams: &[BeamFit], unit_m: f64) -> bool {
    let (mut sums, mut square) = (Sums::default(), 0.0);
    for beam in beams {
        let shortening = |rho: f64| beam.h_offset * beam.h_offset / (2.0 * rho) * beam.line.cos;
        let samples = beam.samples.iter().map(|s| [shortening(s.rho), unit::off_count(beam, unit_m, s)]);
        // About each beam's own mean: its range phase was fitted to that.
        let mut own = Sums::default();
        samples.clone().for_each(|[shorter, off]| own.add(shorter, off));
        let [mean_shorter, mean_off] = own.mean();
        for [shorter, off] in samples {
            sums.add(shorter - mean_shorter, off - mean_off);
            square += (off - mean_off) * (off - mean_off);
        }
    }
    let [doubt, _] = sums.deviation((square / sums.n).sqrt());
    doubt < DOUBT && sums.fit().slope < -0.5
}
