//! Bit output, least significant bit first: the packing order of RFC 1951.

use super::OutputFull;

/// Half a machine word: what goes from the accumulator to the buffer at once.
const HALF_BITS: u32 = usize::BITS / 2;
const HALF_LEN: usize = HALF_BITS as usize / 8;

/// Packs bit strings into a byte buffer, least significant bit first.
#[derive(Debug)]
pub struct BitWriter<'a> {
    sink: Sink<'a>,
    pending: Pending,
}

/// The buffer, and how far it is filled.
#[derive(Debug)]
struct Sink<'a> {
    out: &'a mut [u8],
    len: usize,
}

/// Bits on their way to the buffer: fewer than [`HALF_BITS`] between calls.
#[derive(Clone, Copy, Debug)]
struct Pending {
    bits: usize,
    count: u32,
}

/// A [`BitWriter`] whose pending bits stay in registers; [`BitWriter::burst`] lends it.
pub struct Burst<'w, 'a> {
    sink: &'w mut Sink<'a>,
    pending: Pending,
}

impl Burst<'_, '_> {
    /// Most bits that may be put at once.
    pub const MOST_BITS: u32 = HALF_BITS;

    /// Appends the low `count` (at most [`MOST_BITS`](Self::MOST_BITS)) bits of `value`, whose other bits must be zero.
    ///
    /// # Errors
    /// [`OutputFull`] if the buffer cannot take them.
    #[inline(always)]
    pub fn put(&mut self, value: u32, count: u32) -> Result<(), OutputFull> {
        self.pending.bits |= (value as usize) << (self.pending.count & (usize::BITS - 1));
        self.pending.count += count;
        if self.pending.count >= HALF_BITS { self.flush() } else { Ok(()) }
    }

    /// Moves half a word to the buffer.
    #[inline(always)]
    fn flush(&mut self) -> Result<(), OutputFull> {
        let half = self.pending.bits.to_le_bytes();
        if let (Some(room), Some(half)) = (self.sink.room(), half.first_chunk::<HALF_LEN>()) {
            *room = *half;
            self.sink.len += HALF_LEN;
            self.pending.bits >>= HALF_BITS;
            self.pending.count -= HALF_BITS;
            return Ok(());
        }
        self.pending.drain(self.sink)
    }
}

impl Sink<'_> {
    #[inline(always)]
    fn room(&mut self) -> Option<&mut [u8; HALF_LEN]> {
        self.out.get_mut(self.len..)?.first_chunk_mut()
    }
}

impl Pending {
    /// Moves whole bytes to the buffer, where half a word may no longer fit.
    #[cold]
    fn drain(&mut self, sink: &mut Sink<'_>) -> Result<(), OutputFull> {
        while self.count >= 8 {
            *sink.out.get_mut(sink.len).ok_or(OutputFull)? = self.bits as u8;
            sink.len += 1;
            self.bits >>= 8;
            self.count -= 8;
        }
        Ok(())
    }
}

impl<'a> BitWriter<'a> {
    /// A writer at the first bit of `out`.
    pub const fn new(out: &'a mut [u8]) -> Self {
        Self { sink: Sink { out, len: 0 }, pending: Pending { bits: 0, count: 0 } }
    }

    /// How many bits of the byte that is next completed are already taken (0 to 7).
    pub const fn phase_bits(&self) -> u32 {
        self.pending.count & 7
    }

    /// Runs `write` with the pending bits in registers. After an error nothing more may be written.
    ///
    /// # Errors
    /// Those of `write`.
    #[inline(always)]
    pub fn burst(
        &mut self,
        write: impl FnOnce(&mut Burst<'_, 'a>) -> Result<(), OutputFull>,
    ) -> Result<(), OutputFull> {
        let mut burst = Burst { sink: &mut self.sink, pending: self.pending };
        write(&mut burst)?;
        self.pending = burst.pending;
        Ok(())
    }

    /// Appends the low `count` (at most 16) bits of `value`, whose other bits must be zero.
    ///
    /// # Errors
    /// [`OutputFull`] if the buffer cannot take them.
    #[inline(never)]
    pub fn put(&mut self, value: u32, count: u32) -> Result<(), OutputFull> {
        self.burst(|burst| burst.put(value, count))
    }

    /// Fills the last byte with zero bits, so that what follows starts at a byte.
    ///
    /// # Errors
    /// [`OutputFull`] if the buffer cannot take it.
    pub fn align(&mut self) -> Result<(), OutputFull> {
        self.pending.count = self.pending.count.next_multiple_of(8);
        self.pending.drain(&mut self.sink)
    }

    /// Appends whole bytes, after [`align`](Self::align).
    ///
    /// # Errors
    /// [`OutputFull`] if the buffer cannot take them.
    pub fn put_bytes(&mut self, bytes: &[u8]) -> Result<(), OutputFull> {
        self.align()?;
        let Sink { out, len } = &mut self.sink;
        let room = out.get_mut(*len..).and_then(|rest| rest.get_mut(..bytes.len())).ok_or(OutputFull)?;
        room.copy_from_slice(bytes);
        *len += bytes.len();
        Ok(())
    }

    /// Aligns, and gives the number of bytes written.
    ///
    /// # Errors
    /// [`OutputFull`] if the last byte does not fit.
    pub fn finish(mut self) -> Result<usize, OutputFull> {
        self.align()?;
        Ok(self.sink.len)
    }
}
