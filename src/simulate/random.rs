//! Random numbers that are a pure function of where they are used.
//!
//! Every wall, leaf and measurement draws from a key made of the seed and its own place, so the
//! street does not depend on the order in which it is looked at, and a turn can be made alone.
//! The mixer is `SplitMix64` (Steele, Lea, Flood 2014): public, stable, integers only.

/// Step of the `SplitMix64` sequence: 2^64 over the golden ratio.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// A short sequence of random numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Random(u64);

impl Random {
    /// The sequence that belongs to a place: a seed and the coordinates there.
    pub(super) fn at(seed: u64, place: &[i64]) -> Self {
        Self(place.iter().fold(seed, |key, &part| mix(key.wrapping_add(GOLDEN) ^ part.cast_unsigned())))
    }

    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mix(self.0)
    }

    /// Uniform over 0 to 1, 1 excluded.
    pub(super) fn unit(&mut self) -> f64 {
        // 53 bits fit a double exactly.
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform over low to high.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with the given probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Mean 0, deviation 1, never beyond 3.5: the sum of four uniform numbers.
    /// A logarithm would be more exact, and four times slower.
    pub(super) fn normal(&mut self) -> f64 {
        let bits = self.bits();
        let sum: u64 = (0..4).map(|part| (bits >> (16 * part)) & 0xFFFF).sum();
        (sum as f64 / 65536.0 - 2.0 + 2.0 / 65536.0) * SQRT_3
    }
}

/// Scales the sum of four uniform numbers (variance 4/12) to a deviation of 1.
const SQRT_3: f64 = 1.732_050_807_568_877_2;

fn mix(mut word: u64) -> u64 {
    word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ (word >> 31)
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::{GOLDEN, Random, mix};

    #[test]
    fn splitmix64_gives_its_published_sequence() {
        let mut random = Random(0);
        assert_eq!(random.bits(), 0xE220_A839_7B1D_CDAF);
        assert_eq!(random.bits(), 0x6E78_9E6A_A1B9_65F4);
        assert_eq!(mix(GOLDEN), 0xE220_A839_7B1D_CDAF);
    }

    #[test]
    fn normal_has_mean_0_and_deviation_1() {
        let mut random = Random::at(1, &[2, 3]);
        let draws: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
        let mean = draws.iter().sum::<f64>() / 2e4;
        let variance = draws.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / 2e4;
        assert!(mean.abs() < 0.03, "{mean}");
        assert!((variance - 1.0).abs() < 0.05, "{variance}");
    }
}
