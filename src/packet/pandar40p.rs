//! Hesai Pandar40P and Pandar40M data packets.
//!
//! ```text
//! 1262 or 1266 bytes, little endian    block, 124 bytes            tail, 22 or 26 bytes
//!    0  10 blocks of 124                  0  0xff 0xee                5  u8 shutdown flag
//! 1240  tail                              2  u16 azimuth, 0.01 deg    8  u16 motor speed
//!                                         4  40 channels:            10  u32 microseconds
//! channel: u16 range, 4 mm; u8 reflectivity                          14  u8 return mode
//!                                                                    15  u8 factory: 0x42
//!                                                                    16  date and time, 6 bytes
//!                                                                    22  u32 sequence (optional)
//! ```
//!
//! In dual return two blocks in turn share an azimuth. Sources: Hesai's Pandar40P and Pandar40M
//! user manuals, section 3.1; `HesaiLidar_General_SDK` (times).

use super::bytes::{byte, check_markers, le_u32, tail};
use super::column::CellFormat;
use super::hesai_time::unix_ns;
use super::spin::{Frame, Layout, Stamp};
use super::{Model, PacketError};

/// Bytes of a packet without and with a sequence number.
pub(super) const LENS: [usize; 2] = [1262, 1266];

const TAIL_AT: usize = 1240;
const FLAG: u16 = 0xeeff;

static LAYOUT: Layout = Layout {
    model: Model::Pandar40p,
    blocks_at: 0,
    block_len: 124,
    blocks: 10,
    azimuth_at: 2,
    cells_at: 4,
    cell: CellFormat::Three,
    cell_len: 3,
    run_len: 40,
    blocks_per_firing: 1,
    firings_per_block: 1,
    spread: 0,
};

/// The packet's time is that of its end: the last firing's own time lies this much before.
const LAST_FIRING_NS: u64 = 28_580;

/// Checks the frame of a packet of one of [`LENS`] bytes.
pub(super) fn check(packet: &[u8]) -> Result<Frame, PacketError> {
    check_markers(packet, LAYOUT.blocks, LAYOUT.block_len, FLAG)?;
    let tail = tail(packet, TAIL_AT);
    let dual = is_dual(byte(tail, 14))?;
    Ok(Frame { layout: &LAYOUT, dual, stamp: stamp(tail, &LAYOUT, dual, LAST_FIRING_NS) })
}

/// Return modes of Pandar40P and Pandar64.
pub(super) fn is_dual(mode: u8) -> Result<bool, PacketError> {
    match mode {
        0x37 | 0x38 => Ok(false),
        0x39 => Ok(true),
        found => Err(PacketError::ReturnMode { found }),
    }
}

/// Time and number from the tail that Pandar40P and Pandar64 share.
pub(super) fn stamp(tail: &[u8], layout: &Layout, dual: bool, last_firing_ns: u64) -> Stamp {
    let date = tail.get(16..).and_then(|date| date.first_chunk());
    let (end_ns, clock_wrap_ns) = unix_ns(date.copied().unwrap_or([0; 6]), le_u32(tail, 10));
    let firings = layout.blocks as u64 / if dual { 2 } else { 1 };
    let lasts_ns = firings.saturating_sub(1) * u64::from(layout.model.facts().period_ns);
    let back_ns = lasts_ns + last_firing_ns;
    Stamp {
        mode: byte(tail, 14),
        // A clock that wraps must not go below zero.
        time_ns: if end_ns < back_ns {
            end_ns.wrapping_add(clock_wrap_ns).saturating_sub(back_ns)
        } else {
            end_ns - back_ns
        },
        clock_wrap_ns,
        sequence: (tail.len() >= 26).then(|| le_u32(tail, 22)),
    }
}
