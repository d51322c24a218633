//! The shared captures and what other decoders made of them.

use etherparse::{SlicedPacket, TransportSlice};
use flicr::packet::{Event, ReturnPolicy, Sensor, Turn, TurnAssembler};
use pcap_parser::{LegacyPcapReader, PcapBlockOwned, PcapError, traits::PcapReaderIterator};
use std::fs::File;
use std::path::PathBuf;

/// The file in the shared data, or `None` with a line that says so.
pub fn shared(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("FLICR_DATA").map_or("../shared/data".into(), PathBuf::from);
    let path = root.join(path);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no {}", path.display());
    None
}

/// UDP payloads to `port` in a capture.
pub fn payloads(path: &str, port: u16) -> Option<Vec<Vec<u8>>> {
    let file = File::open(shared(path)?).expect("capture opens");
    let mut reader = LegacyPcapReader::new(1 << 16, file).expect("a pcap file");
    let mut payloads = Vec::new();
    loop {
        match reader.next() {
            Ok((used, block)) => {
                if let PcapBlockOwned::Legacy(frame) = block {
                    payloads.extend(udp(frame.data, port));
                }
                reader.consume(used);
            }
            Err(PcapError::Incomplete(_)) => reader.refill().expect("capture reads"),
            Err(PcapError::Eof) => return Some(payloads),
            Err(error) => panic!("{path}: {error}"),
        }
    }
}

fn udp(frame: &[u8], port: u16) -> Option<Vec<u8>> {
    match SlicedPacket::from_ethernet(frame).ok()?.transport? {
        TransportSlice::Udp(udp) if udp.destination_port() == port => Some(udp.payload().to_vec()),
        _ => None,
    }
}

/// A return with what is needed to place it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    pub turn: u32,
    pub column: u16,
    pub layer: u8,
    pub beam: u8,
    pub tick: u16,
    pub step_q8: u32,
    pub count: u32,
    pub intensity: u16,
    pub time_ns: u64,
}

/// All that an assembler makes of a sequence of packets.
#[derive(Debug, Default)]
pub struct Stream {
    pub returns: Vec<Placed>,
    pub turns: Vec<Turn>,
    pub gaps: Vec<(u32, u16, flicr::packet::GapCause)>,
    pub lost_turns: u32,
    pub stats: flicr::packet::PacketStats,
    pub errors: Vec<(usize, flicr::packet::PacketError)>,
    pub turn: u32,
}

impl Stream {
    pub fn of(packets: &[Vec<u8>], sensor: Sensor, policy: ReturnPolicy) -> Self {
        let mut turns = TurnAssembler::new(sensor, policy);
        let mut stream = Self::default();
        for (nth, packet) in packets.iter().enumerate() {
            if let Err(error) = turns.push(packet, |event| stream.take(event)) {
                stream.errors.push((nth, error));
            }
        }
        turns.finish(|event| stream.take(event));
        stream.stats = turns.stats();
        stream
    }

    pub fn take(&mut self, event: Event<'_>) {
        match event {
            Event::Column(column) => column.for_each_return(|r| {
                self.returns.push(Placed {
                    turn: self.turn,
                    column: r.column,
                    layer: column.layer,
                    beam: r.beam,
                    tick: r.tick,
                    step_q8: column.step_q8,
                    count: r.count,
                    intensity: r.intensity,
                    time_ns: r.time_ns,
                });
            }),
            Event::Gap { columns, cause } => self.gaps.push((self.turn, columns, cause)),
            Event::TurnEnd(turn) => {
                self.turns.push(turn);
                self.turn += 1;
            }
            Event::TurnsLost { turns } => {
                self.lost_turns += turns;
                self.turn += turns;
            }
            _ => {}
        }
    }
}

/// Points of an `.xyzir.bin`.
pub fn xyzir(path: &str) -> Option<Vec<[f32; 5]>> {
    let bytes = std::fs::read(shared(path)?).expect("points read");
    Some(floats(&bytes))
}

/// Points of a binary .pcd with fields x, y, z.
pub fn pcd_xyz(path: &str) -> Option<Vec<[f32; 3]>> {
    const DATA: &[u8] = b"DATA binary\n";
    let bytes = std::fs::read(shared(path)?).expect("cloud reads");
    let header = bytes.windows(DATA.len()).position(|window| window == DATA);
    Some(floats(&bytes[header.expect("a binary pcd") + DATA.len()..]))
}

fn floats<const N: usize>(bytes: &[u8]) -> Vec<[f32; N]> {
    let (words, rest) = bytes.as_chunks::<4>();
    assert!(rest.is_empty());
    let floats: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
    let (points, rest) = floats.as_chunks::<N>();
    assert!(rest.is_empty());
    points.to_vec()
}

/// A two-dimensional u32 array, row by row, with its columns.
pub fn npy_u32(path: &str) -> Option<(Vec<u32>, usize)> {
    let bytes = std::fs::read(shared(path)?).expect("array reads");
    let header_len = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..header_len]).into_owned();
    assert!(header.contains("'<u4'") && header.contains("'fortran_order': False"));
    let shape = header.split('(').nth(1).and_then(|shape| shape.split(')').next());
    let columns = shape.and_then(|shape| shape.split(',').nth(1));
    let columns = columns.and_then(|columns| columns.trim().parse().ok());
    let (words, _) = bytes[header_len..].as_chunks::<4>();
    let values = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    Some((values, columns.expect("two dimensions")))
}

/// Smallest difference of two angles in degrees.
pub fn apart_deg(a: f64, b: f64) -> f64 {
    let apart = (a - b).rem_euclid(360.0);
    apart.min(360.0 - apart)
}
