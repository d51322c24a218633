//! RFC 1951 section 3.2.5: match lengths and distances as symbol and extra bits.

/// Literal and length symbols: the 288 of the fixed code, and one that is never used, so that
/// `FIRST_LENGTH + (symbol & 31)` needs no bounds check.
pub(super) const LITERALS: usize = 289;
/// Distance symbols, rounded up so that a mask can stand for a bounds check.
pub(super) const DISTANCES: usize = 32;
/// The symbol that ends a block.
pub(super) const END_OF_BLOCK: usize = 256;
/// The symbol of match length 3.
pub(super) const FIRST_LENGTH: usize = 257;
/// Shortest match that the format can express.
pub(super) const MIN_MATCH: usize = 3;
/// Longest match that the format can express.
pub(super) const MAX_MATCH: usize = 258;
/// Farthest distance that the format can express.
pub(super) const WINDOW: usize = 32_768;

/// A symbol's extra bits: how many, and their value.
#[derive(Clone, Copy)]
pub(super) struct Extra {
    pub symbol: usize,
    pub bits: u32,
    pub value: u32,
}

/// Length minus 3 to length symbol minus 257.
static LENGTH_SYMBOL: [u8; 256] = length_symbols();

const fn length_symbols() -> [u8; 256] {
    let mut table = [0; 256];
    let mut x = 0;
    while x < 255 {
        table[x] = if x < 8 { x } else { split_length(x) } as u8;
        x += 1;
    }
    table[255] = 28; // 258 has a symbol of its own
    table
}

const fn split_length(x: usize) -> usize {
    let bits = x.ilog2() as usize - 2;
    4 * bits + (x >> bits)
}

/// Extra bits of a length symbol (symbol minus 257).
#[inline(always)]
pub(super) const fn length_extra_bits(symbol: usize) -> u32 {
    if symbol < 8 || symbol == 28 { 0 } else { (symbol as u32 >> 2) - 1 }
}

/// Symbol minus 257, and extra bits, of a match length less 3.
#[inline(always)]
pub(super) fn length(less_3: u8) -> Extra {
    let symbol = usize::from(LENGTH_SYMBOL[usize::from(less_3)] & 31);
    let bits = length_extra_bits(symbol);
    Extra { symbol, bits, value: u32::from(less_3) & ((1 << bits) - 1) }
}

/// Extra bits of a distance symbol.
pub(super) const fn distance_extra_bits(symbol: usize) -> u32 {
    (symbol as u32 >> 1).saturating_sub(1)
}

/// Symbol and extra bits of a distance less 1 (0 to 32767).
#[inline(always)]
pub(super) const fn distance(less_1: u32) -> Extra {
    if less_1 < 2 {
        return Extra { symbol: less_1 as usize, bits: 0, value: 0 };
    }
    let bits = 30 - less_1.leading_zeros();
    let symbol = 2 * bits + (less_1 >> bits);
    Extra { symbol: symbol as usize & (DISTANCES - 1), bits, value: less_1 & ((1 << bits) - 1) }
}
