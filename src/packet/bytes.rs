//! Little-endian fields of byte slices, without a panic.
//!
//! A packet's length is checked before any field is read, so the "outside" answer of these (zero)
//! is never seen; it stands where an index would carry a panic into the firmware.

use super::PacketError;

pub(super) fn le_u16(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(field(bytes, at))
}

pub(super) fn le_u32(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(field(bytes, at))
}

pub(super) fn le_u64(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(field(bytes, at))
}

pub(super) fn byte(bytes: &[u8], at: usize) -> u8 {
    bytes.get(at).copied().unwrap_or(0)
}

/// Everything from `at` on; empty past the end.
pub(super) fn tail(bytes: &[u8], at: usize) -> &[u8] {
    bytes.get(at..).unwrap_or(&[])
}

fn field<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    tail(bytes, at).first_chunk().copied().unwrap_or([0; N])
}

/// A fixed u16 that the format has at `at`.
pub(super) fn check_marker(bytes: &[u8], at: usize, expected: u16) -> Result<(), PacketError> {
    let found = le_u16(bytes, at);
    if found == expected {
        return Ok(());
    }
    Err(PacketError::Marker { at: at as u16, found, expected })
}

/// The same at the start of each block. The packet has so many blocks.
pub(super) fn check_markers(packet: &[u8], blocks: usize, block_len: usize, expected: u16) -> Result<(), PacketError> {
    for (block, nth) in packet.chunks_exact(block_len.max(1)).take(blocks).zip(0..) {
        let found = le_u16(block, 0);
        if found != expected {
            return Err(PacketError::Marker { at: (nth * block_len) as u16, found, expected });
        }
    }
    Ok(())
}
