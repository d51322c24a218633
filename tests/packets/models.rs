//! Every model, single and dual, from packets written by an independent writer.

use crate::stream::{Placed, Stream};
use crate::writer::{self, Echo, Plan};
use flicr::packet::{GapCause, Model, OusterFormat, OusterProfile, ReturnPolicy, Sensor, TurnCut};

pub const MODELS: [Model; 8] = [
    Model::Vlp16,
    Model::PuckHiRes,
    Model::Vlp32c,
    Model::Hdl32e,
    Model::Vls128,
    Model::Pandar40p,
    Model::Pandar64,
    Model::PandarXt32,
];

/// Rows by the manuals' wording, not by the crate's tables.
fn row(model: Model, channel: usize) -> usize {
    match model {
        // Even channels look down from the lowest up, odd ones up from the middle.
        Model::Vlp16 | Model::PuckHiRes if channel.is_multiple_of(2) => 15 - channel / 2,
        Model::Vlp16 | Model::PuckHiRes => 7 - channel / 2,
        Model::Hdl32e if channel.is_multiple_of(2) => 31 - channel / 2,
        Model::Hdl32e => 15 - channel / 2,
        Model::Pandar40p | Model::Pandar64 | Model::PandarXt32 => channel,
        // No rule: by elevation.
        _ => {
            let elevations = model.facts().elevation_mdeg;
            elevations.iter().filter(|&&other| other > elevations[channel]).count()
        }
    }
}

/// The layers that a policy makes of (last, strongest or second strongest).
fn layers([last, other]: [Echo; 2], dual: bool, policy: ReturnPolicy) -> Vec<Echo> {
    if !dual {
        return vec![last];
    }
    let strongest = if other.1 > last.1 { other } else { last };
    let rest = if other.1 > last.1 { last } else { other };
    match policy {
        ReturnPolicy::Strongest => vec![strongest],
        ReturnPolicy::Last => vec![last],
        ReturnPolicy::Both if rest.0 == strongest.0 => vec![strongest, (0, 0)],
        ReturnPolicy::Both => vec![strongest, rest],
    }
}

/// What must come out of the first `firings` of a plan that starts at tick 0.
fn expected(plan: &Plan, firings: usize, policy: ReturnPolicy) -> Vec<(u32, u16, u8, u8, Echo)> {
    let per_turn = 36_000 / plan.step as usize;
    let mut all = Vec::new();
    for firing in 0..firings {
        for channel in 0..plan.channels() {
            let layers = layers(Plan::echoes(firing, channel), plan.dual, policy);
            for (layer, echo) in layers.into_iter().enumerate().filter(|(_, echo)| echo.0 != 0) {
                all.push((
                    (firing / per_turn) as u32,
                    (firing % per_turn) as u16,
                    layer as u8,
                    row(plan.model, channel) as u8,
                    echo,
                ));
            }
        }
    }
    all.sort_unstable();
    all
}

