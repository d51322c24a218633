//! Coders of a range image's levels; all but [`context`]'s are lossless, and so are these at a step of one level. Forward and inverse of each stand side by side in one file.

pub(crate) mod bits;
pub mod context;
pub(crate) mod deflate;
#[cfg(feature = "std")]
pub(crate) mod inflate;
pub(crate) mod rle;
pub(crate) mod store;

#[cfg(feature = "std")]
#[doc(hidden)]
pub use context::fast::lab as fast_lab;
pub use context::{ContextCoder, ContextSettings, Dense, DenseModel, Fast, Predictor, Small, SmallModel, Step};
pub use deflate::{Deflate, DeflateDefault, DeflateDense, DeflateSmall};
pub use rle::Rle;
pub use store::Store;

use crate::image::{ImageView, Level};

/// The output buffer ran out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputFull;

impl core::fmt::Display for OutputFull {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the payload does not fit in the output buffer")
    }
}

impl core::error::Error for OutputFull {}

/// Which coder wrote a payload; the number in the frame header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[repr(u8)]
pub enum CoderId {
    /// [`Store`]: the levels as they are.
    Store = 0,
    /// [`Rle`]: run-length coding.
    Rle = 1,
    /// Raw DEFLATE (RFC 1951).
    Deflate = 2,
    /// [`context`]: the coders made for range images, every tier.
    Context = 3,
}

impl CoderId {
    /// The coder of a header byte.
    #[must_use]
    pub const fn from_byte(byte: u8) -> Option<Self> {
        match byte {
            0 => Some(Self::Store),
            1 => Some(Self::Rle),
            2 => Some(Self::Deflate),
            3 => Some(Self::Context),
            _ => None,
        }
    }
}

/// The longest payload of a coder: levels as they are, in blocks that each cost some bytes more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorstCase {
    /// Bytes of a level.
    pub bytes_per_level: usize,
    /// Bytes of levels in a block.
    pub block_len: usize,
    /// Bytes that a block costs; there is one block at least.
    pub bytes_per_block: usize,
    /// Whether the coder needs a strip's levels in one piece. Where an image is cut into several they are not, and copied
    /// to the end of the output, which must have room for them.
    pub gathers: bool,
}

impl WorstCase {
    /// Most bytes that `pixels` pixels can take.
    #[must_use]
    pub const fn len(&self, pixels: usize) -> usize {
        let levels_len = pixels * self.bytes_per_level;
        let blocks = levels_len.div_ceil(self.block_len);
        levels_len + self.bytes_per_block * if blocks == 0 { 1 } else { blocks }
    }
}

/// The forward direction of a coder: levels to payload.
pub trait Coder<L: Level> {
    /// What the frame header calls this coder.
    const ID: CoderId;

    /// How long a payload can get.
    const WORST_CASE: WorstCase;

    /// Most rows that an image may have.
    const ROWS_MAX: usize = usize::MAX;

    /// Most levels that a decoded level is off; 0 where nothing is lost.
    fn error_max(&self) -> u16 {
        0
    }

    /// Writes the payload of `image` to the front of `out` and gives its length.
    ///
    /// # Errors
    /// [`OutputFull`] where it does not fit; never with [`WORST_CASE`](Self::WORST_CASE)`.len(pixels)` bytes.
    fn encode(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull>;

    /// As [`encode`](Self::encode), by what the frame before had at the same place where the coder can, and that is less.
    #[doc(hidden)]
    fn encode_after(
        &mut self,
        image: ImageView<'_, L>,
        _: &mut context::Recall<'_>,
        out: &mut [u8],
    ) -> Result<usize, OutputFull> {
        self.encode(image, out)
    }
}

/// A slice that is filled from the front.
#[derive(Debug)]
pub(crate) struct Sink<'a> {
    out: &'a mut [u8],
    len: usize,
}

impl<'a> Sink<'a> {
    pub(crate) const fn new(out: &'a mut [u8]) -> Self {
        Self { out, len: 0 }
    }

    pub(crate) const fn len(&self) -> usize {
        self.len
    }

    #[inline]
    pub(crate) fn put(&mut self, byte: u8) -> Result<(), OutputFull> {
        *self.out.get_mut(self.len).ok_or(OutputFull)? = byte;
        self.len += 1;
        Ok(())
    }

    pub(crate) fn put_all(&mut self, bytes: &[u8]) -> Result<(), OutputFull> {
        let room = self.out.get_mut(self.len..).ok_or(OutputFull)?;
        room.get_mut(..bytes.len()).ok_or(OutputFull)?.copy_from_slice(bytes);
        self.len += bytes.len();
        Ok(())
    }
}

/// A payload that ends too early or too late for its pixels.
#[cfg(feature = "std")]
pub(crate) const fn check_len(found: usize, expected: usize) -> Result<(), crate::error::PayloadFault> {
    use crate::error::PayloadFault;
    if found < expected {
        Err(PayloadFault::TooShort)
    } else if found > expected {
        Err(PayloadFault::TooLong)
    } else {
        Ok(())
    }
}
