//! What symbols are expected to cost.

use super::block::Codes;
use super::matcher::Match;
use super::symbols::{self, DISTANCES, FIRST_LENGTH, MIN_MATCH};

/// Estimated cost in bits of every symbol, extra bits included.
pub(super) struct Costs {
    literals: [u8; 256],
    lengths: [u8; 256],
    distances: [u8; DISTANCES],
}

impl Costs {
    pub const fn new() -> Self {
        Self { literals: [0; 256], lengths: [0; 256], distances: [0; DISTANCES] }
    }

    /// What an image usually has, for the first block.
    pub fn reset(&mut self) {
        for (i, cost) in self.literals.iter_mut().enumerate() {
            *cost = if i == 0 { 3 } else { 7 };
        }
        for (i, cost) in self.lengths.iter_mut().enumerate() {
            let length = symbols::length(i as u8);
            *cost = length.bits as u8 + if length.symbol < 13 { 5 } else { 8 };
        }
        for (symbol, cost) in self.distances.iter_mut().enumerate() {
            *cost = symbols::distance_extra_bits(symbol) as u8 + 5;
        }
    }

    /// Takes over the code lengths of the block before.
    pub fn learn(&mut self, codes: &Codes) {
        let (literal_lens, distance_lens) = (&codes.literal_lens, &codes.distance_lens);
        let known = |len: u8, unseen: u8| if len > 0 { len } else { unseen };
        for (cost, &len) in self.literals.iter_mut().zip(literal_lens) {
            *cost = known(len, 11);
        }
        for (i, cost) in self.lengths.iter_mut().enumerate() {
            let length = symbols::length(i as u8);
            *cost = length.bits as u8 + known(literal_lens[FIRST_LENGTH + length.symbol], 10);
        }
        for (symbol, (cost, &len)) in self.distances.iter_mut().zip(distance_lens).enumerate() {
            *cost = symbols::distance_extra_bits(symbol) as u8 + known(len, 8);
        }
    }

    /// Bits of these bytes as literals.
    pub fn literals(&self, bytes: &[u8]) -> u32 {
        bytes.iter().map(|&byte| u32::from(self.literals[usize::from(byte)])).sum()
    }

    /// Bits of a match.
    pub fn matched(&self, found: Match) -> u32 {
        let distance = self.distances[symbols::distance(found.distance as u32 - 1).symbol];
        u32::from(distance) + u32::from(self.lengths[(found.len - MIN_MATCH) & 0xFF])
    }
}
