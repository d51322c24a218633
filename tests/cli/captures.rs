//! Captures: a frame for every whole turn of every model, nothing lost; what is damaged is counted and named.

use flicr::packet::{Model, OusterFormat, OusterProfile};

use super::capture_writer::{all_frames, pcap, pcapng};
use super::packet_writer::{self, Plan};
use super::run::{Place, objects, points};

/// Ticks from firing to firing, and firings a turn.
const STEP: usize = 20;
const PER_TURN: usize = 36_000 / STEP;
/// The first firing of the first whole turn.
const FIRST_WHOLE: usize = PER_TURN / 4;
const PORT: u16 = 2368;

/// Two whole turns between a cut one and another.
fn plan(model: Model, dual: bool) -> Plan {
    Plan { start_tick: 27_000, ..Plan::new(model, dual) }
}

fn packets(plan: &Plan) -> Vec<Vec<u8>> {
    plan.packets((FIRST_WHOLE + 2 * PER_TURN + PER_TURN / 3).div_ceil(plan.firings_a_packet()))
}

fn capture(packets: &[Vec<u8>]) -> Vec<u8> {
    pcap(&all_frames(packets.iter().map(|packet| (PORT, packet.as_slice()))))
}

/// Returns of a whole turn; of two, either is one.
fn returns(plan: &Plan, turn: usize) -> usize {
    let firings = FIRST_WHOLE + turn * PER_TURN..FIRST_WHOLE + (turn + 1) * PER_TURN;
    let cells = firings.flat_map(|firing| (0..plan.channels()).map(move |channel| Plan::echoes(firing, channel)[0]));
    cells.filter(|last| last.0 != 0).count()
}

#[test]
fn another_sensor_than_the_packets_is_not_taken_in_silence() {
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    place.write("c.pcap", &capture(&packets(&plan)));
    let (_, notes) = place.noted(&["encode", "c.pcap", "-o", "c.flicr", "--sensor", "hdl64e"]);
    assert!(notes.contains("the packets are VLP-16's: --sensor (HDL-64E (KITTI)) is not used"), "{notes}");
    let (_, notes) = place.noted(&["encode", "c.pcap", "-o", "c.flicr", "--sensor", "vlp16"]);
    assert!(!notes.contains("not used"), "{notes}");
    let wrong = place.fails(1, &["encode", "c.pcap", "-o", "c.flicr", "--preset", "uniform", "--step", "native"]);
    assert!(wrong.contains("expected meters (--preset)"), "{wrong}");
}

#[test]
fn every_model_gives_a_frame_a_turn_and_loses_nothing() {
    let models = [
        (Model::Vlp16, "VLP-16"),
        (Model::Vlp32c, "VLP-32C"),
        (Model::Hdl32e, "HDL-32E"),
        (Model::Vls128, "VLS-128"),
        (Model::Pandar40p, "Pandar40P"),
        (Model::Pandar64, "Pandar64"),
        (Model::PandarXt32, "PandarXT-32"),
    ];
    for (model, name) in models {
        for dual in [false, true] {
            let (place, plan) = (Place::new(), plan(model, dual));
            place.write("c.pcap", &capture(&packets(&plan)));
            let (lines, notes) = place.noted(&["encode", "c.pcap", "-o", "c.flicr", "--step", "native"]);
            assert!(notes.contains(&format!("{name}, firings: the packets are {name}'s")), "{notes}");
            assert_eq!(lines.lines().count(), 2, "{name}: {lines}");
            let infos = objects(&place.fine(&["info", "c.flicr", "--json"]));
            assert_eq!(infos.len(), 2);
            for (turn, info) in infos.iter().enumerate() {
                let number = |field: &str| info[field].as_u64().unwrap() as usize;
                let expected = returns(&plan, turn);
                assert_eq!(
                    (number("returns"), number("kept")),
                    (expected, expected),
                    "{name} turn {turn}, dual {dual}"
                );
                assert_eq!((number("rows"), number("columns")), (plan.channels(), PER_TURN));
                let firing = FIRST_WHOLE + turn * PER_TURN;
                assert!(number("timestamp_ns").abs_diff(plan.time_ns(firing) as usize) < 2000 || is_hesai(model));
            }
        }
    }
}

