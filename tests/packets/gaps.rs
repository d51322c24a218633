//! Lost, late, doubled packets: what is missing is marked, what is there stays where it was.

use crate::models::MODELS;
use crate::stream::{Placed, Stream};
use crate::writer::{self, Plan};
use flicr::packet::{GapCause, Model, OusterFormat, OusterProfile, PacketError, ReturnPolicy, Sensor};
use proptest::prelude::*;

fn decode(packets: &[Vec<u8>]) -> Stream {
    Stream::of(packets, Sensor::Auto, ReturnPolicy::Both)
}

/// Everything but the number of the return: its turn, place and value.
fn key(placed: &Placed) -> (u64, u32, u16, u8, u8, u32) {
    let Placed { turn, column, layer, beam, count, time_ns, .. } = *placed;
    (time_ns, turn, column, layer, beam, count)
}

/// The returns of `stream` are those of `whole` without the packets that are missing.
fn is_part_of(stream: &Stream, whole: &Stream) -> bool {
    let all: std::collections::HashSet<_> = whole.returns.iter().map(key).collect();
    stream.returns.iter().all(|placed| all.contains(&key(placed)))
}

#[test]
fn a_lost_packet_leaves_a_gap_of_its_size() {
    for model in MODELS {
        for dual in [false, true] {
            let plan = Plan::new(model, dual);
            let per_packet = plan.firings_a_packet() as u16;
            let packets = plan.packets(4000 / usize::from(per_packet));
            let whole = decode(&packets);
            for lost in [1, 2, 7] {
                let mut some = packets.clone();
                some.drain(30..30 + lost);
                let stream = decode(&some);
                assert_eq!(
                    stream.gaps,
                    [(0, per_packet * lost as u16, GapCause::Lost)],
                    "{model:?} dual {dual}, {lost} lost"
                );
                assert!(is_part_of(&stream, &whole), "{model:?} {dual}");
                assert_eq!(stream.turns[0].columns, 1800);
            }
        }
    }
}

#[test]
fn a_gap_over_the_cut_is_split_by_it() {
    for model in MODELS {
        let plan = Plan::new(model, false);
        let per_packet = plan.firings_a_packet();
        let packets = plan.packets(4000 / per_packet);
        let whole = decode(&packets);
        let cut = 1800 / per_packet;
        let mut some = packets.clone();
        some.drain(cut - 2..cut + 3);
        let stream = decode(&some);
        assert!(is_part_of(&stream, &whole), "{model:?}");
        let missing: u16 = stream.gaps.iter().map(|gap| gap.1).sum();
        assert_eq!(usize::from(missing), 5 * per_packet);
        assert_eq!(stream.gaps.len(), 2, "{model:?} {:?}", stream.gaps);
        assert_eq!(stream.turns[0].columns, 1800);
        assert_eq!(stream.turns[1].columns, 1800);
    }
}

#[test]
fn whole_turns_lost_are_counted() {
    for model in MODELS {
        let plan = Plan::new(model, false);
        let per_packet = plan.firings_a_packet();
        let packets = plan.packets(1800 * 6 / per_packet);
        let whole = decode(&packets);
        let mut some = packets.clone();
        // From the middle of turn 0 to the middle of turn 4.
        some.drain(900 / per_packet..8_000 / per_packet);
        let stream = decode(&some);
        assert_eq!(stream.stats.refused(), 0, "{model:?} {:?}", stream.errors);
        assert_eq!(stream.lost_turns, 3, "{model:?} {:?}", stream.gaps);
        assert!(is_part_of(&stream, &whole), "{model:?}");
    }
}

#[test]
fn doubled_and_late_packets_are_refused() {
    for model in MODELS {
        let plan = Plan::new(model, true);
        let packets = plan.packets(200);
        let mut doubled = packets.clone();
        doubled.insert(51, packets[50].clone());
        let stream = decode(&doubled);
        assert_eq!(stream.errors, [(51, PacketError::Duplicate)], "{model:?}");
        assert_eq!(stream.gaps, []);
        let mut late = packets.clone();
        late.swap(50, 51);
        let stream = decode(&late);
        assert_eq!(stream.errors, [(51, PacketError::Late)], "{model:?}");
        assert_eq!(stream.gaps.len(), 1);
        assert!(is_part_of(&stream, &decode(&packets)));
    }
}

