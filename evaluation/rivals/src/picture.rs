//! The authors' 8-bit image for image and video codecs, and points out of what those make of it.

use std::path::Path;

use serde_json::json;

use crate::authors::baseline;
use crate::{Outcome, cloud};

pub fn write(columns: usize, scan: &[[f32; 4]], out: &Path) -> Outcome {
    let scan: Vec<[f32; 4]> = scan.iter().copied().filter(|&[x, y, z, _]| x * x + y * y + z * z > 0.0).collect();
    let (mut image, mut levels) = (vec![0.0; baseline::ROWS * columns], vec![0; baseline::ROWS * columns]);
    baseline::project(&scan, columns, &mut image);
    let max_m = baseline::quantize(&image, &mut levels);
    std::fs::write(out, levels)?;
    Ok(json!({ "max_m": max_m, "rows": baseline::ROWS }))
}

pub fn read(columns: usize, max_m: f32, image: &Path, out: &Path) -> Outcome {
    let levels = std::fs::read(image)?;
    if levels.len() != baseline::ROWS * columns {
        return Err(format!("{} bytes of image: expected {}", levels.len(), baseline::ROWS * columns).into());
    }
    let (mut ranges, mut points) = (vec![0.0; levels.len()], Vec::new());
    baseline::reconstruct(&levels, columns, max_m, &mut ranges, &mut points);
    cloud::write(out, &points)?;
    Ok(json!({ "points": points.len() }))
}
