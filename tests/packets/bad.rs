//! Bad packets: refused with a reason, counted, and the neighbours stay as they were.

use crate::bench::{AFTER, BEFORE, BOTH, Bench};
use crate::models::MODELS;
use crate::writer::{self, Plan};
use flicr::packet::{Event, Model, OusterFormat, OusterProfile, PacketError, Sensor, TurnAssembler};
use proptest::prelude::*;

fn ouster_format(profile: OusterProfile) -> OusterFormat {
    OusterFormat::new(profile, 16, 512)
}

fn ouster_packets(format: &OusterFormat, first: u16) -> Vec<Vec<u8>> {
    let packets = (0..(BEFORE + 1 + AFTER) as u16).map(|nth| first + nth * 16);
    packets.map(|at| writer::ouster(format, at / 512, at % 512)).collect()
}

/// Every format, amid a turn and with the bad packet around the cut.
fn benches() -> Vec<(String, Bench)> {
    let mut benches = Vec::new();
    for model in MODELS {
        for dual in [false, true] {
            let plan = Plan::new(model, dual);
            let firings = plan.firings_a_packet() as u32 * plan.step;
            for start_tick in [3_000, 36_000 - 4 * firings - firings / 2 / 20 * 20] {
                let plan = Plan { start_tick, ..plan };
                let packets = plan.packets(BEFORE + 1 + AFTER);
                let name = format!("{model:?} dual {dual} from {start_tick}");
                benches.push((name, Bench::new(packets, Sensor::Auto)));
            }
        }
    }
    for profile in [OusterProfile::Legacy, OusterProfile::Single, OusterProfile::Dual, OusterProfile::LowRate] {
        let format = ouster_format(profile);
        for first in [64, 512 - 64] {
            let packets = ouster_packets(&format, first);
            let name = format!("{profile:?} from {first}");
            benches.push((name, Bench::new(packets, Sensor::Ouster(format))));
        }
    }
    benches
}

#[test]
fn every_truncation_is_refused() {
    for (name, bench) in benches() {
        let good = &bench.packets[bench.bad_at];
        for len in 0..good.len() {
            let refused = bench.check(&good[..len]);
            // Pandar64 may do without its sequence number.
            assert!(refused.is_err() || len == 1194, "{name}, {len} bytes");
        }
        let mut long = good.clone();
        for _ in 0..8 {
            long.push(0);
            let outcome = bench.check(&long);
            // Pandar40P may be four bytes longer: its sequence number.
            assert!(outcome.is_err() || long.len() == 1266, "{name}, {} bytes", long.len());
        }
    }
}

#[test]
fn every_flipped_bit_leaves_the_neighbours_alone() {
    for (name, bench) in benches() {
        println!("{name}");
        let good = bench.packets[bench.bad_at].clone();
        let refused = (0..good.len() * 8)
            .filter(|bit| {
                let mut bad = good.clone();
                bad[bit / 8] ^= 1 << (bit % 8);
                bench.check(&bad).is_err()
            })
            .count();
        assert!(refused > 0, "{name}");
    }
}

#[test]
fn other_sensors_packets_are_refused() {
    for (name, bench) in benches() {
        for model in MODELS {
            let packet = Plan::new(model, false).packet(3);
            if packet.len() == bench.packets[0].len() && name.starts_with(&format!("{model:?} ")) {
                continue;
            }
            let refused = bench.check(&packet);
            assert!(
                matches!(refused, Err(PacketError::Model { .. } | PacketError::Length { .. })),
                "{name} {model:?} {refused:?}"
            );
        }
    }
}

#[test]
fn wrong_azimuths_are_refused() {
    let plan = Plan { start_tick: 3_000, ..Plan::new(Model::Vlp32c, false) };
    let bench = Bench::new(plan.packets(BEFORE + 1 + AFTER), Sensor::Auto);
    let good = bench.packets[bench.bad_at].clone();
    for block in 0..12 {
        for azimuth in [36_000, 40_000, u16::MAX, 12_345, 30_000] {
            let mut bad = good.clone();
            bad[block * 100 + 2..block * 100 + 4].copy_from_slice(&u16::to_le_bytes(azimuth));
            let outcome = bench.check(&bad);
            assert!(
                matches!(outcome, Err(PacketError::Azimuth { .. } | PacketError::Discontinuity { .. })),
                "block {block} {azimuth} {outcome:?}"
            );
        }
    }
}

#[test]
fn errors_name_what_was_wrong() {
    let plan = Plan::new(Model::Vlp16, false);
    let mut assembler = TurnAssembler::new(Sensor::Auto, BOTH);
    let mut refuse = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut packet = plan.packet(0);
        change(&mut packet);
        assembler.push(&packet, |_| panic!("used")).expect_err("a bad packet")
    };
    let length = PacketError::Length { found: 1205, expected: 0 };
    assert_eq!(refuse(&|p| p.truncate(1205)), length);
    let marker = PacketError::Marker { at: 300, found: 0xee00, expected: 0xeeff };
    assert_eq!(refuse(&|p| p[300] = 0), marker);
    let model = PacketError::Model { found: 0x31, expected: 0 };
    assert_eq!(refuse(&|p| p[1205] = 0x31), model);
    assert_eq!(refuse(&|p| p[1204] = 0x40), PacketError::ReturnMode { found: 0x40 });
    let azimuth = PacketError::Azimuth { block: 0, found: 36_000, expected: 36_000 };
    assert_eq!(refuse(&|p| p[2..4].copy_from_slice(&36_000u16.to_le_bytes())), azimuth);
    let stats = assembler.stats();
    let counted = (stats.wrong_length, stats.damaged, stats.wrong_model, stats.wrong_azimuth);
    assert_eq!(counted, (1, 2, 1, 1));
    assert_eq!(stats.refused(), 5);
}

