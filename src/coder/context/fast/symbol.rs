//! Residuals as symbols: a class of size, two an octave, and a sign; the rest of the size in raw bits.
//!
//! | steps | 0 | 1 | 2 | 3 | 4, 5 | 6, 7 | 8 to 11 | 12 to 15 | … |
//! |---|---|---|---|---|---|---|---|---|---|
//! | class | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 | … 31 |
//! | raw bits | 0 | 0 | 0 | 0 | 1 | 1 | 2 | 2 | … 14 |
//!
//! The symbol is 0, or 2 class - 1, one more where the sign is not the expected one.

use super::band::{Lanes, ROWS, Residuals};

/// Symbols, the escape included.
pub(crate) const SYMBOLS: usize = 64;
/// Stands for a symbol that its context's table has not: 16 bits of size and one of sign follow.
pub(crate) const ESCAPE: u16 = SYMBOLS as u16 - 1;

/// The symbol of each residual, given which signs are not expected.
#[inline]
pub(crate) fn symbols(residuals: &Residuals, flip: &Lanes) -> Lanes {
    let mut symbols = [0; ROWS];
    for (row, symbol) in symbols.iter_mut().enumerate() {
        let steps = residuals.steps[row];
        // A float's exponent and first bit of mantissa count half octaves: 254 for 1.0, 256 for 2.0.
        let half_octave = (f32::from(steps).to_bits() >> 22) as u16;
        let class = half_octave.saturating_sub(253);
        let class = class - u16::from(class > 2);
        *symbol = (2 * class + (residuals.negative[row] ^ flip[row])).saturating_sub(1)
            & u16::from(steps != 0).wrapping_neg();
    }
    symbols
}

/// Raw bits behind a symbol.
pub(crate) const fn raw_bits(symbol: u16) -> u32 {
    let class = symbol.div_ceil(2) as u32;
    if class < 4 || symbol == ESCAPE { 0 } else { class / 2 - 1 }
}

/// The smallest size of a symbol's class.
#[cfg(feature = "std")]
pub(crate) const fn first_steps(symbol: u16) -> u16 {
    let class = symbol.div_ceil(2);
    if class < 4 { class } else { (2 | class & 1) << (class / 2 - 1) }
}

/// What a symbol stands for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Class {
    /// The smallest size; 0 for the escape.
    #[cfg(feature = "std")]
    pub(crate) first: u16,
    /// The bits of the size that are raw.
    pub(crate) mask: u16,
    /// How many those are; [`ESCAPES`](Self::ESCAPES) more for the escape, so that a sum of them tells of escapes.
    pub(crate) raw_bits: u32,
}

impl Class {
    /// Many more raw bits than there are, and so many that a shift by them is none.
    pub(crate) const ESCAPES: u32 = 1 << 16;
}

/// By symbol.
pub(crate) static CLASSES: [Class; SYMBOLS] = {
    const OF_ESCAPE: Class = Class {
        #[cfg(feature = "std")]
        first: 0,
        mask: 0,
        raw_bits: Class::ESCAPES,
    };
    let mut classes = [OF_ESCAPE; SYMBOLS];
    let mut symbol = 0;
    while symbol < ESCAPE {
        let raw_bits = raw_bits(symbol);
        classes[symbol as usize] = Class {
            #[cfg(feature = "std")]
            first: first_steps(symbol),
            mask: (1 << raw_bits) - 1,
            raw_bits,
        };
        symbol += 1;
    }
    classes
};

/// Signs from symbols, where `residuals` has the sizes: the inverse of [`symbols`] but for escapes.
#[cfg(feature = "std")]
#[inline]
pub(crate) fn signs(symbols: &Lanes, flip: &Lanes, residuals: &mut Residuals) {
    for row in 0..ROWS {
        let symbol = symbols[row];
        residuals.negative[row] = ((symbol & 1) ^ 1 ^ flip[row]) & u16::from(symbol != 0);
    }
}