/// Their clocks count from 1970.
fn is_hesai(model: Model) -> bool {
    matches!(model, Model::Pandar40p | Model::Pandar64 | Model::PandarXt32)
}

#[test]
fn decoded_turns_are_the_packets_ranges() {
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    place.write("c.pcap", &capture(&packets(&plan)));
    place.fine(&["encode", "c.pcap", "-o", "c.flicr", "--step", "native", "--turn", "1"]);
    place.fine(&["decode", "c.flicr", "-o", "c.bin"]);
    let firings = FIRST_WHOLE + PER_TURN..FIRST_WHOLE + 2 * PER_TURN;
    let mut counts: Vec<u32> = firings
        .flat_map(|firing| (0..16).map(move |channel| u32::from(Plan::echoes(firing, channel)[0].0)))
        .filter(|&count| count > 0)
        .collect();
    // A range is counted from a lens 42 mm before the axis, and a beam is at most 11 mm higher there.
    let range_mm = |[x, y, z, _]: &[f32; 4]| f64::from((x * x + y * y + z * z).sqrt()) * 1000.0;
    let mut ranges_mm: Vec<f64> = points(&place.read("c.bin")).iter().map(range_mm).collect();
    counts.sort_unstable();
    ranges_mm.sort_by(f64::total_cmp);
    assert_eq!(counts.len(), ranges_mm.len());
    for (count, range_mm) in counts.iter().zip(&ranges_mm) {
        assert!((f64::from(2 * count) - range_mm).abs() < 12.0, "{count} {range_mm}");
    }
}

#[test]
fn eval_view_and_info_take_captures() {
    let (place, plan) = (Place::new(), plan(Model::PandarXt32, true));
    place.write("c.pcap", &capture(&packets(&plan)));
    let measured = objects(&place.fine(&["eval", "c.pcap", "--json", "--step", "native", "--columns", "native,900"]));
    assert_eq!(measured.len(), 4);
    for (nth, object) in measured.iter().enumerate() {
        assert_eq!(object["file"], format!("c.pcap turn {}", nth / 2));
        let is_native = nth % 2 == 0;
        assert_eq!(object["geometry"], if is_native { "firings" } else { "even-columns" });
        assert_eq!(object["sensor"], "PandarXT-32");
        let (lost, farthest_m) = (object["se"].as_f64().unwrap(), object["max_error_m"].as_f64().unwrap());
        assert!(if is_native { lost == 0.0 && farthest_m < 1e-4 } else { lost > 0.3 }, "{lost} {farthest_m}");
    }
    let uniform = objects(&place.fine(&["eval", "c.pcap", "--json", "--preset", "uniform", "--turn", "1"]));
    assert_eq!((uniform.len(), &uniform[0]["geometry"]), (1, &"uniform".into()));
    place.fine(&["view", "c.pcap", "-o", "c.png", "--turn", "1"]);
    let [info] = objects(&place.fine(&["info", "c.pcap", "--json"])).try_into().unwrap();
    assert_eq!((&info["sensor"], &info["refused"]), (&"PandarXT-32".into(), &0.into()));
    let turns: Vec<_> = info["turns"].as_array().unwrap().iter().map(|turn| turn["turn"].as_u64()).collect();
    assert_eq!(turns, [None, Some(0), Some(1), None]);
    assert!(place.fine(&["info", "c.pcap"]).contains("turn 1: 1,800 firings, 0 columns missing"));
}

#[test]
fn cut_turns_are_left_out_unless_they_are_asked_for() {
    let (place, plan) = (Place::new(), plan(Model::Vlp32c, false));
    place.write("c.pcap", &capture(&packets(&plan)));
    let lines = place.fine(&["encode", "c.pcap", "-o", "c.flicr", "--partial"]);
    assert_eq!(lines.lines().count(), 4, "{lines}");
    place.fails_with(2, &["encode", "c.pcap", "-o", "d.flicr", "--turn", "2"], "c.pcap", &["no turn 2", "found 2"]);
    place.write("short.pcap", &capture(&packets(&plan)[..10]));
    place.fails_with(1, &["encode", "short.pcap", "-o", "d.flicr"], "short.pcap", &["no whole turn", "--partial"]);
    place.fine(&["encode", "short.pcap", "-o", "short.flicr", "--partial"]);
}

