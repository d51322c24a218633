//! Promise: point files are read as other programs read and write them, and a broken one says where it is broken.
#![cfg(feature = "std")]

use std::io::Cursor;
use std::path::{Path, PathBuf};

use flicr::files::{self, Fault, FileError, Format, ParseError, PointCloud, kitti, pcd, ply};
use pcd_rs::{DataKind, DynReader, DynRecord, DynWriter, Field, Schema, ValueKind, WriterInit};
use ply_rs_bw::ply::{DefaultElement, Property};
use proptest::collection::vec;
use proptest::prelude::*;

fn cloud(intensities: bool, rings: bool) -> PointCloud {
    PointCloud {
        points: vec![[1.5, -2.25, 0.125], [-0.0, f32::MAX, f32::MIN_POSITIVE], [80.1, 0.2, -3.3]],
        intensities: intensities.then(|| vec![0.0, 0.37, 255.0]),
        rings: rings.then(|| vec![0, 63, 65_535]),
    }
}

/// All four: with and without intensities and rings.
fn clouds() -> [PointCloud; 4] {
    [(false, false), (true, false), (false, true), (true, true)].map(|(intensities, rings)| cloud(intensities, rings))
}

type Write = fn(&mut Vec<u8>, &PointCloud) -> std::io::Result<()>;

fn written(write: Write, cloud: &PointCloud) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(&mut bytes, cloud).unwrap();
    bytes
}

// --- KITTI ------------------------------------------------------------------------------------------------------------

#[test]
fn kitti_is_four_little_endian_floats_a_point() {
    let mut bytes = Vec::new();
    for value in [1.0_f32, -2.0, 3.5, 0.25, 4.0, 5.0, 6.0, 0.5] {
        bytes.extend(value.to_le_bytes());
    }
    let found = kitti::parse(&bytes).unwrap();
    assert_eq!(found.points, [[1.0, -2.0, 3.5], [4.0, 5.0, 6.0]]);
    assert_eq!((&found.intensities, &found.rings), (&Some(vec![0.25, 0.5]), &None));
    assert_eq!(written(kitti::write, &found), bytes);
    assert_eq!(kitti::parse(&[]).unwrap().points.len(), 0);
}

#[test]
fn kitti_with_rings_comes_back() {
    let cloud = cloud(true, true);
    let bytes = written(kitti::write_with_rings, &cloud);
    assert_eq!(bytes.len(), 60);
    assert_eq!(kitti::parse_with_rings(&bytes).unwrap(), cloud);
}

#[test]
fn kitti_writes_zeros_for_what_a_cloud_lacks() {
    let bytes = written(kitti::write_with_rings, &cloud(false, false));
    let found = kitti::parse_with_rings(&bytes).unwrap();
    assert_eq!((found.intensities, found.rings), (Some(vec![0.0; 3]), Some(vec![0; 3])));
}

#[test]
fn kitti_of_a_length_that_is_no_number_of_points_is_an_error() {
    let bytes = written(kitti::write, &cloud(true, false));
    for len in (0..bytes.len()).filter(|len| len % 16 != 0) {
        let error = kitti::parse(&bytes[..len]).unwrap_err();
        assert_eq!((error.fault, error.offset), (Fault::Length, len / 16 * 16));
    }
    let error = kitti::parse(&bytes[..33]).unwrap_err();
    assert_eq!(error.to_string(), "at byte 32: found 1 byte after 2 points, expected records of 16 bytes");
}

#[test]
fn kitti_rings_that_are_no_beam_are_an_error() {
    for ring in [-1.0, 0.5, 65_536.0, f32::NAN, f32::INFINITY] {
        let mut bytes = written(kitti::write_with_rings, &cloud(true, true));
        bytes[36..40].copy_from_slice(&ring.to_le_bytes());
        let error = kitti::parse_with_rings(&bytes).unwrap_err();
        assert_eq!((error.fault, error.offset), (Fault::Value, 36), "{ring}");
    }
}

// --- PCD against pcd-rs -----------------------------------------------------------------------------------------------

const KINDS: [ValueKind; 10] = [
    ValueKind::F32,
    ValueKind::F64,
    ValueKind::I8,
    ValueKind::I16,
    ValueKind::I32,
    ValueKind::I64,
    ValueKind::U8,
    ValueKind::U16,
    ValueKind::U32,
    ValueKind::U64,
];

