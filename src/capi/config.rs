//! What frames are to be like, and what became of the points.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use super::context::{CDense, CSmall};
use super::memory::{Outcome, StartsAsZeros, choose, deliver};
use super::status::flicr_status;
use crate::coder::{DeflateDefault, DeflateDense, DeflateSmall, Rle, Store};
use crate::config::{Config, Scale};
use crate::encoder::{Encoded, Stamp};
use crate::frame::worst_case_len_in_strips as worst_case_len;
use crate::geometry::{Placement, UniformView, check_size};
use crate::image::Level;
use crate::insert::{Collision, OutOfView, Policy};
use crate::quantize::Companding;
use crate::tally::Tally;

/// A `flicr_preset` as it comes from C.
pub type PresetCode = u32;
/// A `flicr_coder` as it comes from C.
pub type CoderCode = u32;
/// A `flicr_collision` as it comes from C.
pub type CollisionCode = u32;
/// A `flicr_out_of_view` as it comes from C.
pub type OutOfViewCode = u32;
/// A `flicr_companding` as it comes from C.
pub type CompandingCode = u32;
/// A `flicr_placement` as it comes from C.
pub type PlacementCode = u32;

/// Where a configuration starts from.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_preset {
    /// As the code that made the paper's tables: the last point wins, points above or below go to the edge rows, the
    /// scale follows each frame, points come back at the corner of their pixel.
    Paper = 0,
    /// The best that evenly spaced rows and columns can do: the nearest point wins and comes back in the middle.
    Uniform = 1,
}

/// What makes the levels small. An encoder gets its coder from the function that makes it, so that a linker leaves out
/// all other coders; these are for sizes.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_coder {
    /// Nothing: the levels as they are.
    Store = 0,
    /// Run lengths: no state, the fewest instructions.
    Rle = 1,
    /// DEFLATE (RFC 1951), which every zlib inflates: about as small as zlib -6 makes it, much sooner.
    Deflate = 2,
    /// DEFLATE with a quarter of the memory, and a few percent more bytes.
    DeflateSmall = 3,
    /// DEFLATE with four times the memory, and a few percent fewer bytes.
    DeflateDense = 4,
    /// The context coder made for range images, its small tier: two thirds of DEFLATE's bytes and fewer, lossless or in
    /// steps.
    Small = 5,
    /// The same, its dense tier: the fewest bytes.
    Dense = 6,
}

/// Which point a pixel keeps where several fall into it.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_collision {
    /// The nearest.
    Nearest = 0,
    /// The farthest.
    Farthest = 1,
    /// The first inserted.
    First = 2,
    /// The last inserted.
    Last = 3,
}

/// What is done with points above the first row or below the last.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_out_of_view {
    /// Dropped and counted.
    Drop = 0,
    /// Moved into the first or last row, and counted.
    Clamp = 1,
}

/// Where in its pixel a decoded point is put.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_placement {
    /// In the middle: half the largest error.
    Center = 0,
    /// At the corner of smallest azimuth and largest elevation.
    Corner = 1,
}

/// How levels are spread over ranges.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_companding {
    /// Evenly.
    None = 0,
    /// By the square root, for up to 8 bits: finer near, coarser far, with less error on the whole. A step is the range of
    /// level 1 then.
    SquareRoot = 1,
}

