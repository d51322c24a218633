//! A sensor's own grid made ready for projection: rows are beams, columns are spread over the encoder's turn.

use core::f64::consts::TAU;

use super::angles::{self, AngleTables};
use super::beam::{Beam, BeamLine, SensorGrid};
use super::{Pixels, Projection};
use crate::error::ConfigError;
use crate::kernel;
use crate::point::Block;
use crate::quantize::Quantizer;

/// Bins of slope in the table of lines.
pub(crate) const BINS: usize = 256;

/// 2^-32 turns a radian.
const TURNED_PER_RAD: f64 = 4_294_967_296.0 / TAU;

/// Nearer to the axis than this every beam is tried, meters.
pub(crate) const BINS_FROM_M: f32 = 0.5;

/// Rows are a sensor's beams, columns evenly spread over its encoder's turn: column `c` is centered on the encoder
/// azimuth `c / columns` turns from tick 0, in the sensor's direction. With as many columns as ticks, every return of
/// the sensor has a pixel of its own, in which it comes back exactly.
///
/// The range of a pixel is that along the beam, less the beam's range phase: a multiple of the range unit.
///
/// The row needs no arc: a point's slope, seen from the height of the lowest beam, picks a beam from a table, and exact
/// comparisons with the lines midway between beams do the rest: one, where all beams start at one height, 1.6 on average
/// over scans of an HDL-64E, whose blocks of lasers are 8 cm apart. That is right for any table of beams that do not
/// cross between the sensor and the point.
///
/// RAM or, in a `static`, flash: 32 bytes a line and 400. `LINES` is at least two more than the beams; `NODES` picks
/// the angle table as for [`UniformGrid`](crate::UniformGrid).
///
/// ```
/// use flicr::geometry::{Lattice, sensors::hdl64e};
/// static EVERY_TICK: Lattice<66> = match Lattice::new(hdl64e::GRID, 4000) {
///     Ok(lattice) => lattice,
///     Err(_) => panic!("checked at compile time"),
/// };
/// ```
#[derive(Debug, Clone)]
pub struct Lattice<'a, const LINES: usize, const NODES: usize = 257> {
    grid: SensorGrid<'a>,
    columns: u16,
    /// Row 0 is line 1: line 0 is above the view, the last but one or later below.
    pub(crate) lines: [Line; LINES],
    pub(crate) slopes: Slopes,
    /// No nearer than any beam passes the axis; the divisor never is less.
    pub(crate) nearest_axis_m: f32,
    /// 2^-32 turns a radian; negative where the sensor turns clockwise.
    pub(crate) turned_per_rad: f32,
    /// 2^-32 turns a quarter of a turn; negative likewise.
    pub(crate) quarter_turned: i32,
    /// Radians a 2^-32 turn, squared and halved: what makes the product of two [`Line::h_turned`] that of two offsets. 0
    /// where ranges run from the axis, which no offset makes longer.
    pub(crate) half_square_rad: f32,
    tables: &'static AngleTables<NODES>,
}

/// A beam's constants, and where its row ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// Lower edge of the row: midway to the next beam.
    pub(crate) edge: Edge,
    pub(crate) sin: f32,
    pub(crate) cos: f32,
    /// The beam's distance from the axis, m, times [`Lattice::turned_per_rad`].
    pub(crate) h_turned: f32,
    pub(crate) range_phase_m: f32,
    /// From the edge of column 0 to azimuth 0, 2^-32 turns.
    pub(crate) turned: u32,
    /// First pixel of the row, with [`Pixels::CLAMPED`] outside the view.
    pub(crate) first_pixel: u32,
}

/// A line in the plane of the spin axis: z = slope rho + height.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    pub(crate) slope: f32,
    pub(crate) height_m: f32,
}

impl Edge {
    /// Below everything.
    pub(crate) const NONE: Self = Self { slope: 0.0, height_m: f32::NEG_INFINITY };
}

/// Lines by the slope at which a point is seen from the axis, at the lowest beam's height.
///
/// A line through a higher point of the axis is nowhere below its own slope there: what lies below that slope by the
/// table lies below the line at any distance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slopes {
    pub(crate) height_m: f32,
    pub(crate) bins_per_slope: f32,
    /// Bin of slope 0.
    pub(crate) bin: f32,
    /// Line that the search begins at, by bin: no line before it can be the one.
    pub(crate) starts: [u8; BINS],
}

