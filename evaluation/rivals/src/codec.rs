//! Codecs by name:
//!
//! * `rle`, `gzip:LEVEL`, `zstd:LEVEL`: bytes of the file as they are, 16 a point, intensity with them;
//! * `cloudini:STEP_M:zstd|lz4`, `laszip:STEP_M`: x, y and z in steps;
//! * `authors:...`: authors.rs.

use std::error::Error;
use std::io::{Read, Write};
use std::path::Path;

use serde_json::json;

use crate::cost::{Cost, measure};
use crate::{Outcome, authors};

type Boxed<T> = Result<T, Box<dyn Error>>;

pub fn run(name: &str, scan: &[[f32; 4]], out: &Path, runs: usize) -> Outcome {
    let words: Vec<&str> = name.split(':').collect();
    match *words.as_slice() {
        ["rle"] => of_bytes(scan, out, runs, |bytes| Ok(rle(bytes)), |coded, len| Ok(unrle(coded, len))),
        ["gzip", level] => {
            let level = flate2::Compression::new(level.parse()?);
            of_bytes(scan, out, runs, |bytes| deflate(bytes, level), inflate)
        }
        ["authors", ..] => authors::run(&words[1..], scan, out, runs),
        #[cfg(feature = "codecs")]
        ["zstd", level] => {
            let level = level.parse()?;
            of_bytes(
                scan,
                out,
                runs,
                |bytes| Ok(zstd::bulk::compress(bytes, level)?),
                |coded, len| Ok(zstd::bulk::decompress(coded, len)?),
            )
        }
        #[cfg(feature = "codecs")]
        ["cloudini", step_m, second] => others::cloudini(step_m.parse()?, second, scan, out, runs),
        #[cfg(feature = "codecs")]
        ["laszip", step_m] => others::laszip(step_m.parse()?, scan, out, runs),
        _ => Err(format!("no codec {name}").into()),
    }
}

pub fn report(bytes: usize, encode: Cost, decode: Cost) -> serde_json::Value {
    json!({ "bytes": bytes, "encode": encode.json(), "decode": decode.json() })
}

/// A lossless codec of the whole file's bytes.
fn of_bytes(
    scan: &[[f32; 4]],
    out: &Path,
    runs: usize,
    encode: impl Fn(&[u8]) -> Boxed<Vec<u8>>,
    decode: impl Fn(&[u8], usize) -> Boxed<Vec<u8>>,
) -> Outcome {
    let raw: &[u8] = bytemuck::cast_slice(scan);
    let (coded, encoding) = measure(runs, || encode(raw));
    let coded = coded?;
    let (decoded, decoding) = measure(runs, || decode(&coded, raw.len()));
    let decoded = decoded?;
    if decoded != raw {
        return Err("what came back is not what went in".into());
    }
    std::fs::write(out, decoded)?;
    Ok(report(coded.len(), encoding, decoding))
}

/// A byte and how often it comes, up to 255 times: what the paper's 0.54 is of.
pub fn rle(bytes: &[u8]) -> Vec<u8> {
    let mut coded = Vec::with_capacity(2 * bytes.len());
    let mut rest = bytes;
    while let [first, ..] = *rest {
        let run = rest.iter().take(255).take_while(|&&byte| byte == first).count();
        coded.extend([first, run as u8]);
        rest = &rest[run..];
    }
    coded
}

pub fn unrle(coded: &[u8], len: usize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(len);
    for pair in coded.chunks_exact(2) {
        bytes.resize(bytes.len() + usize::from(pair[1]), pair[0]);
    }
    bytes
}

pub fn deflate(bytes: &[u8], level: flate2::Compression) -> Boxed<Vec<u8>> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::with_capacity(bytes.len()), level);
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}

pub fn inflate(coded: &[u8], len: usize) -> Boxed<Vec<u8>> {
    let mut bytes = Vec::with_capacity(len);
    flate2::read::ZlibDecoder::new(coded).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(feature = "codecs")]
mod others {
    use super::{Outcome, Path, measure, report};
    use crate::cloud;
    use cloudini::{
        CompressionOption, EncodingInfo, EncodingOptions, FieldType, PointField, PointcloudDecoder, PointcloudEncoder,
    };
    use laz::{LasZipCompressor, LasZipDecompressor, LazItemRecordBuilder, LazItemType, LazVlr};
    use std::io::Cursor;

    pub fn cloudini(step_m: f32, second: &str, scan: &[[f32; 4]], out: &Path, runs: usize) -> Outcome {
        let points = cloud::returns(scan);
        let field = |(index, name): (usize, &str)| PointField {
            name: name.into(),
            offset: 4 * index as u32,
            field_type: FieldType::Float32,
            resolution: Some(step_m),
        };
        let info = EncodingInfo {
            fields: ["x", "y", "z"].into_iter().enumerate().map(field).collect(),
            width: points.len() as u32,
            height: 1,
            point_step: 12,
            encoding_opt: EncodingOptions::Lossy,
            compression_opt: if second == "lz4" { CompressionOption::Lz4 } else { CompressionOption::Zstd },
            ..EncodingInfo::default()
        };
        // One core, as all others have.
        let encoder = PointcloudEncoder::new(info).with_threads(false);
        let (coded, encode) = measure(runs, || encoder.encode(bytemuck::cast_slice(&points)));
        let coded = coded?;
        let decoder = PointcloudDecoder::new().with_threads(false);
        let (decoded, decode) = measure(runs, || decoder.decode(&coded));
        let decoded: Vec<[f32; 3]> = decoded?.1.chunks_exact(12).map(bytemuck::pod_read_unaligned).collect();
        cloud::write(out, &decoded)?;
        Ok(report(coded.len(), encode, decode))
    }

    const RECORD_LEN: usize = 20;

    /// LAS point format 0 with nothing in it but x, y and z: the other fields are zero and cost next to nothing.
    pub fn laszip(step_m: f64, scan: &[[f32; 4]], out: &Path, runs: usize) -> Outcome {
        let points = cloud::returns(scan);
        let vlr = || LazVlr::from_laz_items(LazItemRecordBuilder::new().add_item(LazItemType::Point10).build());
        let (coded, encode) = measure(runs, || {
            let mut records = Vec::with_capacity(RECORD_LEN * points.len());
            for &point in &points {
                for coordinate in point {
                    let steps = (f64::from(coordinate) / step_m).round() as i32;
                    records.extend(steps.to_le_bytes());
                }
                records.extend([0; RECORD_LEN - 12]);
            }
            let mut coded = Cursor::new(Vec::new());
            let mut compressor = LasZipCompressor::new(&mut coded, vlr())?;
            compressor.compress_many(&records)?;
            compressor.done()?;
            drop(compressor);
            laz::Result::Ok(coded.into_inner())
        });
        let coded = coded?;
        let (decoded, decode) = measure(runs, || {
            let mut records = vec![0; RECORD_LEN * points.len()];
            LasZipDecompressor::new(Cursor::new(&coded), vlr())?.decompress_many(&mut records)?;
            let steps = |record: &[u8], axis: usize| i32::from_le_bytes([0, 1, 2, 3].map(|at| record[4 * axis + at]));
            let point = |record: &[u8]| [0, 1, 2].map(|axis| (f64::from(steps(record, axis)) * step_m) as f32);
            laz::Result::Ok(records.chunks_exact(RECORD_LEN).map(point).collect::<Vec<_>>())
        });
        cloud::write(out, &decoded?)?;
        Ok(report(coded.len(), encode, decode))
    }
}
