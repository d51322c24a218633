//! What a frame is to be like: the choices of every stage in one place, and the presets.

use crate::error::{ConfigError, EncodeError};
use crate::fit::{GridFit, NoFit};
use crate::frame::{BeamsHeader, GeometryFields, UniformHeader};
use crate::geometry::angles::{self, AngleTables};
use crate::geometry::{Lattice, Placement, Projection, SensorGrid, UniformGrid, UniformView};
use crate::insert::{Collision, OutOfView, Policy};
use crate::point::Points;
use crate::quantize::{Companding, Quantizer};

/// Where the quantizer's largest range comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// This many meters, for every frame.
    Fixed {
        /// The largest range that has a level; points beyond are dropped and counted.
        max_range_m: f32,
    },
    /// The farthest point of each frame, which takes a pass of its own over the points.
    PerFrame,
    /// Levels this far apart; the largest range follows from their number.
    Step {
        /// Distance between two levels, meters.
        step_m: f32,
    },
}

/// The choices of every stage. `NODES` follows from `tables`.
///
/// ```
/// use flicr::{Config, Scale};
/// const CONFIG: Config = Config { scale: Scale::Fixed { max_range_m: 120.0 }, ..Config::UNIFORM };
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Config<const NODES: usize = 257> {
    /// The part of the sphere that rows and columns divide.
    pub view: UniformView,
    /// Where in its pixel a decoded point is put.
    pub placement: Placement,
    /// Bits of a level: 1 to 8 in an image of `u8`, 9 to 16 in one of `u16`.
    pub level_bits: u32,
    /// Range of the largest level.
    pub scale: Scale,
    /// How levels are spread; by the square root, a [`Scale::Step`] is the range of level 1.
    pub companding: Companding,
    /// Collisions and points out of view.
    pub policy: Policy,
    /// The angle tables: [`angles::FINE`] or [`angles::COARSE`].
    pub tables: &'static AngleTables<NODES>,
    /// Strips that a frame is cut into, 1 to as many as columns. Each is a run of columns that decodes alone: on a core of its
    /// own, or where others are lost. 16 make a frame of the context coders 1 to 4 % longer (the fast tier's 2 to 6 %).
    pub strips: u16,
}

impl Config {
    /// As the code that made the paper's tables: rows of 0.4187 degrees from +2 degrees, the last point wins, points
    /// above or below are clamped into the edge rows, the scale follows the frame, points come back at the corner.
    pub const PAPER: Self = Self {
        view: UniformView::all_around(2.0, 2.0 - 64.0 * 0.4187),
        placement: Placement::Corner,
        level_bits: 8,
        scale: Scale::PerFrame,
        companding: Companding::None,
        policy: Policy { collision: Collision::Last, out_of_view: OutOfView::Clamp },
        tables: &angles::FINE,
        strips: 1,
    };

    /// The best that evenly spaced rows and columns can do on an HDL-64E: the nearest point wins and comes back in
    /// the middle of its pixel, and the rows lie a tenth of a degree higher, where its beams fit them better (0.04 to
    /// 0.14 dB on KITTI).
    pub const UNIFORM: Self = Self {
        view: UniformView::all_around(2.1, -24.7),
        placement: Placement::Center,
        policy: Policy { collision: Collision::Nearest, out_of_view: OutOfView::Clamp },
        ..Self::PAPER
    };
}

