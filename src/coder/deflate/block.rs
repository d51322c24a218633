//! One DEFLATE block: sequences in, the cheapest of stored, fixed and dynamic out (RFC 1951 section 3.2.3).

use super::header::{CodeLengths, Header};
use super::huffman::{self, Code, MAX_BITS, split};
use super::symbols::{self, DISTANCES, END_OF_BLOCK, Extra, FIRST_LENGTH, LITERALS};
use crate::coder::OutputFull;
use crate::coder::bits::{BitWriter, Burst};

/// A run of literals and the match that follows it: literals (9 bits), length less 3 (8), distance less 1 (15).
#[derive(Clone, Copy)]
pub(super) struct Sequence(u32);

impl Sequence {
    /// What an unused place holds.
    pub const EMPTY: Self = Self(0);
    /// A run of this many literals has no match behind it.
    pub const MAX_LITERALS: usize = 511;

    #[inline(always)]
    pub const fn new(literals: usize, len_less_3: usize, distance_less_1: usize) -> Self {
        Self((literals << 23 | len_less_3 << 15 | distance_less_1) as u32)
    }

    pub const fn only_literals() -> Self {
        Self((Self::MAX_LITERALS as u32) << 23)
    }

    const fn literals(self) -> usize {
        (self.0 >> 23) as usize
    }

    /// Length less 3 and distance less 1.
    const fn matched(self) -> Option<(u8, u32)> {
        if self.literals() == Self::MAX_LITERALS { None } else { Some(((self.0 >> 15) as u8, self.0 & 0x7FFF)) }
    }
}

/// A block's bytes and how they were parsed; the bytes after the last sequence are literals.
#[derive(Clone, Copy)]
pub(super) struct Block<'a> {
    pub bytes: &'a [u8],
    pub sequences: &'a [Sequence],
    pub last: bool,
}

/// Longest stored block.
const MAX_STORED: usize = 65_535;
/// Block types, as the two bits that name them.
const STORED: u32 = 0;
const FIXED: u32 = 1;
const DYNAMIC: u32 = 2;

/// The codes of a block; before they are made, the counts of its symbols.
pub(super) struct Codes {
    literals: [Code; LITERALS],
    distances: [Code; DISTANCES],
    pub literal_lens: [u8; LITERALS],
    pub distance_lens: [u8; DISTANCES],
    nodes: [u32; LITERALS],
}

impl Codes {
    pub const fn new() -> Self {
        Self {
            literals: [0; LITERALS],
            distances: [0; DISTANCES],
            literal_lens: [0; LITERALS],
            distance_lens: [0; DISTANCES],
            nodes: [0; LITERALS],
        }
    }

    /// Writes a block in its cheapest form and leaves the lengths of its own best code in `self`.
    pub fn write(&mut self, block: Block<'_>, out: &mut BitWriter<'_>) -> Result<(), OutputFull> {
        let extra_bits = self.count(block);
        let fixed_bits = extra_bits + self.cost_bits(&FIXED_LITERAL_LENS, &FIXED_DISTANCE_LENS);
        huffman::lengths(&self.literals, MAX_BITS, &mut self.nodes, &mut self.literal_lens);
        huffman::lengths(&self.distances, MAX_BITS, &mut self.nodes, &mut self.distance_lens);
        let header = Header::new(CodeLengths::new(&self.literal_lens, &self.distance_lens), &mut self.nodes);
        let dynamic_bits = header.len_bits() + extra_bits + self.cost_bits(&self.literal_lens, &self.distance_lens);
        if stored_bits(block.bytes.len(), out.phase_bits()) <= fixed_bits.min(dynamic_bits) + 3 {
            return store(block, out);
        }
        let kind = if fixed_bits <= dynamic_bits { FIXED } else { DYNAMIC };
        out.put(u32::from(block.last) | kind << 1, 3)?;
        if kind == FIXED {
            huffman::assign(&FIXED_LITERAL_LENS, &mut self.literals);
            huffman::assign(&FIXED_DISTANCE_LENS, &mut self.distances);
        } else {
            header.write(CodeLengths::new(&self.literal_lens, &self.distance_lens), out)?;
            huffman::assign(&self.literal_lens, &mut self.literals);
            huffman::assign(&self.distance_lens, &mut self.distances);
        }
        self.write_symbols(block, out)
    }

    #[inline(never)]
    /// Counts the block's symbols; gives the sum of their extra bits.
    fn count(&mut self, block: Block<'_>) -> usize {
        self.literals.fill(0);
        self.distances.fill(0);
        self.literals[END_OF_BLOCK] = 1;
        let mut extra_bits = 0;
        let mut rest = block.bytes;
        for sequence in block.sequences {
            rest = self.count_literals(rest, sequence.literals());
            if let Some((len_less_3, distance_less_1)) = sequence.matched() {
                let (length, distance) = (symbols::length(len_less_3), symbols::distance(distance_less_1));
                self.literals[FIRST_LENGTH + length.symbol] += 1;
                self.distances[distance.symbol] += 1;
                extra_bits += (length.bits + distance.bits) as usize;
                rest = rest.get(usize::from(len_less_3) + 3..).unwrap_or_default();
            }
        }
        self.count_literals(rest, rest.len());
        extra_bits
    }

