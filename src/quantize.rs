//! Range to level and back, with the bound on what is lost in between.

use crate::error::ConfigError;
use crate::kernel::to_index;

/// How levels are spread over ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Companding {
    /// Evenly: range = level x step.
    #[default]
    None = 0,
    /// By the square root: range = level x level x step. Fine where it is near, coarse where it is far, for levels of up to 8
    /// bits: on KITTI's scans, 255 levels up to 80 m are 3.7 dB better so than evenly spread, and the error of far points is
    /// twice as large.
    SquareRoot = 1,
}

/// Quantizer: level = range / step, rounded; range = level x step; level 0 = no return. With
/// [`Companding::SquareRoot`] level = the square root of range / step.
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
    companding: Companding,
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
        match Self::from_step(level_bits, max_range_m / max_level as f32, Companding::None) {
            Some(quantizer) => Ok(quantizer),
            None => Err(ConfigError::MaxRange { found_m: max_range_m }),
        }
    }

    /// As [`new`](Self::new), by the square root.
    ///
    /// ```
    /// let quantizer = flicr::Quantizer::square_root(8, 80.0).unwrap();
    /// let level = quantizer.level(5.0).unwrap();
    /// assert!((quantizer.range_m(level) - 5.0).abs() <= quantizer.range_bound_at_m(level, 0));
    /// assert!(quantizer.range_bound_at_m(level, 0) < 0.08);
    /// assert!(quantizer.range_bound_m() < 0.32);
    /// ```
    ///
    /// # Errors
    /// [`ConfigError::LevelBits`] unless 1 <= `level_bits` <= 8; [`ConfigError::MaxRange`] as there.
    pub const fn square_root(level_bits: u32, max_range_m: f32) -> Result<Self, ConfigError> {
        if level_bits < 1 || level_bits > SQUARE_ROOT_BITS_MAX {
            return Err(ConfigError::LevelBits { found: level_bits, min: 1, max: SQUARE_ROOT_BITS_MAX });
        }
        let max_level = (1_u32 << level_bits) - 1;
        match Self::from_step(level_bits, max_range_m / (max_level * max_level) as f32, Companding::SquareRoot) {
            Some(quantizer) => Ok(quantizer),
            None => Err(ConfigError::MaxRange { found_m: max_range_m }),
        }
    }

    /// The same with level 1 at `step_m` meters.
    ///
    /// # Errors
    /// As [`square_root`](Self::square_root).
    pub const fn square_root_with_step(level_bits: u32, step_m: f32) -> Result<Self, ConfigError> {
        if level_bits < 1 || level_bits > SQUARE_ROOT_BITS_MAX {
            return Err(ConfigError::LevelBits { found: level_bits, min: 1, max: SQUARE_ROOT_BITS_MAX });
        }
        match Self::from_step(level_bits, step_m, Companding::SquareRoot) {
            Some(quantizer) => Ok(quantizer),
            None => Err(ConfigError::MaxRange { found_m: step_m * (1_u32 << (2 * level_bits)) as f32 }),
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
        match Self::from_step(level_bits, step_m, Companding::None) {
            Some(quantizer) => Ok(quantizer),
            None => Err(ConfigError::MaxRange { found_m: step_m * ((1_u32 << level_bits) - 1) as f32 }),
        }
    }

    /// Levels of `level_bits` bits (1 to 16) that are `step_m` meters apart. `None` where the step is not positive
    /// and finite, or so extreme that its inverse or largest range is not.
    #[must_use]
    pub(crate) const fn from_step(level_bits: u32, step_m: f32, companding: Companding) -> Option<Self> {
        let steps_per_m = 1.0 / step_m;
        let quantizer = Self { step_m, steps_per_m, level_bits, companding };
        let usable =
            step_m > 0.0 && steps_per_m > 0.0 && steps_per_m.is_finite() && quantizer.max_range_m().is_finite();
        if usable { Some(quantizer) } else { None }
    }

    /// How levels are spread over ranges.
    #[must_use]
    pub const fn companding(&self) -> Companding {
        self.companding
    }

    /// Distance between two levels, meters; by the square root, the range of level 1.
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
    /// the four float operations between a point's coordinates and its range. By the square root, of the farthest; see
    /// [`range_bound_at_m`](Self::range_bound_at_m) for the others.
    #[must_use]
    pub const fn range_bound_m(&self) -> f32 {
        self.range_bound_with_m(0)
    }

    /// As [`range_bound_m`](Self::range_bound_m), where a coder may change levels by up to `error_max`.
    #[must_use]
    pub const fn range_bound_with_m(&self, error_max: u16) -> f32 {
        // Each operation is off by at most 2^-24 of its result, which is at most max_level steps; the range itself
        // (three products, two sums, a square root) by no more than four of them again.
        let (max_level, steps) = (self.max_level() as f32, self.max_steps() as f32);
        match self.companding {
            Companding::None => self.step_m * (0.5 + error_max as f32 + max_level * f32::EPSILON * 4.0),
            // Neither level is beyond the largest, so that the squares of two that are error_max apart are no farther apart.
            Companding::SquareRoot => {
                self.step_m * ((2.0 * error_max as f32 + 1.0) * max_level + 0.5 + steps * f32::EPSILON * 4.0)
            }
        }
    }

    /// Most that a range is off that comes back as that of `level`, where a coder may change levels by up to `error_max`: all
    /// the same where levels are even, by the square root the less the nearer it is.
    #[must_use]
    pub const fn range_bound_at_m(&self, level: u16, error_max: u16) -> f32 {
        let (level, error) = (level as f32, error_max as f32);
        match self.companding {
            Companding::None => self.range_bound_with_m(error_max),
            // Level l takes from l^2 - l + 1/2 to l^2 + l + 1/2 steps.
            Companding::SquareRoot => {
                let steps = (2.0 * error + 1.0) * level + error * error + error + 0.5;
                self.step_m * (steps + self.max_steps() as f32 * f32::EPSILON * 4.0)
            }
        }
    }

    /// Most by which ranges of levels differ that are `error_max` apart, meters.
    pub(crate) const fn apart_m(&self, error_max: u16) -> f32 {
        let steps = error_max as f32 * self.step_m;
        match self.companding {
            Companding::None => steps,
            Companding::SquareRoot => steps * (2 * self.max_level() as u32) as f32,
        }
    }

    /// The largest level's range in steps.
    const fn max_steps(&self) -> u32 {
        let max_level = self.max_level() as u32;
        match self.companding {
            Companding::None => max_level,
            Companding::SquareRoot => max_level * max_level,
        }
    }

    /// The PSNR that rounding to even levels alone leaves, dB: errors even over a step, against the peak `max_range_m`
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
        let level = self.level_of_steps(self.rounded(range_m));
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

    /// The level of so many steps; 0 and more than the largest where they have none.
    #[inline]
    pub(crate) fn level_of_steps(&self, steps: u32) -> u32 {
        match self.companding {
            Companding::None => steps,
            Companding::SquareRoot => square_root(steps),
        }
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
        match self.companding {
            Companding::None => level as f32 * self.step_m,
            // Exact: a level has 8 bits.
            Companding::SquareRoot => (level as u32 * level as u32) as f32 * self.step_m,
        }
    }
}

/// Most bits of a level by the square root: their squares are 16 bits.
const SQUARE_ROOT_BITS_MAX: u32 = 8;

/// The number whose square is nearest, of two as near the smaller one's; at most 511. Integers only: the same on every
/// target.
fn square_root(square: u32) -> u32 {
    (0..=SQUARE_ROOT_BITS_MAX).rev().fold(0, |root, bit| {
        let more = root | 1 << bit;
        if more * more - more < square { more } else { root }
    })
}
