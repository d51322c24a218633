//! Returns in the sensor's own integers make the frame that their points make, and are all counted.

use flicr::geometry::{Beam, Lattice, SensorGrid, sensors::hdl64e};
use flicr::{
    Collision, Encoded, FrameEncoder, GridConfig, GridReturn, GridSettings, ImageViewMut, LatticeConfig, Level, Policy,
    Rle, Scale, Settings, Stamp,
};
use proptest::prelude::*;

const STAMP: Stamp = Stamp { sequence: 4, timestamp_ns: 9 };

fn frame<L: Level>(config: &impl GridSettings, columns: usize, returns: &[GridReturn]) -> (Encoded, Vec<u8>, Vec<u16>) {
    let rows = config.grid().beams.len();
    let mut levels = vec![L::NONE; rows * columns];
    let (mut coder, mut out) = (Rle::new(), vec![0; 2000 + rows * columns * 3]);
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let mut frame = FrameEncoder::start(config, STAMP, image, &mut coder).unwrap();
    frame.insert_returns(returns.iter().copied());
    let encoded = frame.finish(&mut out).unwrap();
    out.truncate(encoded.len);
    (encoded, out, levels.into_iter().map(Level::get).collect())
}

fn frame_of_points<L: Level>(config: &(impl Settings + GridSettings), columns: usize, points: &[[f32; 3]]) -> Vec<u8> {
    let rows = config.grid().beams.len();
    let mut levels = vec![L::NONE; rows * columns];
    let (mut coder, mut out) = (Rle::new(), vec![0; 2000 + rows * columns * 3]);
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let mut frame = FrameEncoder::start(config, STAMP, image, &mut coder).unwrap();
    frame.insert(points);
    let len = frame.finish(&mut out).unwrap().len;
    out.truncate(len);
    out
}

/// A return for every second cell, ranges all over; none midway between two levels of `per_level` counts, where a
/// point's floats decide.
fn returns(grid: &SensorGrid<'_>, per_level: u32) -> Vec<GridReturn> {
    let mut scramble = 1_u32;
    let mut found = Vec::new();
    for tick in 0..grid.ticks {
        for row in 0..grid.beams.len() as u16 {
            scramble = scramble.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let count = 500 + (scramble >> 8) % 59_000;
            let count = if per_level > 1 { count / per_level * per_level + scramble % per_level / 3 } else { count };
            if scramble & 0x80 != 0 {
                found.push(GridReturn { row, tick, count });
            }
        }
    }
    found
}

fn points(grid: &SensorGrid<'_>, returns: &[GridReturn]) -> Vec<[f32; 3]> {
    let point = |found: &GridReturn| grid.position(found.row.into(), found.tick, found.count).unwrap();
    returns.iter().map(|found| point(found).map(|v| v as f32)).collect()
}

#[test]
fn pixels_are_those_of_the_points() {
    let grid = hdl64e::GRID;
    // On 3200 columns, ticks lie a tenth of a column off the midway at least.
    for columns in [4000, 3200] {
        let lattice = Lattice::<66>::new(grid, columns).unwrap();
        for (level_bits, step_m, per_level) in [(16, 0.002, 1), (16, 0.02, 10), (12, 0.05, 25)] {
            let returns = returns(&grid, per_level);
            let scale = Scale::Step { step_m };
            let of_points = LatticeConfig { level_bits, scale, ..LatticeConfig::new(&lattice) };
            let expected = frame_of_points::<u16>(&of_points, columns, &points(&grid, &returns));
            let config = GridConfig { level_bits, scale, ..GridConfig::new(grid, columns as u16) };
            assert!(frame::<u16>(&config, columns, &returns).1 == expected, "{columns} columns, {step_m} m");
            assert!(frame::<u16>(&of_points, columns, &returns).1 == expected, "on the lattice");
        }
    }
}

#[test]
fn small_levels_are_those_of_the_points() {
    let (grid, columns) = (hdl64e::GRID, 4000);
    let lattice = Lattice::<66>::new(grid, columns).unwrap();
    let (returns, scale) = (returns(&grid, 200), Scale::Step { step_m: 0.4 });
    let policy = Policy { collision: Collision::Last, ..LatticeConfig::new(&lattice).policy };
    let of_points = LatticeConfig { level_bits: 8, scale, policy, ..LatticeConfig::new(&lattice) };
    let config = GridConfig { level_bits: 8, scale, collision: Collision::Last, ..GridConfig::new(grid, 4000) };
    let expected = frame_of_points::<u8>(&of_points, columns, &points(&grid, &returns));
    assert!(frame::<u8>(&config, columns, &returns).1 == expected);
}

