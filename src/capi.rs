//! The C ABI. `include/flicr.h` is made from this file by cbindgen, and `tests/capi.rs` compares the two, so that the
//! types have their C names here too.
//!
//! The conventions, which the header's first comment tells C: a status is returned; results go to the last argument,
//! and only on success; the caller owns all memory and can size it at compile time.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]
#![allow(non_camel_case_types, reason = "as in C")]
#![allow(
    clippy::missing_safety_doc,
    reason = "one contract for all, in the header's first comment and `cbindgen.toml`"
)]

use core::ffi::{CStr, c_char, c_void};

use crate::coder::{Coder, DeflateDefault, DeflateDense, DeflateSmall, Rle, Store, WorstCase};
use crate::config::{Config, Scale};
use crate::encoder::{Encoded, OpenFrame, Stamp};
use crate::error::{ConfigError, EncodeError};
use crate::frame;
use crate::geometry::{Placement, UniformView, check_size};
use crate::image::{ImageView, ImageViewMut};
use crate::insert::{Collision, OutOfView, Policy};
use crate::point::{Block, Points, StridedPoints, XYZ_LEN, read_xyz};
use crate::tally::Tally;

/// Major version: changes where programs that use this header must be changed.
pub const FLICR_VERSION_MAJOR: u32 = 0;
/// Minor version: changes where something is added (and, while the major version is 0, where something breaks).
pub const FLICR_VERSION_MINOR: u32 = 1;
/// Patch version.
pub const FLICR_VERSION_PATCH: u32 = 0;

/// An encoder's memory must start at a multiple of this many bytes.
pub const FLICR_ENCODER_ALIGN: usize = 8;
/// Bytes that an encoder takes besides its image and its coder's state.
pub const FLICR_ENCODER_OVERHEAD: usize = 256;
/// Bytes that a frame takes besides its payload.
pub const FLICR_FRAME_OVERHEAD_LEN: usize = 76;
/// Bytes of the state of FLICR_CODER_DEFLATE.
pub const FLICR_DEFLATE_STATE_LEN: usize = 56_556;
/// Bytes of the state of FLICR_CODER_DEFLATE_SMALL.
pub const FLICR_DEFLATE_SMALL_STATE_LEN: usize = 13_548;
/// Bytes of the state of FLICR_CODER_DEFLATE_DENSE.
pub const FLICR_DEFLATE_DENSE_STATE_LEN: usize = 204_012;
/// FLICR_CODER_RLE writes one byte more for each so many pixels that do not repeat.
pub const FLICR_RLE_BLOCK_LEN: usize = 128;
/// FLICR_CODER_DEFLATE writes FLICR_DEFLATE_BLOCK_COST bytes more for each so many pixels that it cannot make smaller.
pub const FLICR_DEFLATE_BLOCK_LEN: usize = 3071;
/// As FLICR_DEFLATE_BLOCK_LEN, for FLICR_CODER_DEFLATE_SMALL.
pub const FLICR_DEFLATE_SMALL_BLOCK_LEN: usize = 1535;
/// As FLICR_DEFLATE_BLOCK_LEN, for FLICR_CODER_DEFLATE_DENSE.
pub const FLICR_DEFLATE_DENSE_BLOCK_LEN: usize = 3071;
/// Bytes that every block costs, with any of the three.
pub const FLICR_DEFLATE_BLOCK_COST: usize = 5;