    #[inline(always)]
    fn count_literals<'a>(&mut self, bytes: &'a [u8], run: usize) -> &'a [u8] {
        let (literals, rest) = bytes.split_at_checked(run).unwrap_or_default();
        for &byte in literals {
            self.literals[usize::from(byte)] += 1;
        }
        rest
    }

    /// What the counted symbols take, without their extra bits, under codes of these lengths.
    fn cost_bits(&self, literal_lens: &[u8], distance_lens: &[u8]) -> usize {
        cost_bits(&self.literals, literal_lens) + cost_bits(&self.distances, distance_lens)
    }

    #[inline(never)]
    fn write_symbols(&self, block: Block<'_>, out: &mut BitWriter<'_>) -> Result<(), OutputFull> {
        out.burst(|out| {
            let mut rest = block.bytes;
            for sequence in block.sequences {
                rest = self.write_literals(rest, sequence.literals(), out)?;
                if let Some((len_less_3, distance_less_1)) = sequence.matched() {
                    self.write_match(len_less_3, distance_less_1, out)?;
                    rest = rest.get(usize::from(len_less_3) + 3..).unwrap_or_default();
                }
            }
            self.write_literals(rest, rest.len(), out)?;
            put_code(self.literals[END_OF_BLOCK], out)
        })
    }

    #[inline(always)]
    fn write_literals<'a>(&self, bytes: &'a [u8], run: usize, out: &mut Burst<'_, '_>) -> Result<&'a [u8], OutputFull> {
        let (literals, rest) = bytes.split_at_checked(run).unwrap_or_default();
        for &byte in literals {
            put_code(self.literals[usize::from(byte)], out)?;
        }
        Ok(rest)
    }

    #[inline(always)]
    fn write_match(&self, len_less_3: u8, distance_less_1: u32, out: &mut Burst<'_, '_>) -> Result<(), OutputFull> {
        let length = symbols::length(len_less_3);
        put_both(self.literals[FIRST_LENGTH + length.symbol], length, out)?;
        let distance = symbols::distance(distance_less_1);
        put_both(self.distances[distance.symbol], distance, out)
    }
}

#[inline(never)]
fn cost_bits(counts: &[u32], lens: &[u8]) -> usize {
    counts.iter().zip(lens).map(|(&count, &len)| count as usize * usize::from(len)).sum()
}

#[inline(always)]
fn put_code(code: Code, out: &mut Burst<'_, '_>) -> Result<(), OutputFull> {
    let (bits, len) = split(code);
    out.put(bits, len)
}

/// A code and its symbol's extra bits, which take 28 bits at most.
#[inline(always)]
fn put_both(code: Code, extra: Extra, out: &mut Burst<'_, '_>) -> Result<(), OutputFull> {
    let (bits, len) = split(code);
    if Burst::MOST_BITS >= 28 {
        return out.put(bits | extra.value << len, len + extra.bits);
    }
    out.put(bits, len)?;
    if extra.bits > 0 { out.put(extra.value, extra.bits) } else { Ok(()) }
}

/// Lengths of the fixed literal code, RFC 1951 section 3.2.6.
static FIXED_LITERAL_LENS: [u8; LITERALS] = fixed_literal_lens();
/// Lengths of the fixed distance code.
static FIXED_DISTANCE_LENS: [u8; DISTANCES] = [5; DISTANCES];

const fn fixed_literal_lens() -> [u8; LITERALS] {
    let mut lens = [8; LITERALS];
    lens[LITERALS - 1] = 0;
    let mut symbol = 144;
    while symbol < 280 {
        lens[symbol] = if symbol < 256 { 9 } else { 7 };
        symbol += 1;
    }
    lens
}

/// What stored blocks of `len` bytes take from a bit position `phase_bits` into a byte.
const fn stored_bits(len: usize, phase_bits: u32) -> usize {
    let first = (3 + phase_bits).next_multiple_of(8) - phase_bits;
    let more = len.saturating_sub(1) / MAX_STORED;
    first as usize + 32 + 40 * more + 8 * len
}

fn store(block: Block<'_>, out: &mut BitWriter<'_>) -> Result<(), OutputFull> {
    let mut rest = block.bytes;
    loop {
        let (part, after) = rest.split_at_checked(MAX_STORED).unwrap_or((rest, &[]));
        out.put(u32::from(block.last && after.is_empty()) | STORED << 1, 3)?;
        out.align()?;
        let len = part.len() as u16;
        out.put_bytes(&len.to_le_bytes())?;
        out.put_bytes(&(!len).to_le_bytes())?;
        out.put_bytes(part)?;
        rest = after;
        if rest.is_empty() {
            return Ok(());
        }
    }
}
