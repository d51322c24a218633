//! What intensities' numbers mean.

/// What the numbers of a plane mean, and how finely they are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IntensityScale {
    per_unit: f32,
    step: u8,
}

impl IntensityScale {
    /// The sensor's own numbers, as in packets, kept as they are.
    pub const RAW: Self = Self { per_unit: 1.0, step: 1 };
    /// Hundredths, as in KITTI's files, kept as they are.
    pub const PERCENT: Self = Self { per_unit: 100.0, step: 1 };

    /// `per_unit` numbers stand for an intensity of 1; they are kept in steps of `step`: 1 as they are, 16 to about 4 bits.
    /// `None` where `per_unit` is not a positive finite number, or `step` is 0.
    #[must_use]
    pub const fn new(per_unit: f32, step: u8) -> Option<Self> {
        if per_unit > 0.0 && per_unit < f32::INFINITY && step > 0 { Some(Self { per_unit, step }) } else { None }
    }

    /// Numbers for an intensity of 1.
    #[must_use]
    pub const fn per_unit(self) -> f32 {
        self.per_unit
    }

    /// Distance of the numbers that are kept.
    #[must_use]
    pub const fn step(self) -> u8 {
        self.step
    }

    /// Most that a number is off after decoding: half a step.
    #[must_use]
    pub const fn error_max(self) -> u8 {
        self.step / 2
    }

    /// Steps of a number, rounded.
    pub(super) const fn steps(self, number: u8) -> u8 {
        // Below 512: 255 and half of 255, in steps of 1 at least.
        ((number as u16 + (self.step / 2) as u16) / if self.step == 0 { 1 } else { self.step } as u16) as u8
    }

    /// The number of so many steps.
    #[cfg(feature = "std")]
    pub(crate) const fn number(self, steps: u8) -> u8 {
        steps.saturating_mul(self.step)
    }

    /// The intensity of a number: the quotient in double precision, rounded to the nearest `f32`.
    #[cfg(feature = "std")]
    #[must_use]
    pub fn intensity(self, number: u8) -> f32 {
        (f64::from(number) / f64::from(self.per_unit)) as f32
    }
}

#[cfg(feature = "std")]
impl IntensityScale {
    /// The scale by which intensities are numbers of 8 bits exactly, in steps of 1: hundredths, 255ths, 256ths or whole numbers.
    /// `None` where they are not.
    ///
    /// ```
    /// use flicr::plane::IntensityScale;
    /// assert_eq!(IntensityScale::recognize(&[0.0, 0.25, 0.99]), Some(IntensityScale::PERCENT));
    /// assert_eq!(IntensityScale::recognize(&[0.0, 17.0, 255.0]), Some(IntensityScale::RAW));
    /// assert_eq!(IntensityScale::recognize(&[0.123_456]), None);
    /// ```
    #[must_use]
    pub fn recognize(intensities: &[f32]) -> Option<Self> {
        let scales = [100.0, 255.0, 256.0, 1.0].map(|per_unit| Self { per_unit, step: 1 });
        scales.into_iter().find(|scale| intensities.iter().all(|&intensity| scale.is_exact(intensity)))
    }

    /// Whether an intensity is exactly that of its number; minus zero is none.
    #[must_use]
    pub fn is_exact(self, intensity: f32) -> bool {
        self.intensity(self.nearest(intensity)).to_bits() == intensity.to_bits()
    }

    /// The number nearest to an intensity; 0 for what is no number.
    #[must_use]
    pub fn nearest(self, intensity: f32) -> u8 {
        libm::round(f64::from(intensity) * f64::from(self.per_unit)) as u8
    }
}
