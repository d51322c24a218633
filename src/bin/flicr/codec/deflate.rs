//! DEFLATE by `miniz_oxide`, in the place of the library's own coder until that is there.

use flicr::coder::{Coder, CoderId, OutputFull, WorstCase};
use flicr::{ImageView, Level};

/// As zlib's default.
const EFFORT: u8 = 6;

/// Raw DEFLATE (RFC 1951).
pub struct Deflate;

impl Deflate {
    pub const fn new() -> Self {
        Self
    }
}

impl<L: Level> Coder<L> for Deflate {
    const ID: CoderId = CoderId::Deflate;

    // Levels that do not compress are stored, in blocks of at least 4 KB.
    const WORST_CASE: WorstCase = WorstCase { bytes_per_level: size_of::<L>(), block_len: 4096, bytes_per_block: 16 };

    fn encode(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
        let payload = miniz_oxide::deflate::compress_to_vec(image.bytes(), EFFORT);
        out.get_mut(..payload.len()).ok_or(OutputFull)?.copy_from_slice(&payload);
        Ok(payload.len())
    }
}
