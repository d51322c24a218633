//! Promise: on the sensor's own grid no point is lost, none changes its beam, and each comes back to the count.
#![allow(missing_docs)]

mod common;
#[path = "common/lattice.rs"]
mod support;

use std::f64::consts::TAU;

use flicr::geometry::{Beam, Lattice, Pixels, Projection, SensorGrid, sensors};
use flicr::simulate::{EgoMotion, Simulator};
use flicr::{
    BLOCK_LEN, Block, ConfigError, DecodeError, Decoder, FrameEncoder, Geometry, GeometryChoice, ImageViewMut,
    LatticeConfig, Levels, Rle, Scale, Stamp, choose_geometry, encode,
};
use proptest::prelude::*;
use support::{counts, distance, distances, encoded, exact_cell, hdl64e, pixels_of, projected};

fn round_mm(v: f64) -> f32 {
    (libm::round(v * 1000.0) / 1000.0) as f32
}

#[test]
fn every_return_of_the_simulated_sensor_is_on_its_pixel() {
    let (lattice, turn) = (hdl64e(), Simulator::hdl64e(3).turn(5));
    for (found, (row, column, level)) in turn.returns.iter().zip(projected(&lattice, turn.points.as_slice())) {
        assert_eq!((row, column, level), (found.beam.into(), found.tick.into(), found.count));
    }
}

/// Goes from cells to points and back.
fn check_cells<const LINES: usize>(grid: SensorGrid<'_>, cells: impl Iterator<Item = (usize, u32, u32)>) {
    let lattice = Lattice::<LINES>::new(grid, grid.ticks as usize).unwrap();
    let cells: Vec<_> = cells.collect();
    let position = |&(row, tick, count): &(usize, u32, u32)| grid.position(row, tick, count).unwrap();
    let points: Vec<[f32; 3]> = cells.iter().map(position).map(|point| point.map(|v| v as f32)).collect();
    for (&(row, tick, count), (r, c, level)) in cells.iter().zip(projected(&lattice, points.as_slice())) {
        assert_eq!((r as usize, c, level), (row, tick, count));
    }
}

#[test]
fn cells_of_all_built_in_sensors_come_back() {
    for grid in sensors::ALL {
        let (rows, ticks) = (grid.beams.len(), grid.ticks);
        let near = (0.5 / grid.range_unit_m) as u32;
        let far = ((125.0 / grid.range_unit_m) as u32).min(65_535);
        let counts = [near, near + 1, 2 * near, 5 * near, 20 * near, far / 2, far];
        let ticks = (0..ticks).step_by(7).chain([ticks - 1, ticks / 2, ticks / 2 - 1, ticks / 4, 3 * ticks / 4]);
        let cells = ticks.flat_map(|tick| counts.map(|count| (tick, count)));
        check_cells::<258>(*grid, cells.flat_map(|(tick, count)| (0..rows).map(move |row| (row, tick, count))));
    }
}

#[test]
fn the_beam_is_that_of_double_precision_anywhere_in_view() {
    let (lattice, grid) = (hdl64e(), sensors::hdl64e::GRID);
    let points: Vec<[f32; 3]> = (0..200_000_u32)
        .map(|i| {
            let part = |factor: f64| (f64::from(i) * factor).fract();
            let (rho, azimuth) = (0.6 * 200.0_f64.powf(part(0.618_034)), TAU * part(0.754_877_666));
            let z = rho * (0.036 - 0.508 * part(0.569_840_29)) + 0.2 - 0.085 * part(0.569_840_29);
            [rho * azimuth.cos(), rho * azimuth.sin(), z].map(|v| v as f32)
        })
        .collect();
    for (point, (row, ..)) in points.iter().zip(projected(&lattice, points.as_slice())) {
        let (beam, ..) = exact_cell(&grid, point.map(f64::from));
        if row as usize != beam {
            // Only where both beams are equally near.
            let [x, y, z] = point.map(f64::from);
            let off = |beam: &Beam| (z - f64::from(beam.slope) * x.hypot(y) - f64::from(beam.z_offset_m)).abs();
            let differ = (off(&grid.beams[beam]) - off(&grid.beams[row as usize])).abs();
            assert!(differ < 2e-5, "{point:?}: {row} for {beam}, {differ}");
        }
    }
}

