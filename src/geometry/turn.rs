//! The inverse of the lattice: beam, column and level back to a point, without a sine a point.

use core::f64::consts::TAU;
use std::vec::Vec;

use super::beam::{Beam, BeamLine, SensorGrid};

/// Sine and cosine of every column's encoder azimuth, and every beam's constants.
///
/// In double precision: the products are then exact to far below a micrometer, and cost no more.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    made_for: Option<(bool, u32, u16, u32)>,
    beams: Vec<Beam>,
    rows: Vec<BeamRow>,
    columns: Vec<SinCos>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct SinCos {
    sin: f64,
    cos: f64,
}

/// A beam's constants for one step: a point is linear in its level.
///
/// With a and h as in [`Beam`], and the beam's azimuth phase turned into both, x = ahead cos + aside sin and
/// y = ahead sin - aside cos of the encoder's azimuth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BeamRow {
    ahead: Linear,
    aside: Linear,
    z: Linear,
}

/// level x per_level + at_zero.
#[derive(Debug, Clone, Copy)]
struct Linear {
    per_level: f64,
    at_zero: f64,
}

impl Turn {
    /// Computes the constants unless they are those of the last frame.
    pub(crate) fn prepare(&mut self, grid: &SensorGrid<'_>, columns: u16, step_m: f32) {
        let wanted = Some((grid.clockwise, grid.zero_rad.to_bits(), columns, step_m.to_bits()));
        if self.made_for == wanted && self.beams == grid.beams {
            return;
        }
        self.beams.clear();
        self.beams.extend_from_slice(grid.beams);
        let column_rad = if grid.clockwise { -TAU } else { TAU } / f64::from(columns);
        self.columns.clear();
        self.columns
            .extend((0..columns).map(|column| SinCos::of(f64::from(grid.zero_rad) + f64::from(column) * column_rad)));
        self.rows.clear();
        self.rows.extend(grid.beams.iter().map(|beam| BeamRow::new(beam, step_m.into())));
        self.made_for = wanted;
    }

    /// A row's beam.
    pub(crate) fn row(&self, row: usize) -> BeamRow {
        self.rows[row]
    }

    /// Azimuths of all columns.
    pub(crate) fn columns(&self) -> &[SinCos] {
        &self.columns
    }
}

impl SinCos {
    fn of(angle_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(angle_rad);
        Self { sin, cos }
    }
}

impl Linear {
    fn at(self, level: f64) -> f64 {
        level * self.per_level + self.at_zero
    }
}

impl BeamRow {
    fn new(beam: &Beam, step_m: f64) -> Self {
        let (line, phase_m) = (BeamLine::new(beam), f64::from(beam.range_phase_m));
        let h_m = f64::from(beam.h_offset_m);
        let a = Linear { per_level: step_m * line.cos, at_zero: phase_m * line.cos - line.lift_m * line.sin };
        let SinCos { sin, cos } = SinCos::of(beam.azimuth_phase_rad.into());
        Self {
            ahead: Linear { per_level: a.per_level * cos, at_zero: a.at_zero * cos + h_m * sin },
            aside: Linear { per_level: -a.per_level * sin, at_zero: h_m * cos - a.at_zero * sin },
            z: Linear { per_level: step_m * line.sin, at_zero: phase_m * line.sin + line.lift_m * line.cos },
        }
    }

    /// The point of a level in a column: x, y, z and a zero.
    #[inline]
    pub(crate) fn at(self, &SinCos { sin, cos }: &SinCos, level: u16) -> [f32; 4] {
        let level = f64::from(level);
        let (ahead, aside) = (self.ahead.at(level), self.aside.at(level));
        [(ahead * cos + aside * sin) as f32, (ahead * sin - aside * cos) as f32, self.z.at(level) as f32, 0.0]
    }
}
