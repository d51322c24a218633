//! Velodyne data packets: VLP-16, Puck Hi-Res, VLP-32C, HDL-32E, VLS-128.
//!
//! ```text
//! 1206 bytes, little endian           block, 100 bytes            channel, 3 bytes
//!    0  12 blocks of 100                 0  u16 flag                 0  u16 range count
//! 1200  u32 time of the first firing,    2  u16 azimuth, 0.01 deg    2  u8 intensity
//!       microseconds past the hour       4  32 channels
//! 1204  u8 return mode
//! 1205  u8 product
//! ```
//!
//! A block holds one firing of 32 beams, two firings of 16 (VLP-16), or a quarter of one (VLS-128,
//! whose four banks have flags of their own). In dual return each block is followed by its twin of
//! the same azimuth: last return first, then the strongest, or the second strongest if the last is
//! the strongest. A VLS-128 then sends one firing a packet and leaves the last four blocks empty.
//!
//! Sources: Velodyne 63-9243 Rev E (VLP-16) and 63-9325 Rev C (VLP-32C), chapter 9; 63-9277 Rev D
//! (HDL-32E). VLS-128: as two open drivers read it (ROS `velodyne`, `velodyne_decoder`); its
//! product byte is 0x63 in the VLP-16 manual and 0xa1 on the wire, and both are taken.

use super::bytes::{byte, check_marker, check_markers, le_u32};
use super::column::CellFormat;
use super::spin::{Frame, Layout, Stamp};
use super::{Model, PacketError};

/// Bytes of every Velodyne data packet.
pub(super) const LEN: usize = 1206;

const MODE_AT: usize = 1204;
const PRODUCT_AT: usize = 1205;
const MODES: core::ops::RangeInclusive<u8> = 0x37..=0x39;
const DUAL: u8 = 0x39;
const FLAG: u16 = 0xeeff;
const HOUR_NS: u64 = 3_600_000_000_000;

const fn layout(model: Model, run_len: usize, firings_per_block: usize) -> Layout {
    Layout {
        model,
        blocks_at: 0,
        block_len: 100,
        blocks: 12,
        azimuth_at: 2,
        cells_at: 4,
        cell: CellFormat::Three,
        cell_len: 3,
        run_len,
        blocks_per_firing: 1,
        firings_per_block,
        spread: 0,
    }
}

static VLP16: Layout = layout(Model::Vlp16, 16, 2);
static PUCK_HI_RES: Layout = layout(Model::PuckHiRes, 16, 2);
static VLP32C: Layout = layout(Model::Vlp32c, 32, 1);
static HDL32E: Layout = layout(Model::Hdl32e, 32, 1);
static VLS128: Layout = Layout {
    blocks_per_firing: 4,
    // No source says whether the banks repeat the first one's azimuth or carry their own: allow a
    // firing's worth.
    spread: 60,
    ..layout(Model::Vls128, 32, 1)
};
static VLS128_DUAL: Layout = Layout { blocks_per_firing: 4, blocks: 8, spread: 60, ..layout(Model::Vls128, 32, 1) };

/// Checks the frame of a packet of [`LEN`] bytes.
pub(super) fn check(packet: &[u8]) -> Result<Frame, PacketError> {
    let mode = byte(packet, MODE_AT);
    let layout = layout_of(byte(packet, PRODUCT_AT), mode == DUAL)?;
    if !MODES.contains(&mode) {
        return Err(PacketError::ReturnMode { found: mode });
    }
    check_flags(packet, layout, mode == DUAL)?;
    let stamp = Stamp {
        mode,
        time_ns: u64::from(le_u32(packet, 1200)) * 1000 % HOUR_NS,
        clock_wrap_ns: HOUR_NS,
        sequence: None,
    };
    Ok(Frame { layout, dual: mode == DUAL, stamp })
}

fn layout_of(product: u8, dual: bool) -> Result<&'static Layout, PacketError> {
    Ok(match product {
        0x21 => &HDL32E,
        0x22 => &VLP16,
        0x24 => &PUCK_HI_RES,
        0x28 => &VLP32C,
        0x63 | 0xa1 if dual => &VLS128_DUAL,
        0x63 | 0xa1 => &VLS128,
        found => return Err(PacketError::Model { found, expected: 0 }),
    })
}

/// Every block starts with 0xeeff, but the second to fourth bank of a VLS-128: 0xddff, 0xccff,
/// 0xbbff.
fn check_flags(packet: &[u8], layout: &Layout, dual: bool) -> Result<(), PacketError> {
    if layout.blocks_per_firing == 1 {
        return check_markers(packet, layout.blocks, layout.block_len, FLAG);
    }
    let repeats = if dual { 2 } else { 1 };
    for block in 0..layout.blocks {
        let bank = block / repeats % layout.blocks_per_firing.max(1);
        check_marker(packet, block * layout.block_len, FLAG - 0x1100 * bank as u16)?;
    }
    Ok(())
}
