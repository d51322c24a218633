//! The paper's geometry: rows and columns evenly spaced in elevation and azimuth.

use core::f32::consts::{FRAC_PI_2, FRAC_PI_6, PI, TAU};

use super::angles::{self, AngleTables};
use super::{Pixels, Projection};
use crate::error::ConfigError;
use crate::kernel;
use crate::point::Block;
use crate::quantize::Quantizer;

/// Most pixels of an image: row-major places leave the two topmost bits to marks.
const PIXELS_MAX: usize = 1 << 30;

/// The part of the sphere that a [`UniformGrid`] divides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UniformView {
    /// Upper edge of row 0, radians above the horizon.
    pub top_rad: f32,
    /// Lower edge of the last row, radians above the horizon (mostly negative).
    pub bottom_rad: f32,
    /// Azimuth at which column 0 begins, radians from -pi to pi, counterclockwise from x.
    pub start_rad: f32,
    /// Azimuth that the columns span, radians; at most one turn.
    pub span_rad: f32,
}

impl UniformView {
    /// The HDL-64E as the paper's authors set it: +2 to -24.8 degrees, all around from -x.
    pub const HDL64E: Self = Self::all_around(2.0, -24.8);
    /// The VLP-16: +16 to -16 degrees, so that each of the 16 beams (+15 to -15) is in the middle of its row.
    pub const VLP16: Self = Self::all_around(16.0, -16.0);

    /// All around, between two elevations in degrees.
    #[must_use]
    pub const fn all_around(top_deg: f32, bottom_deg: f32) -> Self {
        Self { top_rad: top_deg.to_radians(), bottom_rad: bottom_deg.to_radians(), start_rad: -PI, span_rad: TAU }
    }

    /// Checks what the docs of the fields say.
    ///
    /// # Errors
    /// [`ConfigError::ElevationView`], [`ConfigError::AzimuthView`].
    pub const fn check(&self) -> Result<(), ConfigError> {
        let Self { top_rad, bottom_rad, start_rad, span_rad } = *self;
        if !(bottom_rad >= -FRAC_PI_2 && bottom_rad < top_rad && top_rad <= FRAC_PI_2) {
            return Err(ConfigError::ElevationView { top_rad, bottom_rad });
        }
        if !(start_rad >= -PI && start_rad <= PI && span_rad > 0.0 && span_rad <= TAU) {
            return Err(ConfigError::AzimuthView { start_rad, span_rad });
        }
        Ok(())
    }
}

/// Whether an image can have that many rows and columns.
pub(crate) const fn check_size(rows: usize, columns: usize) -> Result<(), ConfigError> {
    let too_large = rows > u16::MAX as usize || columns > u16::MAX as usize || rows * columns > PIXELS_MAX;
    if too_large || rows == 0 || columns == 0 { Err(ConfigError::Size { rows, columns }) } else { Ok(()) }
}

/// Where in its pixel a decoded point is put.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Placement {
    /// In the middle: half the largest error.
    #[default]
    Center,
    /// At the corner of smallest azimuth and largest elevation, as the paper's authors do.
    Corner,
}

impl Placement {
    /// Where the point is, in pixels from that corner.
    #[must_use]
    pub const fn offset(self) -> f64 {
        match self {
            Self::Center => 0.5,
            Self::Corner => 0.0,
        }
    }
}

/// Rows evenly spaced in elevation, columns in azimuth. The paper's equation 1: range = |p|, polar angle =
/// acos(z / range), azimuth = atan(y / x), each divided by the sensor's angular precision.
///
/// `NODES` picks the angle tables: [`angles::FINE`] by default, [`angles::COARSE`] with `UniformGrid::<65>`.
///
/// ```
/// use flicr::{UniformGrid, UniformView};
/// const GRID: UniformGrid = match UniformGrid::new(64, 4500, UniformView::HDL64E) {
///     Ok(grid) => grid,
///     Err(_) => panic!("checked at compile time"),
/// };
/// ```
#[derive(Debug, Clone, Copy)]
pub struct UniformGrid<const NODES: usize = 257> {
    rows: u16,
    columns: u16,
    view: UniformView,
    pub(crate) last_row: u32,
    pub(crate) last_column: u32,
    pub(crate) rows_per_rad: f32,
    pub(crate) columns_per_rad: f32,
    /// All around from -pi and within 30 degrees of the horizon: the kernel's shortest way will do.
    pub(crate) is_plain: bool,
    tables: &'static AngleTables<NODES>,
}

impl UniformGrid {
    /// `rows` x `columns` pixels over `view`, projected with [`angles::FINE`].
    ///
    /// # Errors
    /// [`ConfigError::Size`], [`ConfigError::ElevationView`], [`ConfigError::AzimuthView`].
    pub const fn new(rows: usize, columns: usize, view: UniformView) -> Result<Self, ConfigError> {
        UniformGrid::with_tables(rows, columns, view, &angles::FINE)
    }
}

impl<const NODES: usize> UniformGrid<NODES> {
    /// `rows` x `columns` pixels over `view`, projected with the given tables.
    ///
    /// # Errors
    /// [`ConfigError::Size`], [`ConfigError::ElevationView`], [`ConfigError::AzimuthView`].
    pub const fn with_tables(
        rows: usize,
        columns: usize,
        view: UniformView,
        tables: &'static AngleTables<NODES>,
    ) -> Result<Self, ConfigError> {
        if let Err(error) = check_size(rows, columns) {
            return Err(error);
        }
        if let Err(error) = view.check() {
            return Err(error);
        }
        Ok(Self {
            rows: rows as u16,
            columns: columns as u16,
            view,
            last_row: rows as u32 - 1,
            last_column: columns as u32 - 1,
            is_plain: view.span_rad == TAU
                && view.start_rad == -PI
                && view.top_rad <= FRAC_PI_6
                && view.bottom_rad >= -FRAC_PI_6,
            rows_per_rad: rows as f32 / (view.top_rad - view.bottom_rad),
            columns_per_rad: columns_per_rad(columns as f32, view.span_rad),
            tables,
        })
    }

    /// The part of the sphere that is divided.
    #[must_use]
    pub const fn view(&self) -> &UniformView {
        &self.view
    }

    /// The angle tables.
    #[must_use]
    pub const fn tables(&self) -> &'static AngleTables<NODES> {
        self.tables
    }
}

/// The largest scale by which the end of the span is still in the last column, rounding included.
const fn columns_per_rad(columns: f32, span_rad: f32) -> f32 {
    let mut scale = columns / span_rad;
    while span_rad * scale >= columns {
        scale = scale.next_down();
    }
    scale
}

impl<const NODES: usize> Projection for UniformGrid<NODES> {
    fn rows(&self) -> u16 {
        self.rows
    }

    fn columns(&self) -> u16 {
        self.columns
    }

    fn project(&self, block: &Block, quantizer: &Quantizer, pixels: &mut Pixels) {
        kernel::project_uniform(self, quantizer, block, pixels);
    }
}
