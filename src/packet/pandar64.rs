//! Hesai Pandar64 data packets.
//!
//! ```text
//! 1194 or 1198 bytes, little endian    header, 8 bytes           block, 194 bytes
//!    0  header                            0  0xee 0xff              0  u16 azimuth, 0.01 deg
//!    8  6 blocks of 194                   2  u8 channels: 0x40      2  64 channels:
//! 1172  tail: that of Pandar40P           3  u8 blocks: 6              u16 range, u8 reflectivity
//!                                         4  u8 first block's return
//!                                         5  u8 range unit: 4 mm
//! ```
//!
//! In dual return two blocks in turn share an azimuth. Sources: Hesai's Pandar64 user manual,
//! section 3.1; `HesaiLidar_General_SDK` (times).

use super::bytes::{byte, check_marker, tail};
use super::column::CellFormat;
use super::pandar40p::{is_dual, stamp};
use super::spin::{Frame, Layout};
use super::{Model, PacketError};

/// Bytes of a packet without and with a sequence number.
pub(super) const LENS: [usize; 2] = [1194, 1198];

const TAIL_AT: usize = 1172;

static LAYOUT: Layout = Layout {
    model: Model::Pandar64,
    blocks_at: 8,
    block_len: 194,
    blocks: 6,
    azimuth_at: 0,
    cells_at: 2,
    cell: CellFormat::Three,
    cell_len: 3,
    run_len: 64,
    blocks_per_firing: 1,
    firings_per_block: 1,
    spread: 0,
};

/// The packet's time is that of its end: the last firing's own time lies this much before.
const LAST_FIRING_NS: u64 = 42_580;

/// Checks the frame of a packet of one of [`LENS`] bytes.
pub(super) fn check(packet: &[u8]) -> Result<Frame, PacketError> {
    check_start(packet)?;
    check_fields(packet, &[(3, 6), (5, 4)])?;
    let tail = tail(packet, TAIL_AT);
    let dual = is_dual(byte(tail, 14))?;
    Ok(Frame { layout: &LAYOUT, dual, stamp: stamp(tail, &LAYOUT, dual, LAST_FIRING_NS) })
}

fn check_start(packet: &[u8]) -> Result<(), PacketError> {
    check_marker(packet, 0, 0xffee)?;
    check_channels(packet, 2, 0x40)
}

/// The header's count of channels, which tells the model.
pub(super) fn check_channels(packet: &[u8], at: usize, expected: u8) -> Result<(), PacketError> {
    match byte(packet, at) {
        found if found == expected => Ok(()),
        found => Err(PacketError::Model { found, expected }),
    }
}

/// Header bytes that have one value only.
pub(super) fn check_fields(packet: &[u8], fields: &[(u16, u8)]) -> Result<(), PacketError> {
    for &(at, expected) in fields {
        let found = byte(packet, usize::from(at));
        if found != expected {
            return Err(PacketError::Field { at, found, expected });
        }
    }
    Ok(())
}
