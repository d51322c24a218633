//! Bits that are not modeled, least significant first: up to 56 at once.

use super::super::super::OutputFull;

/// Appends bits to the front of a slice.
#[derive(Debug)]
pub(crate) struct RawWriter {
    /// Bytes written.
    pub(crate) len: usize,
    pending: u64,
    /// Bits pending, fewer than 8 between calls.
    count: u32,
}

impl RawWriter {
    pub(crate) const fn new(len: usize) -> Self {
        Self { len, pending: 0, count: 0 }
    }

    /// Adds the low `count` bits of `value`, whose others are 0. No more than 56 before [`flush`](Self::flush).
    #[inline(always)]
    pub(crate) fn put(&mut self, value: u64, count: u32) {
        self.pending |= value << (self.count & 63);
        self.count += count;
    }

    /// Writes whole bytes, 8 of which must have room.
    #[inline(always)]
    pub(crate) fn flush(&mut self, out: &mut [u8]) -> Result<(), OutputFull> {
        let room = out.get_mut(self.len..).and_then(|room| room.first_chunk_mut()).ok_or(OutputFull)?;
        *room = self.pending.to_le_bytes();
        self.pending >>= self.count & !7;
        self.len += self.count as usize / 8;
        self.count &= 7;
        Ok(())
    }

    /// Fills the last byte with zeros; gives the length.
    pub(crate) fn finish(mut self, out: &mut [u8]) -> Result<usize, OutputFull> {
        if self.count > 0 {
            *out.get_mut(self.len).ok_or(OutputFull)? = self.pending as u8;
            self.len += 1;
        }
        Ok(self.len)
    }
}

/// The inverse.
#[cfg(feature = "std")]
#[derive(Debug)]
pub(crate) struct RawReader<'a> {
    code: &'a [u8],
    /// Bits read.
    at: usize,
}

#[cfg(feature = "std")]
impl<'a> RawReader<'a> {
    pub(crate) const fn new(code: &'a [u8]) -> Self {
        Self { code, at: 0 }
    }

    /// The next 57 bits or more; zeros behind the end.
    #[inline(always)]
    pub(crate) fn peek(&self) -> u64 {
        let rest = self.code.get(self.at / 8..).unwrap_or(&[]);
        let bytes = match rest.first_chunk() {
            Some(bytes) => *bytes,
            None => short(rest),
        };
        u64::from_le_bytes(bytes) >> (self.at % 8)
    }

    /// Takes bits off.
    #[inline(always)]
    pub(crate) fn take(&mut self, count: u32) {
        self.at += count as usize;
    }

    /// Bytes that were read, and whether what is left of the last is zeros.
    pub(crate) fn end(&self) -> (usize, bool) {
        let rest = (8 - self.at % 8) % 8;
        (self.at.div_ceil(8), self.peek() & ((1 << rest) - 1) == 0)
    }
}

#[cfg(feature = "std")]
#[cold]
fn short(rest: &[u8]) -> [u8; 8] {
    let mut bytes = [0; 8];
    bytes.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
    bytes
}
