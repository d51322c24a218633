//! Hesai PandarXT-32 data packets.
//!
//! ```text
//! 1080 bytes, little endian   header, 12 bytes            block, 130 bytes
//!    0  header                   0  0xee 0xff                0  u16 azimuth, 0.01 deg
//!   12  8 blocks of 130          2  u8 protocol: 6, 1        2  32 channels: u16 range,
//! 1052  tail                     6  u8 channels: 0x20           u8 reflectivity, u8 reserved
//!                                7  u8 blocks: 8
//! tail, 28 bytes                 8  u8 first block's return
//!   10  u8 return mode           9  u8 range unit: 4 mm
//!   11  u16 motor speed         10  u8 returns
//!   13  date and time, 6 bytes  11  u8 flags, bit 0: sequence number
//!   19  u32 microseconds
//!   23  u8 factory: 0x42
//!   24  u32 sequence number
//! ```
//!
//! In dual return two blocks in turn share an azimuth. Sources: Hesai's PandarXT-32 user manual,
//! section 3.1 and appendix II.

use super::bytes::{byte, check_marker, le_u32, tail};
use super::column::CellFormat;
use super::hesai_time::unix_ns;
use super::pandar64::{check_channels, check_fields};
use super::spin::{Frame, Layout, Stamp};
use super::{Model, PacketError};

/// Bytes of a packet.
pub(super) const LEN: usize = 1080;

const TAIL_AT: usize = 1052;

static LAYOUT: Layout = Layout {
    model: Model::PandarXt32,
    blocks_at: 12,
    block_len: 130,
    blocks: 8,
    azimuth_at: 0,
    cells_at: 2,
    cell: CellFormat::Four,
    cell_len: 4,
    run_len: 32,
    blocks_per_firing: 1,
    firings_per_block: 1,
    spread: 0,
};

/// The last firing's own time lies this much after the packet's.
const LAST_FIRING_NS: u64 = 3_280;

/// Checks the frame of a packet of [`LEN`] bytes.
pub(super) fn check(packet: &[u8]) -> Result<Frame, PacketError> {
    check_start(packet)?;
    check_fields(packet, &[(7, 8), (9, 4)])?;
    let tail = tail(packet, TAIL_AT);
    let dual = is_dual(byte(tail, 10))?;
    let has_sequence = byte(packet, 11) & 1 == 1;
    Ok(Frame { layout: &LAYOUT, dual, stamp: stamp(tail, dual, has_sequence) })
}

fn check_start(packet: &[u8]) -> Result<(), PacketError> {
    check_marker(packet, 0, 0xffee)?;
    check_marker(packet, 2, 0x0106)?;
    check_channels(packet, 6, 0x20)
}

fn is_dual(mode: u8) -> Result<bool, PacketError> {
    match mode {
        0x33 | 0x37 | 0x38 => Ok(false),
        0x39 | 0x3b | 0x3c => Ok(true),
        found => Err(PacketError::ReturnMode { found }),
    }
}

fn stamp(tail: &[u8], dual: bool, has_sequence: bool) -> Stamp {
    let date = tail.get(13..).and_then(|date| date.first_chunk());
    let (packet_ns, clock_wrap_ns) = unix_ns(date.copied().unwrap_or([0; 6]), le_u32(tail, 19));
    let firings = LAYOUT.blocks as u64 / if dual { 2 } else { 1 };
    let lasts_ns = firings.saturating_sub(1) * u64::from(LAYOUT.model.facts().period_ns);
    let ahead_ns = packet_ns + LAST_FIRING_NS;
    Stamp {
        mode: byte(tail, 10),
        time_ns: if ahead_ns < lasts_ns {
            ahead_ns.wrapping_add(clock_wrap_ns).saturating_sub(lasts_ns)
        } else {
            ahead_ns - lasts_ns
        },
        clock_wrap_ns,
        sequence: has_sequence.then(|| le_u32(tail, 24)),
    }
}