/// What went wrong. The numbers stay what they are; later versions may add some.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum flicr_status {
    /// Nothing.
    Ok = 0,
    /// A pointer is null.
    NullPointer = 1,
    /// A pointer is not aligned for what it points to; an encoder's memory must be to FLICR_ENCODER_ALIGN.
    Misaligned = 2,
    /// The memory is smaller than FLICR_ENCODER_SIZE.
    StateTooSmall = 3,
    /// The memory holds no encoder: no flicr_encoder_init_... has been called, or something wrote over it.
    NotInitialized = 4,
    /// Points, output and encoder share memory.
    Overlap = 5,
    /// A preset that is not in flicr_preset.
    Preset = 6,
    /// Rows and columns must be 1 to 65535 each, with at most 2^30 pixels.
    Size = 7,
    /// Level bits must be 1 to 8.
    LevelBits = 8,
    /// The largest range must be 0 (the scale follows each frame) or a positive, finite number of meters.
    MaxRange = 9,
    /// Elevations must satisfy -pi/2 <= bottom < top <= pi/2.
    ElevationView = 10,
    /// The azimuths must start at -pi to pi and span more than nothing and at most one turn.
    AzimuthView = 11,
    /// A policy that is not in flicr_collision.
    Collision = 12,
    /// A policy that is not in flicr_out_of_view.
    OutOfView = 13,
    /// A placement that is not in flicr_placement.
    Placement = 14,
    /// A record must have at least the 12 bytes of x, y, z.
    Stride = 15,
    /// More points than memory can hold, or than a frame can count (2^32 - 1).
    TooManyPoints = 16,
    /// The frame does not fit the output buffer. Nothing in the buffer is a frame.
    OutputTooSmall = 17,
    /// The scale follows each frame's farthest point: encode whole scans, or configure a largest range.
    ScaleNeedsWholeScan = 18,
    /// No frame has been started.
    NotStarted = 19,
}

/// A `flicr_status` as it comes from C: any number. The header calls it `flicr_status`, as with those below.
pub type StatusCode = i32;
/// A `flicr_preset` as it comes from C.
pub type PresetCode = u32;
/// A `flicr_coder` as it comes from C.
pub type CoderCode = u32;
/// A `flicr_collision` as it comes from C.
pub type CollisionCode = u32;
/// A `flicr_out_of_view` as it comes from C.
pub type OutOfViewCode = u32;
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

/// An encoder, in memory of the caller's: this head, the coder's state, the image. To be ended, it needs nothing but
/// its memory's end.
#[derive(Debug)]
#[repr(align(8))]
pub struct flicr_encoder {
    magic: u32,
    layout: Layout,
    columns: usize,
    finish: Finish,
    config: Config,
    frame: Option<OpenFrame>,
}

/// Marks memory that holds an encoder.
const MAGIC: u32 = u32::from_be_bytes(*b"FLCe");

/// What the header and cbindgen must be told in plain numbers, and what C's numbers stand for here.
const _: () = {
    assert!(size_of::<flicr_encoder>() <= FLICR_ENCODER_OVERHEAD);
    assert!(align_of::<flicr_encoder>() == FLICR_ENCODER_ALIGN);
    assert!(FLICR_ENCODER_OVERHEAD.is_multiple_of(FLICR_ENCODER_ALIGN));
    assert!(FLICR_FRAME_OVERHEAD_LEN == frame::OVERHEAD_LEN);
    assert!(is_worst_case::<Rle>(FLICR_RLE_BLOCK_LEN, 1));
    assert!(is_worst_case::<DeflateDefault>(FLICR_DEFLATE_BLOCK_LEN, FLICR_DEFLATE_BLOCK_COST));
    assert!(is_worst_case::<DeflateSmall>(FLICR_DEFLATE_SMALL_BLOCK_LEN, FLICR_DEFLATE_BLOCK_COST));
    assert!(is_worst_case::<DeflateDense>(FLICR_DEFLATE_DENSE_BLOCK_LEN, FLICR_DEFLATE_BLOCK_COST));
    // Where one of these does not compile, the compiler says which length is right.
    let _: [u8; size_of::<DeflateDefault>()] = [0; FLICR_DEFLATE_STATE_LEN];
    let _: [u8; size_of::<DeflateSmall>()] = [0; FLICR_DEFLATE_SMALL_STATE_LEN];
    let _: [u8; size_of::<DeflateDense>()] = [0; FLICR_DEFLATE_DENSE_STATE_LEN];
    assert!(flicr_collision::Nearest as u32 == Collision::Nearest as u32);
    assert!(flicr_collision::Farthest as u32 == Collision::Farthest as u32);
    assert!(flicr_collision::First as u32 == Collision::First as u32);
    assert!(flicr_collision::Last as u32 == Collision::Last as u32);
    assert!(flicr_out_of_view::Drop as u32 == OutOfView::Drop as u32);
    assert!(flicr_out_of_view::Clamp as u32 == OutOfView::Clamp as u32);
    assert!(flicr_placement::Center as u32 == Placement::Center as u32);
    assert!(flicr_placement::Corner as u32 == Placement::Corner as u32);
};

