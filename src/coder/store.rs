//! No coding: the levels as they are, a `u16` low byte first.

use super::{Coder, CoderId, OutputFull, Sink, WorstCase};
use crate::image::{ImageView, Level};

/// The levels as they are. For links that are faster than any coder, and as the yardstick of the others.
#[derive(Debug, Clone, Copy, Default)]
pub struct Store;

impl Store {
    /// A coder without state.
    #[must_use]
    pub const fn new() -> Self {
        Self
    }
}

impl<L: Level> Coder<L> for Store {
    const ID: CoderId = CoderId::Store;

    const WORST_CASE: WorstCase =
        WorstCase { bytes_per_level: size_of::<L>(), block_len: usize::MAX, bytes_per_block: 0, gathers: false };

    fn encode(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
        let mut sink = Sink::new(out);
        put(image, &mut sink)?;
        Ok(sink.len())
    }
}

pub(crate) fn put<L: Level>(image: ImageView<'_, L>, sink: &mut Sink<'_>) -> Result<(), OutputFull> {
    image.row_levels().try_for_each(|row| sink.put_all(bytemuck::cast_slice(row)))
}

#[cfg(feature = "std")]
pub(crate) fn decode<L: Level>(payload: &[u8], levels: &mut [L]) -> Result<(), crate::error::PayloadFault> {
    let bytes = bytemuck::cast_slice_mut::<L, u8>(levels);
    super::check_len(payload.len(), bytes.len())?;
    bytes.copy_from_slice(payload);
    Ok(())
}
