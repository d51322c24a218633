//! Any sequence of datagrams: strips within bounds or errors, turns within the limits, no panic.
//!
//! Each datagram is a u16 length and its bytes; the high bit of the length says that beginning, sensor and checksum are made
//! to fit.
#![no_main]

use flicr::geometry::{
    SensorGrid,
    sensors::{hdl64e, velodyne},
};
use flicr::stream::{StreamDecoder, StreamLimits};
use libfuzzer_sys::fuzz_target;

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

fn seal(mut datagram: Vec<u8>, grid: &SensorGrid<'_>) -> Vec<u8> {
    let sensor = grid.checksum().to_le_bytes();
    if let Some(start) = datagram.first_chunk_mut::<4>() {
        (start[0], start[2], start[3]) = (0xf1, sensor[0], sensor[1]);
    }
    let mut digest = CRC.digest();
    digest.update(&datagram);
    digest.update(&sensor);
    datagram.extend(digest.finalize().to_le_bytes());
    datagram
}

fuzz_target!(|data: &[u8]| {
    let grids = [hdl64e::GRID, velodyne::VLP16.grid()];
    let limits = StreamLimits { open_turns: 2, turns_over: 3, streams: 2 };
    let mut decoder = StreamDecoder::new(limits);
    for grid in &grids {
        decoder.know(grid).expect("a grid");
    }
    let mut rest = data;
    while let Some((&len, after)) = rest.split_first_chunk::<2>() {
        let len = u16::from_le_bytes(len);
        let (bytes, after) = after.split_at(usize::from(len & 0x0fff).min(after.len()));
        rest = after;
        let grid = &grids[usize::from(len >> 12 & 1)];
        let datagram = if len & 0x8000 == 0 { bytes.to_vec() } else { seal(bytes.to_vec(), grid) };
        if let Ok(strip) = decoder.push(&datagram) {
            let columns = strip.columns().count();
            assert!(columns <= 8192 && strip.returns() <= columns * strip.rows());
            assert_eq!(strip.points().len(), strip.returns());
        }
        if len & 0x4000 != 0 {
            while let Some(turn) = decoder.next_turn() {
                assert!(turn.points().len() <= 128 * 8192);
            }
        }
    }
    decoder.flush();
    let mut turns = 0;
    while let Some(turn) = decoder.next_turn() {
        turns += 1;
        assert_eq!(turn.points().len(), turn.strips().iter().map(|strip| strip.returns()).sum::<usize>());
    }
    assert!(turns <= limits.turns_over);
});
