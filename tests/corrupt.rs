//! Promise: whatever the bytes, decoding ends in an error value or an image within the limits. Nothing panics, nothing
//! is read or taken beyond what the caller allows, and no damage passes for a frame.
#![allow(missing_docs)]

mod common;

use flicr::geometry::{Lattice, sensors};
use flicr::{
    Coder, CoderId, Config, DecodeError, Decoder, DeflateSmall, HeaderField, ImageViewMut, LatticeConfig, LimitKind,
    Limits, PayloadFault, Rle, Scale, Stamp, Store, encode, frame,
};
use proptest::prelude::*;

const COLUMNS: usize = 64;

fn frame_by<C: Coder<u8>>(mut coder: C) -> Vec<u8> {
    let mut levels = vec![0_u8; 64 * COLUMNS];
    let image = ImageViewMut::new(&mut levels, COLUMNS).unwrap();
    let mut out = vec![0; frame::worst_case_len::<u8, C>(64 * COLUMNS)];
    let points = common::spiral(800);
    let encoded = encode(&Config::UNIFORM, points.as_slice(), Stamp::default(), image, &mut coder, &mut out).unwrap();
    out.truncate(encoded.len);
    out
}

/// On a sensor's own grid: known by its checksum, and with its beams.
fn grid_frame(table: bool) -> Vec<u8> {
    let lattice = Lattice::<66>::new(sensors::hdl64e::GRID, COLUMNS).unwrap();
    let config = LatticeConfig {
        table,
        scale: Scale::Fixed { max_range_m: 80.0 },
        level_bits: 8,
        ..LatticeConfig::new(&lattice)
    };
    let mut levels = vec![0_u8; 64 * COLUMNS];
    let image = ImageViewMut::new(&mut levels, COLUMNS).unwrap();
    let mut out = vec![0; config.worst_case_len::<u8, Rle>()];
    let points = common::spiral(800);
    let encoded = encode(&config, points.as_slice(), Stamp::default(), image, &mut Rle::new(), &mut out).unwrap();
    out.truncate(encoded.len);
    out
}

fn frames() -> [Vec<u8>; 5] {
    let deflate = frame_by(DeflateSmall::new());
    [frame_by(Store::new()), frame_by(Rle::new()), deflate, grid_frame(false), grid_frame(true)]
}

fn error(bytes: &[u8]) -> DecodeError {
    Decoder::default().decode(bytes).unwrap_err()
}

/// `bytes` with a checksum that fits, so that what lies behind it is looked at.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let mut crc = crc32_bitwise(&bytes[..body]).to_le_bytes();
    bytes[body..].swap_with_slice(&mut crc);
    bytes
}

/// CRC-32 by its definition, one bit at a time.
fn crc32_bitwise(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc: u32, &byte| (0..8).fold(crc ^ u32::from(byte), step))
}