const fn is_worst_case<C: Coder<u8>>(len: usize, cost: usize) -> bool {
    let WorstCase { bytes_per_level, block_len, bytes_per_block } = C::WORST_CASE;
    bytes_per_level == 1 && block_len == len && bytes_per_block == cost
}

/// The version of the library, to compare with FLICR_VERSION, the header's.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_version() -> u32 {
    (FLICR_VERSION_MAJOR << 16) | (FLICR_VERSION_MINOR << 8) | FLICR_VERSION_PATCH
}

/// A sentence in English for a status; a sentence for numbers that are none, too. Never null, never to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_status_text(status: StatusCode) -> *const c_char {
    flicr_status::text(status).as_ptr()
}

/// What FLICR_ENCODER_SIZE gives: bytes that an encoder takes. 0 where there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_encoder_size(columns: u32, rows: u32, coder: CoderCode) -> usize {
    size_of_encoder(columns, rows, coder).unwrap_or(0)
}

/// What FLICR_WORST_CASE_LEN gives: output bytes that are enough for every frame. 0 where there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_worst_case_len(columns: u32, rows: u32, coder: CoderCode) -> usize {
    worst_case_len(columns, rows, coder).unwrap_or(0)
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
    unsafe { deliver(out_config, || preset_config(preset, columns, rows)) }
}

/// Makes an encoder that stores levels as they are, in memory of at least
/// FLICR_ENCODER_SIZE(config->columns, config->rows, FLICR_CODER_STORE) bytes, aligned to FLICR_ENCODER_ALIGN. What the
/// memory held does not matter.
///
/// FLICR_STATUS_STATE_TOO_SMALL, FLICR_STATUS_MISALIGNED, and any status that names a member of the configuration.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_store(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, || place_encoder::<Store>(state, state_len, &read(config)?)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_RLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_rle(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, || place_encoder::<Rle>(state, state_len, &read(config)?)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_DEFLATE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_deflate(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, || place_encoder::<DeflateDefault>(state, state_len, &read(config)?)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_DEFLATE_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_deflate_small(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, || place_encoder::<DeflateSmall>(state, state_len, &read(config)?)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_DEFLATE_DENSE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_deflate_dense(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, || place_encoder::<DeflateDense>(state, state_len, &read(config)?)) }
}

/// Encodes a whole scan to the front of `out`: `count` records, `stride_bytes` apart, each starting with x, y, z as
/// float, meters (x forward, y left, z up), at any alignment. Of the last record only these 12 bytes are read. A frame
/// that was started is dropped.
///
/// FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_WORST_CASE_LEN bytes; FLICR_STATUS_STRIDE,
/// FLICR_STATUS_TOO_MANY_POINTS, FLICR_STATUS_OVERLAP.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "C has no slices")]
pub unsafe extern "C" fn flicr_encode(
    encoder: *mut flicr_encoder,
    points: *const c_void,
    count: usize,
    stride_bytes: usize,
    stamp: flicr_stamp,
    out: *mut c_void,
    out_len: usize,
    out_encoded: *mut flicr_encoded,
) -> flicr_status {
    let scan = || Records::new(points, count, stride_bytes);
    // SAFETY: the caller's promises about the four pointers.
    unsafe { deliver(out_encoded, || encode(encoder, scan()?, stamp, Output::new(out, out_len)?)) }
}