/// A number from 0 to 127, which every kind holds.
fn field(kind: ValueKind, value: i8, count: usize) -> Field {
    let unsigned = value.unsigned_abs();
    match kind {
        ValueKind::F32 => Field::F32(vec![f32::from(value); count]),
        ValueKind::F64 => Field::F64(vec![f64::from(value); count]),
        ValueKind::I8 => Field::I8(vec![value; count]),
        ValueKind::I16 => Field::I16(vec![value.into(); count]),
        ValueKind::I32 => Field::I32(vec![value.into(); count]),
        ValueKind::I64 => Field::I64(vec![value.into(); count]),
        ValueKind::U8 => Field::U8(vec![unsigned; count]),
        ValueKind::U16 => Field::U16(vec![unsigned.into(); count]),
        ValueKind::U32 => Field::U32(vec![unsigned.into(); count]),
        ValueKind::U64 => Field::U64(vec![unsigned.into(); count]),
    }
}

/// Points 0, 1, 2 … whose field number `f` is `(10 point + f) mod 100`, as pcd-rs writes them.
fn written_by_pcd_rs(data_kind: DataKind, schema: &[(&str, ValueKind, u64)], points: u8) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let init = WriterInit {
        width: points.into(),
        height: 1,
        viewpoint: pcd_rs::ViewPoint::default(),
        data_kind,
        schema: Some(schema.iter().copied().collect::<Schema>()),
        version: None,
    };
    let mut writer: DynWriter<_> = init.build_from_writer(&mut bytes).unwrap();
    for point in 0..points {
        let fields = schema
            .iter()
            .enumerate()
            .map(|(index, &(_, kind, count))| field(kind, expected_value(point, index), count.try_into().unwrap()));
        writer.push(&DynRecord(fields.collect())).unwrap();
    }
    writer.finish().unwrap();
    bytes.into_inner()
}

fn expected_value(point: u8, field: usize) -> i8 {
    i8::try_from((usize::from(point) * 10 + field) % 100).unwrap()
}

const ENCODINGS: [DataKind; 3] = [DataKind::Ascii, DataKind::Binary, DataKind::BinaryCompressed];

#[test]
fn pcd_of_any_types_and_order_is_read() {
    for (shift, encoding) in (0..KINDS.len()).flat_map(|shift| ENCODINGS.map(|encoding| (shift, encoding))) {
        let kind = |index: usize| KINDS[(shift + index) % KINDS.len()];
        let schema = [
            ("ring", kind(0), 1),
            ("z", kind(1), 1),
            ("normal", kind(2), 3),
            ("x", kind(3), 1),
            ("timestamp", kind(4), 1),
            ("intensity", kind(5), 1),
            ("y", kind(6), 1),
        ];
        let found = pcd::parse(&written_by_pcd_rs(encoding, &schema, 60)).unwrap();
        let float = |point, field| f32::from(expected_value(point, field));
        let points: Vec<_> = (0..60).map(|point| [3, 6, 1].map(|field| float(point, field))).collect();
        assert_eq!(found.points, points, "{schema:?} {encoding:?}");
        assert_eq!(found.intensities, Some((0..60).map(|point| float(point, 5)).collect()));
        let rings = (0..60).map(|point| expected_value(point, 0).unsigned_abs().into());
        assert_eq!(found.rings, Some(rings.collect()));
    }
}

#[test]
fn pcd_fields_of_other_names_are_skipped_and_aliases_known() {
    let schema = [
        ("x", ValueKind::F32, 1),
        ("y", ValueKind::F32, 1),
        ("z", ValueKind::F32, 1),
        ("i", ValueKind::U8, 1),
        ("channel", ValueKind::U16, 1),
        ("rgb", ValueKind::U32, 1),
    ];
    let found = pcd::parse(&written_by_pcd_rs(DataKind::Binary, &schema, 2)).unwrap();
    assert_eq!((found.intensities, found.rings), (Some(vec![3.0, 13.0]), Some(vec![4, 14])));
    let found = pcd::parse(&written_by_pcd_rs(DataKind::Binary, &schema[..3], 2)).unwrap();
    assert_eq!((found.intensities, found.rings), (None, None));
}

