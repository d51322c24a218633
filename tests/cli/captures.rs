//! Captures: a frame for every whole turn of every model, nothing lost; what is damaged is counted and named.

use flicr::packet::{Model, OusterFormat, OusterProfile};

use super::capture_writer::{all_frames, frames_from, pcap, pcapng};
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
        (&whole[..1000], &["at byte 24", "end of the file", "expected a whole block"]),
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

#[test]
fn a_capture_that_breaks_off_keeps_its_good_turns() {
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    let frames = all_frames(packets(&plan).iter().map(|packet| (PORT, packet.as_slice())).collect::<Vec<_>>());
    place.write("whole.pcap", &pcap(&frames));
    place.fine(&["encode", "whole.pcap", "-o", "whole.flicr"]);
    for (name, bytes) in [("cut.pcap", pcap(&frames)), ("cut.pcapng", pcapng(&frames))] {
        place.write(name, &bytes[..bytes.len() - 5]);
        let (lines, notes) = place.noted(&["encode", name, "-o", "cut.flicr"]);
        assert_eq!(lines.lines().count(), 2, "{lines}");
        for words in [name, "not read to its end: at byte", "the end of the file", "expected a whole block"] {
            assert!(notes.contains(words), "no {words:?} in {notes}");
        }
        assert_eq!(place.read("cut.flicr"), place.read("whole.flicr"));
        let (lines, _) = place.noted(&["info", name]);
        assert!(lines.contains("not read to its end: at byte"), "{lines}");
        assert_eq!(place.noted(&["eval", name, "--json"]).0.lines().count(), 2);
    }
    // In the middle of the second whole turn: the first is as good as ever.
    let bytes = pcap(&frames);
    place.write("half.pcap", &bytes[..bytes.len() / 2]);
    place.noted(&["encode", "half.pcap", "-o", "half.flicr"]);
    assert!(place.read("whole.flicr").starts_with(&place.read("half.flicr")));
}

#[test]
fn two_sensors_on_one_port_are_never_mixed() {
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    // The other one turns elsewhere at the same time.
    let other = Plan { start_tick: 9_000, step: 24, ..plan };
    let mut streams: [Vec<Vec<u8>>; 2] = [Vec::new(), Vec::new()];
    let mut both = Vec::new();
    for (nth, (one, two)) in packets(&plan).iter().zip(packets(&other)).enumerate() {
        let [one, two] =
            [(201, one.as_slice()), (77, &two)].map(|(host, packet)| frames_from(host, PORT, packet, nth as u16));
        streams[0].extend(one.clone());
        streams[1].extend(two.clone());
        both.extend([one, two].concat());
    }
    place.write("one.pcap", &pcap(&streams[0]));
    place.write("two.pcap", &pcap(&streams[1]));
    place.write("both.pcap", &pcap(&both));
    for (alone, source, other) in [("one.pcap", None, 77), ("one.pcap", Some(201), 77), ("two.pcap", Some(77), 201)] {
        place.fine(&["encode", alone, "-o", "alone.flicr"]);
        let source = source.map(|host| format!("192.168.1.{host}"));
        let chosen = source.iter().flat_map(|source| ["--source", source]);
        let args: Vec<&str> = ["encode", "both.pcap", "-o", "both.flicr"].into_iter().chain(chosen).collect();
        let (_, notes) = place.noted(&args);
        assert!(notes.contains(&format!("to the same port from 192.168.1.{other}")), "{notes}");
        assert!(notes.contains("not used (--source") && !notes.contains("refused"), "{notes}");
        assert!(place.read("both.flicr") == place.read("alone.flicr"), "{source:?}");
    }
    let wrong = ["encode", "both.pcap", "-o", "a.flicr", "--source", "10.0.0.1"];
    place.fails_with(1, &wrong, "both.pcap", &["no packet from 10.0.0.1"]);
}

/// As where a capture was made with a snap length.
#[test]
fn frames_that_are_cut_short_are_counted() {
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    let packets = packets(&plan);
    let mut frames = all_frames(packets.iter().map(|packet| (PORT, packet.as_slice())));
    frames.iter_mut().skip(40).step_by(50).take(3).for_each(|frame| frame.truncate(96));
    place.write("some.pcap", &pcap(&frames));
    let (_, notes) = place.noted(&["encode", "some.pcap", "-o", "some.flicr"]);
    let lost = 3 * plan.firings_a_packet();
    assert!(notes.contains(&format!("{lost} columns lost; 3 frames cut short or damaged: not used")), "{notes}");
    for frame in &mut frames {
        frame.truncate(96);
    }
    place.write("all.pcap", &pcap(&frames));
    let all = format!("found no UDP packet among {0} frames ({0} frames cut short", frames.len());
    place.fails_with(1, &["info", "all.pcap"], "all.pcap", &[&all]);
}