/// Begins a frame whose points come piece by piece. A frame that was started before is dropped.
///
/// FLICR_STATUS_SCALE_NEEDS_WHOLE_SCAN where the configuration has no largest range.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_start(encoder: *mut flicr_encoder, stamp: flicr_stamp) -> flicr_status {
    // SAFETY: the caller's promise about `encoder`.
    code(unsafe { start(encoder, stamp) })
}

/// Puts points into the frame that was started; as in flicr_encode.
///
/// FLICR_STATUS_NOT_STARTED, FLICR_STATUS_STRIDE, FLICR_STATUS_TOO_MANY_POINTS, FLICR_STATUS_OVERLAP: none of the
/// points are in the frame then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_insert(
    encoder: *mut flicr_encoder,
    points: *const c_void,
    count: usize,
    stride_bytes: usize,
) -> flicr_status {
    // SAFETY: the caller's promises about `encoder` and `points`.
    code(Records::new(points, count, stride_bytes).and_then(|scan| unsafe { insert(encoder, scan) }))
}

/// Codes the frame that was started to the front of `out`, and ends it.
///
/// FLICR_STATUS_NOT_STARTED; FLICR_STATUS_OUTPUT_TOO_SMALL and FLICR_STATUS_OVERLAP: the frame stays as it is then, to
/// be finished elsewhere.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_finish(
    encoder: *mut flicr_encoder,
    out: *mut c_void,
    out_len: usize,
    out_encoded: *mut flicr_encoded,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoded, || finish(encoder, Output::new(out, out_len)?)) }
}

type Outcome<T> = Result<T, flicr_status>;

fn code(outcome: Outcome<()>) -> flicr_status {
    outcome.err().unwrap_or(flicr_status::Ok)
}

/// Checks where the result is to go, does the work, and writes the result if there is one.
///
/// # Safety
/// `out` is null or may be written to.
unsafe fn deliver<T>(out: *mut T, work: impl FnOnce() -> Outcome<T>) -> flicr_status {
    code(check_place(out).and_then(|()| {
        let result = work()?;
        // SAFETY: neither null nor misaligned, and the caller's promise.
        unsafe { out.write(result) };
        Ok(())
    }))
}

fn check_place<T>(place: *const T) -> Outcome<()> {
    if place.is_null() {
        Err(flicr_status::NullPointer)
    } else if !place.is_aligned() {
        Err(flicr_status::Misaligned)
    } else {
        Ok(())
    }
}

/// # Safety
/// `place` is null or may be read.
unsafe fn read<T: Copy>(place: *const T) -> Outcome<T> {
    check_place(place)?;
    // SAFETY: neither null nor misaligned, and the caller's promise.
    Ok(unsafe { place.read() })
}

/// The choice that has this number: C's numbers are those of the enumerations here.
fn choose<T: Copy>(choices: &[T], number: u32, otherwise: flicr_status) -> Outcome<T> {
    choices.get(number as usize).copied().ok_or(otherwise)
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
        }
    }

    fn to_config(self) -> Outcome<Config> {
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
        Ok(Config { view, placement, level_bits, scale, policy, ..Config::UNIFORM })
    }
}

impl flicr_coder {
    fn from_code(code: CoderCode) -> Option<Self> {
        let all = [Self::Store, Self::Rle, Self::Deflate, Self::DeflateSmall, Self::DeflateDense];
        all.get(code as usize).copied()
    }

    const fn state_len(self) -> usize {
        match self {
            Self::Store => size_of::<Store>(),
            Self::Rle => size_of::<Rle>(),
            Self::Deflate => size_of::<DeflateDefault>(),
            Self::DeflateSmall => size_of::<DeflateSmall>(),
            Self::DeflateDense => size_of::<DeflateDense>(),
        }
    }

    const fn worst_case_len(self, pixels: usize) -> usize {
        match self {
            Self::Store => frame::worst_case_len::<u8, Store>(pixels),
            Self::Rle => frame::worst_case_len::<u8, Rle>(pixels),
            Self::Deflate => frame::worst_case_len::<u8, DeflateDefault>(pixels),
            Self::DeflateSmall => frame::worst_case_len::<u8, DeflateSmall>(pixels),
            Self::DeflateDense => frame::worst_case_len::<u8, DeflateDense>(pixels),
        }
    }
}

