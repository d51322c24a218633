//! Decisions whose probability follows what they were, and whole numbers made of them: small ones are short, and what is
//! common gets shorter.

use super::range_coder::BinaryCoder;

/// The probability of a decision, moved by each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chance(u16);

impl Chance {
    pub(crate) const EVEN: Self = Self(1 << 15);
    /// For what hardly ever is.
    pub(crate) const RARE: Self = Self(1 << 9);

    #[inline]
    pub(crate) fn code(&mut self, coder: &mut impl BinaryCoder, decision: bool) -> bool {
        let decision = coder.decide(self.0, decision);
        if decision {
            self.0 += (u16::MAX - self.0) >> 5;
        } else {
            self.0 -= self.0 >> 5;
        }
        decision
    }
}

/// Numbers of up to 32 bits by the bits of their successor: how many there are in unary, then all but the highest.
#[derive(Debug, Clone)]
pub(crate) struct Number([Chance; 32]);

impl Number {
    pub(crate) const NEW: Self = Self([Chance::EVEN; 32]);

    /// `value` is less than 2^32 - 1.
    pub(crate) fn code(&mut self, coder: &mut impl BinaryCoder, value: u32) -> u32 {
        let value = value.saturating_add(1);
        let mut bits = 0_u32;
        for chance in &mut self.0[..31] {
            if !chance.code(coder, value >> bits > 1) {
                break;
            }
            bits += 1;
        }
        let (high, low) = (bits.saturating_sub(16), bits.min(16));
        let high_bits = coder.raw(high, value >> low & ((1 << high) - 1));
        let low_bits = coder.raw(low, value & ((1 << low) - 1));
        (1 << bits | high_bits << low | low_bits) - 1
    }
}