/// A frame on the sensor's own grid: every return comes back on its beam and tick, its range within half a step.
///
/// The image must have a row for each beam and the lattice's columns.
///
/// ```
/// use flicr::geometry::{Lattice, sensors::hdl64e};
/// use flicr::{Encoder, LatticeConfig, Rle, Stamp};
/// let lattice = Lattice::<66>::new(hdl64e::GRID, 500)?;
/// let config = LatticeConfig::new(&lattice);
/// let mut encoder: Encoder<64, 500, u16, Rle> = Encoder::new(Rle::new());
/// let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
/// let encoded = encoder.encode(&config, [[10.0_f32, 0.0, -1.0]].as_slice(), Stamp::default(), &mut out)?;
/// assert_eq!(encoded.tally.kept(), 1);
/// # Ok::<(), flicr::EncodeError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct LatticeConfig<'a, const LINES: usize, const NODES: usize = 257> {
    /// The sensor's grid and the columns.
    pub lattice: &'a Lattice<'a, LINES, NODES>,
    /// Bits of a level: 1 to 8 in an image of `u8`, 9 to 16 in one of `u16`.
    pub level_bits: u32,
    /// Distance of the levels.
    pub scale: Scale,
    /// As [`Config::companding`].
    pub companding: Companding,
    /// Collisions and points out of view.
    pub policy: Policy,
    /// Whether each frame carries the beams (20 bytes each), for receivers that do not know the sensor.
    pub table: bool,
    /// Whether to measure how far points are off the grid: then the frame states the bound that holds for every point.
    /// Takes about as long as the projection once more.
    pub measure: bool,
    /// As [`Config::strips`].
    pub strips: u16,
}

impl<'a, const LINES: usize, const NODES: usize> LatticeConfig<'a, LINES, NODES> {
    /// Lossless: a level is a range count. Points above or below the beams are moved to the nearest one.
    #[must_use]
    pub const fn new(lattice: &'a Lattice<'a, LINES, NODES>) -> Self {
        Self {
            lattice,
            level_bits: 16,
            scale: Scale::Step { step_m: lattice.grid().range_unit_m },
            companding: Companding::None,
            policy: Policy { collision: Collision::Nearest, out_of_view: OutOfView::Clamp },
            table: false,
            measure: false,
            strips: 1,
        }
    }

    /// Output bytes that are enough for every frame.
    #[must_use]
    pub const fn worst_case_len<L: crate::image::Level, C: crate::coder::Coder<L>>(&self) -> usize {
        let columns = self.lattice.columns_in_turn() as usize;
        beams_worst_case_len::<L, C>(self.lattice.grid().beams.len(), columns, self.strips, self.table)
    }
}

/// A frame of returns, from a sensor's packets or a driver that has its integers: as [`LatticeConfig`], but without what
/// only points need, so that neither a table of the beams' edges nor a float takes room or time.
///
/// The image must have a row for each beam and `columns` columns. Returns at the same distance from two columns' centers
/// get the later one.
///
/// The same frame as of a [`LatticeConfig`] of the same grid and columns comes out, if the returns are those that the
/// points were made from.
#[derive(Debug, Clone, Copy)]
pub struct GridConfig<'a> {
    /// The sensor's grid. A packet's beams fire one after another; for beams that account for it see
    /// [`SensorGeometry::beams_at`](crate::geometry::sensors::SensorGeometry::beams_at).
    pub grid: SensorGrid<'a>,
    /// Columns, spread evenly over the encoder's turn from tick 0 on.
    pub columns: u16,
    /// Bits of a level: 1 to 8 in an image of `u8`, 9 to 16 in one of `u16`.
    pub level_bits: u32,
    /// Distance of the levels; [`Scale::PerFrame`] is none for returns, which come piece by piece.
    pub scale: Scale,
    /// As [`Config::companding`].
    pub companding: Companding,
    /// Several returns in one pixel.
    pub collision: Collision,
    /// Whether each frame carries the beams (20 bytes each), for receivers that do not know the sensor.
    pub table: bool,
    /// As [`Config::strips`].
    pub strips: u16,
}

impl<'a> GridConfig<'a> {
    /// Lossless: a level is a range count.
    #[must_use]
    pub const fn new(grid: SensorGrid<'a>, columns: u16) -> Self {
        let scale = Scale::Step { step_m: grid.range_unit_m };
        let (companding, collision) = (Companding::None, Collision::Nearest);
        Self { grid, columns, level_bits: 16, scale, companding, collision, table: false, strips: 1 }
    }

    /// Output bytes that are enough for every frame.
    #[must_use]
    pub const fn worst_case_len<L: crate::image::Level, C: crate::coder::Coder<L>>(&self) -> usize {
        beams_worst_case_len::<L, C>(self.grid.beams.len(), self.columns as usize, self.strips, self.table)
    }
}

