//! The binary arithmetic coder: a range that each decision narrows in proportion to how likely it was. Forward and
//! inverse share one trait, so that a model is walked by the same code in both directions.
//!
//! Source: Martin's range coder with LZMA's layout (32-bit range, bytes out when it falls below 2^24); a carry goes
//! straight into the bytes that are already out, and the code ends with one byte that no decoder can mistake.

/// Probabilities are out of 2^16, of the decision 1, from 1 to 2^16 - 1.
pub(crate) const PROBABILITY_BITS: u32 = 16;

/// Below this the range is too small for probabilities.
const RENORMALIZE: u32 = 1 << 24;

/// One direction of the coder. In the forward one a decision is what it is told; in the inverse one it is told
/// nothing of use, and what it gives back counts.
pub(crate) trait BinaryCoder {
    /// Whether it is the inverse direction.
    const DECODES: bool;

    /// One decision whose probability of being 1 is `one` / 2^16.
    fn decide(&mut self, one: u16, decision: bool) -> bool;

    /// One decision whose probability, out of 2^16, follows what decisions were: by 2^-rate of the way.
    fn learn(&mut self, one: &mut u16, rate: u32, decision: bool) -> bool;

    /// A `value` of `bits` (0 to 16) bits, each as likely as not.
    fn raw(&mut self, bits: u32, value: u32) -> u32;
}

/// Decisions to bytes at the front of a slice.
#[derive(Debug)]
pub(crate) struct RangeEncoder<'a> {
    out: &'a mut [u8],
    /// Bytes so far; where it is more than `out` holds, the rest was dropped.
    len: usize,
    low: u32,
    range: u32,
    /// Bytes before this were out at a mark.
    marked_len: usize,
    /// Whether a carry went into those.
    carried: bool,
}

/// A place in the code to which an encoder can go back, or from which another can go on in the same bytes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mark {
    len: usize,
    low: u32,
    range: u32,
}

impl Mark {
    /// Nowhere: zeros.
    pub(crate) const BLANK: Self = Self { len: 0, low: 0, range: 0 };

    /// Before the first decision.
    pub(crate) const START: Self = Self { len: 0, low: 0, range: u32::MAX };

    /// Length of the code if it ended here.
    pub(crate) const fn code_len(self) -> usize {
        self.len + 1
    }
}

impl<'a> RangeEncoder<'a> {
    pub(crate) fn new(out: &'a mut [u8]) -> Self {
        Self::from_mark(out, Mark::START)
    }

    /// Goes on from `mark` in `out`, which holds the code so far.
    pub(crate) fn from_mark(out: &'a mut [u8], Mark { len, low, range }: Mark) -> Self {
        Self { out, len, low, range, marked_len: len, carried: false }
    }

    /// The place where it stands.
    pub(crate) const fn mark(&self) -> Mark {
        Mark { len: self.len, low: self.low, range: self.range }
    }

    /// Forgets all since [`from_mark`](Self::from_mark) and leaves the bytes as they were.
    ///
    /// What was coded since is less than the range was at the mark, so that at most one carry went into the bytes before.
    pub(crate) fn forget(self) {
        if self.carried {
            let written = self.marked_len.min(self.out.len());
            for byte in self.out.iter_mut().take(written).rev() {
                let borrows = *byte == 0;
                *byte = byte.wrapping_sub(1);
                if !borrows {
                    break;
                }
            }
        }
    }

    /// Whether bytes were dropped.
    pub(crate) const fn is_full(&self) -> bool {
        self.len > self.out.len()
    }

    /// Ends the code and gives its length; `None` where it did not fit.
    pub(crate) fn finish(mut self) -> Option<usize> {
        // The range is 2^24 at least, so that it holds a number of which all but the first byte are zero; behind its
        // end a decoder reads zeros.
        self.add(RENORMALIZE - 1);
        self.put();
        (!self.is_full()).then_some(self.len)
    }

    #[inline(always)]
    fn add(&mut self, offset: u32) {
        let (low, carry) = self.low.overflowing_add(offset);
        self.low = low;
        if carry {
            // By value: what the coder counts with stays in registers.
            let reached = carry_into(self.out, self.len);
            self.carried |= reached < self.marked_len;
        }
    }

    #[inline(always)]
    fn put(&mut self) {
        if let Some(byte) = self.out.get_mut(self.len) {
            *byte = (self.low >> 24) as u8;
        }
        self.len += 1;
        self.low <<= 8;
    }