#[test]
fn pcd_is_what_pcd_rs_reads() {
    for cloud in clouds() {
        let bytes = written(pcd::write, &cloud);
        let records: Vec<DynRecord> = DynReader::from_bytes(&bytes).unwrap().map(Result::unwrap).collect();
        for (index, (record, point)) in records.iter().zip(&cloud.points).enumerate() {
            let mut expected = point.map(|coordinate| Field::F32(vec![coordinate])).to_vec();
            expected.extend(cloud.intensities.as_ref().map(|list| Field::F32(vec![list[index]])));
            expected.extend(cloud.rings.as_ref().map(|list| Field::U16(vec![list[index]])));
            assert_eq!(record.0, expected);
        }
        assert_eq!(records.len(), cloud.points.len());
    }
}

#[test]
fn pcd_comes_back() {
    for cloud in clouds() {
        assert_eq!(pcd::parse(&written(pcd::write, &cloud)).unwrap(), cloud);
    }
    let empty = PointCloud::default();
    assert_eq!(pcd::parse(&written(pcd::write, &empty)).unwrap(), empty);
}

// --- PCD headers ------------------------------------------------------------------------------------------------------

const HEADER: &str = "# comment\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n\
    VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n";
const POINTS: &str = "1 2.5 -3e1\nnan +0.5 inf\n";

fn parse_text(text: &str) -> Result<PointCloud, ParseError> {
    pcd::parse(text.as_bytes())
}

#[test]
fn pcd_text_is_read() {
    let found = parse_text(&(HEADER.to_owned() + POINTS)).unwrap();
    assert_eq!(found.points[0], [1.0, 2.5, -30.0]);
    assert!(found.points[1][0].is_nan() && found.points[1][1..] == [0.5, f32::INFINITY]);
}

#[test]
fn pcd_headers_of_all_ages_are_read() {
    let variants = [
        ("\n", "\r\n"),
        ("VERSION 0.7", "VERSION .7"),
        ("VERSION 0.7", "VERSION .5"),
        ("FIELDS x", "COLUMNS x"),
        ("COUNT 1 1 1\n", ""),
        ("VIEWPOINT 0 0 0 1 0 0 0\n", ""),
        ("POINTS 2\n", ""),
        ("POINTS 2\n", "  POINTS   2  \n\nSENSOR_MODEL some lidar\n"),
        ("WIDTH 2\nHEIGHT 1\n", "HEIGHT 2\nWIDTH 1\n"),
    ];
    let plain = HEADER.to_owned() + POINTS;
    for (from, to) in variants {
        let found = parse_text(&plain.replace(from, to)).unwrap_or_else(|error| panic!("{to:?}: {error}"));
        assert_eq!(found.points[0], [1.0, 2.5, -30.0], "{to:?}");
        assert_eq!(found.points.len(), 2);
    }
}

/// A header with one thing wrong, the fault, and the piece of text that the error must point at.
const BROKEN_HEADERS: [(&str, &str, Fault, &str); 22] = [
    ("VERSION 0.7", "VERSION 0.8", Fault::Header, "0.8"),
    ("VERSION 0.7", "Version 0.7", Fault::Header, "Version"),
    ("FIELDS x y z", "FIELDS x y", Fault::Fields, "F F F"),
    ("FIELDS x y z", "FIELDS x y w", Fault::Fields, "x y w"),
    ("FIELDS x y z", "FIELDS x y y", Fault::Fields, "x y y"),
    ("SIZE 4 4 4", "SIZE 4 4", Fault::Fields, "4 4\n"),
    ("SIZE 4 4 4", "SIZE 4 4 3", Fault::Fields, "F F F"),
    ("SIZE 4 4 4", "SIZE 4 4 1", Fault::Fields, "F F F"),
    ("TYPE F F F", "TYPE F F G", Fault::Fields, "F F G"),
    ("TYPE F F F", "TYPE F F F F", Fault::Fields, "F F F F"),
    ("COUNT 1 1 1", "COUNT 1 1 0", Fault::Fields, "1 1 0"),
    ("COUNT 1 1 1", "COUNT 1 1 2", Fault::Fields, "x y z"),
    ("COUNT 1 1 1", "COUNT 1 1 -1", Fault::Fields, "1 1 -1"),
    ("COUNT 1 1 1", "COUNT 1 1 18446744073709551615", Fault::Fields, "x y z"),
    ("WIDTH 2", "WIDTH 3", Fault::PointCount, "2\nDATA"),
    ("WIDTH 2", "WIDTH two", Fault::Header, "two"),
    ("WIDTH 2\nHEIGHT 1", "WIDTH 8589934592\nHEIGHT 8589934592", Fault::PointCount, "2\nDATA"),
    ("POINTS 2", "POINTS 99999999999999999999999", Fault::Header, "99999999999999999999999"),
    ("POINTS 2", "POINTS -2", Fault::Header, "-2"),
    ("DATA ascii", "DATA", Fault::Header, "\n1 2.5"),
    ("DATA ascii", "DATA text", Fault::Header, "text"),
    ("WIDTH 2", "WIDTH 2\nWIDTH 2", Fault::Header, "WIDTH 2\nHEIGHT"),
];