#[test]
fn both_returns_are_two_frames_a_turn() {
    for model in [Model::Vlp16, Model::PandarXt32] {
        let (place, plan) = (Place::new(), plan(model, true));
        place.write("c.pcap", &capture(&packets(&plan)));
        let frames = |returns: &str| {
            let out = format!("{returns}.flicr");
            place.fine(&["encode", "c.pcap", "-o", &out, "--returns", returns, "--step", "native"]);
            objects(&place.fine(&["info", &out, "--json"]))
        };
        let (strongest, both) = (frames("strongest"), frames("both"));
        assert_eq!((strongest.len(), both.len()), (2, 4));
        for (turn, pair) in both.chunks(2).enumerate() {
            // The first is what `strongest` gives; the second has what that leaves.
            assert_eq!(pair[0]["kept"], strongest[turn]["kept"]);
            let firings = FIRST_WHOLE + turn * PER_TURN..FIRST_WHOLE + (turn + 1) * PER_TURN;
            let cells =
                firings.flat_map(|firing| (0..plan.channels()).map(move |channel| Plan::echoes(firing, channel)));
            let others = cells.filter(|[last, strongest]| last.0 != strongest.0).count();
            assert_eq!(pair[1]["kept"], others);
            assert_eq!(pair[0]["timestamp_ns"], pair[1]["timestamp_ns"]);
        }
        let one = place.fine(&["encode", "c.pcap", "-o", "one.flicr", "--returns", "both", "--turn", "1"]);
        assert!(one.lines().count() == 2 && one.contains("turn 1, other returns"), "{one}");
    }
}

#[test]
fn frames_from_packets_say_their_sensor_and_how_near_their_points_are() {
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    place.write("c.pcap", &capture(&packets(&plan)));
    place.fine(&["encode", "c.pcap", "-o", "c.flicr", "--step", "native"]);
    for info in objects(&place.fine(&["info", "c.flicr", "--json"])) {
        let sensor = info["sensor"].as_str().unwrap();
        assert!(sensor.starts_with("VLP-16 at ") && sensor.ends_with(" turns a minute"), "{sensor}");
        // Half a count of 2 mm, and what floats do.
        let bound_m = info["point_bound_m"].as_f64().unwrap();
        assert!((0.001..0.0015).contains(&bound_m), "{bound_m}");
    }
    let coarse = ["encode", "c.pcap", "-o", "coarse.flicr", "--step", "0.5", "--turn", "0"];
    place.fine(&coarse);
    let info = &objects(&place.fine(&["info", "coarse.flicr", "--json"]))[0];
    let [point_m, range_m] = ["point_bound_m", "range_bound_m"].map(|field| info[field].as_f64().unwrap());
    assert!(range_m >= 0.25 && (range_m..1.1 * range_m).contains(&point_m), "{info:?}");
    // Between columns, points move by what depends on their range: nothing is promised.
    place.fine(&["encode", "c.pcap", "-o", "even.flicr", "--step", "native", "--columns", "900"]);
    assert!(objects(&place.fine(&["info", "even.flicr", "--json"]))[0]["point_bound_m"].is_null());
}

#[test]
fn a_sensor_file_is_applied_to_packets_like_its_own_or_refused() {
    use flicr::geometry::sensors::velodyne;
    use flicr::sensor::Sensor;
    let (place, plan) = (Place::new(), plan(Model::Vlp16, false));
    place.write("c.pcap", &capture(&packets(&plan)));
    let mut beams = velodyne::VLP16.beams_at::<16>(600).unwrap();
    for beam in &mut beams {
        beam.slope += 0.01;
    }
    let file = |name: &str, beams: &[flicr::geometry::Beam]| {
        Sensor {
            name: name.into(),
            ticks_per_turn: 36_000,
            range_unit_m: 0.002,
            beams: beams.to_vec(),
            range_from_axis: false,
        }
        .to_toml()
    };
    place.write("my.toml", file("my-vlp16", &beams).as_bytes());
    let (_, notes) =
        place.noted(&["encode", "c.pcap", "-o", "c.flicr", "--step", "native", "--sensor", "my.toml", "--turn", "0"]);
    assert!(notes.contains("my-vlp16, firings"), "{notes}");
    place.fine(&["decode", "c.flicr", "-o", "c.bin"]);
    let back = points(&place.read("c.bin"));
    // Nearer, the lens' distance from the axis counts.
    let far = back.iter().filter(|[x, y, ..]| x.hypot(*y) > 20.0);
    let highest = far.map(|[x, y, z, _]| z / x.hypot(*y)).fold(-9.0, f32::max);
    assert!((highest - (15_f32.to_radians().tan() + 0.01)).abs() < 0.003, "{highest}");
    place.write("half.toml", file("half", &beams[..8]).as_bytes());
    let args = ["encode", "c.pcap", "-o", "c2.flicr", "--sensor", "half.toml"];
    place.fails_with(
        2,
        &args,
        "c.pcap",
        &["found --sensor half (8 beams", "expected one like the packets' VLP-16 (16 beams"],
    );
}