#[test]
fn all_lanes_compute_the_same_and_strange_points_do_no_harm() {
    let lattice = hdl64e();
    let strange = [0.0, -0.0, 1e-30, 0.01, 5.0, -5.0, 3e20, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    let pixels = u32::from(lattice.rows()) * u32::from(lattice.columns());
    for x in strange {
        for (y, z) in strange.iter().flat_map(|&y| strange.map(|z| (y, z))) {
            let mut block = Block::new();
            block.fill([[x, y, z]; BLOCK_LEN].into_iter());
            let mut found = Pixels::new();
            lattice.project(&block, &counts(&sensors::hdl64e::GRID), &mut found);
            assert!(found.pixel.iter().all(|&p| p == found.pixel[0] && p & !Pixels::CLAMPED < pixels), "{x} {y} {z}");
            assert!(found.level.iter().all(|&level| level == found.level[0]));
            let finite = [x, y, z].iter().all(|v| v.is_finite());
            assert!(finite || !(1..65_536).contains(&found.level[0]), "{x} {y} {z}: {}", found.level[0]);
        }
    }
}

#[test]
fn points_above_and_below_the_beams_are_marked() {
    let lattice = hdl64e();
    let mut block = Block::new();
    block.fill([[10.0, 0.0, 2.0], [10.0, 0.0, -5.5], [10.0, 0.0, -1.0]].into_iter());
    let mut pixels = Pixels::new();
    lattice.project(&block, &counts(&sensors::hdl64e::GRID), &mut pixels);
    let row = |pixel: u32| (pixel & !Pixels::CLAMPED) / 4000;
    assert!(pixels.pixel[0] > Pixels::CLAMPED && row(pixels.pixel[0]) == 0);
    assert!(pixels.pixel[1] > Pixels::CLAMPED && row(pixels.pixel[1]) == 63);
    assert!(pixels.pixel[2] < Pixels::CLAMPED);
}

#[test]
fn grids_that_cannot_be_are_refused() {
    let good = sensors::hdl64e::GRID;
    let error = |grid: SensorGrid<'_>, columns| Lattice::<66>::new(grid, columns).unwrap_err();
    let beam = |edit: fn(&mut Beam)| {
        let mut beams = sensors::hdl64e::BEAMS;
        edit(&mut beams[7]);
        error(SensorGrid { beams: &beams, ..good }, 4000)
    };
    assert_eq!(beam(|beam| beam.slope = 0.5), ConfigError::Beam { row: 7 });
    assert_eq!(beam(|beam| beam.slope = f32::NAN), ConfigError::Beam { row: 7 });
    assert_eq!(beam(|beam| beam.z_offset_m = f32::NAN), ConfigError::Beam { row: 7 });
    assert_eq!(beam(|beam| beam.h_offset_m = 2.0), ConfigError::Beam { row: 7 });
    assert_eq!(beam(|beam| beam.azimuth_phase_rad = f32::INFINITY), ConfigError::Beam { row: 7 });
    assert_eq!(beam(|beam| beam.range_phase_m = 11.0), ConfigError::Beam { row: 7 });
    assert_eq!(error(SensorGrid { beams: &[], ..good }, 4000), ConfigError::Beams { found: 0, max: 1024 });
    assert_eq!(Lattice::<65>::new(good, 4000).unwrap_err(), ConfigError::Beams { found: 64, max: 63 });
    assert_eq!(error(SensorGrid { ticks: 0, ..good }, 4000), ConfigError::Ticks { found: 0, max: 1 << 20 });
    assert!(matches!(error(SensorGrid { zero_rad: f32::NAN, ..good }, 4000), ConfigError::AzimuthView { .. }));
    assert!(matches!(error(SensorGrid { range_unit_m: f32::NAN, ..good }, 4000), ConfigError::RangeUnit { .. }));
    for columns in [0, 65_536] {
        assert_eq!(error(good, columns), ConfigError::Size { rows: 64, columns });
    }
}

#[test]
fn decoded_points_are_those_of_the_formulas() {
    let (lattice, turn, grid) = (hdl64e(), Simulator::hdl64e(2).turn(1), sensors::hdl64e::GRID);
    let (encoded, bytes) = encoded::<u16, 66>(&LatticeConfig::new(&lattice), turn.points.as_slice());
    assert_eq!(encoded.tally.kept() as usize, turn.points.len());
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&bytes).unwrap();
    let Levels::U16(levels) = frame.levels() else { panic!("16 bits") };
    let mut returns: Vec<_> = turn.returns.iter().map(|r| (r.beam, r.tick, r.count)).collect();
    returns.sort_unstable();
    for (&(row, tick, count), point) in returns.iter().zip(frame.points()) {
        assert_eq!(u32::from(levels[usize::from(row) * 4000 + usize::from(tick)]), count);
        let exact = grid.position(row.into(), tick, count).unwrap();
        for (ours, exact) in point.iter().zip(exact) {
            assert!((f64::from(*ours) - exact).abs() < 20e-6, "{row} {tick} {count}: {point:?} {exact:?}");
        }
    }
    let back = encoded_again(&lattice, &frame.points());
    assert_eq!(&back, frame.levels());
}

