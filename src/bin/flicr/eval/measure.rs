//! One scan in one configuration: everything that is measured of it.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use flicr::metrics::{self, EpsnrParameters, PAPER_MAX_RANGE_M, Quality};
use flicr::{Decoder, Encoded, Limits, Stamp};
use serde::Serialize;

use crate::args::word;
use crate::codec::Codec;
use crate::failure::Failure;
use crate::input::Scan;
use crate::plan::Plan;

/// Runs of which the fastest counts: the others were disturbed.
const RUNS: usize = 7;

/// The JSON object, in its order of fields. What is infinite (the PSNR of equal clouds) is null there.
#[derive(Debug, Serialize)]
pub struct Measured {
    pub file: String,
    /// `paper`, `uniform`, or `sensor` where none was asked for.
    pub preset: String,
    pub geometry: &'static str,
    pub sensor: Option<String>,
    pub why: String,
    /// As asked for; what a table is made by.
    #[serde(skip)]
    pub columns_asked: String,
    pub columns: usize,
    pub rows: usize,
    pub coder: String,
    pub tier: Option<String>,
    pub bits: u32,
    pub step_m: Option<f32>,
    pub range_bound_m: f32,
    pub points: u32,
    pub kept: u32,
    pub bytes: usize,
    pub ratio_xyz: f64,
    pub ratio_xyzi: f64,
    pub bpp: f64,
    pub se: f64,
    pub psnr_db: f64,
    pub psnr_reverse_db: f64,
    pub cd_m2: f64,
    pub cd_mean_m: f64,
    pub epsnr_db: f64,
    pub max_error_m: f64,
    pub encode_ns: u64,
    pub decode_ns: u64,
}

/// Encodes, decodes and compares.
pub fn measure(codec: &mut Codec, scan: &Scan, file: &Path, smooth: bool) -> Result<Measured, Failure> {
    let (encoded, encode_ns) = fastest(|| codec.encode(scan, Stamp::default()));
    let encoded = encoded.map_err(|error| Failure::data(file, error))?;
    let mut decoder = Decoder::new(Limits::default());
    let mut points = Vec::new();
    let (result, decode_ns) = fastest(|| {
        decoder
            .decode(codec.frame())
            .map(|frame| if smooth { points = frame.smooth_points() } else { frame.points_into(&mut points) })
    });
    result.map_err(|error| Failure::data(file, error))?;
    let (se, epsnr_db, quality) = compare(scan, &points, &encoded).map_err(|error| Failure::data(file, error))?;
    let (Plan { shape, why }, args) = (codec.plan(), codec.args());
    let sensor = shape.sensor();
    let (bytes, points_in_file) = (encoded.len as f64, scan.cloud.points.len() as f64);
    Ok(Measured {
        file: scan.name(file),
        preset: args.preset.as_ref().map_or_else(|| "sensor".to_owned(), word),
        geometry: shape.word(),
        sensor: sensor.map(|sensor| sensor.grid().name.to_owned()),
        why: why.clone(),
        columns_asked: codec.columns_asked(),
        columns: shape.columns(),
        rows: sensor.map_or(args.rows.into(), |sensor| sensor.grid().beams.len()),
        coder: word(&args.coder()),
        tier: args.is_context().then(|| word(&args.choice.tier)),
        bits: args.bits(),
        step_m: codec.step_m(),
        range_bound_m: encoded.range_bound_m,
        points: encoded.tally.returns(),
        kept: encoded.tally.kept(),
        bytes: encoded.len,
        ratio_xyz: 12.0 * points_in_file / bytes,
        ratio_xyzi: 16.0 * points_in_file / bytes,
        bpp: 8.0 * bytes / points_in_file,
        se,
        psnr_db: quality.psnr_db,
        psnr_reverse_db: quality.psnr_reverse_db,
        cd_m2: quality.cd_m2,
        cd_mean_m: quality.cd_mean_m,
        epsnr_db,
        max_error_m: quality.max_error_m,
        encode_ns,
        decode_ns,
    })
}

fn compare(scan: &Scan, decoded: &[[f32; 3]], encoded: &Encoded) -> Result<(f64, f64, Quality), metrics::MetricError> {
    let se = metrics::sampling_error(encoded.tally.returns() as usize, decoded.len())?;
    let quality = metrics::compare(&scan.returns(), decoded, PAPER_MAX_RANGE_M)?;
    let epsnr_db = metrics::epsnr_db(quality.psnr_db, se, EpsnrParameters::PAPER)?;
    Ok((se, epsnr_db, quality))
}

/// The last run's result, and the time of the fastest.
fn fastest<T>(mut work: impl FnMut() -> T) -> (T, u64) {
    let mut timed = || {
        let start = Instant::now();
        let result = black_box(work());
        (result, start.elapsed().as_nanos() as u64)
    };
    let (mut result, mut fastest_ns) = timed();
    for _ in 1..RUNS {
        let (next, ns) = timed();
        (result, fastest_ns) = (next, fastest_ns.min(ns));
    }
    (result, fastest_ns)
}