/// Where in an encoder's memory its parts are; the coder's state is at `FLICR_ENCODER_OVERHEAD`.
#[derive(Debug, Clone, Copy)]
struct Layout {
    image_at: usize,
    len: usize,
}

impl Layout {
    const fn new(state_len: usize, pixels: usize) -> Self {
        let image_at = FLICR_ENCODER_OVERHEAD + state_len;
        Self { image_at, len: image_at + pixels }
    }
}

fn pixels(columns: u32, rows: u32) -> Outcome<usize> {
    let (columns, rows) = (columns as usize, rows as usize);
    check_size(rows, columns)?;
    Ok(rows * columns)
}

fn size_of_encoder(columns: u32, rows: u32, coder: CoderCode) -> Option<usize> {
    let pixels = pixels(columns, rows).ok()?;
    Some(Layout::new(flicr_coder::from_code(coder)?.state_len(), pixels).len)
}

fn worst_case_len(columns: u32, rows: u32, coder: CoderCode) -> Option<usize> {
    let pixels = pixels(columns, rows).ok()?;
    Some(flicr_coder::from_code(coder)?.worst_case_len(pixels))
}

/// Coders that may start as zeros where they are to stay. One that is made elsewhere and moved there goes through the
/// stack, which on a device is smaller than the coder.
///
/// # Safety
/// Zeros must be a value of the type, and code as a new one does.
unsafe trait StartsAsZeros: Coder<u8> {}

// SAFETY: there is no state.
unsafe impl StartsAsZeros for Store {}
// SAFETY: there is no state.
unsafe impl StartsAsZeros for Rle {}
// SAFETY: numbers only, as the constants below show, and all zero when new, as the type's documentation promises.
unsafe impl StartsAsZeros for DeflateDefault {}
// SAFETY: as above.
unsafe impl StartsAsZeros for DeflateSmall {}
// SAFETY: as above.
unsafe impl StartsAsZeros for DeflateDense {}

// SAFETY: a constant that is no value of its type does not compile.
const _: DeflateDefault = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: DeflateSmall = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: DeflateDense = unsafe { core::mem::zeroed() };

/// Codes and writes a frame, with the coder's state at the pointer.
type Finish = unsafe fn(*mut c_void, &OpenFrame, ImageView<'_, u8>, &mut [u8]) -> Outcome<flicr_encoded>;

/// # Safety
/// `state` is where [`place_encoder`] has put a `C`, and nobody else uses that meanwhile.
unsafe fn finish_with<C: Coder<u8>>(
    state: *mut c_void,
    frame: &OpenFrame,
    image: ImageView<'_, u8>,
    out: &mut [u8],
) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promise.
    let coder = unsafe { &mut *state.cast::<C>() };
    Ok(frame.finish(image, coder, out)?.into())
}

/// # Safety
/// `state` is null or may be written for `state_len` bytes.
unsafe fn place_encoder<C: StartsAsZeros>(
    state: *mut c_void,
    state_len: usize,
    settings: &flicr_config,
) -> Outcome<*mut flicr_encoder> {
    const { assert!(align_of::<C>() <= FLICR_ENCODER_ALIGN) };
    let layout = Layout::new(size_of::<C>(), pixels(settings.columns, settings.rows)?);
    let head = flicr_encoder::new(settings, layout, finish_with::<C>)?;
    let encoder = state.cast::<flicr_encoder>();
    check_place(encoder)?;
    if state_len < layout.len {
        return Err(flicr_status::StateTooSmall);
    }
    // SAFETY: `layout.len` bytes may be written, the head at their aligned start. Zeros are a coder that has been
    // vouched for, and an image without returns.
    unsafe {
        state.write_bytes(0, layout.len);
        encoder.write(head);
    }
    Ok(encoder)
}