fn encoded_again(lattice: &Lattice<'_, 66>, points: &[[f32; 3]]) -> Levels {
    let (_, bytes) = encoded::<u16, 66>(&LatticeConfig::new(lattice), points);
    Decoder::default().decode(&bytes).unwrap().levels().clone()
}

/// As by `docs/FORMAT.md`, any step and any number of columns: the bound holds for each point that is not lost.
#[test]
fn the_bound_holds_for_other_steps_columns_and_clouds() {
    let on_grid = Simulator::hdl64e(4).turn(2).points;
    let moved = Simulator::hdl64e(4).ego_motion(EgoMotion::Compensated).turn(2).points;
    for (columns, step_m, level_bits) in [(4000, 0.02, 13), (4500, 0.05, 11), (2048, 0.002, 16), (256, 0.1, 10)] {
        let lattice = Lattice::<66>::new(sensors::hdl64e::GRID, columns).unwrap();
        let config =
            LatticeConfig { scale: Scale::Step { step_m }, level_bits, measure: true, ..LatticeConfig::new(&lattice) };
        for points in [&on_grid, &moved, &common::spiral(3000).iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect()] {
            let (encoded, bytes) = encoded::<u16, 66>(&config, points.as_slice());
            let found = distances(&lattice, &common::xyz(points), &bytes);
            assert!(found.len() >= encoded.tally.kept() as usize);
            let farthest = found.iter().map(|f| f.2).fold(0.0, f64::max);
            let bound = f64::from(encoded.fit.point_bound_m());
            println!(
                "{columns} columns, {step_m} m: {farthest} m at most, bound {bound}, {} lost",
                encoded.tally.lost()
            );
            assert!(farthest <= bound, "{columns} columns, {step_m} m: {farthest} > {bound}");
        }
    }
    let lattice = Lattice::<66>::new(sensors::hdl64e::GRID, 4000).unwrap();
    let config =
        LatticeConfig { scale: Scale::Fixed { max_range_m: 80.0 }, level_bits: 8, ..LatticeConfig::new(&lattice) };
    let (encoded, bytes) = encoded::<u8, 66>(&config, on_grid.as_slice());
    assert_eq!(encoded.tally.collided, 0);
    let Geometry::Beams(beams) = flicr::frame::parse_header(&bytes).unwrap().geometry else { panic!("beams") };
    assert_eq!(beams.point_bound_m, f32::INFINITY, "not measured");
}

