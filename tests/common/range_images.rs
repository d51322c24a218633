//! The paper's 8-bit images by an independent few lines, and zlib: the yardstick of the coders.

#[allow(dead_code, reason = "not every user goes through all widths")]
pub const WIDTHS: [usize; 6] = [4500, 4096, 2048, 1024, 512, 256];
const ROWS: usize = 64;

/// Uniform rows (+2 to -24.8 degrees, clamped) and columns, the nearest point wins, level = range * 255 / largest.
pub fn image(points: &[[f32; 4]], columns: usize) -> Vec<u8> {
    let mut ranges = vec![0.0_f64; ROWS * columns];
    for &[x, y, z, _] in points {
        let [x, y, z] = [x, y, z].map(f64::from);
        let range = (x * x + y * y + z * z).sqrt();
        if range > 0.0 {
            let row = ((z / range).acos().to_degrees() - 88.0) / 0.41875;
            let column = (y.atan2(x).to_degrees() + 180.0) / (360.0 / columns as f64);
            let row = (row as usize).min(ROWS - 1);
            let pixel = &mut ranges[row * columns + (column as usize).min(columns - 1)];
            if *pixel == 0.0 || range < *pixel {
                *pixel = range;
            }
        }
    }
    let largest = ranges.iter().copied().fold(0.0, f64::max);
    ranges.iter().map(|&r| if r == 0.0 { 0 } else { ((r * 255.0 / largest).round() as u8).max(1) }).collect()
}

/// Writes zlib's raw stream of `bytes` to `out`; gives its length.
pub fn zlib(bytes: &[u8], level: u32, out: &mut [u8]) -> usize {
    let mut zlib = flate2::Compress::new(flate2::Compression::new(level), false);
    zlib.compress(bytes, out, flate2::FlushCompress::Finish).unwrap();
    zlib.total_out() as usize
}
