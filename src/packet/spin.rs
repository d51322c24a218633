//! What Velodyne and Hesai packets have in common: blocks of (azimuth, channels).
//!
//! Each wire format has a file of its own that checks the packet's frame; what it then holds is
//! described by a [`Layout`], and all further code is written once, for that.

use super::bytes::{self, le_u16};
use super::column::{CellFormat, Cells, Pick};
use super::model::TICKS_PER_TURN;
use super::{Model, PacketError, ReturnPolicy};

/// Most azimuths in a packet.
const MAX_GROUPS: usize = 12;

/// Faster than any of these sensors turns, in turns a second.
const MAX_TURNS_PER_SECOND: u32 = 40;

/// Jumps that are a blind sector, in ticks the shorter way: at least 5 degrees ahead, or so far that
/// at least 20 degrees of view are left. Smaller ones are damage: a flipped bit of an azimuth makes
/// one too many or one of those.
const BLIND_AHEAD: core::ops::RangeInclusive<i32> = 500..=18_000;
const BLIND_MOST: core::ops::RangeInclusive<i32> = -18_000..=-2_000;

/// Where things lie in a packet of blocks. Offsets and lengths in bytes.
///
/// A *group* is the blocks that share an azimuth: one, two in dual return, four (eight) on VLS-128.
#[derive(Debug)]
pub(super) struct Layout {
    pub model: Model,
    /// First block.
    pub blocks_at: usize,
    pub block_len: usize,
    pub blocks: usize,
    /// Azimuth and first cell, within a block.
    pub azimuth_at: usize,
    pub cells_at: usize,
    pub cell: CellFormat,
    pub cell_len: usize,
    /// Cells of one firing in one block.
    pub run_len: usize,
    /// Blocks that hold one firing (4 on VLS-128), or firings that share a block (2 on VLP-16).
    pub blocks_per_firing: usize,
    pub firings_per_block: usize,
    /// How much later than the group's first the azimuth of its other blocks may be, in ticks.
    pub spread: u16,
}

/// A packet of blocks whose frame was checked.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpinPacket<'p> {
    pub layout: &'static Layout,
    blocks: &'p [u8],
    dual: bool,
    mode: u8,
    groups: usize,
    azimuths: [u16; MAX_GROUPS],
    /// Time of the first firing.
    pub time_ns: u64,
    /// The clock starts again after this much; 0: never.
    pub clock_wrap_ns: u64,
    pub sequence: Option<u32>,
}

/// Return mode, time and number of a packet, as its tail tells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamp {
    /// The mode byte as sent.
    pub mode: u8,
    pub time_ns: u64,
    pub clock_wrap_ns: u64,
    pub sequence: Option<u32>,
}

impl<'p> SpinPacket<'p> {
    /// Reads and checks the azimuths. `packet` is long enough for its layout.
    pub fn new(packet: &'p [u8], layout: &'static Layout, dual: bool, stamp: Stamp) -> Result<Self, PacketError> {
        let group_len = layout.blocks_per_firing * if dual { 2 } else { 1 };
        let mut checked = Self {
            layout,
            blocks: bytes::tail(packet, layout.blocks_at),
            dual,
            mode: stamp.mode,
            groups: layout.blocks / group_len.max(1),
            azimuths: [0; MAX_GROUPS],
            time_ns: stamp.time_ns,
            clock_wrap_ns: stamp.clock_wrap_ns,
            sequence: stamp.sequence,
        };
        let groups = checked.blocks.chunks((layout.block_len * group_len).max(1)).take(checked.groups);
        for ((group, azimuth), nth) in groups.zip(&mut checked.azimuths).zip(0..) {
            *azimuth = shared_azimuth(group, layout, nth * group_len)?;
        }
        Ok(checked)
    }

    /// Firings in the packet.
    pub fn firings(&self) -> usize {
        self.groups * self.layout.firings_per_block
    }

    pub fn azimuths(&self) -> &[u16] {
        self.azimuths.get(..self.groups).unwrap_or(&[])
    }

    pub fn period_ns(&self) -> u32 {
        self.layout.model.facts().period_ns
    }