#[test]
fn ouster_checksum_is_checked_on_request() {
    const XZ: crc::Crc<u64> = crc::Crc::<u64>::new(&crc::CRC_64_XZ);
    let format = OusterFormat { check_crc: true, ..ouster_format(OusterProfile::Dual) };
    let mut packet = writer::ouster(&format, 1, 0);
    let body = packet.len() - 8;
    let sum = XZ.checksum(&packet[..body]);
    packet[body..].copy_from_slice(&sum.to_le_bytes());
    let push = |packet: &[u8]| TurnAssembler::new(Sensor::Ouster(format), BOTH).push(packet, |_| {});
    assert_eq!(push(&packet), Ok(()));
    for at in [0, 100, body - 1, body, body + 7] {
        let mut bad = packet.clone();
        bad[at] ^= 0x10;
        assert!(push(&bad).is_err(), "byte {at}");
    }
}

fn any_sensor() -> impl Strategy<Value = Sensor> {
    prop_oneof![
        Just(Sensor::Auto),
        Just(Sensor::Ouster(ouster_format(OusterProfile::Dual))),
        Just(Sensor::Ouster(ouster_format(OusterProfile::Legacy))),
        (any::<u8>(), any::<u8>(), any::<u16>(), any::<[u16; 2]>(), any::<bool>()).prop_map(
            |(rows, columns_per_packet, columns_per_frame, window, check_crc)| {
                Sensor::Ouster(OusterFormat {
                    columns_per_packet,
                    window,
                    check_crc,
                    ..OusterFormat::new(OusterProfile::LowRate, rows, columns_per_frame)
                })
            }
        ),
    ]
}

/// Everything a caller may read of an event.
fn read(event: Event<'_>) {
    if let Event::Column(column) = event {
        let mut counts = [0; 128];
        column.counts(&mut counts);
        column.for_each_return(|r| {
            assert!(r.count > 0);
            assert!(usize::from(r.beam) < column.rows());
        });
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn random_bytes_never_panic(
        sensor in any_sensor(),
        packets in prop::collection::vec(
            prop_oneof![
                prop::collection::vec(any::<u8>(), 0..64),
                prop::sample::select(vec![1080usize, 1194, 1198, 1206, 1262, 1266]).prop_flat_map(|len| {
                    prop::collection::vec(any::<u8>(), len)
                }),
            ],
            0..8,
        ),
    ) {
        let mut assembler = TurnAssembler::new(sensor, BOTH);
        for packet in &packets {
            let _ = assembler.push(packet, read);
        }
        assembler.finish(read);
    }

    /// Good frames around random times, azimuths and cells, in any order.
    #[test]
    fn scrambled_streams_never_panic(
        model in prop::sample::select(&MODELS[..]),
        dual: bool,
        order in prop::collection::vec(0usize..400, 1..60),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0u8..8), 0..20),
        step in 0u32..60,
    ) {
        let plan = Plan { step: step * 2, ..Plan::new(model, dual) };
        let mut packets: Vec<Vec<u8>> = order.iter().map(|&nth| plan.packet(nth)).collect();
        for (at, bit) in flips {
            let count = packets.len();
            let packet = &mut packets[at.index(count)];
            let byte = at.index(packet.len());
            packet[byte] ^= 1 << bit;
        }
        let mut assembler = TurnAssembler::new(Sensor::Auto, BOTH);
        for packet in &packets {
            let _ = assembler.push(packet, read);
        }
        assembler.finish(read);
        let stats = assembler.stats();
        prop_assert_eq!((stats.used + stats.refused()) as usize, packets.len());
    }
}

#[test]
fn a_clock_that_leaps_by_half_its_range_is_refused() {
    for profile in [OusterProfile::Legacy, OusterProfile::Single, OusterProfile::Dual, OusterProfile::LowRate] {
        let format = ouster_format(profile);
        let at_time = |first_id: u16, time_ns: u64| {
            let mut packet = writer::ouster(&format, 0, first_id);
            let head = if profile == OusterProfile::Legacy { 0 } else { 64 };
            let column_len = (packet.len() - head) / 16;
            packet[head / 2..].chunks_exact_mut(column_len).for_each(|column| {
                column[..8].copy_from_slice(&time_ns.to_le_bytes());
            });
            packet
        };
        for leap_ns in [1 << 63, (1 << 63) - 1, (1 << 63) + 1] {
            let mut assembler = TurnAssembler::new(Sensor::Ouster(format), BOTH);
            assert_eq!(assembler.push(&at_time(0, leap_ns), |_| ()), Ok(()));
            // A packet is missing between them, so that the time is asked.
            let refused = assembler.push(&at_time(32, 0), |_| panic!("nothing of it is used"));
            assert_eq!(refused, Err(PacketError::Discontinuity { found: 32, expected: 16 }), "{profile:?} {leap_ns}");
        }
    }
}
