//! What the paper's authors do, plainly: libm per point, zlib level 1, sine and cosine per pixel. The yardstick of
//! the timings in `docs/PERFORMANCE.md`; never changed to make ours look better or worse.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

pub const ROWS: usize = 64;
const TOP_DEG: f32 = 88.0;
const ROW_DEG: f32 = 0.4187;

/// Ranges, row-major, 0 = no return; the last point wins.
pub fn project(points: &[[f32; 4]], columns: usize, image: &mut [f32]) {
    image.fill(0.0);
    let column_deg = 360.0 / columns as f32;
    for &[x, y, z, _] in points {
        let range = (x * x + y * y + z * z).sqrt();
        let polar_deg = (z / range).acos().to_degrees();
        let azimuth_deg = y.atan2(x).to_degrees();
        let row = ((polar_deg - TOP_DEG) / ROW_DEG) as i32;
        let column = ((azimuth_deg + 180.0) / column_deg) as usize;
        let row = row.clamp(0, 63) as usize;
        image[row * columns + column.min(columns - 1)] = range;
    }
}

/// 8 bits over 0 to the image's largest range.
pub fn quantize(image: &[f32], levels: &mut [u8]) -> f32 {
    let max = image.iter().copied().fold(0.0, f32::max);
    for (level, range) in levels.iter_mut().zip(image) {
        *level = (range * 255.0 / max + 0.5) as u8;
    }
    max
}

pub fn deflate(levels: &[u8], level: u32) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(levels.len()), Compression::new(level));
    encoder.write_all(levels).unwrap();
    encoder.finish().unwrap()
}

pub fn inflate(bytes: &[u8], levels: &mut [u8]) {
    ZlibDecoder::new(bytes).read_exact(levels).unwrap();
}

/// The authors' way back: a float image first, then sine and cosine of both angles for every pixel that holds a
/// return, in a function of its own (theirs is a method of another object).
pub fn reconstruct(levels: &[u8], columns: usize, max: f32, image: &mut [f32], points: &mut Vec<[f32; 3]>) {
    for (range, &level) in image.iter_mut().zip(levels) {
        *range = f32::from(level) * max / 255.0;
    }
    points.clear();
    for (row, ranges) in image.chunks_exact(columns).enumerate() {
        for (column, &range) in ranges.iter().enumerate() {
            if range > 0.0 {
                points.push(to_xyz(range, row, column, 360.0 / columns as f32));
            }
        }
    }
}

#[inline(never)]
pub fn to_xyz(range: f32, row: usize, column: usize, column_deg: f32) -> [f32; 3] {
    let polar = (row as f32 * ROW_DEG + TOP_DEG).to_radians();
    let azimuth = (column as f32 * column_deg - 180.0).to_radians();
    [range * polar.sin() * azimuth.cos(), range * polar.sin() * azimuth.sin(), range * polar.cos()]
}