const fn coder_of(encoder: *mut flicr_encoder) -> *mut c_void {
    encoder.cast::<c_void>().wrapping_byte_add(FLICR_ENCODER_OVERHEAD)
}

impl flicr_encoder {
    fn new(settings: &flicr_config, layout: Layout, finish: Finish) -> Outcome<Self> {
        let config = settings.to_config()?;
        let (rows, columns) = (settings.rows as usize, settings.columns as usize);
        // Finds now what would be found with every frame.
        OpenFrame::new::<u8>(&config, || Some(1.0), Stamp::default(), rows, columns)?;
        Ok(Self { magic: MAGIC, layout, columns, finish, config, frame: None })
    }
}

/// An encoder's parts. The coder's state stays a pointer: its type is known to `finish` alone.
#[derive(Debug)]
struct Parts<'a> {
    head: &'a mut flicr_encoder,
    coder: *mut c_void,
    image: ImageViewMut<'a, u8>,
}

/// Checks that memory is an encoder's, and that the `others` have no part in it or in one another.
///
/// # Safety
/// `encoder` is null or points to memory that is large enough for a head, holds whatever `place_encoder` and the
/// functions below have written, and is used by nobody else before the result's last use.
unsafe fn parts<'a>(encoder: *mut flicr_encoder, others: [Span; 2]) -> Outcome<Parts<'a>> {
    check_place(encoder)?;
    // SAFETY: neither null nor misaligned; a number may have any value.
    if unsafe { (&raw const (*encoder).magic).read() } != MAGIC {
        return Err(flicr_status::NotInitialized);
    }
    // SAFETY: so `place_encoder` wrote a head here.
    let layout = unsafe { (*encoder).layout };
    check_apart(Span { start: encoder.cast(), len: layout.len }, others)?;
    // SAFETY: as above; and behind the head it wrote the coder's state and the image, to `layout.len`. The three share
    // no byte.
    unsafe {
        let head = &mut *encoder;
        let start = encoder.cast::<u8>();
        let levels = core::slice::from_raw_parts_mut(start.add(layout.image_at), layout.len - layout.image_at);
        let image = ImageViewMut::new(levels, head.columns).ok_or(flicr_status::Size)?;
        Ok(Parts { head, coder: coder_of(encoder), image })
    }
}

/// Memory that C lends for one call.
#[derive(Debug, Clone, Copy)]
struct Span {
    start: *const u8,
    len: usize,
}

impl Span {
    const NONE: Self = Self { start: core::ptr::dangling(), len: 0 };

    /// A slice has no more bytes than `isize` counts; a longer one cannot be meant.
    fn new(start: *const c_void, len: usize) -> Outcome<Self> {
        check_place(start)?;
        Ok(Self { start: start.cast(), len: len.min(isize::MAX as usize) })
    }

    fn is_apart(&self, other: &Self) -> bool {
        let (a, b) = (self.start.addr(), other.start.addr());
        a.saturating_add(self.len) <= b || b.saturating_add(other.len) <= a
    }
}

fn check_apart(memory: Span, [a, b]: [Span; 2]) -> Outcome<()> {
    let apart = memory.is_apart(&a) && memory.is_apart(&b) && a.is_apart(&b);
    if apart { Ok(()) } else { Err(flicr_status::Overlap) }
}

/// Records that start with x, y, z; the last one may end behind them.
#[derive(Debug, Clone, Copy)]
struct Records {
    span: Span,
    count: u32,
    stride: usize,
}

impl Records {
    fn new(points: *const c_void, count: usize, stride: usize) -> Outcome<Self> {
        if stride < XYZ_LEN {
            return Err(flicr_status::Stride);
        }
        let Some(gaps) = count.checked_sub(1) else {
            return Ok(Self { span: Span::NONE, count: 0, stride });
        };
        let len = gaps.checked_mul(stride).and_then(|len| len.checked_add(XYZ_LEN));
        let len = len.filter(|&len| isize::try_from(len).is_ok()).ok_or(flicr_status::TooManyPoints)?;
        let count = u32::try_from(count).map_err(|_| flicr_status::TooManyPoints)?;
        Ok(Self { span: Span::new(points, len)?, count, stride })
    }