fn with(bytes: &[u8], at: usize, new: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

#[test]
fn truncated_at_every_length() {
    for bytes in frames() {
        for have in 0..bytes.len() {
            let error = error(&bytes[..have]);
            assert!(matches!(error, DecodeError::Truncated { need, have: h } if h == have && need > have), "{error:?}");
        }
    }
}

#[test]
fn every_single_bit_flipped() {
    for mut bytes in frames() {
        for bit in 0..bytes.len() * 8 {
            bytes[bit / 8] ^= 1 << (bit % 8);
            error(&bytes);
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        assert!(Decoder::default().decode(&bytes).is_ok());
    }
}

#[test]
fn a_damaged_body_is_named_as_such() {
    for mut bytes in frames() {
        let at = bytes.len() / 2;
        bytes[at] ^= 0x10;
        assert!(matches!(error(&bytes), DecodeError::Checksum { .. }));
    }
}

#[test]
fn wrong_magic_and_version() {
    let [bytes, ..] = frames();
    assert_eq!(error(&with(&bytes, 0, b"GLCR")), DecodeError::Magic { found: *b"GLCR" });
    assert_eq!(error(&with(&bytes, 4, &[9])), DecodeError::Version { found: 9, supported: 1 });
    assert_eq!(error(b"ply\nformat ascii"), DecodeError::Magic { found: *b"ply\n" });
}

#[test]
fn wrong_header_fields_are_named() {
    let [bytes, ..] = frames();
    let nan = f32::NAN.to_le_bytes();
    let cases: [(usize, &[u8], HeaderField); 17] = [
        (5, &[8], HeaderField::Flags),
        (6, &[63, 0], HeaderField::HeaderLen),
        (8, &[75, 0, 0, 0], HeaderField::FrameLen),
        (24, &[0, 0], HeaderField::Rows),
        (26, &[0, 0], HeaderField::Columns),
        (28, &[0], HeaderField::LevelBits),
        (28, &[17], HeaderField::LevelBits),
        (29, &[200], HeaderField::Coder),
        (30, &[0, 0], HeaderField::Strips),
        (30, &[65, 0], HeaderField::Strips),
        (32, &nan, HeaderField::Step),
        (32, &[0; 4], HeaderField::Step),
        (36, &nan, HeaderField::RangeBound),
        (44, &[7], HeaderField::GeometryKind),
        (45, &[1], HeaderField::Reserved),
        (48, &nan, HeaderField::GeometryView),
        (60, &nan, HeaderField::GeometryView),
    ];
    for (at, new, expected) in cases {
        let found = error(&with(&bytes, at, new));
        assert!(matches!(found, DecodeError::Header { field, .. } if field == expected), "{at}: {found:?}");
        assert!(found.to_string().contains(&format!("{expected:?}")));
    }
}

#[test]
fn wrong_fields_of_a_grid_are_named() {
    let (nan, bytes) = (f32::NAN.to_le_bytes(), grid_frame(true));
    let cases: [(usize, &[u8], HeaderField); 17] = [
        (5, &[1], HeaderField::Flags),
        (6, &[72, 0], HeaderField::HeaderLen),
        (6, &[64, 0], HeaderField::HeaderLen),
        (24, &[63, 0], HeaderField::HeaderLen),
        (24, &[1, 4], HeaderField::Rows),
        (44, &[0], HeaderField::Reserved),
        (45, &[8], HeaderField::GeometryFlags),
        (45, &[0], HeaderField::HeaderLen),
        (46, &[3], HeaderField::ColumnMode),
        (47, &[1], HeaderField::Reserved),
        (52, &[0; 4], HeaderField::Ticks),
        (52, &[0xff; 4], HeaderField::Ticks),
        (56, &nan, HeaderField::RangeUnit),
        (60, &nan, HeaderField::GeometryView),
        (64, &nan, HeaderField::PointBound),
        (68, &[1], HeaderField::Firings),
        (70, &[1], HeaderField::Reserved),
    ];
    for (at, new, expected) in cases {
        let found = error(&with(&bytes, at, new));
        assert!(matches!(found, DecodeError::Header { field, .. } if field == expected), "{at}: {found:?}");
    }
    let sealed_error = |at, new: &[u8]| error(&sealed(with(&bytes, at, new)));
    // Any change of the grid is noticed, though header and frame are whole.
    for at in [48, 52, 56, 60, 45] {
        let found = sealed_error(at, &[bytes[at] ^ 1]);
        assert!(matches!(found, DecodeError::Header { field: HeaderField::Sensor, .. }), "{at}: {found:?}");
    }
    assert_eq!(sealed_error(72 + 20 * 9, &nan), DecodeError::Header { field: HeaderField::Beam, found: 9 });
    assert!(matches!(sealed_error(72 + 4, &[0; 4]), DecodeError::Header { field: HeaderField::Sensor, .. }));
    let bare = grid_frame(false);
    let found = error(&sealed(with(&bare, 48, &[1, 2, 3, 4])));
    assert_eq!(found, DecodeError::UnknownSensor { sensor: 0x0403_0201 });
    // A known sensor, but not of this many beams, ticks...
    for (at, new) in [(24, &[63, 0]), (52, &[1, 2])] {
        let found = error(&sealed(with(&bare, at, new)));
        assert!(matches!(found, DecodeError::Header { field: HeaderField::Sensor, .. }), "{at}: {found:?}");
    }
}

#[test]
fn a_gigantic_claim_costs_nothing() {
    let [bytes, ..] = frames();
    let huge = sealed(with(&bytes, 24, &[0xff; 4]));
    let claimed = 65_535 * 65_535;
    let limit = DecodeError::Limit { limit: LimitKind::Pixels, found: claimed, allowed: 4 << 20 };
    assert_eq!(error(&huge), limit);
    let long = with(&bytes, 8, &[0xff; 4]);
    assert_eq!(error(&long), DecodeError::Truncated { need: 0xffff_ffff, have: bytes.len() });
    let small = Limits { frame_len: 100, pixels: 64 * COLUMNS };
    let limit = DecodeError::Limit { limit: LimitKind::FrameLen, found: bytes.len() as u64, allowed: 100 };
    assert_eq!(Decoder::new(small).decode(&bytes).unwrap_err(), limit);
    let exact = Limits { frame_len: bytes.len(), pixels: 64 * COLUMNS };
    assert!(Decoder::new(exact).decode(&bytes).is_ok());
    assert!(Decoder::new(Limits { pixels: 64 * COLUMNS - 1, ..exact }).decode(&bytes).is_err());
}

#[test]
fn trailing_bytes() {
    for bytes in frames() {
        let (frame_len, have) = (bytes.len(), bytes.len() + 1);
        let longer = [bytes.as_slice(), &[0]].concat();
        assert_eq!(error(&longer), DecodeError::TrailingBytes { frame_len, have });
        assert_eq!(frame::frame_len(&longer), Ok(frame_len));
    }
}

#[test]
fn strips_out_of_order_or_short() {
    let [bytes, ..] = frames();
    let case = |at, new: &[u8]| error(&sealed(with(&bytes, at, new)));
    assert_eq!(case(64, &[1, 0]), DecodeError::StripOrder { found: 1, expected: 0 });
    for columns in [0, 63, 65] {
        let found = case(66, &[columns, 0]);
        assert!(matches!(found, DecodeError::Header { field: HeaderField::StripColumns, .. }), "{found:?}");
    }
    assert!(matches!(case(68, &[0xff; 4]), DecodeError::Truncated { .. }));
    assert!(matches!(case(68, &[0, 0, 0, 0]), DecodeError::TrailingBytes { .. }));
    // Two strips announced, one there.
    assert!(matches!(case(30, &[2, 0]), DecodeError::Header { field: HeaderField::StripColumns, .. }));
}

/// The frame of a payload, and as many strips as payloads.
fn frame_of(coder: CoderId, level_bits: u8, payloads: &[&[u8]]) -> Vec<u8> {
    let [bytes, ..] = frames();
    let columns = (COLUMNS / payloads.len()) as u16;
    let mut frame = with(&bytes[..64], 28, &[level_bits, coder as u8, payloads.len() as u8, 0]);
    let step = flicr::Quantizer::new(level_bits.into(), 80.0).unwrap();
    frame[32..36].copy_from_slice(&step.step_m().to_le_bytes());
    frame[36..40].copy_from_slice(&step.range_bound_m().to_le_bytes());
    for (first_column, payload) in (0..).step_by(columns.into()).zip(payloads) {
        frame.extend(u16::to_le_bytes(first_column));
        frame.extend(columns.to_le_bytes());
        frame.extend((payload.len() as u32).to_le_bytes());
        frame.extend_from_slice(payload);
    }
    frame.extend([0; 4]);
    let frame_len = frame.len() as u32;
    sealed(with(&frame, 8, &frame_len.to_le_bytes()))
}

#[test]
fn payloads_that_do_not_make_the_image() {
    let pixels = 64 * COLUMNS;
    let fault = |coder, payload: &[u8]| match error(&frame_of(coder, 8, &[payload])) {
        DecodeError::Payload { strip: 0, fault } => fault,
        other => panic!("{other:?}"),
    };
    let all_empty = vec![0xff; pixels / 64];
    assert!(Decoder::default().decode(&frame_of(CoderId::Rle, 8, &[&all_empty])).is_ok());
    assert_eq!(fault(CoderId::Rle, &all_empty[1..]), PayloadFault::TooShort);
    assert_eq!(fault(CoderId::Rle, &[&all_empty[..], &[0xc0]].concat()), PayloadFault::TooLong);
    assert_eq!(fault(CoderId::Rle, &[5, 1, 2]), PayloadFault::TooShort);
    assert_eq!(fault(CoderId::Rle, &[0x80]), PayloadFault::TooShort);
    assert_eq!(fault(CoderId::Store, &vec![1; pixels - 1]), PayloadFault::TooShort);
    assert_eq!(fault(CoderId::Store, &vec![1; pixels + 1]), PayloadFault::TooLong);
    assert_eq!(fault(CoderId::Deflate, &[]), PayloadFault::TooShort);
    assert_eq!(fault(CoderId::Deflate, &[0x07]), PayloadFault::Malformed);
}

/// Empty blocks of DEFLATE, ten bits each (0, 01, 0000000), and then one that holds all levels.
fn blocks_before(empty_blocks: usize, levels: &[u8]) -> Vec<u8> {
    let mut bits = Vec::new();
    for _ in 0..empty_blocks {
        bits.extend([0, 1, 0, 0, 0, 0, 0, 0, 0, 0]);
    }
    bits.extend([1, 0, 0]); // the last, stored
    bits.resize(bits.len().next_multiple_of(8), 0);
    let mut stream: Vec<u8> =
        bits.chunks(8).map(|byte| (0..8).fold(0, |value, bit| value | byte[bit] << bit)).collect();
    stream.extend((levels.len() as u16).to_le_bytes());
    stream.extend((!levels.len() as u16).to_le_bytes());
    stream.extend_from_slice(levels);
    stream
}

#[test]
fn blocks_without_levels_are_counted() {
    let levels = vec![7; 64 * COLUMNS];
    let most = 16 + levels.len() / 8;
    let decode = |empty| {
        Decoder::default().decode(&frame_of(CoderId::Deflate, 8, &[&blocks_before(empty, &levels)])).map(|_| ())
    };
    for empty_blocks in [0, 1, most / 2, most - 2] {
        assert_eq!(decode(empty_blocks), Ok(()), "{empty_blocks}");
    }
    let refused = DecodeError::Payload { strip: 0, fault: PayloadFault::TooManyBlocks };
    for empty_blocks in [most + 2, 100 * most] {
        assert_eq!(decode(empty_blocks), Err(refused), "{empty_blocks}");
    }
}

#[test]
fn levels_beyond_the_header_s_bits() {
    let levels = vec![63; 64 * COLUMNS];
    assert!(Decoder::default().decode(&frame_of(CoderId::Store, 6, &[&levels])).is_ok());
    let mut levels = levels;
    levels[1000] = 64;
    let fault = PayloadFault::LevelRange { found: 64, max: 63 };
    assert_eq!(error(&frame_of(CoderId::Store, 6, &[&levels])), DecodeError::Payload { strip: 0, fault });
}

#[test]
fn strips_are_put_side_by_side() {
    let strip = |level| vec![level; 64 * COLUMNS / 4];
    let payloads = [strip(1), strip(2), strip(3), strip(4)];
    let bytes = frame_of(CoderId::Store, 8, &payloads.each_ref().map(Vec::as_slice));
    let mut decoder = Decoder::default();
    let flicr::Levels::U8(levels) = decoder.decode(&bytes).unwrap().levels() else { panic!("8 bits") };
    for row in levels.chunks(COLUMNS) {
        let expected: Vec<u8> = (1..=4).flat_map(|level| [level; COLUMNS / 4]).collect();
        assert_eq!(row, expected);
    }
}

proptest! {
    #[test]
    fn random_payloads_end_in_an_error_or_an_image(
        coder in prop::sample::select(vec![CoderId::Store, CoderId::Rle, CoderId::Deflate]),
        level_bits in 1_u8..=16,
        payload in prop::collection::vec(any::<u8>(), 0..600),
    ) {
        let mut decoder = Decoder::default();
        if let Ok(frame) = decoder.decode(&frame_of(coder, level_bits, &[&payload])) {
            prop_assert!(frame.points().len() <= 64 * COLUMNS);
        }
    }

    #[test]
    fn changes_before_a_checksum_that_fits(
        which in 0_usize..5,
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..110, any::<bool>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = frames()[which].clone();
        for (anywhere, at_front, in_front, value) in changes {
            let at = if in_front { at_front.min(bytes.len() - 1) } else { anywhere.index(bytes.len()) };
            bytes[at] = value;
        }
        let mut decoder = Decoder::default();
        if let Ok(frame) = decoder.decode(&sealed(bytes)) {
            prop_assert!(frame.points().len() <= frame.header().pixels());
            prop_assert!(frame.points().iter().flatten().all(|coordinate| coordinate.is_finite()));
        }
    }

    #[test]
    fn random_bytes_behind_a_right_start(
        mut bytes in prop::collection::vec(any::<u8>(), 60..400),
        keep in 5_usize..80,
        which in 0_usize..5,
    ) {
        let good = frames()[which].clone();
        let keep = keep.min(good.len());
        let keep = keep.min(bytes.len());
        bytes[..keep].copy_from_slice(&good[..keep]);
        let _ = Decoder::default().decode(&bytes);
        let _ = Decoder::default().decode(&sealed(bytes));
    }
}
