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
    /// Direction, where ranges begin, azimuth of tick 0, ticks, columns and step.
    made_for: Option<(bool, bool, u32, u32, u16, u32)>,
    beams: Vec<Beam>,
    rows: Vec<BeamRow>,
    /// Twice over where the columns are firings, and each row begins at its own.
    columns: Vec<SinCos>,
    /// First column of each row, and the last but one.
    spans: Vec<Range<usize>>,
    firings: Vec<u32>,
    as_fired: bool,
    by_tick: ByTick,
}

/// Sines and cosines of a turn's ticks, computed when first asked for: firings change from turn to turn, ticks do not.
#[derive(Debug, Default)]
struct ByTick {
    /// Direction, azimuth of tick 0, ticks.
    made_for: Option<(bool, u32, u32)>,
    /// NaN where not computed yet.
    ticks: Vec<SinCos>,
}

impl ByTick {
    fn prepare(&mut self, grid: &SensorGrid<'_>) {
        let wanted = Some((grid.clockwise, grid.zero_rad.to_bits(), grid.ticks));
        if self.made_for != wanted {
            self.ticks.clear();
            self.ticks.resize(grid.ticks as usize, SinCos { sin: f64::NAN, cos: f64::NAN });
            self.made_for = wanted;
        }
    }

    fn get(&mut self, tick: u32, compute: impl Fn() -> SinCos) -> SinCos {
        match self.ticks.get_mut(tick as usize) {
            Some(known) if known.sin.is_nan() => {
                *known = compute();
                *known
            }
            Some(known) => *known,
            None => compute(),
        }
    }
}

/// Where the columns lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spread<'a> {
    /// Evenly over the turn.
    Even,
    /// At these ticks, each beam's turned by its azimuth phase.
    At(&'a [u32]),
    /// At these ticks, the same for all beams: as the sensor fires.
    AsFired(&'a [u32]),
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct SinCos {
    sin: f64,
    cos: f64,
}

/// A beam's constants for one step: a and z, as in [`Beam`], are linear in the level.
///
/// With the beam's azimuth phase turned into both, x = ahead cos + aside sin and y = ahead sin - aside cos of the
/// encoder's azimuth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BeamRow {
    line: BeamLine,
    a: Linear,
    z: Linear,
    /// Of the azimuth phase.
    phase: SinCos,
    /// The sideways offset, turned by it.
    h_ahead_m: f64,
    h_aside_m: f64,
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
        let SensorGrid { clockwise, range_from_axis, ticks, .. } = *grid;
        let wanted = Some((clockwise, range_from_axis, grid.zero_rad.to_bits(), ticks, columns, step_m.to_bits()));
        let (firings, as_fired) = match spread {
            Spread::Even => (&[][..], false),
            Spread::At(firings) => (firings, false),
            Spread::AsFired(firings) => (firings, true),
        };
        if self.made_for == wanted && self.as_fired == as_fired && self.beams == grid.beams && self.firings == firings {
            return;
        }
        self.beams.clear();
        self.beams.extend_from_slice(grid.beams);
        self.firings.clear();
        self.firings.extend_from_slice(firings);
        self.as_fired = as_fired;
        self.prepare_columns(grid, columns, spread);
        self.rows.clear();
        self.rows.extend(grid.beams.iter().map(|beam| BeamRow::new(beam, range_from_axis, step_m.into())));
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
            Spread::AsFired(ticks) => {
                self.add_ticks(grid, ticks);
                self.spans.extend(grid.beams.iter().map(|_| 0..len));
            }
            Spread::At(ticks) => {
                self.add_ticks(grid, ticks);
                self.columns.extend_from_within(..);
                let first = |beam: &Beam| len - usize::from(shift_of(beam.azimuth_phase_rad, grid.clockwise, columns));
                self.spans.extend(grid.beams.iter().map(first).map(|first| first..first + len));
            }
        }
    }

    fn add_ticks(&mut self, grid: &SensorGrid<'_>, ticks: &[u32]) {
        let tick_rad = if grid.clockwise { -TAU } else { TAU } / f64::from(grid.ticks);
        let of = |tick: u32| SinCos::of(f64::from(grid.zero_rad) + f64::from(tick) * tick_rad);
        self.by_tick.prepare(grid);
        self.columns.extend(ticks.iter().map(|&tick| self.by_tick.get(tick, || of(tick))));
    }

    /// The firing, or the place among the columns, that a row's column 0 is.
    pub(crate) fn first_column(&self, row: usize) -> usize {
        self.spans[row].start
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
    fn new(beam: &Beam, range_from_axis: bool, step_m: f64) -> Self {
        let (line, phase_m) = (BeamLine::new(beam, range_from_axis), f64::from(beam.range_phase_m));
        let phase = SinCos::of(beam.azimuth_phase_rad.into());
        Self {
            line,
            a: Linear { per_level: step_m * line.cos, at_zero: phase_m * line.cos - line.lift_m * line.sin },
            z: Linear { per_level: step_m * line.sin, at_zero: phase_m * line.sin + line.lift_m * line.cos },
            phase,
            h_ahead_m: line.h_m * phase.sin,
            h_aside_m: line.h_m * phase.cos,
        }
    }

    /// The point of a level in a column: x, y, z and a zero.
    #[inline]
    pub(crate) fn at(self, &SinCos { sin, cos }: &SinCos, level: u16) -> [f32; 4] {
        self.at_fraction(&SinCos { sin, cos }, level.into())
    }

    /// The same between two levels.
    #[inline]
    pub(crate) fn at_fraction(self, column: &SinCos, level: f64) -> [f32; 4] {
        let [x, y, z] = self.at_exactly(column, level);
        [x as f32, y as f32, z as f32, 0.0]
    }

    /// The same with all digits.
    #[inline]
    pub(crate) fn at_exactly(self, &SinCos { sin, cos }: &SinCos, level: f64) -> [f64; 3] {
        let ahead_m = self.line.ahead_m(self.a.at(level));
        let (ahead, aside) = (ahead_m * self.phase.cos + self.h_ahead_m, self.h_aside_m - ahead_m * self.phase.sin);
        [ahead * cos + aside * sin, ahead * sin - aside * cos, self.z.at(level)]
    }
}