    /// # Safety
    /// The span may be read, and nobody writes to it before the result's last use.
    unsafe fn points<'a>(self) -> Outcome<StridedXyz<'a>> {
        // SAFETY: the caller's promise; bytes need no alignment.
        let bytes = unsafe { core::slice::from_raw_parts(self.span.start, self.span.len) };
        StridedXyz::new(bytes, self.stride).ok_or(flicr_status::Stride)
    }
}

/// Records of which the last may end behind x, y, z: [`StridedPoints`] takes whole ones only.
#[derive(Debug, Clone, Copy)]
struct StridedXyz<'a> {
    whole: StridedPoints<'a>,
    last: &'a [u8],
}

impl<'a> StridedXyz<'a> {
    fn new(bytes: &'a [u8], stride: usize) -> Option<Self> {
        let whole = StridedPoints::new(bytes, stride)?;
        let last = bytes.get(bytes.len() - whole.remainder_len()..)?;
        Some(Self { whole, last })
    }
}

impl Points for StridedXyz<'_> {
    fn for_each_block(&self, mut each: impl FnMut(&Block, usize)) {
        self.whole.for_each_block(&mut each);
        if !self.last.is_empty() {
            let mut block = Block::new();
            let len = block.fill(core::iter::once(read_xyz(self.last)));
            each(&block, len);
        }
    }
}

/// Where a frame is to go.
#[derive(Debug, Clone, Copy)]
struct Output {
    span: Span,
}

impl Output {
    fn new(start: *mut c_void, len: usize) -> Outcome<Self> {
        Ok(Self { span: Span::new(start, len)? })
    }

    /// # Safety
    /// The span came from a pointer that may be written through, and nobody else uses it before the result's last
    /// use.
    unsafe fn bytes<'a>(self) -> &'a mut [u8] {
        // SAFETY: the caller's promise. What it holds is written before it is read.
        unsafe { core::slice::from_raw_parts_mut(self.span.start.cast_mut(), self.span.len) }
    }
}

/// # Safety
/// As the header demands of `flicr_encode`.
unsafe fn encode(
    encoder: *mut flicr_encoder,
    scan: Records,
    stamp: flicr_stamp,
    out: Output,
) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    unsafe {
        let Parts { head, coder, mut image } = parts(encoder, [scan.span, out.span])?;
        head.frame = None;
        let frame = OpenFrame::of_scan(&head.config, &scan.points()?, stamp.into(), &mut image)?;
        (head.finish)(coder, &frame, image.as_view(), out.bytes())
    }
}

/// # Safety
/// As the header demands of `flicr_start`.
unsafe fn start(encoder: *mut flicr_encoder, stamp: flicr_stamp) -> Outcome<()> {
    // SAFETY: the caller's promise.
    let Parts { head, mut image, .. } = unsafe { parts(encoder, [Span::NONE; 2]) }?;
    head.frame = None;
    head.frame = Some(OpenFrame::start(&head.config, stamp.into(), &mut image)?);
    Ok(())
}

/// # Safety
/// As the header demands of `flicr_insert`.
unsafe fn insert(encoder: *mut flicr_encoder, scan: Records) -> Outcome<()> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    let (Parts { head, mut image, .. }, points) = unsafe { (parts(encoder, [scan.span, Span::NONE])?, scan.points()?) };
    let frame = head.frame.as_mut().ok_or(flicr_status::NotStarted)?;
    frame.tally().points.checked_add(scan.count).ok_or(flicr_status::TooManyPoints)?;
    frame.insert(&points, &mut image);
    Ok(())
}

