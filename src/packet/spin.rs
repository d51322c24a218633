//! What Velodyne and Hesai packets have in common: blocks of (azimuth, channels).
//!
//! Each wire format has a file of its own that checks the packet's frame; what it then holds is
//! described by a [`Layout`], and all further code is written once, for that.

use super::bytes::{self, le_u16};
use super::column::{CellFormat, CellShape, Pick};
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

impl Layout {
    /// Blocks of a group.
    const fn group_len(&self, dual: bool) -> usize {
        self.blocks_per_firing * repeats(dual)
    }
}

/// Blocks that hold the same directions.
const fn repeats(dual: bool) -> usize {
    if dual { 2 } else { 1 }
}

/// What a packet's frame says, once checked: how to read the rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub layout: &'static Layout,
    pub dual: bool,
    pub stamp: Stamp,
}

/// A packet of blocks that was checked.
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
    #[inline(always)]
    pub fn new(packet: &'p [u8], Frame { layout, dual, stamp }: Frame) -> Result<Self, PacketError> {
        let group_len = layout.group_len(dual);
        let blocks = bytes::tail(packet, layout.blocks_at);
        let mut azimuths = [0; MAX_GROUPS];
        let mut shared = azimuths.iter_mut();
        let (mut first, mut left, mut groups) = (0, 0, 0);
        for (block, nth) in blocks.chunks_exact(layout.block_len.max(1)).take(layout.blocks).zip(0..) {
            let found = le_u16(block, layout.azimuth_at);
            if left == 0 {
                (first, left, groups) = (found, group_len, groups + 1);
                shared.next().into_iter().for_each(|azimuth| *azimuth = found);
            }
            left -= 1;
            if found >= TICKS_PER_TURN {
                return Err(PacketError::Azimuth { block: nth, found, expected: TICKS_PER_TURN });
            }
            if found != first && forward(first, found) > layout.spread {
                return Err(PacketError::Azimuth { block: nth, found, expected: first });
            }
        }
        let Stamp { mode, time_ns, clock_wrap_ns, sequence } = stamp;
        Ok(Self { layout, blocks, dual, mode, groups, azimuths, time_ns, clock_wrap_ns, sequence })
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

    /// Azimuth and bytes of each group.
    pub fn groups(&self) -> impl Iterator<Item = (u16, &'p [u8])> {
        let group_len = self.layout.block_len * self.layout.group_len(self.dual);
        self.azimuths().iter().copied().zip(self.blocks.chunks(group_len.max(1)))
    }

    /// How the cells of every firing lie.
    pub fn shape(&self, pick: Pick) -> CellShape {
        let layout = self.layout;
        CellShape {
            format: layout.cell,
            pick,
            to_second: layout.block_len,
            to_next_run: layout.block_len * repeats(self.dual),
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