#[test]
fn broken_pcd_headers_say_what_and_where() {
    for (from, to, fault, at) in BROKEN_HEADERS {
        let text = HEADER.replacen(from, to, 1) + POINTS;
        let error = parse_text(&text).expect_err(to);
        assert_eq!((error.fault, Some(error.offset)), (fault, text.find(at)), "{to:?}: {error}");
    }
}

#[test]
fn pcd_without_a_needed_line_says_which() {
    for keyword in ["VERSION", "FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT"] {
        let text: String = HEADER.split_inclusive('\n').filter(|line| !line.starts_with(keyword)).collect();
        let error = parse_text(&text).unwrap_err();
        assert_eq!((error.fault, error.found), (Fault::Header, format!("a header without {keyword}")));
    }
}

#[test]
fn what_is_no_pcd_is_an_error() {
    for bytes in [&b""[..], b"\n", b"VERSION 0.7\n", b"ply\nformat ascii 1.0\n", b"\xff\xfe\n", &[0; 64]] {
        assert_eq!(pcd::parse(bytes).unwrap_err().fault, Fault::Header, "{bytes:?}");
    }
}

// --- PCD data ---------------------------------------------------------------------------------------------------------

#[test]
fn broken_pcd_text_says_what_and_where() {
    let broken = [
        ("1 2.5 -3e1\n", Fault::Truncated, 11),
        ("1 2.5 -3e1\n1 2 3\n4 5 6\n", Fault::TrailingBytes, 17),
        ("1 2.5\n1 2 3\n", Fault::Value, 0),
        ("1 2.5 -3e1\n1 2 3 4\n", Fault::Value, 11),
        ("1 2.5 -3e1\n1 2 3,5\n", Fault::Value, 15),
        ("1 2.5 \u{e9}\n1 2 3\n", Fault::Value, 6),
    ];
    for (points, fault, offset) in broken {
        let error = parse_text(&(HEADER.to_owned() + points)).expect_err(points);
        assert_eq!((error.fault, error.offset), (fault, HEADER.len() + offset), "{points:?}: {error}");
    }
    let error = parse_text(&(HEADER.to_owned() + "1 2 3\n1 2 abc\n")).unwrap_err();
    let expected = format!("at byte {}: found \"abc\", expected a number", HEADER.len() + 10);
    assert_eq!(error.to_string(), expected);
}

#[test]
fn pcd_text_that_is_no_utf8_is_an_error() {
    let bytes = [HEADER.as_bytes(), b"1 2 \xff\n1 2 3\n"].concat();
    let error = pcd::parse(&bytes).unwrap_err();
    assert_eq!((error.fault, error.offset), (Fault::Value, HEADER.len() + 4));
}

#[test]
fn pcd_rings_that_are_no_beam_are_an_error() {
    let header = HEADER.replace("x y z", "x y ring z").replace("4 4 4", "4 4 4 4");
    let header = header.replace("F F F", "F F F F").replace("1 1 1", "1 1 1 1");
    let error = parse_text(&(header.clone() + "1 2 7 3\n1 2 7.5 3\n")).unwrap_err();
    assert_eq!((error.fault, error.offset), (Fault::Value, header.len() + 12), "{error}");
}

