//! Any sequence of datagrams: no panic, and what comes out keeps its promises.
//!
//! The first byte picks the sensor; then each datagram is a u16 length and its bytes. A length of
//! 0xffff stands for the last datagram once more, with the next four bytes xored into it at a u16
//! place, so that the fuzzer gets past the frame of a packet.
#![no_main]

use flicr::packet::{Event, MAX_COLUMNS, OusterFormat, OusterProfile, ReturnPolicy, Sensor, TurnAssembler};
use libfuzzer_sys::fuzz_target;

fn sensor(pick: u8) -> Sensor {
    let profiles = [OusterProfile::Legacy, OusterProfile::Single, OusterProfile::Dual, OusterProfile::LowRate];
    match profiles.get(usize::from(pick % 8)) {
        Some(&profile) => Sensor::Ouster(OusterFormat {
            check_crc: pick & 0x80 != 0,
            columns_per_packet: 4,
            ..OusterFormat::new(profile, 16, 512)
        }),
        None => Sensor::Auto,
    }
}

fn policy(pick: u8) -> ReturnPolicy {
    match pick >> 3 & 3 {
        0 => ReturnPolicy::Strongest,
        1 => ReturnPolicy::Last,
        _ => ReturnPolicy::Both,
    }
}

fn read(event: Event<'_>) {
    match event {
        Event::Column(column) => {
            assert!(column.index < MAX_COLUMNS);
            let mut returns = 0;
            column.for_each_return(|r| {
                assert!(r.count > 0 && usize::from(r.beam) < column.rows());
                returns += 1;
            });
            assert!(returns <= column.rows());
        }
        Event::TurnEnd(turn) => assert!(turn.missing <= turn.columns),
        Event::Gap { columns, .. } => assert!(columns > 0),
        _ => {}
    }
}

fuzz_target!(|data: &[u8]| {
    let Some((&pick, mut rest)) = data.split_first() else {
        return;
    };
    let mut assembler = TurnAssembler::new(sensor(pick), policy(pick));
    let mut datagram = Vec::new();
    let mut pushed = 0;
    while let Some((&len, after)) = rest.split_first_chunk::<2>() {
        let len = usize::from(u16::from_le_bytes(len));
        rest = after;
        match (len, rest.split_first_chunk::<6>()) {
            (0xffff, Some((&[at, high, change @ ..], after))) => {
                rest = after;
                let at = usize::from(u16::from_le_bytes([at, high]));
                for (byte, change) in datagram.iter_mut().skip(at).zip(change) {
                    *byte ^= change;
                }
            }
            _ => {
                let (bytes, after) = rest.split_at(len.min(rest.len()));
                datagram = bytes.to_vec();
                rest = after;
            }
        }
        let _ = assembler.push(&datagram, read);
        pushed += 1;
    }
    assembler.finish(read);
    let stats = assembler.stats();
    assert_eq!(stats.used + stats.refused(), pushed);
});