    #[inline(always)]
    fn renormalize(&mut self) {
        while self.range < RENORMALIZE {
            self.put();
            self.range <<= 8;
        }
    }
}

/// Adds 1 to the number that ends behind `len` bytes; gives the place of the first byte that changes.
#[cold]
#[inline(never)]
fn carry_into(out: &mut [u8], len: usize) -> usize {
    let mut at = len.min(out.len());
    while let Some(byte) = at.checked_sub(1).and_then(|before| out.get_mut(before)) {
        at -= 1;
        *byte = byte.wrapping_add(1);
        if *byte != 0 {
            break;
        }
    }
    at
}

impl BinaryCoder for RangeEncoder<'_> {
    const DECODES: bool = false;

    #[inline(always)]
    fn decide(&mut self, one: u16, decision: bool) -> bool {
        let part = share(self.range, one);
        if decision {
            self.range = part;
        } else {
            self.add(part);
            self.range -= part;
        }
        self.renormalize();
        decision
    }

    #[inline(always)]
    fn learn(&mut self, one: &mut u16, rate: u32, decision: bool) -> bool {
        let part = share(self.range, *one);
        if decision {
            self.range = part;
            *one = more(*one, rate);
        } else {
            self.add(part);
            self.range -= part;
            *one -= *one >> rate;
        }
        self.renormalize();
        decision
    }

    #[inline(always)]
    fn raw(&mut self, bits: u32, value: u32) -> u32 {
        self.range >>= bits;
        self.add(self.range * value);
        self.renormalize();
        value
    }
}

/// The part of a range that the decision 1 gets: never none, never all.
#[inline(always)]
fn share(range: u32, one: u16) -> u32 {
    (range >> PROBABILITY_BITS) * u32::from(one)
}

/// The probability behind a 1; never all.
#[inline(always)]
fn more(one: u16, rate: u32) -> u16 {
    one + (((1 << PROBABILITY_BITS) - u32::from(one)) >> rate) as u16
}

/// Bytes to decisions. Reads zeros behind the end, so that it always goes on; whether the code was as long as it should
/// have been is known at the end.
#[cfg(feature = "std")]
#[derive(Debug)]
pub(crate) struct RangeDecoder<'a> {
    code: &'a [u8],
    /// Bytes read, those behind the end included.
    read: usize,
    /// What the code is above the lower end of the range.
    offset: u32,
    range: u32,
}

#[cfg(feature = "std")]
impl<'a> RangeDecoder<'a> {
    pub(crate) fn new(code: &'a [u8]) -> Self {
        let mut decoder = Self { code, read: 0, offset: 0, range: u32::MAX };
        (0..4).for_each(|_| decoder.take());
        decoder
    }

    /// Bytes that the code of these decisions takes: of the four that the decoder is ahead the encoder writes one.
    pub(crate) const fn code_len(&self) -> usize {
        self.read - 3
    }

    /// Whether all bytes were read, and so many more that no encoder can have meant it.
    pub(crate) const fn is_past_end(&self) -> bool {
        self.code_len() > self.code.len()
    }

    #[inline(always)]
    fn take(&mut self) {
        let byte = self.code.get(self.read).copied().unwrap_or(0);
        self.read += 1;
        self.offset = self.offset << 8 | u32::from(byte);
    }

    #[inline(always)]
    fn renormalize(&mut self) {
        while self.range < RENORMALIZE {
            self.take();
            self.range <<= 8;
        }
    }
}

#[cfg(feature = "std")]
impl BinaryCoder for RangeDecoder<'_> {
    const DECODES: bool = true;

    #[inline(always)]
    fn decide(&mut self, one: u16, _: bool) -> bool {
        let part = share(self.range, one);
        let decision = self.offset < part;
        if decision {
            self.range = part;
        } else {
            self.offset -= part;
            self.range -= part;
        }
        self.renormalize();
        decision
    }

    #[inline(always)]
    fn learn(&mut self, one: &mut u16, rate: u32, decision: bool) -> bool {
        let decision = self.decide(*one, decision);
        *one = if decision { more(*one, rate) } else { *one - (*one >> rate) };
        decision
    }

    #[inline(always)]
    fn raw(&mut self, bits: u32, _: u32) -> u32 {
        self.range >>= bits;
        // A code that no encoder makes may lie beyond the range: then it is taken for its last value.
        let value = (self.offset / self.range).min((1 << bits) - 1);
        self.offset -= value * self.range;
        self.renormalize();
        value
    }
}
