//! The points, in each of the three encodings.

use std::vec::Vec;

use super::super::error::{counted, quote};
use super::super::{Fault, ParseError, PointCloud, record};
use super::header::{Encoding, Field, Fields, Header, Kind};
use super::lzf;

/// A point of text has at least three digits and their separators.
const MIN_ASCII_POINT_LEN: usize = 6;
/// Two lengths before compressed data.
const COMPRESSED_HEADER_LEN: usize = 8;

pub(super) fn parse(bytes: &[u8], header: &Header) -> Result<PointCloud, ParseError> {
    let data = &bytes[header.data_offset..];
    match header.encoding {
        Encoding::Ascii => parse_ascii(data, header),
        Encoding::Binary => parse_binary(data, header),
        Encoding::Compressed => parse_compressed(data, header),
    }
}

/// A point's value and the byte of the file it is from.
type Value = Result<(f64, usize), ParseError>;

/// Collects points whose values come from a function of the field.
struct Collector<'a> {
    fields: &'a Fields,
    cloud: PointCloud,
}

impl<'a> Collector<'a> {
    /// `points` must be bounded by the input's length.
    fn new(fields: &'a Fields, points: usize) -> Self {
        let cloud = PointCloud {
            points: Vec::with_capacity(points),
            intensities: fields.intensity.map(|_| Vec::with_capacity(points)),
            rings: fields.ring.map(|_| Vec::with_capacity(points)),
        };
        Self { fields, cloud }
    }

    fn push(&mut self, value: impl Fn(Field) -> Value) -> Result<(), ParseError> {
        let [x, y, z] = self.fields.xyz;
        let float = |field| value(field).map(|(value, _)| narrow(value));
        self.cloud.points.push([float(x)?, float(y)?, float(z)?]);
        if let (Some(field), Some(intensities)) = (self.fields.intensity, &mut self.cloud.intensities) {
            intensities.push(float(field)?);
        }
        if let (Some(field), Some(rings)) = (self.fields.ring, &mut self.cloud.rings) {
            let (value, offset) = value(field)?;
            rings.push(record::ring(value, offset)?);
        }
        Ok(())
    }
}

fn narrow(value: f64) -> f32 {
    value as f32
}

// --- binary -----------------------------------------------------------------------------------------------------------

/// Point after point.
fn parse_binary(data: &[u8], header: &Header) -> Result<PointCloud, ParseError> {
    let data = check_len(data, header, binary_len(header))?;
    let mut collector = Collector::new(&header.fields, header.points);
    for point in 0..header.points {
        let start = point * header.fields.record_len;
        collector.push(|field| {
            let offset = start + field.offset;
            Ok((read(field.kind, data, offset), header.data_offset + offset))
        })?;
    }
    Ok(collector.cloud)
}

/// All points' values of the first field, then of the next; LZF over all.
fn parse_compressed(data: &[u8], header: &Header) -> Result<PointCloud, ParseError> {
    let plain = decompress(data, header)?;
    let mut collector = Collector::new(&header.fields, header.points);
    for point in 0..header.points {
        collector.push(|field| {
            let offset = header.points * field.offset + point * field.kind.len();
            // No byte of the file is this value's own.
            Ok((read(field.kind, &plain, offset), header.data_offset))
        })?;
    }
    Ok(collector.cloud)
}

fn decompress(data: &[u8], header: &Header) -> Result<Vec<u8>, ParseError> {
    let Some(&[c0, c1, c2, c3, p0, p1, p2, p3]) = data.first_chunk() else {
        return Err(too_short(data, header, COMPRESSED_HEADER_LEN as u128));
    };
    let compressed_len = u32::from_le_bytes([c0, c1, c2, c3]);
    let plain_len = u32::from_le_bytes([p0, p1, p2, p3]);
    let data = check_len(data, header, COMPRESSED_HEADER_LEN as u128 + u128::from(compressed_len))?;
    if u128::from(plain_len) != binary_len(header) {
        let found = std::format!("a plain length of {}", counted(plain_len as usize, "byte"));
        let expected = std::format!("the points' {}", binary_len(header));
        return Err(ParseError::new(Fault::Compressed, header.data_offset + 4, found, expected));
    }
    lzf::decompress(&data[COMPRESSED_HEADER_LEN..], plain_len as usize).map_err(|broken| {
        let offset = header.data_offset + COMPRESSED_HEADER_LEN + broken.offset;
        let expected = std::format!("one of {plain_len} plain bytes");
        ParseError::new(Fault::Compressed, offset, "a broken LZF stream", expected)
    })
}