#[test]
fn every_return_is_counted() {
    let config =
        GridConfig { level_bits: 8, scale: Scale::Step { step_m: 0.1 }, ..GridConfig::new(hdl64e::GRID, 1000) };
    let cell = |row, tick, count| GridReturn { row, tick, count };
    let returns = [
        cell(0, 0, 5000),
        cell(63, 3999, 5000),
        cell(0, 1, 6000),         // the same pixel as the first
        cell(1, 10, 0),           // nothing came back
        cell(1, 10, 24),          // nearer than half a step
        cell(1, 10, 12_776),      // just beyond the largest level
        cell(1, 10, u32::MAX),    // far beyond
        cell(64, 10, 5000),       // no such beam
        cell(u16::MAX, 10, 5000), // no such beam
        cell(1, 4000, 5000),      // no such tick
        cell(1, u32::MAX, 5000),  // no such tick
        cell(1, u32::MAX, 0),     // that nothing came back is known all the same
        cell(2, 20, 12_774),      // the largest level
    ];
    let (encoded, _, levels) = frame::<u8>(&config, 1000, &returns);
    let tally = encoded.tally;
    assert_eq!((tally.points, tally.kept(), tally.collided), (13, 3, 1));
    assert_eq!((tally.no_return, tally.too_near, tally.beyond_range), (2, 1, 2));
    assert_eq!((tally.out_of_view, tally.clamped, tally.not_finite), (4, 0, 0));
    let at = |row: usize, column: usize| levels[row * 1000 + column];
    // Tick 3999 is nearer to tick 0 than to the last column.
    assert_eq!((at(0, 0), at(63, 0), at(2, 5)), (100, 100, 255));
}

fn counterclockwise(beams: &[Beam]) -> SensorGrid<'_> {
    let (ticks, range_unit_m) = (1, 0.01);
    SensorGrid { name: "", beams, ticks, clockwise: false, zero_rad: 0.0, range_unit_m, range_from_axis: false }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// A level is the nearest to the exact range, but where two are as near but for the quantizer's rounding.
    #[test]
    fn levels_are_within_the_bound(count in 1_u32..1 << 20, unit_um in 1_u32..20_000, step in 1e-6_f32..2.0) {
        let beams = [Beam::default()];
        let range_unit_m = unit_um as f32 * 1e-6;
        let grid = SensorGrid { ticks: 1, range_unit_m, ..counterclockwise(&beams) };
        let config = GridConfig { scale: Scale::Step { step_m: step }, ..GridConfig::new(grid, 1) };
        let (encoded, _, levels) = frame::<u16>(&config, 1, &[GridReturn { row: 0, tick: 0, count }]);
        let exact = f64::from(count) * f64::from(range_unit_m) / f64::from(step);
        let slack = f64::from(encoded.range_bound_m) / f64::from(step);
        match levels[0] {
            0 if encoded.tally.too_near == 1 => prop_assert!(exact <= slack),
            0 => prop_assert!(encoded.tally.beyond_range == 1 && exact >= 65_536.0 - slack),
            level => prop_assert!((exact - f64::from(level)).abs() <= slack),
        }
    }

    /// A column is the nearest to the tick's exact place, of two as near the later one.
    #[test]
    fn columns_are_the_nearest(ticks in 1_u32..=1 << 20, columns in 1_u16.., tick in any::<u32>()) {
        let (beams, tick) = ([Beam::default()], tick % ticks);
        let grid = SensorGrid { ticks, ..counterclockwise(&beams) };
        let config = GridConfig::new(grid, columns);
        let (_, _, levels) = frame::<u16>(&config, columns.into(), &[GridReturn { row: 0, tick, count: 9 }]);
        let found = levels.iter().position(|&level| level != 0).unwrap() as u64;
        let (ticks, columns, tick) = (u64::from(ticks), u64::from(columns), u64::from(tick));
        prop_assert_eq!(found, (2 * tick * columns + ticks) / (2 * ticks) % columns);
    }
}
