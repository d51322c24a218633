//! Range to level and back, with the bound on what is lost in between.

use crate::error::ConfigError;
use crate::kernel::to_index;

/// Uniform quantizer: level = range / step, rounded; range = level x step; level 0 = no return.
///
/// A range below half a step would become 'no return' and one more than half a step beyond the largest has no
/// level: both are refused by [`level`](Self::level), so that the caller can count them. All others come back with
/// an error of at most [`range_bound_m`](Self::range_bound_m).
///
/// Source: FLiCR, section IV-B (quantization of the range image to 8 bits a pixel).
///
/// ```
/// use flicr::Quantizer;
/// let quantizer = Quantizer::new(8, 80.0).unwrap();
/// let level = quantizer.level(10.0).unwrap();
/// assert!((quantizer.range_m(level) - 10.0).abs() <= quantizer.range_bound_m());
/// assert_eq!(quantizer.level(0.1), Err(flicr::OutOfScale::TooNear));
/// assert_eq!(quantizer.level(80.2), Err(flicr::OutOfScale::Beyond));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantizer {
    step_m: f32,
    steps_per_m: f32,
    level_bits: u32,
}

/// Why a range has no level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OutOfScale {
    /// Nearer than half a step.
    TooNear,
    /// More than half a step beyond the largest range.
    Beyond,
}

impl Quantizer {
    /// Levels of `level_bits` bits for ranges of 0 to `max_range_m` meters.
    ///
    /// # Errors
    /// [`ConfigError::LevelBits`] unless 1 <= `level_bits` <= 16; [`ConfigError::MaxRange`] unless `max_range_m` is
    /// positive and finite and so is its step.
    pub const fn new(level_bits: u32, max_range_m: f32) -> Result<Self, ConfigError> {
        if level_bits < 1 || level_bits > 16 {
            return Err(ConfigError::LevelBits { found: level_bits, min: 1, max: 16 });
        }
        let max_level = (1_u32 << level_bits) - 1;
        match Self::from_step(level_bits, max_range_m / max_level as f32) {
            Some(quantizer) => Ok(quantizer),
            None => Err(ConfigError::MaxRange { found_m: max_range_m }),
        }
    }

    /// Levels of `level_bits` bits that are `step_m` meters apart.
    ///
    /// # Errors
    /// [`ConfigError::LevelBits`] unless 1 <= `level_bits` <= 16; [`ConfigError::MaxRange`] unless `step_m` is positive
    /// and finite and so is the largest range.
    pub const fn with_step(level_bits: u32, step_m: f32) -> Result<Self, ConfigError> {
        if level_bits < 1 || level_bits > 16 {
            return Err(ConfigError::LevelBits { found: level_bits, min: 1, max: 16 });
        }
        match Self::from_step(level_bits, step_m) {
            Some(quantizer) => Ok(quantizer),
            None => Err(ConfigError::MaxRange { found_m: step_m * ((1_u32 << level_bits) - 1) as f32 }),
        }
    }

    /// Levels of `level_bits` bits (1 to 16) that are `step_m` meters apart. `None` where the step is not positive
    /// and finite, or so extreme that its inverse or largest range is not.
    #[must_use]
    pub(crate) const fn from_step(level_bits: u32, step_m: f32) -> Option<Self> {
        let steps_per_m = 1.0 / step_m;
        let quantizer = Self { step_m, steps_per_m, level_bits };
        let usable =
            step_m > 0.0 && steps_per_m > 0.0 && steps_per_m.is_finite() && quantizer.max_range_m().is_finite();
        if usable { Some(quantizer) } else { None }
    }

    /// Distance between two levels, meters.
    #[must_use]
    pub const fn step_m(&self) -> f32 {
        self.step_m
    }

    /// Bits of a level.
    #[must_use]
    pub const fn level_bits(&self) -> u32 {
        self.level_bits
    }

    /// The largest level.
    #[must_use]
    pub const fn max_level(&self) -> u16 {
        ((1_u32 << self.level_bits) - 1) as u16
    }

    /// The largest level's range, meters.
    #[must_use]
    pub const fn max_range_m(&self) -> f32 {
        self.range_m(self.max_level())
    }

    /// Most that a range that has a level can be off after a round trip, meters: half a step, and the rounding of
    /// the four float operations between a point's coordinates and its range.
    #[must_use]
    pub const fn range_bound_m(&self) -> f32 {
        self.range_bound_with_m(0)
    }

    /// As [`range_bound_m`](Self::range_bound_m), where a coder may change levels by up to `error_max`.
    #[must_use]
    pub const fn range_bound_with_m(&self, error_max: u16) -> f32 {
        // Each operation is off by at most 2^-24 of its result, which is at most max_level steps; the range itself
        // (three products, two sums, a square root) by no more than four of them again.
        self.step_m * (0.5 + error_max as f32 + self.max_level() as f32 * f32::EPSILON * 4.0)
    }

    /// The PSNR that rounding to levels alone leaves, dB: errors even over a step, against the peak `max_range_m`
    /// (the paper's 80 m). What a device can say of its own quality without decoding. The projection's error is not
    /// in it, nor that the metric takes the nearest of all points.
    ///
    /// `micromath`'s logarithm: within 0.01 dB as long as a step is shorter than `max_range_m`, with a fraction of an
    /// exact one's code. It is for reports; no byte of a frame depends on it.
    ///
    /// ```
    /// let quantizer = flicr::Quantizer::new(8, 80.0).unwrap();
    /// assert!((quantizer.expected_psnr_db(80.0) - 58.92).abs() < 0.01);
    /// ```
    #[must_use]
    pub fn expected_psnr_db(&self, max_range_m: f32) -> f32 {
        // The mean square of an error that is even over a step is step^2 / 12.
        20.0 * micromath::F32Ext::log10(max_range_m / self.step_m) + 10.791_812
    }

    /// The level of a range in meters (not negative, not NaN).
    ///
    /// # Errors
    /// [`OutOfScale`] where the range has none.
    #[inline]
    pub fn level(&self, range_m: f32) -> Result<u16, OutOfScale> {
        let level = self.rounded(range_m);
        if level == 0 {
            Err(OutOfScale::TooNear)
        } else if level > u32::from(self.max_level()) {
            Err(OutOfScale::Beyond)
        } else {
            Ok(level as u16)
        }
    }

    /// A length in steps.
    pub(crate) const fn steps_in(&self, length_m: f32) -> f32 {
        length_m * self.steps_per_m
    }

    /// Range / step to the nearest whole number, at most 2^16; NaN gives 0.
    #[inline]
    pub(crate) fn rounded(&self, range_m: f32) -> u32 {
        to_index(range_m * self.steps_per_m + 0.5, 1 << 16)
    }

    /// The range of a level, meters.
    #[must_use]
    #[inline]
    pub const fn range_m(&self, level: u16) -> f32 {
        level as f32 * self.step_m
    }
}