#[test]
fn damaged_and_lost_packets_are_counted_and_named() {
    let (place, plan) = (Place::new(), plan(Model::Vlp32c, false));
    let mut packets = packets(&plan);
    // Of the first whole turn: a wrong flag, a length of nothing known, and a gap.
    packets[60][100] ^= 0xff;
    packets[70].truncate(900);
    packets.remove(80);
    place.write("bad.pcap", &capture(&packets));
    let (lines, notes) = place.noted(&["encode", "bad.pcap", "-o", "bad.flicr", "--step", "native"]);
    assert_eq!(lines.lines().count(), 2);
    for words in ["2 refused", "1 of another length", "1 damaged", "marker", "36 columns lost"] {
        assert!(notes.contains(words), "no {words:?} in {notes}");
    }
    let kept = |nth: usize, place: &Place| objects(&place.fine(&["info", "bad.flicr", "--json"]))[nth]["kept"].clone();
    let lost: usize = [60, 70, 80].iter().map(|packet| returns_of_packet(&plan, *packet)).sum();
    assert_eq!(kept(0, &place), returns(&plan, 0) - lost);
    assert_eq!(kept(1, &place), returns(&plan, 1));
    let [info] = objects(&place.fine(&["info", "bad.pcap", "--json"])).try_into().unwrap();
    assert_eq!((&info["refused"], &info["lost_columns"]), (&2.into(), &36.into()));
    let text = place.fine(&["info", "bad.pcap"]);
    assert!(text.contains("2 refused") && text.contains("36 columns missing"), "{text}");
}

fn returns_of_packet(plan: &Plan, packet: usize) -> usize {
    let firings = packet * plan.firings_a_packet()..(packet + 1) * plan.firings_a_packet();
    let cells = firings.flat_map(|firing| (0..plan.channels()).map(move |channel| Plan::echoes(firing, channel)[0]));
    cells.filter(|last| last.0 != 0).count()
}

#[test]
fn what_else_went_over_the_network_is_passed_over() {
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    let packets = packets(&plan);
    place.write("alone.pcap", &capture(&packets));
    let mixed = packets.iter().enumerate().flat_map(|(nth, packet)| {
        let other = if nth % 10 == 5 { Some((8308, &[7; 512][..])) } else { None };
        [Some((PORT, packet.as_slice())), other].into_iter().flatten()
    });
    let mut frames = all_frames(mixed);
    // ARP, and a frame of nothing.
    frames.insert(3, [vec![0xff; 12], vec![0x08, 0x06], vec![0; 28]].concat());
    frames.insert(9, vec![1; 20]);
    place.write("mixed.pcap", &pcap(&frames));
    place.write("mixed.pcapng", &pcapng(&frames));
    let frames = ["alone.pcap", "mixed.pcap", "mixed.pcapng"].map(|name| {
        let (_, notes) = place.noted(&["encode", name, "-o", "f.flicr"]);
        assert!(!notes.contains("refused"), "{notes}");
        place.read("f.flicr")
    });
    assert!(frames[0] == frames[1] && frames[1] == frames[2]);
    let text = place.fine(&["info", "mixed.pcap"]);
    assert!(text.contains("datagrams to other ports"), "{text}");
}

#[test]
fn files_that_are_no_captures_are_bad_data() {
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    let whole = capture(&packets(&plan));
    place.fails_with(1, &["encode", "no.pcap", "-o", "a.flicr"], "no.pcap", &["No such file"]);
    for (bytes, words) in [
        (&b""[..], &["expected", "pcap"][..]),
        (b"not a capture at all, whatever its name says", &["expected", "pcap"]),
        (&whole[..24], &["no UDP packet", "expected"]),
        (&whole[..whole.len() - 5], &["at byte", "end of the file", "expected a whole block"]),
    ] {
        place.write("bad.pcap", bytes);
        for args in [&["encode", "bad.pcap", "-o", "a.flicr"][..], &["eval", "bad.pcap"], &["info", "bad.pcap"]] {
            place.fails_with(1, args, "bad.pcap", words);
        }
    }
    place.write("other.pcap", &pcap(&all_frames([(1234, &[0; 600][..]); 20])));
    let words = ["20 other packets", "no known packet has 600 bytes", "expected", "--metadata"];
    place.fails_with(1, &["encode", "other.pcap", "-o", "a.flicr"], "other.pcap", &words);
}

