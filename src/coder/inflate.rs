//! The inverse of `deflate`, by `miniz_oxide`: outside the device a well-kept library does it.

use miniz_oxide::inflate::TINFLStatus;
use miniz_oxide::inflate::core::{DecompressorOxide, decompress, inflate_flags};

use super::check_len;
use super::deflate::LEAST_BLOCK_LEN;
use crate::error::PayloadFault;
use crate::image::Level;

/// Inflates `payload` into `levels`, all of both.
///
/// Blocks are counted: each makes the inflater set up its tables, which takes as long as hundreds of levels, and an
/// empty one is ten bits. 16 MiB of these would keep it busy for a minute.
pub(crate) fn decode<L: Level>(payload: &[u8], levels: &mut [L]) -> Result<(), PayloadFault> {
    let bytes = bytemuck::cast_slice_mut::<L, u8>(levels);
    let mut inflater = DecompressorOxide::new();
    let flags =
        inflate_flags::TINFL_FLAG_USING_NON_WRAPPING_OUTPUT_BUF | inflate_flags::TINFL_FLAG_STOP_ON_BLOCK_BOUNDARY;
    let (mut read, mut written) = (0, 0);
    for _block in 0..=blocks_max(bytes.len()) {
        let rest = payload.get(read..).unwrap_or_default();
        let (status, taken, put) = decompress(&mut inflater, rest, bytes, written, flags);
        (read, written) = (read + taken, written + put);
        match status {
            TINFLStatus::BlockBoundary => {}
            TINFLStatus::Done => {
                check_len(written, bytes.len())?;
                return check_len(payload.len(), read);
            }
            TINFLStatus::HasMoreOutput => return Err(PayloadFault::TooLong),
            TINFLStatus::FailedCannotMakeProgress | TINFLStatus::NeedsMoreInput => return Err(PayloadFault::TooShort),
            _ => return Err(PayloadFault::Malformed),
        }
    }
    Err(PayloadFault::TooManyBlocks)
}

/// Most blocks that `docs/FORMAT.md` allows for so many bytes of levels.
const fn blocks_max(levels_len: usize) -> usize {
    16 + levels_len / LEAST_BLOCK_LEN
}