#[test]
fn pcd_cut_anywhere_is_an_error() {
    let schema = [("x", ValueKind::F32, 1), ("y", ValueKind::F64, 1), ("z", ValueKind::I16, 1)];
    for encoding in [DataKind::Binary, DataKind::BinaryCompressed] {
        let bytes = written_by_pcd_rs(encoding, &schema, 40);
        let header_len = bytes.windows(5).position(|window| window == b"DATA ").unwrap();
        for len in 0..bytes.len() {
            let error = pcd::parse(&bytes[..len]).unwrap_err();
            let expected = if len <= header_len + 5 { Fault::Header } else { Fault::Truncated };
            assert!(error.fault == expected || error.fault == Fault::Header, "{len}: {error}");
            assert!(error.offset <= len, "{len}: {error}");
        }
    }
}

#[test]
fn zeros_may_follow_pcd_data_and_nothing_else() {
    let mut bytes = written(pcd::write, &cloud(true, true));
    let len = bytes.len();
    bytes.extend([0; 100]);
    assert_eq!(pcd::parse(&bytes).unwrap(), cloud(true, true));
    bytes[len + 9] = 1;
    let error = pcd::parse(&bytes).unwrap_err();
    assert_eq!((error.fault, error.offset), (Fault::TrailingBytes, len + 9));
}

#[test]
fn compressed_pcd_of_a_wrong_plain_length_is_an_error() {
    let schema = [("x", ValueKind::F32, 1), ("y", ValueKind::F32, 1), ("z", ValueKind::F32, 1)];
    let good = written_by_pcd_rs(DataKind::BinaryCompressed, &schema, 9);
    let data = good.windows(18).position(|window| window == b"binary_compressed\n").unwrap() + 18;
    let mut longer = good.clone();
    longer[data + 4] += 1;
    let error = pcd::parse(&longer).unwrap_err();
    assert_eq!((error.fault, error.offset), (Fault::Compressed, data + 4));
    let mut broken = good;
    broken[data + 8] = 0xff; // a copy where nothing is yet
    let error = pcd::parse(&broken).unwrap_err();
    assert_eq!(error.fault, Fault::Compressed);
    assert!(error.offset > data + 8);
}

#[test]
fn any_flipped_bit_of_a_pcd_is_survived() {
    let schema =
        [("x", ValueKind::F32, 1), ("y", ValueKind::F64, 1), ("z", ValueKind::U8, 1), ("ring", ValueKind::F32, 1)];
    for encoding in ENCODINGS {
        let good = written_by_pcd_rs(encoding, &schema, 20);
        for bit in 0..good.len() * 8 {
            let mut bytes = good.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            if let Err(error) = pcd::parse(&bytes) {
                assert!(error.offset <= bytes.len(), "bit {bit}: {error}");
            }
        }
    }
}

// --- PLY against ply-rs-bw --------------------------------------------------------------------------------------------

#[test]
fn ply_is_what_ply_rs_reads() {
    for cloud in clouds() {
        let bytes = written(ply::write, &cloud);
        let parser = ply_rs_bw::parser::Parser::<DefaultElement>::new();
        let read = parser.read_ply(&mut bytes.as_slice()).unwrap();
        let vertices = &read.payload["vertex"];
        assert_eq!(vertices.len(), cloud.points.len());
        for (index, (vertex, point)) in vertices.iter().zip(&cloud.points).enumerate() {
            let mut expected = point.map(Property::Float).to_vec();
            expected.extend(cloud.intensities.as_ref().map(|list| Property::Float(list[index])));
            expected.extend(cloud.rings.as_ref().map(|list| Property::UShort(list[index])));
            assert_eq!(vertex.values().cloned().collect::<Vec<_>>(), expected);
            let names = ["x", "y", "z", "intensity", "ring"];
            assert!(vertex.keys().all(|key| names.contains(&key.as_str())));
        }
    }
}

// --- files ------------------------------------------------------------------------------------------------------------

