use core::fmt;

/// Why scans gave no sensor.
///
/// Each reason carries the statistic found and the limit that it missed, so that a
/// user can see whether the scans are a little or entirely unlike a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum CalibrateError {
    /// A scan's beam numbers are not one for each point.
    BeamHints {
        /// Index of the scan.
        scan: usize,
        /// Points it has.
        points: usize,
        /// Beam numbers it has.
        hints: usize,
    },
    /// The scans together hold too few points that are returns.
    TooFewPoints {
        /// Finite points at least 0.3 m from the spin axis.
        found: usize,
        /// How many it takes.
        needed: usize,
    },
    /// Too many points lie on no beam: moved after measuring (motion-compensated,
    /// merged from several sensors, not in the sensor's own frame), noisy, or from a
    /// sensor that does not spin.
    NotOnBeams {
        /// Share of the points within 3 mm of a beam, 0 to 1.
        share: f64,
        /// Least share that is taken for a spinning sensor.
        limit: f64,
        /// Beams that were made out all the same.
        beams: usize,
    },
    /// The points lie on beams, but their azimuths on no encoder: interpolated,
    /// motion-compensated or turned between scans.
    NotOnTicks {
        /// Mean cosine of the azimuths' places within a tick, for the best number of ticks: 0 to 1.
        coherence: f64,
        /// Least coherence that is taken for an encoder.
        limit: f64,
        /// The best number of ticks a turn.
        ticks_per_turn: u32,
    },
    /// Beams and encoder are there, but ranges are no whole counts: filtered, scaled,
    /// or rounded more coarsely than the sensor counts.
    NotOnCounts {
        /// Mean cosine of the ranges' places within a count, for the best unit: 0 to 1.
        coherence: f64,
        /// Least coherence that is taken for a counter.
        limit: f64,
        /// The best unit, metres.
        unit_m: f64,
    },
}

impl fmt::Display for CalibrateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::BeamHints { scan, points, hints } => {
                write!(f, "scan {scan} has {points} points but {hints} beam numbers")
            }
            Self::TooFewPoints { found, needed } => {
                write!(f, "the scans hold {found} returns, it takes {needed}")
            }
            Self::NotOnBeams { share, limit, beams } => write!(
                f,
                "not on beams: {:.1} % of the points lie within 3 mm of one of {beams} beams, it takes {:.0} %; \
                 motion-compensated, merged, in another frame than the sensor's, or not from a spinning sensor",
                100.0 * share,
                100.0 * limit,
            ),
            Self::NotOnTicks { coherence, limit, ticks_per_turn } => write!(
                f,
                "not on encoder ticks: the best, {ticks_per_turn} a turn, has coherence {coherence:.3}, it takes {limit}; \
                 azimuths interpolated, or motion-compensated",
            ),
            Self::NotOnCounts { coherence, limit, unit_m } => write!(
                f,
                "not on range counts: the best, of {:.3} mm, has coherence {coherence:.3}, it takes {limit}; \
                 ranges filtered, scaled, or rounded more coarsely than counted",
                1000.0 * unit_m,
            ),
        }
    }
}

impl core::error::Error for CalibrateError {}
