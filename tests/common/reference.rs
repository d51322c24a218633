//! The uniform grid in double precision, by libm: what the table-driven projection is held against.

use flicr::geometry::{Pixels, Projection};
use flicr::{BLOCK_LEN, Block, Quantizer, UniformGrid, UniformView};

/// Row and column by libm in double precision.
pub fn exact_cell(view: &UniformView, rows: f64, columns: f64, [x, y, z]: [f32; 3]) -> (i64, f64) {
    let [x, y, z] = [x, y, z].map(f64::from);
    let range = (x * x + y * y + z * z).sqrt();
    let elevation = libm::asin(z / range);
    let row = (f64::from(view.top_rad) - elevation) / (f64::from(view.top_rad) - f64::from(view.bottom_rad)) * rows;
    let turn = core::f64::consts::TAU;
    let from_start = (libm::atan2(y, x) - f64::from(view.start_rad)).rem_euclid(turn);
    (row.floor() as i64, from_start / f64::from(view.span_rad) * columns)
}

pub fn pixel_of(grid: &impl Projection, [x, y, z]: [f32; 3]) -> u32 {
    let mut block = Block::new();
    block.fill([[x, y, z]; BLOCK_LEN].into_iter());
    let mut pixels = Pixels::new();
    grid.project(&block, &Quantizer::new(8, 80.0).unwrap(), &mut pixels);
    assert!(pixels.pixel.iter().all(|&pixel| pixel == pixels.pixel[0]), "every lane computes the same");
    pixels.pixel[0]
}

/// At most 2 points in 1,000 of a scan land in another column at 4500, none more than one column away.
pub fn assert_columns_agree(name: &str, points: &[[f32; 3]]) {
    let grid = UniformGrid::new(64, 4500, UniformView::HDL64E).unwrap();
    let columns = u32::from(grid.columns());
    let mut misplaced = 0;
    for &point in points.iter().filter(|point| **point != [0.0; 3]) {
        let (_, exact) = exact_cell(grid.view(), grid.rows().into(), columns.into(), point);
        let column = (pixel_of(&grid, point) & !Pixels::CLAMPED) % columns;
        let apart = column.abs_diff(exact as u32 % columns);
        let apart = apart.min(columns - apart);
        assert!(apart <= 1, "{name}: {point:?} is {apart} columns away");
        misplaced += apart as usize;
    }
    assert!(misplaced * 1000 <= 2 * points.len(), "{name}: {misplaced} of {} points", points.len());
}