fn found(returns: &[Placed]) -> Vec<(u32, u16, u8, u8, Echo)> {
    let mut all: Vec<_> = returns
        .iter()
        .map(|ours| {
            let echo = (ours.count as u16, ours.intensity as u8);
            (ours.turn, ours.column, ours.layer, ours.beam, echo)
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn every_model_gives_what_was_written() {
    for model in MODELS {
        for dual in [false, true] {
            let plan = Plan::new(model, dual);
            // Two and a half turns.
            let packets = plan.packets(4500 / plan.firings_a_packet());
            let firings = packets.len() * plan.firings_a_packet();
            for policy in [ReturnPolicy::Strongest, ReturnPolicy::Last, ReturnPolicy::Both] {
                let stream = Stream::of(&packets, Sensor::Auto, policy);
                assert_eq!(stream.stats.refused(), 0, "{model:?} {dual} {:?}", stream.errors);
                assert_eq!(stream.gaps, []);
                assert!(found(&stream.returns) == expected(&plan, firings, policy), "{model:?} {dual}");
                assert_eq!(stream.turns.len(), 3);
                assert_eq!((stream.turns[0].columns, stream.turns[1].columns), (1800, 1800));
                for ours in &stream.returns {
                    let firing = ours.turn as usize * 1800 + usize::from(ours.column);
                    assert_eq!(ours.tick, plan.tick(firing));
                    check_time(&plan, ours, firing);
                }
            }
        }
    }
}

/// Velodyne counts from the hour, Hesai from 1970; both tell microseconds.
fn check_time(plan: &Plan, ours: &Placed, firing: usize) {
    // 2021-05-06 07:08:09.
    const START_S: u64 = 1_620_284_889;
    let start_ns = match plan.model {
        Model::Pandar40p | Model::Pandar64 | Model::PandarXt32 => START_S * 1_000_000_000,
        _ => 0,
    };
    // The XT32's packets name a time that lies 3.28 us before the last firing.
    let after_ns = if plan.model == Model::PandarXt32 { 3_280 } else { 0 };
    let expected = start_ns + plan.time_ns(firing) + after_ns;
    assert!(expected.abs_diff(ours.time_ns) <= 1_000, "{plan:?} {ours:?} {expected}");
}

#[test]
fn facts_are_consistent() {
    for model in MODELS {
        let facts = model.facts();
        let mut rows = facts.beam_of_channel.to_vec();
        rows.sort_unstable();
        assert!(rows.iter().copied().eq(0..facts.rows() as u8), "{model:?}");
        assert_eq!(facts.elevation_mdeg.len(), facts.rows());
        assert_eq!(facts.azimuth_mdeg.len(), facts.rows());
        assert_eq!(facts.fire_ns.len(), facts.rows());
        let longest = facts.fire_ns.iter().map(|ns| ns.unsigned_abs()).max();
        assert!(longest < Some(facts.period_ns));
        for channel in 0..facts.rows() {
            assert_eq!(usize::from(facts.beam_of_channel[channel]), row(model, channel));
        }
    }
    assert_eq!(Model::Vls128.facts().beam_of_channel[59], 0);
    assert_eq!(Model::Vls128.facts().beam_of_channel[36], 127);
    assert_eq!(Model::Vlp32c.facts().beam_of_channel[29], 0);
}

#[test]
fn another_cut_moves_the_columns_only() {
    let plan = Plan { start_tick: 9_000, ..Plan::new(Model::Hdl32e, false) };
    let mut turns = flicr::packet::TurnAssembler::new(Sensor::Auto, ReturnPolicy::Last).with_cut(9_000);
    let mut stream = Stream::default();
    for packet in plan.packets(160) {
        turns.push(&packet, |event| stream.take(event)).expect("good packets");
    }
    assert_eq!(stream.gaps, []);
    assert_eq!(stream.returns[0].column, 0);
    assert_eq!(stream.returns[0].tick, 9_000);
    assert_eq!(stream.turns[0].columns, 1800);
}

#[test]
fn a_stream_that_starts_amid_a_turn_says_so() {
    let plan = Plan { start_tick: 9_000, ..Plan::new(Model::Vlp32c, false) };
    let stream = Stream::of(&plan.packets(10), Sensor::Auto, ReturnPolicy::Last);
    assert_eq!(stream.gaps, [(0, 450, GapCause::Start)]);
    assert_eq!(stream.returns[0].column, 450);
    assert_eq!(stream.turns[0].end, TurnCut::Finish);
    assert_eq!(stream.stats.lost_columns, 0);
}

#[test]
fn a_sensor_that_does_not_turn_cannot_fill_memory() {
    let plan = Plan { step: 0, ..Plan::new(Model::Hdl32e, false) };
    let stream = Stream::of(&plan.packets(1500), Sensor::Auto, ReturnPolicy::Last);
    assert!(stream.turns.iter().all(|turn| turn.columns <= flicr::packet::MAX_COLUMNS));
    assert_eq!(stream.turns[0].end, TurnCut::Overflow);
}

#[test]
fn ouster_profiles_give_what_was_written() {
    for profile in [OusterProfile::Legacy, OusterProfile::Single, OusterProfile::Dual, OusterProfile::LowRate] {
        let format = OusterFormat::new(profile, 64, 512);
        let packets: Vec<Vec<u8>> =
            (0..3).flat_map(|frame| (0..512).step_by(16).map(move |id| writer::ouster(&format, frame, id))).collect();
        let stream = Stream::of(&packets, Sensor::Ouster(format), ReturnPolicy::Both);
        assert_eq!(stream.stats.refused(), 0, "{profile:?} {:?}", stream.errors);
        assert_eq!(stream.gaps, []);
        let mut expected = Vec::new();
        for (frame, id) in (0..3u16).flat_map(|frame| (0..512u16).map(move |id| (frame, id))) {
            for row in 0..64 {
                let [first, second] = writer::ouster_echoes(frame, id, row);
                expected.push((u32::from(frame), id, 0, row as u8, first));
                if profile == OusterProfile::Dual {
                    expected.push((u32::from(frame), id, 1, row as u8, second));
                }
            }
        }
        expected.retain(|entry| entry.4.0 != 0);
        expected.sort_unstable();
        let mut found: Vec<_> =
            stream.returns.iter().map(|r| (r.turn, r.column, r.layer, r.beam, (r.count, r.intensity as u8))).collect();
        found.sort_unstable();
        assert!(found == expected, "{profile:?}");
        assert_eq!(stream.turns.len(), 3);
        assert!(stream.turns.iter().all(|turn| turn.columns == 512));
    }
}