/// 128 bits hold the product of any two header numbers.
fn binary_len(header: &Header) -> u128 {
    header.points as u128 * header.fields.record_len as u128
}

/// The data without the zeros that PCL pads its files with.
fn check_len<'a>(data: &'a [u8], header: &Header, need: u128) -> Result<&'a [u8], ParseError> {
    let Some((data, padding)) = usize::try_from(need).ok().and_then(|need| data.split_at_checked(need)) else {
        return Err(too_short(data, header, need));
    };
    let Some(index) = padding.iter().position(|&byte| byte != 0) else {
        return Ok(data);
    };
    let found = counted(padding.len(), "byte");
    let expected = std::format!("the end after {} of data, or zeros", counted(data.len(), "byte"));
    Err(ParseError::new(Fault::TrailingBytes, header.data_offset + data.len() + index, found, expected))
}

fn too_short(data: &[u8], header: &Header, need: u128) -> ParseError {
    let found = std::format!("the end after {} of data", counted(data.len(), "byte"));
    let expected = std::format!("{need} for {}", counted(header.points, "point"));
    ParseError::new(Fault::Truncated, header.data_offset + data.len(), found, expected)
}

/// The caller has checked that the value is within `data`.
fn read(kind: Kind, data: &[u8], offset: usize) -> f64 {
    fn bytes<const LEN: usize>(data: &[u8], offset: usize) -> [u8; LEN] {
        let mut bytes = [0; LEN];
        bytes.copy_from_slice(&data[offset..offset + LEN]);
        bytes
    }
    match kind {
        Kind::F32 => f64::from(f32::from_le_bytes(bytes(data, offset))),
        Kind::F64 => f64::from_le_bytes(bytes(data, offset)),
        Kind::I8 => f64::from(i8::from_le_bytes(bytes(data, offset))),
        Kind::I16 => f64::from(i16::from_le_bytes(bytes(data, offset))),
        Kind::I32 => f64::from(i32::from_le_bytes(bytes(data, offset))),
        Kind::I64 => i64::from_le_bytes(bytes(data, offset)) as f64,
        Kind::U8 => f64::from(u8::from_le_bytes(bytes(data, offset))),
        Kind::U16 => f64::from(u16::from_le_bytes(bytes(data, offset))),
        Kind::U32 => f64::from(u32::from_le_bytes(bytes(data, offset))),
        Kind::U64 => u64::from_le_bytes(bytes(data, offset)) as f64,
    }
}

// --- ascii ------------------------------------------------------------------------------------------------------------

/// A line a point, a word a value.
fn parse_ascii(data: &[u8], header: &Header) -> Result<PointCloud, ParseError> {
    let most = data.len() / MIN_ASCII_POINT_LEN + 1;
    let mut collector = Collector::new(&header.fields, header.points.min(most));
    let mut offset = header.data_offset;
    for line in data.split_inclusive(|&byte| byte == b'\n') {
        let words = words(line, offset)?;
        if !words.is_empty() {
            push_words(&mut collector, &words, header)?;
        }
        offset += line.len();
    }
    let found = collector.cloud.points.len();
    if found < header.points {
        let found = counted(found, "point");
        return Err(ParseError::new(Fault::Truncated, offset, found, header.points));
    }
    Ok(collector.cloud)
}

/// A line's words, each with the byte of the file it starts at.
fn words(line: &[u8], offset: usize) -> Result<Vec<(&str, usize)>, ParseError> {
    let text = core::str::from_utf8(line).map_err(|error| {
        let found = "bytes that are no text";
        ParseError::new(Fault::Value, offset + error.valid_up_to(), found, "numbers")
    })?;
    let offset_of = |word: &str| offset + (word.as_ptr().addr() - text.as_ptr().addr());
    Ok(text.split_ascii_whitespace().map(|word| (word, offset_of(word))).collect())
}

fn push_words(collector: &mut Collector, words: &[(&str, usize)], header: &Header) -> Result<(), ParseError> {
    let (_, offset) = words[0];
    if collector.cloud.points.len() == header.points {
        let expected = std::format!("the end after {}", counted(header.points, "point"));
        return Err(ParseError::new(Fault::TrailingBytes, offset, "one more point", expected));
    }
    if words.len() != header.fields.value_count {
        let found = std::format!("a line of {}", counted(words.len(), "value"));
        return Err(ParseError::new(Fault::Value, offset, found, header.fields.value_count));
    }
    collector.push(|field| {
        let (word, offset) = words[field.column];
        let value = word.parse::<f64>();
        let no_number = |_| ParseError::new(Fault::Value, offset, quote(word), "a number");
        value.map(|value| (value, offset)).map_err(no_number)
    })
}
