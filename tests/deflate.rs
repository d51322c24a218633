//! Promise: whatever bytes go into the DEFLATE coder, two independent inflaters give them back, and no stream is
//! longer than the bound.
#![allow(missing_docs)]

use flate2::{Decompress, FlushDecompress, Status};
use flicr::{Deflate, DeflateDefault, DeflateDense, DeflateSmall, OutputFull};
use proptest::prelude::*;

/// So little memory that every table collides and every few matches fill a block.
type Tiny = Deflate<2, 2, 1, 3>;

type Encode<'a> = &'a mut dyn FnMut(&[u8], usize, &mut [u8]) -> Result<usize, OutputFull>;

/// Every profile, kept between calls as firmware does.
struct Coders {
    default: Box<DeflateDefault>,
    small: Box<DeflateSmall>,
    dense: Box<DeflateDense>,
    tiny: Box<Tiny>,
}

impl Coders {
    fn new() -> Self {
        Self {
            default: Box::new(DeflateDefault::new()),
            small: Box::new(DeflateSmall::new()),
            dense: Box::new(DeflateDense::new()),
            tiny: Box::new(Tiny::new()),
        }
    }

    /// Runs `check` with each profile and its bound for `len` bytes.
    fn each(&mut self, len: usize, mut check: impl FnMut(Encode<'_>, usize)) {
        check(&mut |b, r, o| self.default.encode_bytes(b, r, o), DeflateDefault::worst_case_len(len));
        check(&mut |b, r, o| self.small.encode_bytes(b, r, o), DeflateSmall::worst_case_len(len));
        check(&mut |b, r, o| self.dense.encode_bytes(b, r, o), DeflateDense::worst_case_len(len));
        check(&mut |b, r, o| self.tiny.encode_bytes(b, r, o), Tiny::worst_case_len(len));
    }

    fn check(&mut self, bytes: &[u8], row_len: usize) {
        self.each(bytes.len(), |encode, bound| {
            let mut out = vec![0; bound];
            let len = encode(bytes, row_len, &mut out).expect("the bound is enough");
            check_inflates(&out[..len], bytes);
        });
    }
}

fn check_inflates(stream: &[u8], bytes: &[u8]) {
    assert!(miniz_oxide::inflate::decompress_to_vec(stream).expect("miniz_oxide inflates") == bytes);
    let mut zlib = Decompress::new(false);
    let mut inflated = vec![0; bytes.len() + 1];
    let status = zlib.decompress(stream, &mut inflated, FlushDecompress::Finish).expect("zlib inflates");
    assert_eq!(status, Status::StreamEnd);
    assert_eq!(zlib.total_in(), stream.len() as u64, "bytes behind the stream");
    assert!(inflated[..zlib.total_out() as usize] == *bytes);
}

/// The same bytes every time, as random as needed.
fn noise(len: usize, mask: u8) -> Vec<u8> {
    let mut state = 0x9E37_79B9_u32;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        (state >> 11) as u8 & mask
    };
    (0..len).map(|_| next()).collect()
}

/// A ground row's look: one level for long, with the gaps of a grid that is finer than the sensor's.
fn gappy(len: usize, row_len: usize) -> Vec<u8> {
    let noise = noise(len, 63);
    let level = |i: usize| 20 + (i / row_len) as u8 % 50 + u8::from(noise[i] == 0);
    (0..len).map(|i| if i * 2150 / 4500 == (i + 1) * 2150 / 4500 || noise[i] == 1 { 0 } else { level(i) }).collect()
}

#[test]
fn every_small_length_comes_back() {
    let mut coders = Coders::new();
    for len in 0..=700 {
        for bytes in [noise(len, 255), noise(len, 3), gappy(len, 50), vec![0; len], vec![7; len]] {
            coders.check(&bytes, 50);
        }
    }
}

#[test]
fn runs_of_every_length_come_back() {
    let mut coders = Coders::new();
    for run in (0..600).chain([32_767, 32_768, 32_769, 65_535, 65_536, 65_537]) {
        for level in [0, 9] {
            let bytes = [&[1, 2, 3], &*vec![level; run], &[4, 0, 5], &*vec![level; run], &[6]].concat();
            coders.check(&bytes, run);
        }
    }
}

#[test]
fn any_row_length_does() {
    let mut coders = Coders::new();
    let bytes = gappy(70_000, 256);
    for row_len in [0, 1, 2, 3, 255, 256, 257, 32_768, 32_769, 65_536, 69_999, 70_000, 70_001, usize::MAX] {
        coders.check(&bytes, row_len);
    }
}

#[test]
fn matches_reach_back_to_the_window_and_not_beyond() {
    let mut coders = Coders::new();
    for distance in [32_760, 32_767, 32_768, 32_769, 32_780, 65_535, 65_536, 65_537] {
        let block = noise(300, 255);
        let bytes = [&*block, &*vec![0; distance - 300], &*block, &*vec![0; distance - 300], &*block].concat();
        coders.check(&bytes, distance);
    }
}

#[test]
fn images_of_every_size_come_back() {
    let mut coders = Coders::new();
    for columns in [4500, 4096, 2048, 1024, 512, 256] {
        coders.check(&gappy(columns * 64, columns), columns);
    }
}

#[test]
fn every_kind_of_block_is_written_where_it_is_best() {
    let kind = |bytes: &[u8]| {
        let mut out = vec![0; DeflateSmall::worst_case_len(bytes.len())];
        DeflateSmall::new().encode_bytes(bytes, 0, &mut out).unwrap();
        out[0] >> 1 & 3
    };
    assert_eq!(kind(&noise(1000, 255)), 0, "stored");
    assert_eq!(kind(&[1, 2, 3]), 1, "fixed");
    assert_eq!(kind(&gappy(5000, 100)), 2, "dynamic");
}

