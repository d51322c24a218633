//! The inverse of the uniform grid: pixels back to directions, without a sine a point.

use core::array;
use std::vec::Vec;

use super::{Placement, UniformView};

/// Every row's elevation and every column's azimuth.
#[derive(Debug, Default)]
pub(crate) struct Sphere {
    made_for: Option<(u16, u16, UniformView, Placement)>,
    rows: Vec<Elevation>,
    columns: Vec<Azimuth>,
}

/// A column's azimuth: what x, y and z of a row are multiplied by, and nothing to make it a vector.
pub(crate) type Azimuth = [f32; 4];

/// What ranges of a row are multiplied by for the distance along the ground, twice, and the height.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Elevation([f32; 4]);

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
        self.rows.clear();
        self.rows.extend((0..rows).map(|row| Elevation::of(top - (f64::from(row) + offset) * row_rad)));
        self.columns.clear();
        self.columns.extend((0..columns).map(|column| azimuth(start + (f64::from(column) + offset) * column_rad)));
        self.made_for = wanted;
    }

    /// A row's elevation.
    pub(crate) fn row(&self, row: usize) -> Elevation {
        self.rows[row]
    }

    /// Azimuths of all columns.
    pub(crate) fn columns(&self) -> &[Azimuth] {
        &self.columns
    }
}

fn azimuth(angle_rad: f64) -> Azimuth {
    let (sin, cos) = libm::sincos(angle_rad);
    [cos as f32, sin as f32, 1.0, 0.0]
}

impl Elevation {
    fn of(angle_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(angle_rad);
        Self([cos as f32, cos as f32, sin as f32, 0.0])
    }

    /// The point at `range_m` meters in a column: x, y, z and a zero.
    #[inline]
    pub(crate) fn at(self, azimuth: &Azimuth, range_m: f32) -> [f32; 4] {
        array::from_fn(|i| range_m * self.0[i] * azimuth[i])
    }
}
