//! Points on a sensor's own grid, there and back.
#![allow(dead_code, reason = "each test uses a part")]

use std::f64::consts::TAU;

use flicr::geometry::{Beam, Lattice, Pixels, Projection, SensorGrid, sensors};
use flicr::{
    Decoder, Encoded, ImageViewMut, LatticeConfig, Level, Levels, Limits, Points, Quantizer, Rle, Stamp, encode,
};

/// Beam, tick and range in counts.
pub type Cell = (usize, u32, f64);

/// The nearest cell, by `codec.md`'s formulas in double precision over all beams, with no offset in the distance from
/// the axis where ranges begin there: nothing is shared with the crate but the table of beams.
#[expect(clippy::many_single_char_names, reason = "the letters of the formulas")]
pub fn exact_cell(grid: &SensorGrid<'_>, [x, y, z]: [f64; 3]) -> Cell {
    let rho = libm::hypot(x, y);
    let beside = |beam: &Beam| if grid.range_from_axis { 0.0 } else { f64::from(beam.h_offset_m) };
    let reach = |beam: &Beam| libm::sqrt(rho * rho - beside(beam).powi(2));
    let off = |beam: &Beam| (z - f64::from(beam.slope) * reach(beam) - f64::from(beam.z_offset_m)).abs();
    let offs = grid.beams.iter().map(off).enumerate();
    let (row, _) = offs.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let beam = &grid.beams[row];
    let aside = libm::asin(f64::from(beam.h_offset_m) / rho);
    let turned = libm::atan2(y, x) + aside - f64::from(beam.azimuth_phase_rad) - f64::from(grid.zero_rad);
    let turned = if grid.clockwise { -turned } else { turned };
    let tick = libm::round(turned / TAU * f64::from(grid.ticks)) as i64;
    let v = libm::atan(f64::from(beam.slope));
    let vo = f64::from(beam.z_offset_m) * libm::cos(v);
    let d = (reach(beam) + vo * libm::sin(v)) * libm::cos(v) + (z - vo * libm::cos(v)) * libm::sin(v);
    let count = (d - f64::from(beam.range_phase_m)) / f64::from(grid.range_unit_m);
    (row, tick.rem_euclid(i64::from(grid.ticks)) as u32, count)
}

/// Levels that are range counts.
pub fn counts(grid: &SensorGrid<'_>) -> Quantizer {
    Quantizer::with_step(16, grid.range_unit_m).unwrap()
}

/// Row, column and count of each point, in order; the mark of points outside the elevations is taken off.
pub fn projected<const LINES: usize>(
    lattice: &Lattice<'_, LINES>,
    points: &(impl Points + ?Sized),
) -> Vec<(u32, u32, u32)> {
    let (columns, mut pixels, mut found) = (u32::from(lattice.columns()), Pixels::new(), Vec::new());
    let quantizer = counts(lattice.grid());
    points.for_each_block(|block, len| {
        lattice.project(block, &quantizer, &mut pixels);
        let lanes = pixels.pixel.iter().zip(&pixels.level).take(len);
        let pixel = |pixel: u32| pixel & !Pixels::CLAMPED;
        found.extend(lanes.map(|(&p, &level)| (pixel(p) / columns, pixel(p) % columns, level)));
    });
    found
}

pub fn hdl64e() -> Lattice<'static, 66> {
    Lattice::new(sensors::hdl64e::GRID, 4000).unwrap()
}

pub fn encoded<L: Level, const LINES: usize>(
    config: &LatticeConfig<'_, LINES>,
    points: &(impl Points + ?Sized),
) -> (Encoded, Vec<u8>) {
    let columns = usize::from(config.lattice.columns());
    let mut levels = vec![L::NONE; columns * usize::from(config.lattice.rows())];
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let mut out = vec![0; config.worst_case_len::<L, Rle>()];
    let stamp = Stamp { sequence: 3, timestamp_ns: 5 };
    let encoded = encode(config, points, stamp, image, &mut Rle::new(), &mut out).unwrap();
    out.truncate(encoded.len);
    (encoded, out)
}

/// The pixel of every decoded point, in their order.
pub fn pixels_of(levels: &Levels) -> Vec<u32> {
    let occupied = |levels: &[u16]| (0..).zip(levels).filter(|(_, l)| **l != 0).map(|(pixel, _)| pixel).collect();
    match levels {
        Levels::U8(levels) => occupied(&levels.iter().map(|&level| level.into()).collect::<Vec<u16>>()),
        Levels::U16(levels) => occupied(levels),
    }
}

pub fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    let apart = [0, 1, 2].map(|i| f64::from(a[i]) - f64::from(b[i]));
    apart.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// How far each point is from the decoded point of its pixel; those whose pixel another point got are left out where
/// its level is another.
pub fn distances(lattice: &impl Projection, points: &[[f32; 3]], bytes: &[u8]) -> Vec<([f32; 3], [f32; 3], f64)> {
    let mut decoder = Decoder::new(Limits::default());
    let frame = decoder.decode(bytes).unwrap();
    let decoded = frame.points();
    let places: std::collections::HashMap<u32, [f32; 3]> =
        pixels_of(frame.levels()).into_iter().zip(decoded.iter().copied()).collect();
    assert_eq!(places.len(), decoded.len());
    let (quantizer, mut pixels, mut found) = (frame.header().quantizer, Pixels::new(), Vec::new());
    points.for_each_block(|block, len| {
        lattice.project(block, &quantizer, &mut pixels);
        for i in 0..len {
            let point = [block.x[i], block.y[i], block.z[i]];
            let pixel = pixels.pixel[i] & !Pixels::CLAMPED;
            let kept = match frame.levels() {
                Levels::U8(levels) => u32::from(levels[pixel as usize]) == pixels.level[i],
                Levels::U16(levels) => u32::from(levels[pixel as usize]) == pixels.level[i],
            };
            if kept {
                found.push((point, places[&pixel], distance(point, places[&pixel])));
            }
        }
    });
    found
}