pub(crate) const fn beams_worst_case_len<L: crate::image::Level, C: crate::coder::Coder<L>>(
    rows: usize,
    columns: usize,
    strips: u16,
    table: bool,
) -> usize {
    let table_len = if table { rows * BeamsHeader::BEAM_LEN } else { 0 };
    let more = BeamsHeader::HEADER_LEN - crate::frame::HEADER_LEN + table_len;
    crate::frame::worst_case_len_in_strips::<L, C>(rows, columns, strips) + more
}

/// What the encoder asks of every configuration: [`Config`], [`LatticeConfig`] and [`GridConfig`] are the three there
/// are. The geometry that is not used costs no flash.
pub trait FrameSettings: Copy {
    /// The forward direction of the geometry; where it is a [`Projection`], points can be inserted ([`Settings`]).
    type Projection: Copy + core::fmt::Debug;
    /// What it keeps of how far points are off the grid: [`NoFit`] or [`GridFit`].
    type Fit: Copy + core::fmt::Debug + Default + Into<GridFit>;
    /// What the frame says of the geometry.
    type Fields: GeometryFields;

    /// The projection into an image of this size.
    ///
    /// # Errors
    /// Where there is none.
    fn projection(&self, rows: usize, columns: usize) -> Result<Self::Projection, ConfigError>;

    /// Bits of a level, the distance of the levels, and how they are spread.
    fn levels(&self) -> (u32, Scale, Companding);

    /// Collisions and points out of view.
    fn policy(&self) -> Policy;

    /// Strips that a frame is cut into.
    fn strips(&self) -> u16;

    /// The geometry's fields of the header, given how well the points fitted.
    fn fields(&self, fit: &Self::Fit) -> Self::Fields;

    /// Calls `each` with the ticks that columns are, in ascending order, where they are a sensor's firings.
    fn for_each_firing(&self, _each: &mut dyn FnMut(u32)) {}

    /// Adds to `fit` how far points are off the grid, where that is asked for.
    fn measure(&self, _points: &(impl Points + ?Sized), _quantizer: &Quantizer, _fit: &mut Self::Fit) {}

    /// The same for returns, which have no coordinates: what is known of all of them.
    fn measure_returns(&self, _quantizer: &Quantizer, _fit: &mut Self::Fit) {}
}

/// A configuration for points: [`Config`] and [`LatticeConfig`].
pub trait Settings: FrameSettings<Projection: Projection> {}

impl<S: FrameSettings<Projection: Projection>> Settings for S {}

/// A configuration for returns: [`GridConfig`] and [`LatticeConfig`].
pub trait GridSettings: FrameSettings {
    /// The sensor's grid.
    fn grid(&self) -> &SensorGrid<'_>;
}

impl<'a> FrameSettings for GridConfig<'a> {
    type Projection = ();
    type Fit = NoFit;
    type Fields = BeamsHeader<'a>;

    fn projection(&self, rows: usize, columns: usize) -> Result<(), ConfigError> {
        self.grid.check()?;
        let expected = (self.grid.beams.len() as u16, self.columns);
        check_image((rows, columns), expected)
    }

    fn levels(&self) -> (u32, Scale, Companding) {
        (self.level_bits, self.scale, self.companding)
    }

    fn policy(&self) -> Policy {
        Policy { collision: self.collision, out_of_view: OutOfView::Drop }
    }

    fn strips(&self) -> u16 {
        self.strips
    }

    fn fields(&self, _: &NoFit) -> BeamsHeader<'a> {
        BeamsHeader { grid: self.grid, point_bound_m: f32::INFINITY, table: self.table }
    }
}

impl GridSettings for GridConfig<'_> {
    fn grid(&self) -> &SensorGrid<'_> {
        &self.grid
    }
}

impl<const LINES: usize, const NODES: usize> GridSettings for LatticeConfig<'_, LINES, NODES> {
    fn grid(&self) -> &SensorGrid<'_> {
        self.lattice.grid()
    }
}