/// Metadata of a made-up Ouster: 32 beams a degree apart, staggered.
fn metadata(format: &OusterFormat) -> String {
    let list = |each: &dyn Fn(usize) -> f64| {
        let all: Vec<String> = (0..usize::from(format.rows)).map(|row| each(row).to_string()).collect();
        format!("[{}]", all.join(", "))
    };
    format!(
        r#"{{"prod_line": "OS-0-32", "udp_profile_lidar": "RNG19_RFL8_SIG16_NIR16",
        "data_format": {{"pixels_per_column": {}, "columns_per_frame": {}, "columns_per_packet": {},
        "column_window": [0, {}], "pixel_shift_by_row": {}}},
        "lidar_to_sensor_transform": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 38.195, 0, 0, 0, 1],
        "lidar_origin_to_beam_origin_mm": 27.67, "beam_altitude_angles": {}, "beam_azimuth_angles": {}}}"#,
        format.rows,
        format.columns_per_frame,
        format.columns_per_packet,
        format.columns_per_frame - 1,
        list(&|row| [24.0, 8.0, -8.0, -24.0][row % 4]),
        list(&|row| 15.5 - row as f64),
        list(&|row| [8.4, 2.8, -2.8, -8.4][row % 4]),
    )
}

#[test]
fn ouster_captures_need_their_metadata() {
    let place = Place::new();
    let format = OusterFormat::new(OusterProfile::Single, 32, 1024);
    let ids: Vec<(u16, u16)> = (1..3).flat_map(|frame| (0..1024).step_by(16).map(move |id| (frame, id))).collect();
    let packets: Vec<Vec<u8>> = ids.iter().map(|&(frame, id)| packet_writer::ouster(&format, frame, id)).collect();
    // Long enough to be cut up on their way.
    assert!(packets[0].len() > 2000);
    let frames = all_frames(packets.iter().map(|packet| (7502, packet.as_slice())));
    assert!(frames.len() > 2 * packets.len());
    place.write("os.pcap", &pcap(&frames));
    place.write("os.json", metadata(&format).as_bytes());
    place.fails_with(1, &["encode", "os.pcap", "-o", "a.flicr"], "os.pcap", &["other packets", "--metadata"]);
    place.write("no.json", b"{}");
    let wrong = ["encode", "os.pcap", "-o", "a.flicr", "--metadata", "no.json"];
    place.fails_with(1, &wrong, "no.json", &["udp_profile_lidar"]);
    let lines = place.fine(&["encode", "os.pcap", "-o", "os.flicr", "--metadata", "os.json", "--step", "native"]);
    assert_eq!(lines.lines().count(), 2);
    place.fine(&["encode", "os.pcap", "-o", "by-sensor.flicr", "--sensor", "os.json", "--step", "native"]);
    assert_eq!(place.read("os.flicr"), place.read("by-sensor.flicr"));
    let seen = |frame: u16| {
        let cells = (0..1024).flat_map(|id| (0..32).map(move |row| packet_writer::ouster_echoes(frame, id, row)[0]));
        cells.filter(|echo| echo.0 > 0).count()
    };
    let kept: Vec<_> =
        objects(&place.fine(&["info", "os.flicr", "--json"])).iter().map(|info| info["kept"].clone()).collect();
    assert_eq!(kept, [seen(1), seen(2)]);
    place.fine(&["info", "os.pcap", "--metadata", "os.json"]);
    // A piece that is lost takes its packet along, no other.
    place.write("gap.pcap", &pcap(&[&frames[..31], &frames[32..]].concat()));
    let (_, notes) = place.noted(&["encode", "gap.pcap", "-o", "gap.flicr", "--metadata", "os.json"]);
    assert!(notes.contains("16 columns lost"), "{notes}");
}