/// A folder of this test's own, removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("flicr-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn files_are_told_by_their_extension() {
    let folder = Folder::new("extensions");
    let full = cloud(true, true);
    for (name, expected) in [("a.bin", cloud(true, false)), ("a.xyzir.bin", full.clone()), ("A.PCD", full.clone())] {
        let path = folder.0.join(name);
        files::write(&path, &full).unwrap();
        assert_eq!(files::read(&path).unwrap(), expected, "{name}");
    }
    let path = folder.0.join("a.ply");
    files::write(&path, &full).unwrap();
    assert!(std::fs::read(&path).unwrap().starts_with(b"ply\n"));
    assert!(matches!(files::read(&path), Err(FileError::Extension { .. })));
    assert!(matches!(files::write(&folder.0.join("a.las"), &full), Err(FileError::Extension { .. })));
    assert_eq!(Format::of(Path::new("bin")), None);
}

#[test]
fn file_errors_name_the_file() {
    let folder = Folder::new("errors");
    let path = folder.0.join("short.bin");
    let missing = files::read(&path).unwrap_err();
    assert!(matches!(missing, FileError::Io { .. }) && missing.to_string().contains("short.bin"));
    std::fs::write(&path, [0; 17]).unwrap();
    let broken = files::read(&path).unwrap_err().to_string();
    assert!(broken.ends_with("short.bin: at byte 16: found 1 byte after 1 point, expected records of 16 bytes"));
}

#[test]
fn lists_of_other_lengths_are_not_written() {
    let folder = Folder::new("lengths");
    let mut short = cloud(true, true);
    short.rings = Some(vec![1, 2]);
    let writers: [Write; 4] = [kitti::write, kitti::write_with_rings, pcd::write, ply::write];
    for write in writers {
        let mut bytes = Vec::new();
        assert_eq!(write(&mut bytes, &short).unwrap_err().kind(), std::io::ErrorKind::InvalidInput);
        assert!(bytes.is_empty());
    }
    let path = folder.0.join("short.pcd");
    assert!(files::write(&path, &short).unwrap_err().to_string().contains("2 rings for 3 points"));
    assert!(!path.exists());
}

// --- anything at all --------------------------------------------------------------------------------------------------

fn any_cloud() -> impl Strategy<Value = PointCloud> {
    let float = || -1e30_f32..1e30;
    let point = ([float(), float(), float()], float(), any::<u16>());
    (vec(point, 0..50), any::<bool>(), any::<bool>()).prop_map(|(points, intensities, rings)| PointCloud {
        points: points.iter().map(|point| point.0).collect(),
        intensities: intensities.then(|| points.iter().map(|point| point.1).collect()),
        rings: rings.then(|| points.iter().map(|point| point.2).collect()),
    })
}

/// Lines of a header in any order and number, with values that fit and ones that do not.
fn any_header() -> impl Strategy<Value = String> {
    let line = prop_oneof![
        Just("VERSION 0.7".to_owned()),
        "FIELDS( [xyz_i]){1,5}",
        "SIZE( [1248]){1,5}",
        "TYPE( [FIU]){1,5}",
        "COUNT( [1-9][0-9]{0,18}){1,5}",
        "(WIDTH|HEIGHT|POINTS) [0-9]{1,19}",
        "DATA (ascii|binary|binary_compressed)",
    ];
    vec(line, 1..14).prop_map(|lines| lines.join("\n") + "\n")
}

proptest! {
    #[test]
    fn any_cloud_comes_back(cloud in any_cloud()) {
        prop_assert_eq!(&pcd::parse(&written(pcd::write, &cloud)).unwrap(), &cloud);
        let full = kitti::parse_with_rings(&written(kitti::write_with_rings, &cloud)).unwrap();
        prop_assert_eq!(&full.points, &cloud.points);
        prop_assert_eq!(full.rings, Some(cloud.rings.unwrap_or(vec![0; cloud.points.len()])));
    }

    #[test]
    fn any_bytes_are_survived(bytes in vec(any::<u8>(), 0..200), header in any_header()) {
        let _ = pcd::parse(&bytes);
        let _ = pcd::parse(&[header.as_bytes(), &bytes].concat());
        let sane = HEADER.replace("ascii", "binary_compressed");
        let _ = pcd::parse(&[sane.as_bytes(), &bytes].concat());
        prop_assert_eq!(kitti::parse(&bytes).is_ok(), bytes.len() % 16 == 0);
    }
}