    /// The cells of the `nth` firing of a group.
    #[inline(always)]
    pub fn cells(&self, group: usize, nth: usize) -> Cells<'p> {
        let layout = self.layout;
        let repeats = if self.dual { 2 } else { 1 };
        let block = group * layout.blocks_per_firing * repeats;
        let before = nth * layout.run_len * layout.cell_len;
        Cells {
            bytes: bytes::tail(self.blocks, block * layout.block_len + layout.cells_at + before),
            format: layout.cell,
            pick: Pick::Only,
            to_second: layout.block_len,
            to_next_run: layout.block_len * repeats,
            run_len: layout.run_len,
            beam_of_channel: layout.model.facts().beam_of_channel,
        }
    }

    /// How to choose the cells of the layers that `policy` asks for.
    pub fn picks(&self, policy: ReturnPolicy) -> &'static [Pick] {
        match policy {
            _ if !self.dual => &[Pick::Only],
            ReturnPolicy::Strongest => &[Pick::Brighter],
            ReturnPolicy::Last => &[Pick::Farther],
            ReturnPolicy::Both => &[Pick::Brighter, Pick::Dimmer],
        }
    }

    /// How the azimuth runs through the packet.
    pub fn sweep(&self) -> Result<Sweep, PacketError> {
        if self.looks_dual() {
            return Err(PacketError::ReturnMode { found: self.mode });
        }
        let mut sweep = Sweep::default();
        let most = self.most_ticks_a_group();
        for (pair, block) in self.azimuths().windows(2).zip(1..) {
            let &[before, after] = pair else { continue };
            let step = signed(before, after);
            if (-i32::from(most)..=i32::from(most)).contains(&step) {
                sweep.steps += 1;
                sweep.ticks += step;
            } else if !(BLIND_AHEAD.contains(&step) || BLIND_MOST.contains(&step))
                || sweep.jump_to_group.replace(block).is_some()
            {
                return Err(PacketError::Azimuth { block: block as u8, found: after, expected: before });
            }
        }
        Ok(sweep)
    }

    /// Single return, yet the azimuth changes at every second block only.
    fn looks_dual(&self) -> bool {
        let azimuths = self.azimuths();
        let (pairs, _) = azimuths.as_chunks::<2>();
        !self.dual
            && pairs.len() > 1
            && pairs.iter().all(|[first, second]| first == second)
            && azimuths.first() != azimuths.last()
    }

    /// Most ticks that a group may be from the one before, in either direction.
    pub fn most_ticks_a_group(&self) -> u16 {
        let group_ns = self.period_ns() * self.layout.firings_per_block as u32;
        (group_ns / 1000 * MAX_TURNS_PER_SECOND * 36 / 1000) as u16
    }
}

/// The azimuth that all blocks of a group share.
fn shared_azimuth(group: &[u8], layout: &Layout, block: usize) -> Result<u16, PacketError> {
    let mut shared = None;
    for (bytes, nth) in group.chunks(layout.block_len.max(1)).zip(block..) {
        let found = le_u16(bytes, layout.azimuth_at);
        let first = *shared.get_or_insert(found);
        let expected = match found {
            TICKS_PER_TURN.. => TICKS_PER_TURN,
            _ if forward(first, found) > layout.spread => first,
            _ => continue,
        };
        return Err(PacketError::Azimuth { block: nth as u8, found, expected });
    }
    Ok(shared.unwrap_or(0))
}

/// How the azimuth runs through one packet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sweep {
    /// Ticks turned in the regular steps from group to group, and how many there are.
    ticks: i32,
    steps: u32,
    /// First group after the one irregular step, if there is one: the sensor's blind sector, or
    /// damage in the first or last group.
    pub jump_to_group: Option<usize>,
}

impl Sweep {
    /// Mean ticks a firing, times 256.
    pub fn step_q8(&self, firings_per_block: usize) -> Option<u32> {
        let firings = self.steps * firings_per_block as u32;
        if firings == 0 || self.ticks <= 0 {
            return None;
        }
        Some((self.ticks.unsigned_abs() * 256 + firings / 2) / firings)
    }
}

/// Ticks from `from` on to `to` in the direction of turning, below a turn.
pub(super) fn forward(from: u16, to: u16) -> u16 {
    if to >= from { to - from } else { to.wrapping_add(TICKS_PER_TURN).wrapping_sub(from) }
}

/// Ticks from `from` to `to` the shorter way, negative against the direction of turning.
pub(super) fn signed(from: u16, to: u16) -> i32 {
    let ahead = i32::from(forward(from, to));
    let turn = i32::from(TICKS_PER_TURN);
    if ahead > turn / 2 { ahead - turn } else { ahead }
}