#[test]
fn a_sensor_is_known_by_its_beams_or_brings_them() {
    let mut beams = sensors::hdl64e::BEAMS;
    beams[5].z_offset_m += 0.001;
    let own = SensorGrid { beams: &beams, clockwise: true, zero_rad: 1.5, ..sensors::hdl64e::GRID };
    let lattice = Lattice::<66>::new(own, 4000).unwrap();
    let point = own.position(5, 777_u32, 6000_u32).unwrap().map(|v| v as f32);
    let config = LatticeConfig::new(&lattice);
    let (_, bare) = encoded::<u16, 66>(&config, [point].as_slice());
    let (_, with_table) = encoded::<u16, 66>(&LatticeConfig { table: true, ..config }, [point].as_slice());
    assert_eq!(with_table.len(), bare.len() + 20 * 64);
    let mut decoder = Decoder::default();
    assert_eq!(decoder.decode(&bare).unwrap_err(), DecodeError::UnknownSensor { sensor: own.checksum() });
    let decoded = decoder.decode(&with_table).unwrap().points();
    assert!(distance(decoded[0], point) < 2e-5);
    decoder.know(&own);
    assert_eq!(decoder.decode(&bare).unwrap().points(), decoded);
    // The beams of the frame before are not taken for this one's.
    let (_, other) = encoded::<u16, 66>(&LatticeConfig::new(&hdl64e()), [point].as_slice());
    assert_ne!(decoder.decode(&other).unwrap().points(), decoded);
}

#[test]
fn an_image_of_another_size_is_refused() {
    let lattice = hdl64e();
    let (mut levels, mut out) = (vec![0_u16; 64 * 3999], [0; 100]);
    let image = ImageViewMut::new(&mut levels, 3999).unwrap();
    let points = [[1.0_f32; 3]];
    let config = LatticeConfig::new(&lattice);
    let error = encode(&config, points.as_slice(), Stamp::default(), image, &mut Rle::new(), &mut out).unwrap_err();
    let (rows, columns, expected_rows, expected_columns) = (64, 3999, 64, 4000);
    assert_eq!(error, ConfigError::ImageSize { rows, columns, expected_rows, expected_columns }.into());
}

#[test]
fn scans_on_the_grid_are_told_from_others() {
    let view = flicr::UniformView::HDL64E;
    let choose = |points: &[[f32; 3]]| choose_geometry(points, &sensors::hdl64e::GRID, 4500, view).unwrap();
    let simulated = |motion| common::xyz(&Simulator::hdl64e(7).ego_motion(motion).turn(3).points);
    for motion in [EgoMotion::Frozen, EgoMotion::Raw] {
        let advice = choose(&simulated(motion));
        assert_eq!(advice.choice, GeometryChoice::OwnGrid, "{}", advice.why);
        assert!(advice.rows.is_empty() && advice.why.contains("on the sensor's own grid"));
    }
    let advice = choose(&common::spiral(20_000));
    assert_ne!(advice.choice, GeometryChoice::OwnGrid, "{}", advice.why);
    assert_ne!(advice.choice, GeometryChoice::BeamsInOrder, "{}", advice.why);
}

