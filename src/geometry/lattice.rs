//! A sensor's own grid made ready for projection: rows are beams, columns are spread over the encoder's turn.

use core::f64::consts::TAU;

use super::angles::{self, AngleTables};
use super::beam::{Beam, BeamLine, SensorGrid};
use super::{Pixels, Projection};
use crate::error::ConfigError;
use crate::kernel;
use crate::point::{BLOCK_LEN, Block};
use crate::quantize::Quantizer;

/// Bins of slope in a fan's table.
pub(crate) const BINS: usize = 128;

/// Nearer to the axis than this the tables do not hold, and every beam is tried, meters.
pub(crate) const BINS_FROM_M: f32 = 0.5;

/// Step of `z_offset_m` that parts two blocks of lasers, meters; smaller ones are those within a block.
const BLOCK_STEP_M: f64 = 0.01;

/// Rows are a sensor's beams, columns evenly spread over its encoder's turn: column `c` is centered on the encoder
/// azimuth `c / columns` turns from tick 0, in the sensor's direction. With as many columns as ticks, every return of
/// the sensor has a pixel of its own, in which it comes back exactly.
///
/// The range of a pixel is that along the beam, less the beam's range phase: a multiple of the range unit.
///
/// The row needs no arc: a point's slope, seen from where a block's beams cross, picks a beam from a table, and exact
/// comparisons with the lines midway between beams do the rest (mostly one). That is right for any table of beams that
/// do not cross between the sensor and the point; two blocks of lasers at different heights (HDL-64E) are told apart
/// by the largest step of `z_offset_m`.
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
    pub(crate) fans: [Fan; 2],
    /// The second fan's beams are below this line.
    pub(crate) split: Edge,
    /// No nearer than any beam passes the axis; the divisor never is less.
    pub(crate) nearest_axis_m: f32,
    /// 2^-31 turns a radian; negative where the sensor turns clockwise.
    pub(crate) half_turned_per_rad: f32,
    tables: &'static AngleTables<NODES>,
}

/// A beam's constants, and where its row ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// Lower edge of the row: midway to the next beam.
    pub(crate) edge: Edge,
    pub(crate) sin: f32,
    pub(crate) cos: f32,
    pub(crate) h_offset_m: f32,
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

/// A block of beams, which cross near one point on the far side of the axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fan {
    /// That point's distance from the axis.
    pub(crate) behind_m: f32,
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
        let (edges, below_first) = (edges::<LINES>(grid.beams), block_end(grid.beams));
        let direction = if grid.clockwise { -1.0 } else { 1.0 };
        let split = edges[below_first];
        Ok(Self {
            grid,
            columns: columns as u16,
            lines: lines(&grid, columns, direction, &edges),
            fans: [
                Fan::new(grid.beams, 0, below_first, &edges, None),
                Fan::new(grid.beams, below_first, rows, &edges, Some(split)),
            ],
            split,
            nearest_axis_m: nearest_axis_m(grid.beams),
            half_turned_per_rad: (direction * 2_147_483_648.0 / TAU) as f32,
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

/// A lattice for points whose rows are known: those of one block.
#[derive(Debug)]
pub(crate) struct OnRows<'a, const LINES: usize, const NODES: usize> {
    pub(crate) lattice: &'a Lattice<'a, LINES, NODES>,
    pub(crate) rows: &'a [u16],
}

impl<const LINES: usize, const NODES: usize> Projection for OnRows<'_, LINES, NODES> {
    fn rows(&self) -> u16 {
        self.lattice.rows()
    }

    fn columns(&self) -> u16 {
        self.lattice.columns()
    }

    fn project(&self, block: &Block, quantizer: &Quantizer, pixels: &mut Pixels) {
        for (i, &row) in self.rows.iter().take(BLOCK_LEN).enumerate() {
            let point = [block.x[i], block.y[i], block.z[i]];
            (pixels.pixel[i], pixels.level[i]) = kernel::place_on_row(self.lattice, quantizer, point, row);
        }
    }
}