impl<'a, const LINES: usize> Lattice<'a, LINES> {
    /// `columns` columns on the grid of a sensor, projected with [`angles::FINE`].
    ///
    /// # Errors
    /// As [`SensorGrid::check`]; [`ConfigError::Beams`] where `LINES` are too few; [`ConfigError::Size`].
    pub const fn new(grid: SensorGrid<'a>, columns: usize) -> Result<Self, ConfigError> {
        Lattice::with_tables(grid, columns, &angles::FINE)
    }
}

impl<'a, const LINES: usize, const NODES: usize> Lattice<'a, LINES, NODES> {
    /// `columns` columns on the grid of a sensor, projected with the given tables.
    ///
    /// # Errors
    /// As [`SensorGrid::check`]; [`ConfigError::Beams`] where `LINES` are too few; [`ConfigError::Size`].
    pub const fn with_tables(
        grid: SensorGrid<'a>,
        columns: usize,
        tables: &'static AngleTables<NODES>,
    ) -> Result<Self, ConfigError> {
        if let Err(error) = grid.check() {
            return Err(error);
        }
        let rows = grid.beams.len();
        if rows + 2 > LINES {
            return Err(ConfigError::Beams { found: rows, max: LINES.saturating_sub(2) });
        }
        if columns == 0 || columns > u16::MAX as usize {
            return Err(ConfigError::Size { rows, columns });
        }
        let edges = edges::<LINES>(grid.beams);
        let turned_per_rad = if grid.clockwise { -TURNED_PER_RAD } else { TURNED_PER_RAD };
        Ok(Self {
            grid,
            columns: columns as u16,
            lines: lines(&grid, columns, turned_per_rad, &edges),
            slopes: Slopes::new(grid.beams, &edges),
            nearest_axis_m: nearest_axis_m(grid.beams),
            turned_per_rad: turned_per_rad as f32,
            quarter_turned: if grid.clockwise { -(1 << 30) } else { 1 << 30 },
            half_square_rad: if grid.range_from_axis { 0.0 } else { (0.5 / (TURNED_PER_RAD * TURNED_PER_RAD)) as f32 },
            tables,
        })
    }

    /// The sensor's grid.
    #[must_use]
    pub const fn grid(&self) -> &SensorGrid<'a> {
        &self.grid
    }

    /// Height of a line's beam.
    pub(crate) fn z_offset_m(&self, line: &Line) -> f32 {
        let row = (line.first_pixel & !Pixels::CLAMPED) / u32::from(self.columns);
        self.grid.beams.get(row as usize).map_or(0.0, |beam| beam.z_offset_m)
    }

    /// The line of a row; that below all rows for one that there is not.
    pub(crate) fn line(&self, row: u16) -> &Line {
        let below = self.grid.beams.len() + 1;
        &self.lines[(usize::from(row) + 1).min(below)]
    }

    /// Columns of the image.
    pub(crate) const fn columns_in_turn(&self) -> u16 {
        self.columns
    }

    /// The angle tables.
    #[must_use]
    pub const fn tables(&self) -> &'static AngleTables<NODES> {
        self.tables
    }
}

impl<const LINES: usize, const NODES: usize> Projection for Lattice<'_, LINES, NODES> {
    fn rows(&self) -> u16 {
        self.grid.beams.len() as u16
    }

    fn columns(&self) -> u16 {
        self.columns
    }

    fn project(&self, block: &Block, quantizer: &Quantizer, pixels: &mut Pixels) {
        kernel::project_lattice(self, quantizer, block, pixels);
    }
}

/// The azimuth of (x, y), radians.
#[cfg(feature = "std")]
pub(crate) fn azimuth_rad(y: f32, x: f32) -> f32 {
    angles::FINE.atan2(y, x)
}

impl<P: Projection> Projection for &P {
    fn rows(&self) -> u16 {
        (*self).rows()
    }

    fn columns(&self) -> u16 {
        (*self).columns()
    }

    fn project(&self, block: &Block, quantizer: &Quantizer, pixels: &mut Pixels) {
        (*self).project(block, quantizer, pixels);
    }
}

