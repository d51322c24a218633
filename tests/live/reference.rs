//! What the streaming firmware must send: the host's side of `examples/live_firmware`.

use flicr::coder::{ContextSettings, SmallModel, Step};
use flicr::geometry::sensors::{hdl64e, velodyne};
use flicr::geometry::{Beam, SensorGrid};
use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::stream::{AlignedHdl64e, AsFired, DATAGRAM_LEN, Line, StreamConfig, StreamEncoder};

use crate::reader::{Hdl64e, Packets, Piece};

/// A sensor and what its stream is like.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Kind {
    Vlp16,
    Hdl64e,
    Hdl64eAligned,
}

impl Kind {
    /// What the firmware calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vlp16 => "vlp16",
            Self::Hdl64e => "hdl64e",
            Self::Hdl64eAligned => "hdl64e-aligned",
        }
    }
}

static VLP16: [Beam; 16] = velodyne::VLP16.beams_at(600).expect("16 beams");

/// The grid of a VLP-16 at 600 turns a minute.
pub fn vlp16_grid() -> SensorGrid<'static> {
    velodyne::VLP16.grid_of(&VLP16)
}

/// The datagrams of these packets, in steps of so many range counts.
pub fn datagrams(kind: Kind, step: u16, packets: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let vlp16 = || TurnAssembler::new(Sensor::Spinning(Model::Vlp16), ReturnPolicy::Strongest);
    match kind {
        Kind::Vlp16 => send::<_, 2, AsFired>(vlp16(), &vlp16_grid(), step, packets),
        Kind::Hdl64e => send::<_, 8, AsFired>(Hdl64e::new(), &hdl64e::FIRING_GRID, step, packets),
        Kind::Hdl64eAligned => send::<_, 8, AlignedHdl64e>(Hdl64e::new(), &hdl64e::FIRING_GRID, step, packets),
    }
}

fn send<P: Packets, const GROUPS: usize, L: Line>(
    mut reader: P,
    grid: &SensorGrid<'_>,
    step: u16,
    packets: &[Vec<u8>],
) -> Vec<Vec<u8>> {
    let settings = ContextSettings::FINE.with_step(Step::new(step).expect("a step"));
    let config = StreamConfig::new(grid, 1, settings).expect("a grid");
    let mut stream: Box<StreamEncoder<SmallModel, GROUPS, DATAGRAM_LEN, L>> = Box::new(StreamEncoder::BLANK);
    stream.start(StreamConfig { columns_a_turn: 2150, ..config }).expect("room");
    let mut sent = Vec::new();
    let mut take = |piece: Piece<'_>| {
        piece.feed(&mut stream);
        while let Some(datagram) = stream.next_datagram() {
            sent.push(datagram.to_vec());
        }
    };
    for packet in packets {
        assert!(reader.push(packet, &mut take), "a packet was refused");
    }
    reader.finish(&mut take);
    stream.finish(|datagram| sent.push(datagram.to_vec()));
    sent
}
