//! The shared captures and what other decoders made of them.
#![allow(dead_code, reason = "each test uses a part")]

use etherparse::{SlicedPacket, TransportSlice};
use pcap_parser::{LegacyPcapReader, PcapBlockOwned, PcapError, traits::PcapReaderIterator};
use std::fs::File;

use crate::common::data;

/// UDP payloads to `port` in a capture.
pub fn payloads(path: &str, port: u16) -> Vec<Vec<u8>> {
    let file = File::open(data::path(path)).expect("capture opens");
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
            Err(PcapError::Eof) => return payloads,
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

/// Points of an `.xyzir.bin`.
pub fn xyzir(path: &str) -> Vec<[f32; 5]> {
    let bytes = std::fs::read(data::path(path)).expect("points read");
    floats(&bytes)
}

/// Points of a binary .pcd with fields x, y, z.
pub fn pcd_xyz(path: &str) -> Vec<[f32; 3]> {
    const DATA: &[u8] = b"DATA binary\n";
    let bytes = std::fs::read(data::path(path)).expect("cloud reads");
    let header = bytes.windows(DATA.len()).position(|window| window == DATA);
    floats(&bytes[header.expect("a binary pcd") + DATA.len()..])
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
pub fn npy_u32(path: &str) -> (Vec<u32>, usize) {
    let bytes = std::fs::read(data::path(path)).expect("array reads");
    let header_len = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..header_len]).into_owned();
    assert!(header.contains("'<u4'") && header.contains("'fortran_order': False"));
    let shape = header.split('(').nth(1).and_then(|shape| shape.split(')').next());
    let columns = shape.and_then(|shape| shape.split(',').nth(1));
    let columns = columns.and_then(|columns| columns.trim().parse().ok());
    let (words, _) = bytes[header_len..].as_chunks::<4>();
    let values = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    (values, columns.expect("two dimensions"))
}

/// Smallest difference of two angles in degrees.
pub fn apart_deg(a: f64, b: f64) -> f64 {
    let apart = (a - b).rem_euclid(360.0);
    apart.min(360.0 - apart)
}
