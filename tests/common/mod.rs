//! What several tests share.
#![allow(dead_code, reason = "each test uses a part")]

pub mod data;
pub mod range_images;
pub mod statistics;

/// Points all around at all ranges, the same every time: a spiral over the band that an HDL-64E sees.
pub fn spiral(points: usize) -> Vec<[f32; 3]> {
    (0..points)
        .map(|i| {
            let t = i as f64 / points as f64;
            let (azimuth, elevation) = (t * 977.0, (2.0 - 26.8 * ((t * 64.0) % 1.0)).to_radians());
            let range = 1.0 + 78.0 * ((t * 313.7) % 1.0);
            let ground = range * elevation.cos();
            [ground * azimuth.cos(), ground * azimuth.sin(), range * elevation.sin()].map(|v| v as f32)
        })
        .collect()
}

pub fn xyz(points: &[[f32; 4]]) -> Vec<[f32; 3]> {
    points.iter().map(|&[x, y, z, _]| [x, y, z]).collect()
}