/// # Safety
/// As the header demands of `flicr_finish`.
unsafe fn finish(encoder: *mut flicr_encoder, out: Output) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    unsafe {
        let Parts { head, coder, image } = parts(encoder, [Span::NONE, out.span])?;
        let frame = head.frame.as_ref().ok_or(flicr_status::NotStarted)?;
        let finished = (head.finish)(coder, frame, image.as_view(), out.bytes())?;
        head.frame = None;
        Ok(finished)
    }
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
        let Tally { points, no_return, not_finite, too_near, beyond_range, out_of_view, collided, clamped } = tally;
        Self { points, kept, no_return, not_finite, too_near, beyond_range, out_of_view, collided, clamped }
    }
}

impl From<ConfigError> for flicr_status {
    fn from(error: ConfigError) -> Self {
        match error {
            // The sensors' own grids are not in the C ABI; of their errors, all are about what does not fit the image.
            ConfigError::Size { .. }
            | ConfigError::ImageSize { .. }
            | ConfigError::CoderRows { .. }
            | ConfigError::Beams { .. }
            | ConfigError::Beam { .. }
            | ConfigError::Ticks { .. }
            | ConfigError::RangeUnit { .. } => Self::Size,
            ConfigError::LevelBits { .. } => Self::LevelBits,
            ConfigError::MaxRange { .. } => Self::MaxRange,
            ConfigError::ElevationView { .. } => Self::ElevationView,
            ConfigError::AzimuthView { .. } => Self::AzimuthView,
        }
    }
}

impl From<EncodeError> for flicr_status {
    fn from(error: EncodeError) -> Self {
        match error {
            EncodeError::OutputTooSmall { .. } => Self::OutputTooSmall,
            EncodeError::ScaleNeedsWholeScan => Self::ScaleNeedsWholeScan,
            EncodeError::Config(error) => error.into(),
        }
    }
}

impl flicr_status {
    /// All of them, each at its number.
    const ALL: [(Self, &CStr); 20] = [
        (Self::Ok, c"all is well"),
        (Self::NullPointer, c"a pointer is null"),
        (Self::Misaligned, c"a pointer is not aligned for what it points to"),
        (Self::StateTooSmall, c"the memory for the encoder is too small: FLICR_ENCODER_SIZE says what it takes"),
        (Self::NotInitialized, c"the memory holds no encoder: the functions flicr_encoder_init_... make one"),
        (Self::Overlap, c"points, output and encoder share memory"),
        (Self::Preset, c"no such preset"),
        (Self::Size, c"rows and columns must be 1 to 65535 each, with at most 2^30 pixels"),
        (Self::LevelBits, c"level bits must be 1 to 8"),
        (Self::MaxRange, c"the largest range must be 0 or a positive, finite number of meters"),
        (Self::ElevationView, c"elevations must satisfy -pi/2 <= bottom < top <= pi/2"),
        (Self::AzimuthView, c"the azimuths must start at -pi to pi and span more than nothing and at most one turn"),
        (Self::Collision, c"no such collision policy"),
        (Self::OutOfView, c"no such policy for points out of view"),
        (Self::Placement, c"no such placement"),
        (Self::Stride, c"a record must have at least the 12 bytes of x, y, z"),
        (Self::TooManyPoints, c"more points than memory can hold or a frame can count"),
        (Self::OutputTooSmall, c"the frame does not fit the output: FLICR_WORST_CASE_LEN bytes are always enough"),
        (Self::ScaleNeedsWholeScan, c"the scale follows each frame: encode whole scans or configure a largest range"),
        (Self::NotStarted, c"no frame has been started"),
    ];

    fn text(code: StatusCode) -> &'static CStr {
        let known = usize::try_from(code).ok().and_then(|at| Self::ALL.get(at));
        known.map_or(c"no status of this version of flicr", |&(_, text)| text)
    }
}

const _: () = {
    let mut at = 0;
    while at < flicr_status::ALL.len() {
        assert!(flicr_status::ALL[at].0 as usize == at);
        at += 1;
    }
};

/// For a static library without Rust's standard library, which `tools/staticlib.sh` builds with `--cfg
/// flicr_staticlib`; everybody else has a handler already. Nothing in the library is known to get here: it stops where
/// a debugger can see it, as there is nobody to tell.
#[cfg(flicr_staticlib)]
#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
