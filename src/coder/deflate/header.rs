//! The head of a dynamic block: the code lengths, run-length coded (RFC 1951 section 3.2.7).

use core::iter::{Chain, Peekable};
use core::slice::Iter;

use super::huffman::{self, Code};
use super::symbols::{DISTANCES, LITERALS};
use crate::coder::OutputFull;
use crate::coder::bits::BitWriter;

/// Symbols of the code length alphabet: lengths 0 to 15, and three kinds of repetition.
const SYMBOLS: usize = 19;
/// Repeats the previous length 3 to 6 times (2 extra bits).
const REPEAT: u8 = 16;
/// Repeats length 0 3 to 10 times (3 extra bits).
const ZEROS: u8 = 17;
/// Repeats length 0 11 to 138 times (7 extra bits).
const MANY_ZEROS: u8 = 18;
/// The order in which the lengths of this alphabet's own code are sent.
const ORDER: [u8; SYMBOLS] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
/// Longest code of this alphabet.
const MAX_BITS: usize = 7;

/// Code lengths up to the last that is used, as symbols of the code length alphabet.
#[derive(Clone)]
pub(super) struct CodeLengths<'a> {
    literals: &'a [u8],
    distances: &'a [u8],
    /// The lengths behind the present run.
    rest: Peekable<Chain<Iter<'a, u8>, Iter<'a, u8>>>,
    /// The length that comes next, how often in a row, and whether it came before.
    len: u8,
    run: usize,
    repeats: bool,
}

/// A symbol of the code length alphabet with its extra bits.
pub(super) struct Item {
    symbol: u8,
    extra_bits: u32,
    extra: u32,
}

impl<'a> CodeLengths<'a> {
    pub fn new(literals: &'a [u8; LITERALS], distances: &'a [u8; DISTANCES]) -> Self {
        let (literals, distances) = (trim(literals, 257), trim(distances, 1));
        let rest = literals.iter().chain(distances).peekable();
        Self { literals, distances, rest, len: 0, run: 0, repeats: false }
    }

    /// Goes on to the next run of equal lengths.
    fn next_run(&mut self) -> Option<()> {
        (self.len, self.run, self.repeats) = (*self.rest.next()?, 1, false);
        while self.rest.next_if_eq(&&self.len).is_some() {
            self.run += 1;
        }
        Some(())
    }
}

/// Drops unused symbols from the end, but keeps `min` of them.
#[inline(never)]
fn trim(lens: &[u8], min: usize) -> &[u8] {
    let used = lens.iter().rposition(|&len| len > 0).map_or(0, |last| last + 1);
    lens.get(..used.max(min)).unwrap_or(lens)
}

impl Iterator for CodeLengths<'_> {
    type Item = Item;

    #[inline(never)]
    fn next(&mut self) -> Option<Item> {
        if self.run == 0 {
            self.next_run()?;
        }
        let (symbol, extra_bits, least, most) = match (self.len, self.run) {
            (0, 11..) => (MANY_ZEROS, 7, 11, 138),
            (0, 3..) => (ZEROS, 3, 3, 10),
            (1.., 3..) if self.repeats => (REPEAT, 2, 3, 6),
            (len, _) => (len, 0, 1, 1),
        };
        let taken = self.run.min(most);
        self.run -= taken;
        self.repeats = true;
        Some(Item { symbol, extra_bits, extra: taken.saturating_sub(least) as u32 })
    }
}

/// The code of the code length alphabet, made for one block.
pub(super) struct Header {
    lens: [u8; SYMBOLS],
    order_len: usize,
    bits: usize,
}

impl Header {
    /// Finds the best code for these lengths; `nodes` is scratch.
    pub fn new(code_lengths: CodeLengths<'_>, nodes: &mut [u32]) -> Self {
        let (mut counts, mut lens, mut bits) = ([0; SYMBOLS], [0; SYMBOLS], 0);
        for item in code_lengths {
            if let Some(count) = counts.get_mut(usize::from(item.symbol)) {
                *count += 1;
            }
            bits += item.extra_bits as usize;
        }
        huffman::lengths(&counts, MAX_BITS, nodes, &mut lens);
        bits += counts.iter().zip(&lens).map(|(&count, &len)| count as usize * usize::from(len)).sum::<usize>();
        let used = |&symbol: &u8| lens.get(usize::from(symbol)).is_some_and(|&len| len > 0);
        let order_len = ORDER.iter().rposition(used).map_or(4, |last| (last + 1).max(4));
        Self { lens, order_len, bits: bits + 14 + 3 * order_len }
    }

    /// Length of the header, without the block's first three bits.
    pub const fn len_bits(&self) -> usize {
        self.bits
    }

    pub fn write(&self, code_lengths: CodeLengths<'_>, out: &mut BitWriter<'_>) -> Result<(), OutputFull> {
        out.put(code_lengths.literals.len().saturating_sub(257) as u32, 5)?;
        out.put(code_lengths.distances.len().saturating_sub(1) as u32, 5)?;
        out.put(self.order_len.saturating_sub(4) as u32, 4)?;
        for &symbol in ORDER.iter().take(self.order_len) {
            out.put(self.lens.get(usize::from(symbol)).copied().unwrap_or(0).into(), 3)?;
        }
        let mut codes: [Code; SYMBOLS] = [0; SYMBOLS];
        huffman::assign(&self.lens, &mut codes);
        for item in code_lengths {
            let (bits, len) = huffman::split(codes.get(usize::from(item.symbol)).copied().unwrap_or(0));
            out.put(bits, len)?;
            out.put(item.extra, item.extra_bits)?;
        }
        Ok(())
    }
}