/// Edges between rows from the top edge of the first to the bottom edge of the last; no edge beyond.
const fn edges<const LINES: usize>(beams: &[Beam]) -> [Edge; LINES] {
    let mut edges = [Edge::NONE; LINES];
    let last = beams.len() - 1;
    edges[0] = beyond(&beams[0], if last > 0 { beams[0].slope - beams[1].slope } else { 0.02 });
    let mut row = 0;
    while row < last {
        edges[row + 1] = Edge {
            slope: (0.5 * (beams[row].slope as f64 + beams[row + 1].slope as f64)) as f32,
            height_m: (0.5 * (beams[row].z_offset_m as f64 + beams[row + 1].z_offset_m as f64)) as f32,
        };
        row += 1;
    }
    edges[last + 1] = beyond(&beams[last], if last > 0 { beams[last].slope - beams[last - 1].slope } else { -0.02 });
    edges
}

/// The outer edge of an outer row: half as far from its beam as the next beam on the other side.
const fn beyond(beam: &Beam, spacing: f32) -> Edge {
    Edge { slope: beam.slope + 0.5 * spacing, height_m: beam.z_offset_m }
}

const fn lines<const LINES: usize>(
    grid: &SensorGrid<'_>,
    columns: usize,
    turned_per_rad: f64,
    edges: &[Edge; LINES],
) -> [Line; LINES] {
    let mut lines = [Line::new(grid, 0, columns, turned_per_rad, edges[0]); LINES];
    let last = grid.beams.len() - 1;
    let mut line = 0;
    while line < LINES {
        let row = if line > last + 1 { last } else { line.saturating_sub(1) };
        lines[line] = Line::new(grid, row, columns, turned_per_rad, edges[line]);
        if line == 0 || line > last + 1 {
            lines[line].first_pixel |= Pixels::CLAMPED;
        }
        line += 1;
    }
    lines
}

const fn nearest_axis_m(beams: &[Beam]) -> f32 {
    let (mut nearest_m, mut row) = (0.001_f32, 0);
    while row < beams.len() {
        nearest_m = nearest_m.max(beams[row].h_offset_m.abs());
        row += 1;
    }
    nearest_m
}

impl Line {
    const fn new(grid: &SensorGrid<'_>, row: usize, columns: usize, turned_per_rad: f64, edge: Edge) -> Self {
        let beam = &grid.beams[row];
        let BeamLine { sin, cos, .. } = BeamLine::new(beam, grid.range_from_axis);
        let from_zero = -turned_per_rad * (beam.azimuth_phase_rad as f64 + grid.zero_rad as f64);
        let mut turns = from_zero / 4_294_967_296.0;
        // Columns are centered: the edge is half a column before tick 0.
        turns += 0.5 / columns as f64;
        while turns < 0.0 {
            turns += 1.0;
        }
        Self {
            edge,
            sin: sin as f32,
            cos: cos as f32,
            h_turned: (beam.h_offset_m as f64 * turned_per_rad) as f32,
            range_phase_m: beam.range_phase_m,
            turned: (turns * 4_294_967_296.0) as u64 as u32,
            first_pixel: (row * columns) as u32,
        }
    }
}

impl Slopes {
    const fn new<const LINES: usize>(beams: &[Beam], edges: &[Edge; LINES]) -> Self {
        let (mut height_m, mut row) = (beams[0].z_offset_m, 1);
        while row < beams.len() {
            height_m = height_m.min(beams[row].z_offset_m);
            row += 1;
        }
        let (top, bottom) = (edges[0].slope as f64, edges[beams.len()].slope as f64);
        // Bin 0 is what lies above the view, and near the axis.
        let bins_per_slope = ((BINS - 1) as f64 / (top - bottom)) as f32;
        let bin = (top * bins_per_slope as f64 + 1.0) as f32;
        let mut slopes = Self { height_m, bins_per_slope, bin, starts: [0; BINS] };
        let mut index = 1;
        while index < BINS {
            let start = slopes.lines_above_bin(index, edges, beams.len());
            slopes.starts[index] = if start > 255 { 255 } else { start as u8 };
            index += 1;
        }
        slopes
    }

    /// Lines, from the first on, that lie above all of a bin wherever it is used.
    const fn lines_above_bin<const LINES: usize>(&self, index: usize, edges: &[Edge; LINES], rows: usize) -> usize {
        let upper = (self.bin as f64 - index as f64) / self.bins_per_slope as f64;
        // Of f32 arithmetic, both in the bin and in the comparison.
        let upper = upper + 4e-6 + 5e-7 * upper.abs();
        let mut line = 0;
        while line <= rows && upper < edges[line].slope as f64 {
            line += 1;
        }
        line
    }
}
