//! `--exact`: every byte of a file comes back, or the file is refused with the reason. `--intensity` and `--timestamps`.

use super::capture_writer::{all_frames, pcap};
use super::packet_writer::Plan;
use super::run::{Place, bin, points};
use flicr::Decoder;
use flicr::packet::Model;

/// Encodes and decodes a file; gives how many times smaller the frame is.
fn comes_back(place: &Place, bytes: &[u8]) -> f64 {
    place.write("in.bin", bytes);
    place.fine(&["encode", "in.bin", "-o", "f.flicr", "--exact"]);
    place.fine(&["decode", "f.flicr", "-o", "back.bin"]);
    assert!(place.read("back.bin") == bytes, "other bytes");
    bytes.len() as f64 / place.read("f.flicr").len() as f64
}

fn refused(place: &Place, bytes: &[u8], words: &[&str]) {
    place.write("in.bin", bytes);
    let before = place.names();
    place.fails_with(1, &["encode", "in.bin", "-o", "f.flicr", "--exact"], "in.bin", words);
    assert_eq!(place.names(), before);
}

#[test]
fn a_scan_comes_back_byte_for_byte() {
    let place = Place::with_scan();
    let bytes = place.read("scan.bin");
    let ratio = comes_back(&place, &bytes);
    assert!(ratio > 9.0, "{ratio}");
    // Other formats get the points in the file's order, with their intensities.
    place.fine(&["decode", "f.flicr", "-o", "back.xyzir.bin"]);
    let first: Vec<[u8; 16]> =
        place.read("back.xyzir.bin").chunks_exact(20).map(|r| r[..16].try_into().unwrap()).collect();
    assert!(first.concat() == bytes);
}

#[test]
fn points_in_any_order_and_points_that_no_beam_has() {
    let place = Place::with_scan();
    let scan = points(&place.read("scan.bin"));
    // Column by column, nearly: by azimuth alone, begun somewhere.
    let mut turned = scan.clone();
    turned.sort_by(|a, b| a[1].atan2(a[0]).total_cmp(&b[1].atan2(b[0])));
    turned.rotate_left(5000);
    comes_back(&place, &bin(&turned));
    // No order at all.
    let mut shuffled = scan.clone();
    let mut state = 1_u32;
    for at in (1..shuffled.len()).rev() {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        shuffled.swap(at, (state >> 8) as usize % (at + 1));
    }
    comes_back(&place, &bin(&shuffled));
    // Some that are strange.
    let mut strange = scan.clone();
    strange[7] = [f32::NAN, -0.0, f32::INFINITY, 0.5];
    strange[8] = [0.0, 0.0, 0.0, 0.0];
    strange[9][2] += 0.000_1;
    strange[900][0] = 1e9;
    strange.insert(20_000, scan[20_000]);
    strange.push([0.0; 4]);
    comes_back(&place, &bin(&strange));
}

#[test]
fn what_is_not_on_a_grid_is_refused_with_the_reason() {
    let place = Place::with_scan();
    let scan = points(&place.read("scan.bin"));
    let with = |change: &dyn Fn(&mut [f32; 4])| {
        let mut scan = scan.clone();
        scan.iter_mut().for_each(change);
        bin(&scan)
    };
    refused(&place, &with(&|p| p[0] += 0.25), &["--exact", "grid"]);
    refused(&place, &with(&|p| p[2] *= 1.000_01), &["--exact", "point"]);
    refused(&place, &with(&|p| p[3] = p[0] * 0.01), &["--exact", "intensities"]);
    refused(&place, &bin(&scan)[..999], &["16"]);
    refused(&place, &[], &["--exact", "grid"]);
    comes_back(&place, &bin(&scan[..1]));
    refused(&place, &bin(&[[f32::NAN; 4]; 3]), &["--exact"]);
    place.fine(&["simulate", "-o", "rings.xyzir.bin"]);
    place.fails_with(
        1,
        &["encode", "rings.xyzir.bin", "-o", "f.flicr", "--exact"],
        "rings.xyzir.bin",
        &["four floats"],
    );
    let usage = place.fails(2, &["encode", "scan.bin", "-o", "f.flicr", "--exact", "--step", "0.02"]);
    assert!(usage.contains("--step"), "{usage}");
}

