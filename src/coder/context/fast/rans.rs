//! Static range asymmetric numeral systems: four states of 32 bits that take turns, probabilities of 12 bits, 16 bits
//! in or out at a time. Words lie in the order in which they are written and are read backwards, so that what is
//! written last is read first.
//!
//! Source: Duda, "Asymmetric numeral systems" (2013), the range variant; division by multiplication as Giesen's.

use core::hint::select_unpredictable;

use super::super::super::OutputFull;

/// Bits of a probability.
pub(crate) const PROBABILITY_BITS: u32 = 12;
/// The sum of the frequencies.
pub(crate) const TOTAL: u32 = 1 << PROBABILITY_BITS;
/// States take turns.
pub(crate) const STATES: usize = 4;
/// Tokens of a group, and the most words that it takes.
pub(crate) const GROUP: usize = 8;
/// Bytes that hold a group's words.
pub(crate) const GROUP_LEN: usize = 2 * GROUP;
/// Bytes of the states.
pub(crate) const STATES_LEN: usize = 4 * STATES;
/// A state is this at least.
const FLOOR: u32 = 1 << 16;

/// A symbol, ready to be coded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Share {
    /// 2^64 / frequency, rounded up.
    inverse: u64,
    bias: u32,
    frequency: u16,
    /// All other symbols' frequencies.
    others: u16,
}

impl Share {
    /// A symbol that is certain: costs nothing.
    pub(crate) const CERTAIN: Self = Self::new(0, TOTAL as u16);

    pub(crate) const fn new(start: u16, frequency: u16) -> Self {
        let others = (TOTAL as u16).saturating_sub(frequency);
        // A quotient by 1 comes out one too small.
        let bias = start as u32 + if frequency == 1 { others as u32 } else { 0 };
        let inverse = if frequency < 2 { u64::MAX } else { u64::MAX / frequency as u64 + 1 };
        Self { inverse, bias, frequency, others }
    }
}

/// Writes words to the front of a slice.
#[derive(Debug)]
pub(crate) struct Encoder {
    states: [u32; STATES],
}

impl Encoder {
    pub(crate) const fn new() -> Self {
        Self { states: [FLOOR; STATES] }
    }

    /// Codes a group, its last token first, and gives how many bytes it took at the front of `out`.
    #[inline(always)]
    pub(crate) fn put(&mut self, share: impl Fn(usize) -> &'static Share, out: &mut [u8; GROUP_LEN]) -> usize {
        let (words, _) = out.as_chunks_mut::<2>();
        let (mut states, mut count) = (self.states, 0);
        for round in (0..GROUP / STATES).rev() {
            for turn in (0..STATES).rev() {
                let (x, share) = (states[turn], share(round * STATES + turn));
                words[count & (GROUP - 1)] = (x as u16).to_le_bytes();
                let full = x >> (32 - PROBABILITY_BITS) >= u32::from(share.frequency);
                let x = select_unpredictable(full, x >> 16, x);
                count += usize::from(full);
                let quotient = ((u128::from(x) * u128::from(share.inverse)) >> 64) as u32;
                states[turn] = x.wrapping_add(share.bias).wrapping_add(quotient.wrapping_mul(u32::from(share.others)));
            }
        }
        self.states = states;
        2 * count
    }

    /// Writes the states behind `len` bytes; gives the length with them.
    pub(crate) fn finish(&self, out: &mut [u8], len: usize) -> Result<usize, OutputFull> {
        let room = out.get_mut(len..).and_then(|room| room.first_chunk_mut::<STATES_LEN>()).ok_or(OutputFull)?;
        room.copy_from_slice(bytemuck::bytes_of(&self.states));
        Ok(len + STATES_LEN)
    }
}

/// A symbol, where its slots start, and how many it has.
#[cfg(feature = "std")]
pub(crate) type Part = (u16, u32, u32);

/// Takes one symbol out of a state. All goes without branches: whether a word is due is as good as chance.
#[cfg(feature = "std")]
#[inline(always)]
fn step(state: &mut u32, window: &[u8; GROUP_LEN], count: &mut usize, part: impl FnOnce(u32) -> Part) -> u16 {
    let slot = *state & (TOTAL - 1);
    let (symbol, start, frequency) = part(slot);
    let x = frequency.wrapping_mul(*state >> PROBABILITY_BITS).wrapping_add(slot).wrapping_sub(start);
    let (words, _) = window.as_chunks::<2>();
    let word = u32::from(u16::from_le_bytes(words[GROUP - 1 - (*count & (GROUP - 1))]));
    let due = x < FLOOR;
    *state = select_unpredictable(due, x << 16 | word, x);
    *count += usize::from(due);
    symbol
}

/// The inverse: reads words from the back of a slice.
#[cfg(feature = "std")]
#[derive(Debug)]
pub(crate) struct Decoder<'a> {
    code: &'a [u8],
    /// Bytes that are left.
    pub(crate) len: usize,
    states: [u32; STATES],
}

#[cfg(feature = "std")]
impl<'a> Decoder<'a> {
    /// `None` where there are no states.
    pub(crate) fn new(code: &'a [u8]) -> Option<Self> {
        let (rest, states) = code.split_last_chunk::<STATES_LEN>()?;
        Some(Self { code, len: rest.len(), states: bytemuck::pod_read_unaligned(states) })
    }

    /// The next words, those of a whole group, where they lie; `None` where there are fewer.
    #[inline(always)]
    fn window(&self) -> Option<&'a [u8; GROUP_LEN]> {
        self.code.get(..self.len).and_then(|code| code.last_chunk())
    }

    /// As many words as there are, behind zeros.
    #[cold]
    fn short_window(&self) -> [u8; GROUP_LEN] {
        let mut window = [0; GROUP_LEN];
        let at = window.len() - self.len.min(GROUP_LEN);
        window.iter_mut().skip(at).zip(self.code).for_each(|(to, from)| *to = *from);
        window
    }

    /// Decodes a token: `part` gives symbol, start and frequency of a slot.
    #[inline(always)]
    pub(crate) fn take(&mut self, token: usize, part: impl FnOnce(u32) -> Part) -> Option<u16> {
        let (short, mut count) = (self.window().is_none().then(|| self.short_window()), 0);
        let window = self.window().or(short.as_ref())?;
        let symbol = step(&mut self.states[token % STATES], window, &mut count, part);
        self.took(count)?;
        Some(symbol)
    }

    /// Decodes a group of tokens: `part` gives symbol, start and frequency of a token's slot. `None` where there are
    /// not so many words.
    #[inline(always)]
    pub(crate) fn take_group(&mut self, symbols: &mut [u16; GROUP], part: impl Fn(usize, u32) -> Part) -> Option<()> {
        let short = self.window().is_none().then(|| self.short_window());
        let window = self.window().or(short.as_ref())?;
        let (mut count, mut states) = (0, self.states);
        for (round, symbols) in symbols.as_chunks_mut::<STATES>().0.iter_mut().enumerate() {
            for (turn, (state, symbol)) in states.iter_mut().zip(symbols).enumerate() {
                *symbol = step(state, window, &mut count, |slot| part(round * STATES + turn, slot));
            }
        }
        self.states = states;
        self.took(count)
    }

    /// Takes the group's words off; `None` where there were not so many.
    #[inline(always)]
    pub(crate) fn took(&mut self, count: usize) -> Option<()> {
        self.len = self.len.checked_sub(2 * count)?;
        Some(())
    }

    /// Whether the states are as an encoder began.
    pub(crate) fn is_at_start(&self) -> bool {
        self.states == [FLOOR; STATES]
    }
}
