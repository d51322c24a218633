//! The paper's measures that need no points: sampling error and the PSNR that reflects it.

use super::MetricError;

/// The two parameters of [`epsnr_db`] (paper, eq. 6 to 8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EpsnrParameters {
    /// α: added to the entropy function F before it is held to 0..1.
    pub alpha: f64,
    /// β: mean of the exponential distribution that F is the tail of. Above 0.
    pub beta: f64,
}

impl EpsnrParameters {
    /// α = -0.15, β = 0.5: the paper's, section "FLiCR Benchmark".
    pub const PAPER: Self = Self { alpha: -0.15, beta: 0.5 };

    /// F(SE) + α held to 0..1: the share of the lost points' information that counts as lost (paper, eq. 7).
    fn lost_share(self, se: f64) -> f64 {
        let tail = (-(1.0 - se) / self.beta).exp();
        (tail + self.alpha).clamp(0.0, 1.0)
    }

    fn check(self) -> Result<(), MetricError> {
        let Self { alpha, beta } = self;
        if alpha.is_finite() && beta.is_finite() && beta > 0.0 {
            Ok(())
        } else {
            Err(MetricError::EpsnrParameters { alpha, beta })
        }
    }
}

impl Default for EpsnrParameters {
    fn default() -> Self {
        Self::PAPER
    }
}

/// SE (paper, eq. 5): lost points / original points, 0 to 1, from numbers of points.
///
/// # Errors
/// [`MetricError::PointCount`] if there was no original point, or more are kept than there were.
///
/// ```
/// assert_eq!(flicr::metrics::sampling_error(200, 50), Ok(0.75));
/// ```
pub fn sampling_error(original: usize, kept: usize) -> Result<f64, MetricError> {
    if original == 0 || kept > original {
        return Err(MetricError::PointCount { original, kept });
    }
    Ok((original - kept) as f64 / original as f64)
}

/// ePSNR (paper, eq. 8): PSNR x (1 - SE x (F(SE) + α)), dB; F(SE) = e^(-(1 - SE) / β), F + α held to 0..1.
///
/// An infinite PSNR stays infinite, but for a factor of zero (nothing left), which gives 0 dB.
///
/// # Errors
/// [`MetricError::SamplingError`] if `se` is not in 0 to 1, [`MetricError::Psnr`] if `psnr_db` is not a number,
/// [`MetricError::EpsnrParameters`] if α or β is not finite or β is not above 0.
///
/// ```
/// use flicr::metrics::{EpsnrParameters, epsnr_db};
///
/// let epsnr_db = epsnr_db(53.71, 0.892, EpsnrParameters::PAPER)?;
/// assert!((epsnr_db - 22.29).abs() < 0.01); // the paper's 256x64 frame
/// # Ok::<(), flicr::metrics::MetricError>(())
/// ```
pub fn epsnr_db(psnr_db: f64, se: f64, parameters: EpsnrParameters) -> Result<f64, MetricError> {
    if psnr_db.is_nan() {
        return Err(MetricError::Psnr);
    }
    if !(0.0..=1.0).contains(&se) {
        return Err(MetricError::SamplingError { found: se });
    }
    parameters.check()?;
    let factor = 1.0 - se * parameters.lost_share(se);
    Ok(if factor == 0.0 { 0.0 } else { psnr_db * factor })
}