/// What frames are to be like. Filled by flicr_config_init; then change what you like.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct flicr_config {
    /// Pixels in a row: azimuths. The paper's are 4500, 4096, 2048, 1024, 512 and 256.
    pub columns: u32,
    /// Pixels in a column: elevations, the highest first. The paper's are 64.
    pub rows: u32,
    /// Bits of a level, 1 to 8.
    pub level_bits: u32,
    /// The largest range that has a level, meters; points beyond are dropped and counted. 0: each frame's farthest
    /// point, which takes a pass of its own over the points, and whole scans.
    pub max_range_m: f32,
    /// Upper edge of row 0, radians above the horizon.
    pub top_rad: f32,
    /// Lower edge of the last row, radians above the horizon (mostly negative).
    pub bottom_rad: f32,
    /// Azimuth at which column 0 begins, radians from -pi to pi, counterclockwise from x.
    pub start_rad: f32,
    /// Azimuth that the columns span, radians; at most one turn.
    pub span_rad: f32,
    /// Which point a pixel keeps where several fall into it.
    pub collision: CollisionCode,
    /// What is done with points above the first row or below the last.
    pub out_of_view: OutOfViewCode,
    /// Where in its pixel a decoded point is put.
    pub placement: PlacementCode,
    /// How levels are spread over ranges.
    pub companding: CompandingCode,
    /// Strips that a frame is cut into, 1 to `columns`: runs of columns that decode alone. 1 unless set; with more, see
    /// FLICR_WORST_CASE_LEN_IN_STRIPS.
    pub strips: u32,
}

/// What the receiver is told of a frame besides its points.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct flicr_stamp {
    /// Time of the frame, nanoseconds, of any epoch.
    pub timestamp_ns: u64,
    /// Number of the frame.
    pub sequence: u32,
}

/// Points counted by what became of them. points = kept + no_return + not_finite + too_near + beyond_range +
/// out_of_view + collided.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct flicr_tally {
    /// Points inserted.
    pub points: u32,
    /// In the frame.
    pub kept: u32,
    /// At the origin: the sensor's way of saying that nothing came back.
    pub no_return: u32,
    /// With a coordinate that is NaN or infinite.
    pub not_finite: u32,
    /// Nearer than half a quantizer step.
    pub too_near: u32,
    /// Beyond the largest range.
    pub beyond_range: u32,
    /// Outside the azimuths, or outside the elevations where those are dropped.
    pub out_of_view: u32,
    /// In a pixel that another point was given.
    pub collided: u32,
    /// Of the kept and collided: moved into the first or last row.
    pub clamped: u32,
}

/// An encoded frame's length, and what became of the points.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct flicr_encoded {
    /// Bytes written to the front of the output.
    pub len: usize,
    /// Most that a kept point's range is off after decoding, meters.
    pub range_bound_m: f32,
    /// What became of every point.
    pub tally: flicr_tally,
}

/// Fills a configuration with a preset's choices, for a sensor that looks all around.
///
/// The presets' elevations are the HDL-64E's: for another sensor, set top_rad and bottom_rad.
///
/// FLICR_STATUS_PRESET, FLICR_STATUS_SIZE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_config_init(
    preset: PresetCode,
    columns: u32,
    rows: u32,
    out_config: *mut flicr_config,
) -> flicr_status {
    // SAFETY: the caller's promise about `out_config`.
    unsafe { deliver(out_config, |_| preset_config(preset, columns, rows)) }
}

fn preset_config(preset: PresetCode, columns: u32, rows: u32) -> Outcome<flicr_config> {
    let config = choose(&[Config::PAPER, Config::UNIFORM], preset, flicr_status::Preset)?;
    pixels(columns, rows)?;
    Ok(flicr_config::new(&config, columns, rows))
}

impl flicr_config {
    fn new(config: &Config, columns: u32, rows: u32) -> Self {
        let UniformView { top_rad, bottom_rad, start_rad, span_rad } = config.view;
        let max_range_m = match config.scale {
            Scale::Fixed { max_range_m } => max_range_m,
            Scale::PerFrame | Scale::Step { .. } => 0.0,
        };
        Self {
            columns,
            rows,
            level_bits: config.level_bits,
            max_range_m,
            top_rad,
            bottom_rad,
            start_rad,
            span_rad,
            collision: config.policy.collision as u32,
            out_of_view: config.policy.out_of_view as u32,
            placement: config.placement as u32,
            companding: config.companding as u32,
            strips: config.strips.into(),
        }
    }

