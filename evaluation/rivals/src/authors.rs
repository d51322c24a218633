//! The paper's own codec as its authors wrote it, plainly (benches/baseline): `authors:COLUMNS:8bit|float:lz77|rle`.

#[allow(dead_code, reason = "its coder is for levels only")]
#[path = "../../../benches/baseline/mod.rs"]
pub mod baseline;

use std::path::Path;

use serde_json::json;

use crate::codec::{deflate, inflate, report, rle, unrle};
use crate::cost::measure;
use crate::{Outcome, cloud};

pub fn run(words: &[&str], scan: &[[f32; 4]], out: &Path, runs: usize) -> Outcome {
    let [columns, depth, coder] = *words else { return Err("expected authors:COLUMNS:8bit|float:lz77|rle".into()) };
    let columns: usize = columns.parse()?;
    let is_quantized = depth == "8bit";
    let scan: Vec<[f32; 4]> = scan.iter().copied().filter(|&[x, y, z, _]| x * x + y * y + z * z > 0.0).collect();
    let pixels = baseline::ROWS * columns;
    let (mut image, mut levels) = (vec![0.0_f32; pixels], vec![0_u8; pixels]);
    let ((), project) = measure(runs, || baseline::project(&scan, columns, &mut image));
    let (max, quantize) = measure(runs, || if is_quantized { baseline::quantize(&image, &mut levels) } else { 0.0 });
    let bytes: &[u8] = if is_quantized { &levels } else { bytemuck::cast_slice(&image) };
    let (coded, code) =
        measure(runs, || if coder == "rle" { Ok(rle(bytes)) } else { deflate(bytes, flate2::Compression::new(1)) });
    let coded = coded?;

    let len = bytes.len();
    let (decoded, uncode) =
        measure(runs, || if coder == "rle" { Ok(unrle(&coded, len)) } else { inflate(&coded, len) });
    let decoded = decoded?;
    let mut points = Vec::with_capacity(scan.len());
    let ((), reconstruct) = measure(runs, || {
        if is_quantized {
            baseline::reconstruct(&decoded, columns, max, &mut image, &mut points);
        } else {
            reconstruct(&decoded, columns, &mut points);
        }
    });
    cloud::write(out, &points)?;
    let mut made = report(coded.len(), project.and(quantize).and(code), uncode.and(reconstruct));
    made["stages"] = json!({
        "project": project.json(), "quantize": quantize.json(), "code": code.json(),
        "uncode": uncode.json(), "reconstruct": reconstruct.json(),
    });
    Ok(made)
}

/// As the baseline does it, of an image of floats.
fn reconstruct(image: &[u8], columns: usize, points: &mut Vec<[f32; 3]>) {
    points.clear();
    for (pixel, bytes) in image.chunks_exact(4).enumerate() {
        let range: f32 = bytemuck::pod_read_unaligned(bytes);
        if range > 0.0 {
            points.push(baseline::to_xyz(range, pixel / columns, pixel % columns, 360.0 / columns as f32));
        }
    }
}