#[test]
fn jitter_and_small_steps_back_cut_no_turn() {
    let plan = Plan { start_tick: 200, ..Plan::new(Model::Hdl32e, false) };
    let mut packets = plan.packets(450);
    for (nth, packet) in packets.iter_mut().enumerate() {
        for block in 0..12 {
            // Up to 24 ticks to either side of 20-tick steps: the azimuth runs back at times.
            let wobble = ((nth * 12 + block) * 7919 % 49) as i32 - 24;
            let at = block * 100 + 2;
            let azimuth = i32::from(u16::from_le_bytes([packet[at], packet[at + 1]]));
            let azimuth = (azimuth + wobble).rem_euclid(36_000) as u16;
            packet[at..at + 2].copy_from_slice(&azimuth.to_le_bytes());
        }
    }
    let stream = decode(&packets);
    assert_eq!(stream.stats.refused(), 0, "{:?}", stream.errors);
    assert_eq!(stream.turns.len(), 4, "{:?}", stream.turns);
    for turn in &stream.turns[1..3] {
        assert!((1797..=1803).contains(&turn.columns), "{turn:?}");
    }
    assert_eq!(stream.stats.lost_columns, 0, "{:?}", stream.gaps);
}

#[test]
fn a_restarted_sensor_costs_one_packet() {
    for model in MODELS {
        let before = Plan::new(model, false).packets(40);
        let restart = Plan { start_tick: 20_000, ..Plan::new(model, false) };
        let after = restart.packets(40);
        let packets: Vec<_> = before.into_iter().chain(after).collect();
        let stream = decode(&packets);
        assert_eq!(stream.errors.len(), 1, "{model:?} {:?}", stream.errors);
        assert_eq!(stream.errors[0].0, 40);
        assert_eq!(stream.stats.used, 79);
    }
}

#[test]
fn ouster_losses_are_marked() {
    let format = OusterFormat::new(OusterProfile::LowRate, 32, 512);
    let packets: Vec<Vec<u8>> =
        (0..6).flat_map(|frame| (0..512).step_by(16).map(move |id| writer::ouster(&format, frame, id))).collect();
    let decode = |packets: &[Vec<u8>]| Stream::of(packets, Sensor::Ouster(format), ReturnPolicy::Both);
    let whole = decode(&packets);
    let mut some = packets.clone();
    // Over the end of frame 3, all of frame 1, and one packet amid frame 0.
    some.drain(32 * 4 - 1..32 * 4 + 2);
    some.drain(32..64);
    some.remove(5);
    let stream = decode(&some);
    assert_eq!(stream.stats.refused(), 0, "{:?}", stream.errors);
    assert_eq!(stream.gaps, [(0, 16, GapCause::Lost), (3, 16, GapCause::Lost), (4, 32, GapCause::Lost)]);
    assert_eq!(stream.lost_turns, 1);
    assert!(is_part_of(&stream, &whole));
    let mut late = packets.clone();
    late.swap(40, 41);
    late.insert(50, packets[49].clone());
    let stream = decode(&late);
    assert_eq!(stream.errors, [(41, PacketError::Late), (50, PacketError::Duplicate)]);
}

#[test]
fn ouster_window_is_blind_not_lost() {
    let format = OusterFormat { window: [128, 383], ..OusterFormat::new(OusterProfile::Single, 32, 512) };
    let packets: Vec<Vec<u8>> =
        (0..4).flat_map(|frame| (128..384).step_by(16).map(move |id| writer::ouster(&format, frame, id))).collect();
    let stream = Stream::of(&packets, Sensor::Ouster(format), ReturnPolicy::Strongest);
    assert_eq!(stream.stats.refused(), 0, "{:?}", stream.errors);
    assert_eq!(stream.stats.lost_columns, 0);
    assert_eq!(stream.stats.blind_columns, 128 * 7);
    assert!(stream.turns[..3].iter().all(|turn| turn.columns == 512));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever is lost, what arrives stands where it stood.
    #[test]
    fn any_loss_moves_nothing(
        model in prop::sample::select(&MODELS[..]),
        dual: bool,
        step in 8u32..20,
        seed: u64,
        loss in 1u64..60,
    ) {
        let plan = Plan { step: step * 2, ..Plan::new(model, dual) };
        let packets = plan.packets(4000 / plan.firings_a_packet());
        let mut state = seed | 1;
        let mut keep = |nth: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            nth < 4 || (state >> 33) % 100 >= loss
        };
        let some: Vec<Vec<u8>> = packets
            .iter()
            .enumerate()
            .filter(|&(nth, _)| keep(nth))
            .map(|(_, packet)| packet.clone())
            .collect();
        let (stream, whole) = (decode(&some), decode(&packets));
        prop_assert_eq!(stream.stats.refused(), 0);
        prop_assert!(is_part_of(&stream, &whole));
        let columns = u64::from(stream.stats.columns + stream.stats.lost_columns);
        prop_assert!(columns <= u64::from(whole.stats.columns));
    }
}