    pub(super) fn to_config(self) -> Outcome<Config> {
        let Self { top_rad, bottom_rad, start_rad, span_rad, max_range_m, level_bits, .. } = self;
        let collisions = [Collision::Nearest, Collision::Farthest, Collision::First, Collision::Last];
        let policy = Policy {
            collision: choose(&collisions, self.collision, flicr_status::Collision)?,
            out_of_view: choose(&[OutOfView::Drop, OutOfView::Clamp], self.out_of_view, flicr_status::OutOfView)?,
        };
        let placements = [Placement::Center, Placement::Corner];
        let placement = choose(&placements, self.placement, flicr_status::Placement)?;
        let scale = if max_range_m == 0.0 { Scale::PerFrame } else { Scale::Fixed { max_range_m } };
        let view = UniformView { top_rad, bottom_rad, start_rad, span_rad };
        let strips = u16::try_from(self.strips).map_err(|_| flicr_status::Strips)?;
        let companding = companding(self.companding)?;
        Ok(Config { view, placement, level_bits, scale, companding, policy, strips, ..Config::UNIFORM })
    }
}

impl flicr_coder {
    pub(super) fn from_code(code: CoderCode) -> Option<Self> {
        let all =
            [Self::Store, Self::Rle, Self::Deflate, Self::DeflateSmall, Self::DeflateDense, Self::Small, Self::Dense];
        all.get(code as usize).copied()
    }

    pub(super) const fn state_len(self) -> usize {
        match self {
            Self::Store => Store::STATE_LEN,
            Self::Rle => Rle::STATE_LEN,
            Self::Deflate => DeflateDefault::STATE_LEN,
            Self::DeflateSmall => DeflateSmall::STATE_LEN,
            Self::DeflateDense => DeflateDense::STATE_LEN,
            Self::Small => CSmall::STATE_LEN,
            Self::Dense => CDense::STATE_LEN,
        }
    }

    /// Of `rows` x `columns` levels `L` in so many strips.
    pub(super) const fn worst_case_len<L: Level>(self, rows: usize, columns: usize, strips: u16) -> usize {
        match self {
            Self::Store => worst_case_len::<L, Store>(rows, columns, strips),
            Self::Rle => worst_case_len::<L, Rle>(rows, columns, strips),
            Self::Deflate => worst_case_len::<L, DeflateDefault>(rows, columns, strips),
            Self::DeflateSmall => worst_case_len::<L, DeflateSmall>(rows, columns, strips),
            Self::DeflateDense => worst_case_len::<L, DeflateDense>(rows, columns, strips),
            Self::Small => worst_case_len::<L, CSmall>(rows, columns, strips),
            Self::Dense => worst_case_len::<L, CDense>(rows, columns, strips),
        }
    }
}

pub(super) fn companding(code: CompandingCode) -> Outcome<Companding> {
    choose(&[Companding::None, Companding::SquareRoot], code, flicr_status::Companding)
}

/// Strips as C gives them; `None` where there cannot be as many.
pub(super) fn strips_of(columns: u32, strips: u32) -> Option<u16> {
    u16::try_from(strips).ok().filter(|_| (1..=columns).contains(&strips))
}

pub(super) fn pixels(columns: u32, rows: u32) -> Outcome<usize> {
    let (columns, rows) = (columns as usize, rows as usize);
    check_size(rows, columns)?;
    Ok(rows * columns)
}

impl From<flicr_stamp> for Stamp {
    fn from(stamp: flicr_stamp) -> Self {
        Self { sequence: stamp.sequence, timestamp_ns: stamp.timestamp_ns }
    }
}

impl From<Encoded> for flicr_encoded {
    fn from(encoded: Encoded) -> Self {
        let Encoded { len, tally, range_bound_m, .. } = encoded;
        Self { len, range_bound_m, tally: tally.into() }
    }
}

impl From<Tally> for flicr_tally {
    fn from(tally: Tally) -> Self {
        let kept = tally.kept();
        let Tally { points, no_return, not_finite, too_near, beyond_range, out_of_view, collided, clamped, .. } = tally;
        Self { points, kept, no_return, not_finite, too_near, beyond_range, out_of_view, collided, clamped }
    }
}
