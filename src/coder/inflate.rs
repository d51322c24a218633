//! The inverse of `deflate`, by `miniz_oxide`: outside the device a well-kept library does it.

use miniz_oxide::inflate::TINFLStatus;
use miniz_oxide::inflate::core::{DecompressorOxide, decompress, inflate_flags};

use super::check_len;
use crate::error::PayloadFault;
use crate::image::Level;

/// Inflates `payload` into `levels`, all of both.
pub(crate) fn decode<L: Level>(payload: &[u8], levels: &mut [L]) -> Result<(), PayloadFault> {
    let bytes = bytemuck::cast_slice_mut::<L, u8>(levels);
    let mut inflater = DecompressorOxide::new();
    let flags = inflate_flags::TINFL_FLAG_USING_NON_WRAPPING_OUTPUT_BUF;
    let (status, read, written) = decompress(&mut inflater, payload, bytes, 0, flags);
    match status {
        TINFLStatus::Done => {
            check_len(written, bytes.len())?;
            check_len(payload.len(), read)
        }
        TINFLStatus::HasMoreOutput => Err(PayloadFault::TooLong),
        TINFLStatus::FailedCannotMakeProgress | TINFLStatus::NeedsMoreInput => Err(PayloadFault::TooShort),
        _ => Err(PayloadFault::Malformed),
    }
}
