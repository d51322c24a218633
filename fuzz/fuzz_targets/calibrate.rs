//! Any points to calibrate and to recognize a sensor by: an error or a sensor that is one, no panic.
//!
//! The first byte says whether beams are known and how points are made: of any floats, or on a made-up sensor's grid with
//! some of them moved.
#![no_main]

use flicr::calibrate::{Scan, calibrate};
use flicr::geometry::sensors::{hdl64e, velodyne};
use flicr::recognize_sensor;
use libfuzzer_sys::fuzz_target;

const BEAMS: usize = 4;

/// Turns of a sensor, and a few points put elsewhere: four bytes say which and by how much.
fn on_a_grid([ticks, tilt, unit, near]: [u8; 4], moves: &[u8]) -> (Vec<[f32; 3]>, Vec<u16>) {
    let (ticks, unit_m) = (usize::from(ticks) * 4 + 40, 0.001 * f32::from(unit % 8 + 1));
    let at = |n: usize| {
        let (beam, tick) = (n % BEAMS, n / BEAMS);
        let (sin, cos) = (tick as f32 / ticks as f32 * std::f32::consts::TAU).sin_cos();
        let slope = 0.02 * beam as f32 - 0.001 * f32::from(tilt);
        let count = 500.0 * f32::from(near % 32) + ((n * 7919) % 4001) as f32;
        let rho_m = unit_m * count / (1.0 + slope * slope).sqrt();
        [rho_m * cos, rho_m * sin, rho_m * slope]
    };
    let mut points: Vec<[f32; 3]> = (0..BEAMS * ticks).map(at).collect();
    for &[low, high, axis, by] in moves.as_chunks::<4>().0 {
        let len = points.len();
        let moved = &mut points[usize::from(u16::from_le_bytes([low, high])) % len];
        moved[usize::from(axis) % 3] += 0.01 * (f32::from(by) - 128.0);
    }
    let beams = (0..points.len()).map(|n| (n % BEAMS) as u16).collect();
    (points, beams)
}

fn of_any_floats(bytes: &[u8]) -> (Vec<[f32; 3]>, Vec<u16>) {
    let floats: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect();
    // As many as are needed, over and over.
    let seen = floats.as_chunks::<3>().0;
    let points: Vec<[f32; 3]> = seen.iter().cycle().take(if seen.is_empty() { 0 } else { 700 }).copied().collect();
    let beams = (0..points.len()).map(|n| (n % 5) as u16).collect();
    (points, beams)
}

fuzz_target!(|data: &[u8]| {
    let Some((&[kind, made @ ..], rest)) = data.split_first_chunk::<5>() else { return };
    let (points, beams) = if kind & 1 == 0 { of_any_floats(rest) } else { on_a_grid(made, rest) };
    let beams = (kind & 2 != 0).then_some(beams.as_slice());
    let scans = [Scan { points: &points, beams }];
    if let Ok(found) = calibrate("found", &scans, &mut |progress| assert!((0.0..=1.0).contains(&progress.fraction))) {
        assert!(found.sensor.grid().check().is_ok(), "{:?}", found.sensor);
        assert!((0.0..=1.0).contains(&found.beam_share));
    }
    let _ = recognize_sensor(&points, &[hdl64e::GRID, velodyne::VLP16.grid()]);
});
