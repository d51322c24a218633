//! The fast tier: what goes in comes back within the bound, whatever comes in is answered, and the bytes stay the same.

use flicr::coder::fast_lab::decode;
use flicr::coder::{Coder, ContextSettings, Fast, Step};
use flicr::{ImageView, Level};
use proptest::prelude::*;

/// What a payload says of its code.
const PREFIX_LEN: usize = 6;

fn coder(step: Step) -> Box<Fast<2>> {
    Box::new(Fast::new(ContextSettings::FINE.with_step(step)))
}

const fn worst_case_len(levels_len: usize) -> usize {
    PREFIX_LEN + levels_len
}

fn encoded<L: Level>(levels: &[L], columns: usize, step: Step) -> Vec<u8> {
    let image = ImageView::new(levels, columns).unwrap();
    let mut out = vec![0; worst_case_len(size_of_val(levels))];
    let len = coder(step).encode(image, &mut out).unwrap();
    out.truncate(len);
    out
}

fn decoded<L: Level>(payload: &[u8], len: usize, columns: usize, fill: u16) -> Option<Vec<L>> {
    let mut levels = vec![L::new(fill); len];
    decode(payload, len / columns, &mut levels).ok().map(|()| levels)
}

#[track_caller]
fn check<L: Level + std::fmt::Debug>(levels: &[L], columns: usize, step: Step) -> usize {
    let payload = encoded(levels, columns, step);
    check_payload(&payload, levels, columns, step);
    payload.len()
}

#[track_caller]
fn check_payload<L: Level>(payload: &[u8], levels: &[L], columns: usize, step: Step) {
    let back = decoded::<L>(payload, levels.len(), columns, 7).expect("what was encoded decodes");
    for (there, back) in levels.iter().zip(&back).map(|(there, back)| (there.get(), back.get())) {
        assert_eq!(there == 0, back == 0);
        assert!(there.abs_diff(back) <= step.error_max(), "{there} came back as {back}, {step:?}");
    }
}

/// Surfaces that change every so often, with noise and gaps: `roughness` of 256 columns end one.
fn surfaces(rows: usize, columns: usize, roughness: u32, max: u16, seed: u32) -> Vec<u16> {
    let mut state = seed | 1;
    let mut random = move |below: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((u64::from(state) * u64::from(below)) >> 32) as u32
    };
    let mut levels = vec![0; rows * columns];
    for row in levels.chunks_mut(columns) {
        let (mut level, mut slope, mut gap) = (random(max.into()) + 1, 0, false);
        for pixel in row {
            if random(256) < roughness {
                (level, slope, gap) = (random(max.into()) + 1, random(9), random(4) == 0);
            }
            level = (level + slope + random(5)).saturating_sub(6).clamp(1, max.into());
            *pixel = if gap { 0 } else { level as u16 };
        }
    }
    levels
}

