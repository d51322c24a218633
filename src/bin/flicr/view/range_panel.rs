//! The range image, stretched to be seen.

use flicr::{Header, Level, Levels};

use super::color;
use crate::canvas::{Area, Canvas};

const NO_RETURN: [u8; 3] = [0, 0, 0];

/// Draws the image into `area`.
pub fn draw(canvas: &mut Canvas, area: Area, header: &Header, levels: &Levels) {
    canvas.fill(area, NO_RETURN);
    match levels {
        Levels::U8(levels) => draw_levels(canvas, area, header, levels),
        Levels::U16(levels) => draw_levels(canvas, area, header, levels),
    }
}

fn draw_levels<L: Level>(canvas: &mut Canvas, area: Area, header: &Header, levels: &[L]) {
    let (rows, columns) = (u32::from(header.rows), u32::from(header.columns));
    for y in 0..area.height {
        let row_span = span(y, area.height, rows);
        for x in 0..area.width {
            let column_span = span(x, area.width, columns);
            let some_rows = levels.chunks(columns as usize).skip(row_span.0).take(row_span.1);
            let pixels = some_rows.flat_map(|row| row.iter().skip(column_span.0).take(column_span.1));
            if let Some(level) = pixels.filter(|&&level| level != L::NONE).min() {
                canvas.set(area.x + x, area.y + y, color::of_range(header.quantizer.range_m(level.get())));
            }
        }
    }
}

/// First and number of the `cells` that pixel `at` of `pixels` stands for: one at least.
fn span(at: u32, pixels: u32, cells: u32) -> (usize, usize) {
    let first = u64::from(at) * u64::from(cells) / u64::from(pixels);
    let end = u64::from(at + 1) * u64::from(cells) / u64::from(pixels);
    (first as usize, (end - first).max(1) as usize)
}