/// The row whose beam is nearest to a point.
#[cfg(feature = "std")]
pub(crate) fn nearest_row<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    point: [f32; 3],
) -> u16 {
    let (mut block, mut pixels) = (Block::new(), Pixels::new());
    block.fill(core::iter::once(point));
    // Any levels will do.
    if let Ok(quantizer) = Quantizer::new(16, 100.0) {
        lattice.project(&block, &quantizer, &mut pixels);
    }
    ((pixels.pixel[0] & !Pixels::CLAMPED) / u32::from(lattice.columns)) as u16
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

/// The first row of the second block of lasers: behind the largest step in height, or in the middle of an even table.
const fn block_end(beams: &[Beam]) -> usize {
    let (mut end, mut largest_m) = (beams.len().div_ceil(2), BLOCK_STEP_M);
    let mut row = 1;
    while row < beams.len() {
        let step_m = (beams[row].z_offset_m as f64 - beams[row - 1].z_offset_m as f64).abs();
        if step_m > largest_m {
            (end, largest_m) = (row, step_m);
        }
        row += 1;
    }
    end
}

const fn lines<const LINES: usize>(
    grid: &SensorGrid<'_>,
    columns: usize,
    direction: f64,
    edges: &[Edge; LINES],
) -> [Line; LINES] {
    let mut lines = [Line::new(grid, 0, columns, direction, edges[0]); LINES];
    let last = grid.beams.len() - 1;
    let mut line = 0;
    while line < LINES {
        let row = if line > last + 1 { last } else { line.saturating_sub(1) };
        lines[line] = Line::new(grid, row, columns, direction, edges[line]);
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
    const fn new(grid: &SensorGrid<'_>, row: usize, columns: usize, direction: f64, edge: Edge) -> Self {
        let beam = &grid.beams[row];
        let BeamLine { sin, cos, .. } = BeamLine::new(beam);
        let mut turns = -direction * (beam.azimuth_phase_rad as f64 + grid.zero_rad as f64) / TAU;
        // Columns are centered: the edge is half a column before tick 0.
        turns += 0.5 / columns as f64;
        while turns < 0.0 {
            turns += 1.0;
        }
        Self {
            edge,
            sin: sin as f32,
            cos: cos as f32,
            h_offset_m: beam.h_offset_m,
            range_phase_m: beam.range_phase_m,
            turned: (turns * 4_294_967_296.0) as u64 as u32,
            first_pixel: (row * columns) as u32,
        }
    }
}

impl Fan {
    const fn new<const LINES: usize>(
        beams: &[Beam],
        first: usize,
        end: usize,
        edges: &[Edge; LINES],
        below: Option<Edge>,
    ) -> Self {
        let (behind_m, height_m) = crossing(beams, first, end);
        let (top, bottom) = (edges[first].slope as f64, edges[end].slope as f64);
        // Bin 0 is what lies above the block, and near the axis.
        let bins_per_slope = ((BINS - 1) as f64 / (top - bottom)) as f32;
        let bin = (top * bins_per_slope as f64 + 1.0) as f32;
        let mut fan = Self { behind_m, height_m, bins_per_slope, bin, starts: [0; BINS] };
        let anyway = match below {
            Some(edge) => edges_above(edge, edges, beams.len()),
            None => 0,
        };
        let mut index = 0;
        while index < BINS {
            let start = if index == 0 { 0 } else { fan.lines_above_bin(index, edges, beams.len()) };
            let start = if start > anyway { start } else { anyway };
            fan.starts[index] = if start > 255 { 255 } else { start as u8 };
            index += 1;
        }
        fan
    }

    /// Rows, from the first on, whose lower edges lie above all of a bin wherever it is used.
    const fn lines_above_bin<const LINES: usize>(&self, index: usize, edges: &[Edge; LINES], rows: usize) -> usize {
        // Of f32 arithmetic, both in the bin and in the comparison.
        const SLACK: f64 = 4e-6;
        let (behind_m, height_m) = (self.behind_m as f64, self.height_m as f64);
        let upper = (self.bin as f64 - index as f64) / self.bins_per_slope as f64 + SLACK;
        let at_m = BINS_FROM_M as f64;
        let z_m = height_m + upper * (at_m + behind_m);
        let mut line = 0;
        while line <= rows {
            let edge = &edges[line];
            let above = upper < edge.slope as f64 && z_m < edge.slope as f64 * at_m + edge.height_m as f64 - SLACK;
            if !above {
                break;
            }
            line += 1;
        }
        line
    }
}

/// Edges, from the first on, that are nowhere below `lower`.
const fn edges_above<const LINES: usize>(lower: Edge, edges: &[Edge; LINES], rows: usize) -> usize {
    let mut line = 0;
    while line <= rows && edges[line].slope >= lower.slope && edges[line].height_m >= lower.height_m {
        line += 1;
    }
    line
}

/// The point nearest to where beams cross, by least squares of z_offset = height + behind x slope.
const fn crossing(beams: &[Beam], first: usize, end: usize) -> (f32, f32) {
    let (mut n, mut s, mut c, mut ss, mut sc) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut row = first;
    while row < end {
        let (slope, height) = (beams[row].slope as f64, beams[row].z_offset_m as f64);
        n += 1.0;
        s += slope;
        c += height;
        ss += slope * slope;
        sc += slope * height;
        row += 1;
    }
    if n == 0.0 {
        return (0.0, 0.0);
    }
    let spread = n * ss - s * s;
    let behind = if spread > 1e-9 { (n * sc - s * c) / spread } else { 0.0 };
    // The divisor rho + behind stays well above 0 wherever the bins are used.
    let limit = 0.5 * BINS_FROM_M as f64;
    let behind = behind.clamp(-limit, limit);
    (behind as f32, ((c - behind * s) / n) as f32)
}
