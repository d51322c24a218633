//! Sensors' packets to what a stream encoder takes. The tests on the host read packets by the same code.

use flicr::coder::SmallModel;
use flicr::packet::{Event, TurnAssembler};
use flicr::stream::{DATAGRAM_LEN, Line, StreamEncoder};

/// One thing that was in a packet.
pub enum Piece<'a> {
    Event(Event<'a>),
    Firing { index: u16, tick: u16, time_ns: u64, counts: &'a [u32; 64] },
    TurnEnd,
}

impl Piece<'_> {
    /// Feeds it; the datagrams that it fills are then to be taken.
    pub fn feed<const GROUPS: usize, L: Line>(&self, stream: &mut StreamEncoder<SmallModel, GROUPS, DATAGRAM_LEN, L>) {
        match self {
            Self::Event(event) => stream.feed(event),
            Self::Firing { index, tick, time_ns, counts } => stream.feed_counts(*index, *tick, *time_ns, *counts),
            Self::TurnEnd => stream.feed_turn_end(),
        }
    }

    /// Whether it holds a firing.
    pub fn is_column(&self) -> bool {
        matches!(self, Self::Event(Event::Column(_)) | Self::Firing { .. })
    }

    /// Whether a turn is over with it.
    pub fn is_turn_end(&self) -> bool {
        matches!(self, Self::Event(Event::TurnEnd(_)) | Self::TurnEnd)
    }
}

/// A reader of one sensor's packets.
pub trait Packets {
    /// Whether it was a packet of the sensor; gives what was in it.
    fn push(&mut self, packet: &[u8], take: impl FnMut(Piece<'_>)) -> bool;

    /// No more packets will come: ends the turn that is open.
    fn finish(&mut self, take: impl FnMut(Piece<'_>));
}

impl Packets for TurnAssembler {
    fn push(&mut self, packet: &[u8], mut take: impl FnMut(Piece<'_>)) -> bool {
        TurnAssembler::push(self, packet, |event| take(Piece::Event(event))).is_ok()
    }

    fn finish(&mut self, mut take: impl FnMut(Piece<'_>)) {
        TurnAssembler::finish(self, |event| take(Piece::Event(event)));
    }
}

/// Packets as an HDL-64E sends them: six firings, each a block of the upper 32 lasers and one of the lower 32, 1206 bytes.
///
/// HDL-64E-*like*: lasers are in the order of their elevations, from the highest, and azimuths are those of
/// `hdl64e::FIRING_GRID`, in hundredths of a degree; a real one needs its calibration file for both.
pub struct Hdl64e {
    last_azimuth: u16,
    /// Firings of the turn that is open.
    index: u16,
}

const PACKET_LEN: usize = 1206;
const BLOCK_LEN: usize = 100;
const FLAGS: [[u8; 2]; 2] = [[0xff, 0xee], [0xff, 0xdd]];
/// Hundredths of a degree in a tick.
const AZIMUTH_STEP: u16 = 9;
/// A firing of all lasers takes 46.5 us at ten turns of 2150 firings a second.
const FIRING_NS: u64 = 46_512;

impl Hdl64e {
    pub const fn new() -> Self {
        Self { last_azimuth: 0, index: 0 }
    }

    fn push_firing(&mut self, time_ns: u64, firing: &[u8], take: &mut impl FnMut(Piece<'_>)) {
        let (blocks, _) = firing.as_chunks::<BLOCK_LEN>();
        let mut counts = [0; 64];
        let lasers = blocks.iter().flat_map(|block| block.get(4..).unwrap_or_default().as_chunks::<3>().0);
        for (count, &[low, high, _intensity]) in counts.iter_mut().zip(lasers) {
            *count = u16::from_le_bytes([low, high]).into();
        }
        let azimuth = u16::from_le_bytes([2, 3].map(|at| firing.get(at).copied().unwrap_or_default()));
        if azimuth < self.last_azimuth {
            self.finish(&mut *take);
        }
        take(Piece::Firing { index: self.index, tick: azimuth / AZIMUTH_STEP, time_ns, counts: &counts });
        (self.last_azimuth, self.index) = (azimuth, self.index.saturating_add(1));
    }
}

impl Packets for Hdl64e {
    fn push(&mut self, packet: &[u8], mut take: impl FnMut(Piece<'_>)) -> bool {
        let Some((blocks, [a, b, c, d, _, _])) = packet.split_last_chunk::<6>() else { return false };
        let flags = blocks.chunks_exact(BLOCK_LEN).map(|block| block.get(..2));
        if packet.len() != PACKET_LEN || !flags.zip(FLAGS.iter().cycle()).all(|(found, flag)| found == Some(flag)) {
            return false;
        }
        let time_ns = 1000 * u64::from(u32::from_le_bytes([*a, *b, *c, *d]));
        for (number, firing) in (0..).zip(blocks.chunks_exact(2 * BLOCK_LEN)) {
            self.push_firing(time_ns + number * FIRING_NS, firing, &mut take);
        }
        true
    }

    fn finish(&mut self, mut take: impl FnMut(Piece<'_>)) {
        if self.index > 0 {
            take(Piece::TurnEnd);
        }
        (self.last_azimuth, self.index) = (0, 0);
    }
}
