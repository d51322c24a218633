//! `--previous`: frames that go on from the one before.

use super::run::Place;

#[test]
fn frames_go_on_from_the_one_before_and_say_so() {
    let place = Place::new();
    // The same scan three times: a sensor and a street that stand still.
    place.fine(&["simulate", "-o", "0.bin"]);
    for name in ["1.bin", "2.bin"] {
        place.write(name, &place.read("0.bin"));
    }
    let encode = ["encode", "0.bin", "1.bin", "2.bin", "--tier", "small", "-o"];
    place.fine(&[&encode[..], &["alone.flicr"]].concat());
    place.fine(&[&encode[..], &["after.flicr", "--previous", "2"]].concat());
    let (alone, after) = (place.read("alone.flicr"), place.read("after.flicr"));
    let info = place.fine(&["info", "after.flicr"]);
    for words in ["(a key frame)", "(frame 1 since key frame 0)"] {
        assert!(info.contains(words), "{info}");
    }
    assert!(2 * (alone.len() - after.len()) > alone.len() / 3, "{} for {}", after.len(), alone.len());
    let of_frame = |bytes: &[u8], number: usize| {
        let len = |at: usize| u32::from_le_bytes(bytes[at + 8..][..4].try_into().unwrap()) as usize;
        let at = (0..number).fold(0, |at, _| at + len(at));
        bytes[at..at + len(at)].to_vec()
    };
    // The first and the third need none before them; the second does.
    for number in [0, 2] {
        place.write("one.flicr", &of_frame(&after, number));
        place.fine(&["decode", "one.flicr", "-o", "one.bin"]);
    }
    place.write("one.flicr", &of_frame(&after, 1));
    place.fails_with(1, &["decode", "one.flicr", "-o", "none.bin"], "one.flicr", &["frame before this one is missing"]);
    place.fine(&["decode", "after.flicr", "-o", "after.bin"]);
    place.fine(&["decode", "alone.flicr", "-o", "alone.bin"]);
    assert_eq!(place.read("after-000001.bin").len(), place.read("alone-000001.bin").len());
}

#[test]
fn what_cannot_go_on_is_told() {
    let place = Place::with_scan();
    let encode =
        |options: &[&'static str]| [&["encode", "scan.bin", "-o", "f.flicr", "--previous", "5"], options].concat();
    for options in [&["--tier", "fast"][..], &["--coder", "deflate"]] {
        assert!(place.fails(2, &encode(options)).contains("--previous"));
    }
    assert!(place.fails(2, &encode(&["--exact"])).contains("--exact"));
    place.fails(2, &["encode", "scan.bin", "-o", "f.flicr", "--previous", "0"]);
}
