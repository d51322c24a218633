//! The inverse of the uniform grid: pixels back to directions, without a sine a point.

use std::vec::Vec;

use super::{Placement, UniformView};

/// Sine and cosine of every row's elevation and every column's azimuth.
#[derive(Debug, Default)]
pub(crate) struct Sphere {
    made_for: Option<(u16, u16, UniformView, Placement)>,
    rows: Vec<SinCos>,
    columns: Vec<SinCos>,
}

#[derive(Debug, Clone, Copy)]
struct SinCos {
    sin: f32,
    cos: f32,
}

/// The directions of a row's pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowDirections<'a> {
    elevation: SinCos,
    columns: &'a [SinCos],
}

impl Sphere {
    /// Computes the angles unless they are those of the last frame.
    pub(crate) fn prepare(&mut self, rows: u16, columns: u16, view: UniformView, placement: Placement) {
        let wanted = Some((rows, columns, view, placement));
        if self.made_for == wanted {
            return;
        }
        let (top, start) = (f64::from(view.top_rad), f64::from(view.start_rad));
        let row_rad = (top - f64::from(view.bottom_rad)) / f64::from(rows);
        let column_rad = f64::from(view.span_rad) / f64::from(columns);
        let offset = placement.offset();
        fill(&mut self.rows, rows, |row| top - (row + offset) * row_rad);
        fill(&mut self.columns, columns, |column| start + (column + offset) * column_rad);
        self.made_for = wanted;
    }

    /// Directions of a row's pixels.
    pub(crate) fn row(&self, row: usize) -> RowDirections<'_> {
        RowDirections { elevation: self.rows[row], columns: &self.columns }
    }
}

fn fill(angles: &mut Vec<SinCos>, count: u16, angle_rad: impl Fn(f64) -> f64) {
    angles.clear();
    angles.extend((0..count).map(|index| SinCos::of(angle_rad(index.into()))));
}

impl SinCos {
    fn of(angle_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(angle_rad);
        Self { sin: sin as f32, cos: cos as f32 }
    }
}

impl RowDirections<'_> {
    /// The point at `range_m` meters in a column.
    #[inline]
    pub(crate) fn at(self, column: u16, range_m: f32) -> [f32; 3] {
        let azimuth = self.columns[usize::from(column)];
        let ground_m = range_m * self.elevation.cos;
        [ground_m * azimuth.cos, ground_m * azimuth.sin, range_m * self.elevation.sin]
    }
}
