//! Why a measure has no value.

use core::fmt;

/// A measure that is not defined for what it was asked of.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum MetricError {
    /// A cloud without points is at no distance from anything.
    Empty {
        /// The cloud without points.
        cloud: Cloud,
    },
    /// A point with a coordinate that is infinite or not a number.
    NotFinite {
        /// The cloud it is in.
        cloud: Cloud,
        /// Its index there.
        index: usize,
    },
    /// More points than the search tree can number.
    TooManyPoints {
        /// Points there are.
        found: usize,
        /// Points it can number.
        most: usize,
    },
    /// PSNR needs a positive, finite Max.
    MaxRange {
        /// Meters asked for.
        found_m: f64,
    },
    /// SE needs at least one original point and no more kept points than original ones.
    PointCount {
        /// Original points.
        original: usize,
        /// Points kept of them.
        kept: usize,
    },
    /// A sampling error lies between 0 and 1.
    SamplingError {
        /// What was given.
        found: f64,
    },
    /// The PSNR given is not a number.
    Psnr,
    /// ePSNR needs finite parameters and a β above 0.
    EpsnrParameters {
        /// α given.
        alpha: f64,
        /// β given.
        beta: f64,
    },
}

/// One of the two clouds of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cloud {
    /// What was encoded.
    Original,
    /// What was decoded.
    Reconstructed,
}

impl fmt::Display for Cloud {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Original => "original",
            Self::Reconstructed => "reconstructed",
        })
    }
}

impl fmt::Display for MetricError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Empty { cloud } => {
                write!(f, "the {cloud} cloud has no points: expected at least one")
            }
            Self::NotFinite { cloud, index } => {
                write!(f, "point {index} of the {cloud} cloud has a coordinate that is not finite")
            }
            Self::TooManyPoints { found, most } => {
                write!(f, "a cloud has {found} points: expected at most {most}")
            }
            Self::MaxRange { found_m } => {
                write!(f, "a PSNR against {found_m} m asked for: expected a positive, finite number")
            }
            Self::PointCount { original, kept } => {
                write!(f, "{kept} points kept of {original}: expected 1 original point or more, and no more kept")
            }
            Self::SamplingError { found } => {
                write!(f, "a sampling error of {found}: expected 0 to 1")
            }
            Self::Psnr => write!(f, "the PSNR given is not a number"),
            Self::EpsnrParameters { alpha, beta } => {
                write!(f, "ePSNR parameters alpha = {alpha}, beta = {beta}: expected finite numbers and beta > 0")
            }
        }
    }
}

impl core::error::Error for MetricError {}