#[test]
fn metadata_of_another_ouster_of_equal_packets_are_named() {
    let place = Place::new();
    for (profile, words) in [
        (OusterProfile::Single, "the packets are of sensor 122201000998, but the metadata of sensor 992137000142"),
        (OusterProfile::Legacy, "the packets' encoder makes 1024 columns a turn, but the metadata say 2048"),
    ] {
        let format = OusterFormat::new(profile, 32, 1024);
        let ids = (1..4).flat_map(|frame| (0..1024).step_by(16).map(move |id| (frame, id)));
        let packets: Vec<Vec<u8>> = ids
            .map(|(frame, id)| {
                let mut packet = packet_writer::ouster(&format, frame, id);
                if profile == OusterProfile::Single {
                    packet[7..12].copy_from_slice(&122_201_000_998_u64.to_le_bytes()[..5]);
                }
                packet
            })
            .collect();
        place.write("os.pcap", &pcap(&all_frames(packets.iter().map(|packet| (7502, packet.as_slice())))));
        let name = if profile == OusterProfile::Legacy { "LEGACY" } else { "RNG19_RFL8_SIG16_NIR16" };
        let json = |serial: &str, format: &OusterFormat| {
            let json = metadata(format).replace("RNG19_RFL8_SIG16_NIR16", name);
            json.replacen('{', &format!("{{\"prod_sn\": \"{serial}\", "), 1)
        };
        let wide = OusterFormat::new(profile, 32, 2048);
        let wrong = if profile == OusterProfile::Legacy { &wide } else { &format };
        place.write("right.json", json("122201000998", &format).as_bytes());
        place.write("wrong.json", json("992137000142", wrong).as_bytes());
        let encode = |metadata: &str| {
            place.noted(&["encode", "os.pcap", "-o", "a.flicr", "--partial", "--metadata", metadata]).1
        };
        assert!(!encode("right.json").contains("but the metadata"));
        let notes = encode("wrong.json");
        assert!(notes.contains(words), "{notes}");
    }
}

#[test]
fn five_floats_a_point_are_read_as_five() {
    let place = Place::new();
    let point = |nth: usize| [nth as f32 * 0.01 + 2.0, 1.5, -0.3, 17.0, (nth % 32) as f32];
    let bytes: Vec<u8> = (0..800).flat_map(point).flat_map(f32::to_le_bytes).collect();
    // Divisible by both lengths: 800 points of five floats, or 1000 of four.
    for name in ["sweep.pcd.bin", "sweep.bin", "sweep.xyzir.bin"] {
        place.write(name, &bytes);
        let info = objects(&place.fine(&["info", name, "--json"]));
        assert_eq!((&info[0]["points"], &info[0]["rings"]), (&800.into(), &true.into()), "{name}");
        let (_, notes) = place.noted(&["encode", name, "-o", "s.flicr"]);
        assert_eq!(notes.contains("read as five floats a point"), name == "sweep.bin", "{notes}");
    }
    // Four floats stay four, whatever their number.
    let bytes: Vec<u8> =
        (0..1000).flat_map(|nth| [nth as f32 * 0.01 + 2.0, 1.5, -0.3, 0.5]).flat_map(f32::to_le_bytes).collect();
    place.write("four.bin", &bytes);
    assert_eq!(objects(&place.fine(&["info", "four.bin", "--json"]))[0]["points"], 1000);
    place.write("zeros.bin", &[0; 80]);
    assert_eq!(objects(&place.fine(&["info", "zeros.bin", "--json"]))[0]["points"], 5);
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