pub(crate) fn check_image((rows, columns): (usize, usize), expected: (u16, u16)) -> Result<(), ConfigError> {
    if (usize::from(expected.0), usize::from(expected.1)) == (rows, columns) {
        return Ok(());
    }
    Err(ConfigError::ImageSize { rows, columns, expected_rows: expected.0, expected_columns: expected.1 })
}

impl<const NODES: usize> FrameSettings for Config<NODES> {
    type Projection = UniformGrid<NODES>;
    type Fit = NoFit;
    type Fields = UniformHeader;

    fn projection(&self, rows: usize, columns: usize) -> Result<Self::Projection, ConfigError> {
        UniformGrid::with_tables(rows, columns, self.view, self.tables)
    }

    fn levels(&self) -> (u32, Scale, Companding) {
        (self.level_bits, self.scale, self.companding)
    }

    fn policy(&self) -> Policy {
        self.policy
    }

    fn strips(&self) -> u16 {
        self.strips
    }

    fn fields(&self, _: &NoFit) -> UniformHeader {
        UniformHeader { view: self.view, placement: self.placement }
    }
}

impl<'a, const LINES: usize, const NODES: usize> FrameSettings for LatticeConfig<'a, LINES, NODES> {
    type Projection = &'a Lattice<'a, LINES, NODES>;
    type Fit = GridFit;
    type Fields = BeamsHeader<'a>;

    fn projection(&self, rows: usize, columns: usize) -> Result<Self::Projection, ConfigError> {
        check_image((rows, columns), (self.lattice.rows(), self.lattice.columns()))?;
        Ok(self.lattice)
    }

    fn levels(&self) -> (u32, Scale, Companding) {
        (self.level_bits, self.scale, self.companding)
    }

    fn policy(&self) -> Policy {
        self.policy
    }

    fn strips(&self) -> u16 {
        self.strips
    }

    fn fields(&self, fit: &GridFit) -> BeamsHeader<'a> {
        let point_bound_m = if self.measure { fit.point_bound_m() } else { f32::INFINITY };
        BeamsHeader { grid: *self.lattice.grid(), point_bound_m, table: self.table }
    }

    fn measure(&self, points: &(impl Points + ?Sized), quantizer: &Quantizer, fit: &mut GridFit) {
        if self.measure {
            fit.add(points, self.lattice, quantizer);
        }
    }

    fn measure_returns(&self, quantizer: &Quantizer, fit: &mut GridFit) {
        // Of fewer columns than ticks, how far a point moves depends on its range: no bound.
        let is_exact = u32::from(self.lattice.columns()) == self.lattice.grid().ticks;
        fit.add_returns(quantizer, is_exact);
    }
}

/// The quantizer of these levels; `farthest_m` is asked only where the scale follows the frame, and gives `None` where
/// points come piece by piece. A scan without a point, or with all of them nearer than floats can scale, gets a scale of
/// one meter: its frame is empty and says so.
pub(crate) fn quantizer(
    (level_bits, scale, companding): (u32, Scale, Companding),
    farthest_m: impl FnOnce() -> Option<f32>,
) -> Result<Quantizer, EncodeError> {
    let up_to = |max_range_m| match companding {
        Companding::None => Quantizer::new(level_bits, max_range_m),
        Companding::SquareRoot => Quantizer::square_root(level_bits, max_range_m),
    };
    Ok(match (scale, companding) {
        (Scale::Fixed { max_range_m }, _) => up_to(max_range_m)?,
        (Scale::PerFrame, _) => {
            let farthest_m = farthest_m().ok_or(EncodeError::ScaleNeedsWholeScan)?;
            up_to(farthest_m).or_else(|_| up_to(1.0))?
        }
        (Scale::Step { step_m }, Companding::None) => Quantizer::with_step(level_bits, step_m)?,
        (Scale::Step { step_m }, Companding::SquareRoot) => Quantizer::square_root_with_step(level_bits, step_m)?,
    })
}
