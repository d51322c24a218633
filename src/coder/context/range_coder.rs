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
    /// One decision whose probability of being 1 is `one` / 2^16.
    fn decide(&mut self, one: u16, decision: bool) -> bool;

    /// The low `bits` (0 to 16) of `value`, each as likely as not.
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
}

impl<'a> RangeEncoder<'a> {
    pub(crate) fn new(out: &'a mut [u8]) -> Self {
        Self { out, len: 0, low: 0, range: u32::MAX }
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
            self.carry();
        }
    }

    #[cold]
    fn carry(&mut self) {
        let written = self.len.min(self.out.len());
        for byte in self.out.iter_mut().take(written).rev() {
            *byte = byte.wrapping_add(1);
            if *byte != 0 {
                break;
            }
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

impl BinaryCoder for RangeEncoder<'_> {
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
    fn raw(&mut self, bits: u32, value: u32) -> u32 {
        let mut left = bits;
        while left > 0 {
            let taken = left.min(8);
            left -= taken;
            self.range >>= taken;
            self.add(self.range * (value >> left & ((1 << taken) - 1)));
            self.renormalize();
        }
        value
    }
}

/// The part of a range that the decision 1 gets: never none, never all.
#[inline(always)]
fn share(range: u32, one: u16) -> u32 {
    ((u64::from(range) * u64::from(one)) >> PROBABILITY_BITS) as u32
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
    fn raw(&mut self, bits: u32, _: u32) -> u32 {
        let (mut left, mut value) = (bits, 0);
        while left > 0 {
            let taken = left.min(8);
            left -= taken;
            self.range >>= taken;
            // A code that no encoder makes may lie beyond the range: then it is taken for its last value.
            let found = (self.offset / self.range).min((1 << taken) - 1);
            self.offset -= found * self.range;
            value = value << taken | found;
            self.renormalize();
        }
        value
    }
}
