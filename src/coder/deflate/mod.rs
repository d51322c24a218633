//! The dictionary coder: LZ77 and Huffman, written as one raw DEFLATE stream (RFC 1951).
//!
//! ```text
//! image bytes ─> parse ──────> sequences ──> block ─────────> bits
//!                matcher:      literals      stored, fixed
//!                candidates    and matches   or dynamic code
//! ```
//!
//! The window is the image itself: nothing of it is copied, and a match may reach back 32,768 bytes in any profile.
//! The inverse is any inflater; under `std` this crate uses `miniz_oxide`.

mod block;
mod costs;
mod header;
mod huffman;
mod matcher;
mod parse;
mod symbols;

use super::{Coder, CoderId, OutputFull, WorstCase};
use crate::image::{ImageView, Level};
use block::{Codes, Sequence};
use costs::Costs;
use matcher::Tables;
use parse::Parse;
use symbols::MIN_MATCH;

/// Fewest bytes that a block other than the last may stand for: the format has decoders refuse streams of smaller ones.
pub(crate) const LEAST_BLOCK_LEN: usize = 8;

/// DEFLATE (RFC 1951): the paper's LZ77 (section IV-C), made for range images. All of its state; no allocator.
///
/// `SHORT` and `LONG`, powers of two, are the keys that each two of its four hash tables hold (3 and 9 bytes; 6 and
/// 20), `WAYS` the positions a key, `SEQUENCES` the matches a block: more of each means fewer bytes and, for `WAYS`,
/// more time. RAM: `4 * WAYS * (SHORT + LONG) + 4 * SEQUENCES` + 3.3 KB, all zero when new, so that a `static`
/// one lies in `.bss`. Three choices have names:
///
/// | profile | RAM | bytes, of zlib -6's | time, of zlib -6's |
/// |---|---|---|---|
/// | [`DeflateSmall`] | 13.5 KB | 0.97 to 1.06 | 0.25 to 0.6 |
/// | [`DeflateDefault`] | 56.6 KB | 0.97 to 1.02 | 0.21 to 0.5 |
/// | [`DeflateDense`] | 204 KB | 0.94 to 0.98 | 0.32 to 0.8 |
///
/// Medians over 29 KITTI scans as 8-bit images of 4500 to 256 columns; the times grow towards the narrow ones, where
/// hardly a pixel is empty. Stack: less than 1.2 KB on Cortex-M.
///
/// ```
/// use flicr::DeflateSmall;
/// let mut coder = Box::new(DeflateSmall::new());
/// let image = [[7, 0, 7, 0, 0, 7, 0, 0]; 64]; // 64 rows of 8 pixels
/// let mut out = [0; DeflateSmall::worst_case_len(64 * 8)];
/// let len = coder.encode_bytes(image.as_flattened(), 8, &mut out)?;
/// assert!(len < 32);
/// # Ok::<(), flicr::OutputFull>(())
/// ```
pub struct Deflate<const SHORT: usize, const LONG: usize, const WAYS: usize, const SEQUENCES: usize> {
    tables: Tables<SHORT, LONG, WAYS>,
    costs: Costs,
    codes: Codes,
    sequences: [Sequence; SEQUENCES],
}

/// The default: about the bytes of zlib -6 in a fraction of its time.
pub type DeflateDefault = Deflate<4096, 8192, 1, 1024>;
/// The profile for small parts.
pub type DeflateSmall = Deflate<512, 512, 2, 512>;
/// The profile where memory and time are at hand.
pub type DeflateDense = Deflate<4096, 8192, 4, 1024>;

impl<const SHORT: usize, const LONG: usize, const WAYS: usize, const SEQUENCES: usize>
    Deflate<SHORT, LONG, WAYS, SEQUENCES>
{
    /// A block takes as many bytes at least, except the last: every sequence stands for three or more.
    const MIN_BLOCK_LEN: usize = {
        assert!(SEQUENCES * MIN_MATCH >= LEAST_BLOCK_LEN && SEQUENCES * MIN_MATCH <= 32_768);
        SEQUENCES * MIN_MATCH
    };

    /// A stored block costs five bytes. One byte is taken off its length for the empty block that may come last.
    const BOUND: WorstCase =
        WorstCase { bytes_per_level: 1, block_len: Self::MIN_BLOCK_LEN - 1, bytes_per_block: 5, gathers: true };

    /// A coder; all zeros.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            tables: Tables::new(),
            costs: Costs::new(),
            codes: Codes::new(),
            sequences: [Sequence::EMPTY; SEQUENCES],
        }
    }

    /// Most bytes that `len` bytes can take.
    #[must_use]
    pub const fn worst_case_len(len: usize) -> usize {
        Self::BOUND.len(len)
    }

    /// Writes `bytes`, in rows of `row_len`, to the front of `out` as one DEFLATE stream and gives its length.
    ///
    /// Any length and any `row_len` is coded rightly; range images, row-major, are coded well. The same input gives
    /// the same bytes, whatever was coded before.
    ///
    /// # Errors
    /// [`OutputFull`] where it does not fit; never with [`worst_case_len`](Self::worst_case_len) bytes.
    pub fn encode_bytes(&mut self, bytes: &[u8], row_len: usize, out: &mut [u8]) -> Result<usize, OutputFull> {
        self.tables.clear();
        self.costs.reset();
        Parse::new(self, bytes, row_len, out).run()
    }
}

impl<const SHORT: usize, const LONG: usize, const WAYS: usize, const SEQUENCES: usize> Default
    for Deflate<SHORT, LONG, WAYS, SEQUENCES>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<const SHORT: usize, const LONG: usize, const WAYS: usize, const SEQUENCES: usize> core::fmt::Debug
    for Deflate<SHORT, LONG, WAYS, SEQUENCES>
{
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Deflate").finish_non_exhaustive()
    }
}

impl<L: Level, const SHORT: usize, const LONG: usize, const WAYS: usize, const SEQUENCES: usize> Coder<L>
    for Deflate<SHORT, LONG, WAYS, SEQUENCES>
{
    const ID: CoderId = CoderId::Deflate;

    const WORST_CASE: WorstCase = WorstCase { bytes_per_level: size_of::<L>(), ..Self::BOUND };

    fn encode(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
        let (levels, out) = image.gathered(out).ok_or(OutputFull)?;
        self.encode_bytes(bytemuck::cast_slice(levels), image.columns() * size_of::<L>(), out)
    }
}
