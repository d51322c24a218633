//! The inverse of the lattice: beam, column and level back to a point, without a sine a point.

use core::f64::consts::TAU;
use core::ops::Range;
use std::vec::Vec;

use super::beam::{Beam, BeamLine, SensorGrid};
use super::shift_of;

/// Sine and cosine of every column's encoder azimuth, and every beam's constants.
///
/// In double precision: the products are then exact to far below a micrometer, and cost no more.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    /// Direction, azimuth of tick 0, ticks, columns and step.
    made_for: Option<(bool, u32, u32, u16, u32)>,
    beams: Vec<Beam>,
    rows: Vec<BeamRow>,
    /// Twice over where the columns are firings, and each row begins at its own.
    columns: Vec<SinCos>,
    /// First column of each row, and the last but one.
    spans: Vec<Range<usize>>,
    firings: Vec<u32>,
}

/// Where the columns lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spread<'a> {
    /// Evenly over the turn.
    Even,
    /// At these ticks, each beam's turned by its azimuth phase.
    At(&'a [u32]),
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
    pub(crate) fn prepare(&mut self, grid: &SensorGrid<'_>, columns: u16, spread: Spread<'_>, step_m: f32) {
        let wanted = Some((grid.clockwise, grid.zero_rad.to_bits(), grid.ticks, columns, step_m.to_bits()));
        let firings = if let Spread::At(firings) = spread { firings } else { &[] };
        if self.made_for == wanted && self.beams == grid.beams && self.firings == firings {
            return;
        }
        self.beams.clear();
        self.beams.extend_from_slice(grid.beams);
        self.firings.clear();
        self.firings.extend_from_slice(firings);
        self.prepare_columns(grid, columns, spread);
        self.rows.clear();
        self.rows.extend(grid.beams.iter().map(|beam| BeamRow::new(beam, step_m.into())));
        self.made_for = wanted;
    }

    fn prepare_columns(&mut self, grid: &SensorGrid<'_>, columns: u16, spread: Spread<'_>) {
        let direction = if grid.clockwise { -TAU } else { TAU };
        let at = |turned_rad: f64| SinCos::of(f64::from(grid.zero_rad) + turned_rad);
        let len = usize::from(columns);
        self.columns.clear();
        self.spans.clear();
        match spread {
            Spread::Even => {
                let column_rad = direction / f64::from(columns);
                self.columns.extend((0..columns).map(|column| at(f64::from(column) * column_rad)));
                self.spans.extend(grid.beams.iter().map(|_| 0..len));
            }
            Spread::At(ticks) => {
                let tick_rad = direction / f64::from(grid.ticks);
                self.columns.extend(ticks.iter().map(|&tick| at(f64::from(tick) * tick_rad)));
                self.columns.extend_from_within(..);
                let first = |beam: &Beam| len - usize::from(shift_of(beam.azimuth_phase_rad, grid.clockwise, columns));
                self.spans.extend(grid.beams.iter().map(first).map(|first| first..first + len));
            }
        }
    }

    /// A row's beam, and the azimuths of its columns.
    pub(crate) fn row(&self, row: usize) -> (&[SinCos], BeamRow) {
        (&self.columns[self.spans[row].clone()], self.rows[row])
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