fn steps() -> impl Strategy<Value = Step> {
    let levels = prop_oneof![3 => 1_u16..200, 1 => 1_u16..];
    (levels, any::<bool>()).prop_map(|(levels, exact)| {
        if exact { Step::exact(levels) } else { Step::new(levels) }.expect("a step of one level or more")
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn surfaces_come_back_within_the_bound(
        rows in 1_usize..129, columns in 1_usize..90, roughness in 0_u32..256, step in steps(), seed: u32,
    ) {
        check(&surfaces(rows, columns, roughness, u16::MAX, seed), columns, step);
        let bytes: Vec<u8> = surfaces(rows, columns, roughness, 255, seed).iter().map(|&level| level as u8).collect();
        check(&bytes, columns, step);
    }

    #[test]
    fn noise_comes_back_and_is_no_longer_than_stored(
        (levels, columns) in (1_usize..70, 1_usize..40)
            .prop_flat_map(|(rows, columns)| (prop::collection::vec(any::<u16>(), rows * columns), Just(columns))),
        step in steps(),
    ) {
        let len = check(&levels, columns, step);
        prop_assert!(len <= worst_case_len(2 * levels.len()));
    }

    #[test]
    fn little_room_for_tokens_makes_more_blocks(columns in 1_usize..90, step in steps(), seed: u32) {
        let levels = surfaces(64, columns, 20, u16::MAX, seed);
        let mut out = vec![0; worst_case_len(2 * levels.len())];
        let image = ImageView::new(&levels, columns).unwrap();
        let len = Fast::<1, 24>::new(ContextSettings::FINE.with_step(step)).encode(image, &mut out).unwrap();
        check_payload(&out[..len], &levels, columns, step);
    }

    #[test]
    fn any_bytes_give_an_error_or_a_whole_image(
        payload in prop::collection::vec(any::<u8>(), 0..600), rows in 1_usize..129, columns in 1_usize..40,
        step in steps(),
    ) {
        let len = rows * columns;
        // Behind a prefix that is right, mostly.
        let prefix = if rows % 8 == 0 { Vec::new() } else { encoded(&[1_u16; 64], 8, step)[..PREFIX_LEN].to_vec() };
        let payload = [prefix, payload].concat();
        prop_assert_eq!(
            decoded::<u16>(&payload, len, columns, 1), decoded::<u16>(&payload, len, columns, 2)
        );
        prop_assert_eq!(
            decoded::<u8>(&payload, len, columns, 1), decoded::<u8>(&payload, len, columns, 2)
        );
    }

    #[test]
    fn damaged_payloads_give_an_error_or_a_whole_image(
        seed: u32, step in steps(), at: prop::sample::Index, bit in 0_u32..8, cut: prop::sample::Index, cuts: bool,
    ) {
        let levels = surfaces(64, 40, 20, 60_000, seed);
        let mut payload = encoded(&levels, 40, step);
        if cuts {
            payload.truncate(cut.index(payload.len()));
        } else {
            *at.get_mut(&mut payload) ^= 1 << bit;
        }
        let found = decoded::<u16>(&payload, levels.len(), 40, 1);
        prop_assert_eq!(&found, &decoded(&payload, levels.len(), 40, 2));
        prop_assert!(!cuts || found.is_none(), "a payload that is cut short is noticed");
    }
}

#[test]
fn empty_full_and_ragged_images_come_back() {
    for (rows, columns) in [(1, 1), (1, 100), (7, 3), (8, 16), (63, 17), (64, 15), (65, 33), (128, 16)] {
        for step in [1, 2, 10, 51, 157, u16::MAX].map(|levels| Step::new(levels).unwrap()) {
            check(&vec![0_u16; rows * columns], columns, step);
            check(&vec![u16::MAX; rows * columns], columns, step);
            check(&vec![1_u8; rows * columns], columns, step);
            let ragged: Vec<u16> = (0..rows * columns).map(|i| (i * i % 7 / 3 * (i % 999 + 1)) as u16).collect();
            check(&ragged, columns, step);
            let one: Vec<u16> = (0..rows * columns).map(|i| u16::from(i + 1 == rows * columns)).collect();
            check(&one, columns, step);
        }
    }
}

#[test]
fn an_empty_image_takes_two_bits_a_column() {
    let len = check(&vec![0_u16; 64 * 2000], 2000, Step::LOSSLESS);
    assert!(len < 500, "{len} bytes");
}

#[test]
fn more_rows_than_the_encoder_has_are_an_error() {
    let levels = surfaces(129, 20, 20, u16::MAX, 1);
    let image = ImageView::new(&levels, 20).unwrap();
    assert!(coder(Step::LOSSLESS).encode(image, &mut vec![0; 10_000]).is_err());
}

#[test]
fn an_output_that_is_too_small_is_an_error() {
    let levels = surfaces(64, 50, 20, u16::MAX, 1);
    let image = ImageView::new(&levels, 50).unwrap();
    let len = encoded(&levels, 50, Step::LOSSLESS).len();
    for short in [0, 1, 2, len / 2, len - 1] {
        assert!(coder(Step::LOSSLESS).encode(image, &mut vec![0; short]).is_err(), "{short} bytes");
    }
}

/// What a decoder does with levels beyond a byte never shows.
#[test]
fn levels_of_a_byte_are_not_exceeded() {
    check(&[250_u8, 255, 1, 255, 3, 254, 2, 255], 8, Step::new(58).unwrap());
}

/// A state that was used before leaves no trace.
#[test]
fn the_same_image_gives_the_same_bytes_again() {
    let (large, small) = (surfaces(128, 60, 20, u16::MAX, 1), surfaces(50, 60, 20, u16::MAX, 2));
    let step = Step::new(10).unwrap();
    let mut coder = coder(step);
    let mut out = vec![0; worst_case_len(2 * large.len())];
    coder.encode(ImageView::new(&large, 60).unwrap(), &mut out).unwrap();
    let len = coder.encode(ImageView::new(&small, 60).unwrap(), &mut out).unwrap();
    assert_eq!(out[..len], encoded(&small, 60, step));
}

/// A decoder in another language, written from `docs/FORMAT.md`.
#[test]
fn the_reference_decoder_finds_the_same_levels() {
    for (rows, columns, step, cramped) in
        [(64, 60, 1, false), (64, 60, 10, true), (40, 60, 51, false), (130, 30, 101, false), (7, 50, 157, true)]
    {
        let levels = surfaces(rows, columns, 12, 50_000, 5);
        let settings = ContextSettings::FINE.with_step(Step::new(step).unwrap());
        let (image, mut out) = (ImageView::new(&levels, columns).unwrap(), vec![0; 2 * levels.len() + PREFIX_LEN]);
        let len = if cramped {
            Fast::<3, 36>::new(settings).encode(image, &mut out)
        } else {
            Fast::<3, 1200>::new(settings).encode(image, &mut out)
        };
        out.truncate(len.unwrap());
        let mut expected = vec![0_u16; levels.len()];
        decode(&out, rows, &mut expected).unwrap();
        assert_eq!(reference(&out, rows, columns), expected, "{rows} x {columns}, step {step}");
    }
}

fn reference(payload: &[u8], rows: usize, columns: usize) -> Vec<u16> {
    let here = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let file = std::env::temp_dir().join(format!("flicr-fast-{}.payload", std::process::id()));
    std::fs::write(&file, payload).unwrap();
    let output = std::process::Command::new("python3")
        .arg(here.join("tests/reference/fast_decode.py"))
        .arg(here.join("src/coder/context/fast/priors.bin"))
        .args([file.as_os_str(), rows.to_string().as_ref(), columns.to_string().as_ref()])
        .output()
        .unwrap();
    std::fs::remove_file(&file).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout.chunks_exact(2).map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]])).collect()
}

fn checksum(payloads: impl IntoIterator<Item = Vec<u8>>) -> u32 {
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    payloads.into_iter().for_each(|payload| digest.update(&payload));
    digest.finalize()
}

/// The format: other bytes are another version of it.
#[test]
fn the_bytes_are_those_of_the_format() {
    let of = |levels: u16| {
        let step = Step::new(levels).unwrap();
        let rows = [16, 40, 64, 128].map(|rows| encoded(&surfaces(rows, 300, 12, 50_000, rows as u32), 300, step));
        checksum(rows)
    };
    assert_eq!([1, 5, 10, 51, 101, 157].map(of), SURFACES);
}

const SURFACES: [u32; 6] = [0x1882_c09c, 0x91b6_aa07, 0x503e_68b0, 0xdb0b_61d7, 0x21ee_ce7d, 0x85cf_ed95];