#[test]
fn a_compensated_scan_loses_at_most_one_percent_and_its_bound_holds() {
    for seed in 1..=3 {
        let turn = Simulator::hdl64e(seed).ego_motion(EgoMotion::Compensated).turn(3);
        let points = common::xyz(&turn.points);
        let advice = choose_geometry(&points, &sensors::hdl64e::GRID, 4500, flicr::UniformView::HDL64E).unwrap();
        for trial in &advice.trials {
            println!(
                "{:?} {}: {:.3} % lost, bound {}",
                trial.choice,
                trial.columns,
                100.0 * trial.lost(),
                trial.fit.point_bound_m()
            );
        }
        println!("{}", advice.why);
        assert_eq!(advice.choice, GeometryChoice::BeamsInOrder);
        let wrong = advice.rows.iter().zip(&turn.returns).filter(|(row, found)| **row != u16::from(found.beam)).count();
        assert!(wrong * 1000 <= points.len(), "{wrong} of {} beams wrong", points.len());

        let lattice = Lattice::<66>::new(sensors::hdl64e::GRID, 4500).unwrap();
        let config = LatticeConfig { measure: true, ..LatticeConfig::new(&lattice) };
        let mut levels = vec![0_u16; 64 * 4500];
        let mut coder = Rle::new();
        let image = ImageViewMut::new(&mut levels, 4500).unwrap();
        let mut frame = FrameEncoder::start(&config, Stamp::default(), image, &mut coder).unwrap();
        frame.insert_on_rows(&points, &advice.rows);
        let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
        let encoded = frame.finish(&mut out).unwrap();
        let lost = f64::from(encoded.tally.lost()) / f64::from(encoded.tally.returns());
        assert!(lost <= 0.01, "{lost}");

        let mut decoder = Decoder::default();
        let frame = decoder.decode(&out[..encoded.len]).unwrap();
        let mut in_row = vec![Vec::new(); 64];
        for (pixel, point) in pixels_of(frame.levels()).into_iter().zip(frame.points()) {
            in_row[pixel as usize / 4500].push(point);
        }
        let bound = f64::from(encoded.fit.point_bound_m());
        let is_near = |(point, row): (&[f32; 3], &u16)| {
            in_row[usize::from(*row)].iter().any(|decoded| distance(*decoded, *point) <= bound)
        };
        let far = points.iter().zip(&advice.rows).step_by(11).filter(|pair| !is_near(*pair)).count();
        // Those that lost their pixel to another point need not be near it.
        assert!(far <= encoded.tally.collided as usize / 5, "{far}");
        assert!(bound < 1.0, "{bound}");
    }
}

/// Tables unlike the built-in ones: any number of beams, evenly or unevenly spaced, lenses ahead of or beside the axis.
fn tables() -> impl Strategy<Value = Vec<Beam>> {
    let gaps = prop::collection::vec(prop_oneof![Just(0.0_f32), 0.0_f32..0.05], 0..128);
    let lens = (-0.06_f32..0.06, -0.03_f32..0.03, -0.1_f32..0.1, -0.05_f32..0.05);
    (gaps, -0.3_f32..0.6, lens).prop_map(|(gaps, top, (lens, h, phase, range_phase))| {
        let spacing = 0.0015 + 0.1 / (gaps.len() + 1) as f32;
        let slopes = gaps.iter().scan(top, |slope, gap| {
            *slope -= spacing + gap;
            Some(*slope)
        });
        let beam = |(row, slope): (usize, f32)| Beam {
            slope,
            z_offset_m: 0.05 - lens * slope,
            h_offset_m: if row % 2 == 0 { h } else { -h },
            azimuth_phase_rad: phase * (row % 4) as f32,
            range_phase_m: range_phase,
        };
        std::iter::once(top).chain(slopes).enumerate().map(beam).collect()
    })
}

proptest! {
    #[test]
    fn cells_of_any_sensor_come_back(
        beams in tables(),
        ticks in prop::sample::select(vec![360_u32, 1024, 2048, 4000, 36_000]),
        clockwise in any::<bool>(),
        range_from_axis in any::<bool>(),
        zero_rad in -3.1_f32..3.1,
        range_unit_m in prop::sample::select(vec![0.001_f32, 0.002, 0.004]),
        cells in prop::collection::vec((any::<u16>(), any::<u32>(), 0.0_f32..1.0), 100),
    ) {
        let grid = SensorGrid { name: "", beams: &beams, ticks, clockwise, zero_rad, range_unit_m, range_from_axis };
        let count = |part: f32| ((2.0 + part * part * 118.0) / range_unit_m).min(65_535.0) as u32;
        let cells = cells.iter().map(|&(row, tick, part)| (usize::from(row) % beams.len(), tick % ticks, count(part)));
        check_cells::<130>(grid, cells);
    }

    #[test]
    fn millimeters_are_enough_for_the_hdl64e(row in 0_usize..64, tick in 0_u32..4000, count in 800_u32..60_000) {
        let grid = sensors::hdl64e::GRID;
        let point = grid.position(row, tick, count).unwrap().map(round_mm);
        let (r, c, level) = projected(&hdl64e(), [point].as_slice())[0];
        prop_assert_eq!((r as usize, c, level), (row, tick, count));
    }
}