#[test]
fn intensities_are_kept_as_they_are_or_in_steps() {
    let place = Place::with_scan();
    let scan = points(&place.read("scan.bin"));
    let mut len = [0; 3];
    for (option, (error, len)) in ["lossless", "4", "16"].into_iter().zip([0.0, 0.02, 0.08].into_iter().zip(&mut len)) {
        place.fine(&["encode", "scan.bin", "-o", "f.flicr", "--step", "native", "--intensity", option]);
        place.fine(&["decode", "f.flicr", "-o", "back.bin"]);
        let back = points(&place.read("back.bin"));
        assert_eq!(back.len(), scan.len());
        // The street has far fewer intensities than points: their histograms are alike, rounding left aside.
        let sorted = |points: &[[f32; 4]]| {
            let mut all: Vec<f32> = points.iter().map(|point| point[3]).collect();
            all.sort_by(f32::total_cmp);
            all
        };
        let off = sorted(&back).iter().zip(sorted(&scan)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off <= error + 1e-6, "{option}: {off}");
        *len = place.read("f.flicr").len();
    }
    assert!(len[0] > len[1] && len[1] > len[2], "{len:?}");
    place.fails(2, &["encode", "scan.bin", "-o", "f.flicr", "--intensity", "0"]);
    place.fails_with(
        1,
        &["encode", "scan.bin", "-o", "g.flicr", "--timestamps"],
        "scan.bin",
        &["no times", "a capture"],
    );
}

#[test]
fn captures_keep_intensities_and_times() {
    let (place, plan) = (Place::new(), Plan { start_tick: 27_000, ..Plan::new(Model::Vlp16, false) });
    let (per_turn, first) = (1800, 450);
    let packets = plan.packets((first + 2 * per_turn + per_turn / 3_usize).div_ceil(plan.firings_a_packet()));
    place.write("c.pcap", &pcap(&all_frames(packets.iter().map(|packet| (2368, packet.as_slice())))));
    let encode = ["encode", "c.pcap", "--turn", "1", "--step", "native", "-o"];
    place.fine(&[&encode[..], &["plain.flicr"]].concat());
    place.fine(&[&encode[..], &["times.flicr", "--timestamps"]].concat());
    place.fine(&[&encode[..], &["lit.flicr", "--timestamps", "--intensity", "lossless"]].concat());
    let times_len = place.read("times.flicr").len() - place.read("plain.flicr").len();
    assert!(times_len < 400, "{times_len} bytes for times");
    let (bytes, mut decoder) = (place.read("lit.flicr"), Decoder::default());
    let frame = decoder.decode(&bytes).unwrap();
    let firings = first + per_turn..first + 2 * per_turn;
    let mut expected: Vec<u8> = firings
        .clone()
        .flat_map(|firing| (0..16).map(move |channel| Plan::echoes(firing, channel)[0]))
        .filter(|echo| echo.0 > 0)
        .map(|echo| echo.1)
        .collect();
    let mut found: Vec<u8> = frame.intensities().unwrap().iter().map(|&intensity| intensity as u8).collect();
    expected.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, expected);
    // The plan fires evenly; a packet's clock has whole microseconds, so that its firings are off by less than one.
    let times_ns = frame.column_times_ns().unwrap();
    assert_eq!(times_ns.len(), per_turn);
    for (time_ns, firing) in times_ns.iter().zip(firings) {
        assert!(time_ns.abs_diff(plan.time_ns(firing)) < 2000, "{time_ns} {}", plan.time_ns(firing));
    }
    assert_eq!(frame.times_ns().unwrap().len(), found.len());
}