#[test]
fn noise_takes_five_bytes_a_block_more() {
    let mut coders = Coders::new();
    for len in [0, 1, 65_535, 65_536, 200_000] {
        let bytes = noise(len, 255);
        coders.each(len, |encode, bound| {
            let mut out = vec![0; bound];
            assert!(encode(&bytes, 0, &mut out).unwrap() <= len + 5 * (len / 40_000 + 1));
        });
    }
}

/// Skewed counts make codes that are longer than the 15 bits of the format, were they not limited.
#[test]
fn deep_codes_come_back() {
    let mut bytes = Vec::new();
    let (mut count, mut next) = (1, 1);
    for symbol in 1..=22_u8 {
        bytes.resize(bytes.len() + count, symbol);
        (count, next) = (next, count + next);
    }
    let order = noise(4 * bytes.len(), 255);
    let mut keyed: Vec<_> = bytes.iter().zip(order.chunks(4)).map(|(&byte, key)| (key, byte)).collect();
    keyed.sort_unstable();
    let shuffled: Vec<u8> = keyed.into_iter().map(|(_, byte)| byte).collect();
    Coders::new().check(&shuffled, 0);
}

#[test]
fn a_short_output_is_an_error_and_nothing_is_written_behind_it() {
    const GUARD: u8 = 0xA5;
    let mut coders = Coders::new();
    for bytes in [vec![], vec![0; 40], noise(300, 255), noise(500, 7), gappy(1500, 100)] {
        coders.each(bytes.len(), |encode, bound| {
            let mut whole = vec![0; bound];
            let len = encode(&bytes, 100, &mut whole).unwrap();
            for capacity in 0..=len + 1 {
                let mut out = vec![GUARD; bound + 16];
                let result = encode(&bytes, 100, &mut out[..capacity]);
                assert_eq!(result, if capacity < len { Err(OutputFull) } else { Ok(len) });
                assert!(out[capacity..].iter().all(|&byte| byte == GUARD));
                assert!(result.is_err() || out[..len] == whole[..len]);
            }
        });
    }
}

#[test]
fn what_was_coded_before_does_not_matter() {
    let (first, second) = (gappy(40_000, 300), gappy(50_000, 256));
    let encode = |coder: &mut DeflateDefault, bytes: &[u8]| {
        let mut out = vec![0; DeflateDefault::worst_case_len(bytes.len())];
        let len = coder.encode_bytes(bytes, 256, &mut out).unwrap();
        out.truncate(len);
        out
    };
    let mut used = Box::new(DeflateDefault::new());
    encode(&mut used, &first);
    assert_eq!(used.encode_bytes(&first, 300, &mut [0; 100]), Err(OutputFull));
    assert_eq!(encode(&mut used, &second), encode(&mut Box::new(DeflateDefault::new()), &second));
}

/// The bytes are part of what the crate promises, on every target: these are of the first release.
#[test]
fn golden_bytes() {
    let checksum = |stream: &[u8]| crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(stream);
    let bytes = gappy(4500 * 64, 4500);
    let mut found = Vec::new();
    Coders::new().each(bytes.len(), |encode, bound| {
        let mut out = vec![0; bound];
        let len = encode(&bytes, 4500, &mut out).unwrap();
        found.push((len, checksum(&out[..len])));
    });
    assert_eq!(found, GOLDEN);
}

/// Length and CRC-32 of the streams of the default, small, dense and tiny coders.
const GOLDEN: [(usize, u32); 4] =
    [(16_138, 3_297_036_528), (15_496, 3_531_634_542), (14_156, 2_668_005_903), (64_919, 2_312_840_783)];

#[test]
fn states_are_as_small_as_promised() {
    assert!(size_of::<DeflateDefault>() <= 60_000, "{}", size_of::<DeflateDefault>());
    assert!(size_of::<DeflateSmall>() <= 14_000, "{}", size_of::<DeflateSmall>());
    assert!(size_of::<DeflateDense>() <= 210_000, "{}", size_of::<DeflateDense>());
}

/// Bytes made of runs, copies of what is `back` behind, and noise.
fn structured() -> impl Strategy<Value = Vec<u8>> {
    let part = prop_oneof![
        (any::<u8>(), 1..400_usize).prop_map(|(level, len)| vec![(0, level, len)]),
        (prop::collection::vec(any::<u8>(), 1..80)).prop_map(|b| b.into_iter().map(|b| (0, b, 1)).collect()),
        (1..40_000_usize, 1..600_usize).prop_map(|(back, len)| vec![(back, 0, len)]),
    ];
    prop::collection::vec(part, 0..60).prop_map(|parts| {
        let mut bytes: Vec<u8> = Vec::new();
        for (back, level, len) in parts.into_iter().flatten() {
            for _ in 0..len {
                let copied = bytes.len().checked_sub(back).and_then(|i| bytes.get(i)).copied();
                bytes.push(copied.unwrap_or(level));
            }
        }
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_bytes_come_back(bytes in prop::collection::vec(any::<u8>(), 0..5000), row_len in 0..5000_usize) {
        Coders::new().check(&bytes, row_len);
    }

    #[test]
    fn few_levels_come_back(bytes in prop::collection::vec(0..4_u8, 0..5000), row_len in 0..5000_usize) {
        Coders::new().check(&bytes, row_len);
    }

    #[test]
    fn structured_bytes_come_back(bytes in structured(), row_len in 0..70_000_usize) {
        Coders::new().check(&bytes, row_len);
    }
}
