//! What can go wrong, as small `Copy` values that say what was wrong, what was found and what was expected.

use core::fmt;

/// A configuration that no frame can be made with. Found when the configuration is made, not when it is used.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// A frame has 1 to 65,535 rows, as many columns, and at most 2^30 pixels.
    Size {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
    },
    /// Levels have 1 to 8 bits in an image of `u8`, 9 to 16 in one of `u16`.
    LevelBits {
        /// Bits asked for.
        found: u32,
        /// Fewest bits for the pixel type.
        min: u32,
        /// Most bits for the pixel type.
        max: u32,
    },
    /// A frame is cut into 1 strip to as many as it has columns.
    Strips {
        /// Strips asked for.
        found: u16,
        /// Columns.
        max: u16,
    },
    /// The largest range must be a positive, finite number of meters.
    MaxRange {
        /// Meters asked for.
        found_m: f32,
    },
    /// The image must have a row for each of the sensor's beams, and the lattice's columns.
    ImageSize {
        /// Rows of the image.
        rows: usize,
        /// Columns of the image.
        columns: usize,
        /// Beams.
        expected_rows: u16,
        /// Columns of the lattice.
        expected_columns: u16,
    },
    /// A sensor has at least one beam, and a table of its own size or [`Lattice`](crate::geometry::Lattice) a most.
    Beams {
        /// Beams there are.
        found: usize,
        /// Most that there may be.
        max: usize,
    },
    /// A plane has a number for every pixel of the image, or for every column.
    Plane {
        /// Numbers there are.
        found: usize,
        /// Pixels or columns.
        expected: usize,
    },
    /// A coder has state for a number of rows.
    CoderRows {
        /// Rows of the image.
        found: usize,
        /// Most that the coder has room for.
        max: usize,
    },
    /// The beams' slopes must fall from row to row, and their numbers be such as a sensor can have.
    Beam {
        /// First row that is not so.
        row: usize,
    },
    /// A turn has 1 to 2^20 ticks.
    Ticks {
        /// Ticks asked for.
        found: u32,
        /// Most that there may be.
        max: u32,
    },
    /// A list of firings has at least one, and none beyond the turn's ticks.
    Firings {
        /// First tick that is beyond; `ticks` where there is no firing.
        tick: u32,
        /// Ticks a turn.
        ticks: u32,
    },
    /// A range unit is more than 0 and at most a meter.
    RangeUnit {
        /// Meters asked for.
        found_m: f32,
    },
    /// Columns whose beams are aligned take room for what is fired before the last of it; also where a turn's columns are
    /// not given, or are more than 8192.
    Delay {
        /// Cells that it takes.
        cells: usize,
        /// Cells that there are.
        cells_max: usize,
        /// Firings that it takes.
        firings: usize,
        /// Firings that there is room for.
        firings_max: usize,
    },
    /// Elevations must satisfy -90 degrees <= bottom < top <= 90 degrees.
    ElevationView {
        /// Upper edge asked for, radians.
        top_rad: f32,
        /// Lower edge asked for, radians.
        bottom_rad: f32,
    },
    /// The azimuth view must start at -pi to pi and span more than nothing and at most one turn.
    AzimuthView {
        /// First azimuth asked for, radians.
        start_rad: f32,
        /// Width asked for, radians.
        span_rad: f32,
    },
}

/// Why a frame was not encoded.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EncodeError {
    /// The frame did not fit the output buffer. Nothing in the buffer is a frame.
    OutputTooSmall {
        /// Bytes the buffer has.
        have: usize,
        /// Bytes that are enough for every frame of this configuration.
        worst_case: usize,
    },
    /// The scale follows each frame's farthest point, so the whole scan is needed at once:
    /// call `encode`, or configure a fixed largest range to insert points piece by piece.
    ScaleNeedsWholeScan,
    /// No frame can be made with the configuration.
    Config(ConfigError),
}

impl From<ConfigError> for EncodeError {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

/// A frame that cannot be decoded.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DecodeError {
    /// The input ends before the frame does.
    Truncated {
        /// Bytes there should be.
        need: usize,
        /// Bytes there are.
        have: usize,
    },
    /// The input does not start with `FLCR`.
    Magic {
        /// The four bytes found.
        found: [u8; 4],
    },
    /// A version of the format that this decoder does not know.
    Version {
        /// The version found.
        found: u8,
        /// The version this decoder reads.
        supported: u8,
    },
    /// A header field holds a value that no encoder writes.
    Header {
        /// The field.
        field: HeaderField,
        /// What was found there (floats as their bits).
        found: u32,
    },
    /// The checksum does not match: the frame was damaged.
    Checksum {
        /// CRC-32 that the frame carries.
        stored: u32,
        /// CRC-32 of the bytes received.
        computed: u32,
    },
    /// The frame is larger than the caller allows.
    Limit {
        /// Which of the caller's limits.
        limit: LimitKind,
        /// What the frame asks for.
        found: u64,
        /// What is allowed.
        allowed: u64,
    },
    /// Bytes follow the frame.
    TrailingBytes {
        /// Length of the frame.
        frame_len: usize,
        /// Length of the input.
        have: usize,
    },
    /// Strips must cover the columns from the first to the last without a gap.
    StripOrder {
        /// Column that the strip starts at.
        found: u32,
        /// Column it should start at.
        expected: u32,
    },
    /// The frame is on the grid of a sensor that the decoder does not know, and does not carry its beams.
    UnknownSensor {
        /// Checksum of the grid.
        sensor: u32,
    },
    /// The frame goes on from one that the decoder has not decoded last: it, or one between it and its key frame, is missing.
    /// The next key frame needs none.
    PreviousMissing {
        /// Sequence number of the key frame.
        key: u32,
        /// Frames since that, this one included.
        distance: u32,
        /// Checksum of the frame before.
        need: u32,
        /// That of the frame that was decoded last, if it was one to go on from.
        have: Option<u32>,
    },
    /// A strip's payload does not decode to its pixels.
    Payload {
        /// Number of the strip, from 0.
        strip: u32,
        /// What the coder met.
        fault: PayloadFault,
    },
    /// A section behind the strips is none that there is, is not in its place, or does not decode to what it should.
    Section {
        /// The number that the frame gives it.
        kind: u8,
        /// What was met.
        fault: PayloadFault,
    },
}

/// What a coder met in a payload that no encoder makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PayloadFault {
    /// The payload ends before all pixels are there.
    TooShort,
    /// All pixels are there before the payload ends.
    TooLong,
    /// The code itself is malformed.
    Malformed,
    /// More DEFLATE blocks than the format allows for so few levels: work without a result.
    TooManyBlocks,
    /// A level above what the header's level bits can hold.
    LevelRange {
        /// The level found.
        found: u16,
        /// The largest that the header allows.
        max: u16,
    },
    /// A code that may change levels by more than the header's bound says.
    Bound {
        /// Levels that it may change them by.
        found: u16,
        /// Most that the header allows.
        max: u16,
    },
    /// More rows than the coder's format has room for.
    Rows {
        /// The rows found.
        found: u16,
        /// Most that there can be.
        max: u16,
    },
}

/// Fields of the frame header, as named in `docs/FORMAT.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the names are those of docs/FORMAT.md")]
pub enum HeaderField {
    HeaderLen,
    FrameLen,
    Flags,
    Rows,
    Columns,
    LevelBits,
    Coder,
    Strips,
    Step,
    RangeBound,
    GeometryKind,
    GeometryView,
    GeometryFlags,
    ColumnMode,
    Firings,
    Sensor,
    Ticks,
    RangeUnit,
    PointBound,
    Beam,
    StripColumns,
    Reserved,
}

/// The caller's limits on what a decoder may be asked to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LimitKind {
    /// Bytes of one frame.
    FrameLen,
    /// Rows times columns.
    Pixels,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Size { rows, columns } => {
                write!(
                    f,
                    "a frame of {columns} x {rows} cannot be made: columns and rows must be 1 to 65535, and 2^30 pixels at most"
                )
            }
            Self::LevelBits { found, min, max } => {
                write!(f, "levels of {found} bits asked for: expected {min} to {max}")
            }
            Self::Strips { found, max } => write!(f, "{found} strips asked for: expected 1 to {max}, the columns"),
            Self::MaxRange { found_m } => {
                write!(f, "a largest range of {found_m} m asked for: expected a positive, finite number")
            }
            Self::ImageSize { rows, columns, expected_rows, expected_columns } => {
                write!(f, "an image of {columns} x {rows}: expected the lattice's {expected_columns} x {expected_rows}")
            }
            Self::Beams { found, max } => write!(f, "a sensor of {found} beams: expected 1 to {max}"),
            Self::Plane { found, expected } => write!(f, "a plane of {found} numbers: expected {expected}"),
            Self::CoderRows { found, max } => write!(f, "{found} rows: the coder has room for {max}"),
            Self::Beam { row } => {
                write!(f, "beam {row} is not lower than the one before, or has numbers that no sensor has")
            }
            Self::Ticks { found, max } => write!(f, "{found} ticks a turn: expected 1 to {max}"),
            Self::Firings { tick, ticks } if tick == ticks => {
                write!(f, "no firing: expected some, at ticks below {ticks}")
            }
            Self::Firings { tick, ticks } => write!(f, "a firing at tick {tick}: expected less than {ticks}"),
            Self::Delay { cells, cells_max, firings, firings_max } => {
                write!(
                    f,
                    "aligned columns take {cells} cells and {firings} firings: there are {cells_max} and {firings_max}"
                )
            }
            Self::RangeUnit { found_m } => write!(f, "a range unit of {found_m} m: expected more than 0 and at most 1"),
            Self::ElevationView { top_rad, bottom_rad } => write!(
                f,
                "elevations from {bottom_rad} to {top_rad} rad asked for: expected -pi/2 <= bottom < top <= pi/2"
            ),
            Self::AzimuthView { start_rad, span_rad } => write!(
                f,
                "azimuths from {start_rad} rad over {span_rad} rad asked for: expected a start from -pi to pi and a span of at most one turn"
            ),
        }
    }
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::OutputTooSmall { have, worst_case } => {
                write!(f, "the frame does not fit the output buffer of {have} bytes ({worst_case} are always enough)")
            }
            Self::ScaleNeedsWholeScan => write!(
                f,
                "the scale follows the frame's farthest point: encode the whole scan at once or give a largest range"
            ),
            Self::Config(error) => error.fmt(f),
        }
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Truncated { need, have } => {
                write!(f, "input ends after {have} bytes: expected at least {need}")
            }
            Self::Magic { found } => {
                write!(f, "not a flicr frame: starts with {found:02x?}, expected \"FLCR\"")
            }
            Self::Version { found, supported } => {
                write!(f, "format version {found}: this decoder reads version {supported}")
            }
            Self::Header { field, found } => {
                write!(f, "header field {field:?} holds {found:#x}, which no encoder writes")
            }
            Self::Checksum { stored, computed } => {
                write!(f, "checksum {stored:08x} stored, {computed:08x} computed: the frame is damaged")
            }
            Self::Limit { limit, found, allowed } => {
                write!(f, "the frame asks for {found} {limit:?}: {allowed} allowed")
            }
            Self::TrailingBytes { frame_len, have } => {
                write!(f, "{} bytes follow the frame of {frame_len} bytes", have.saturating_sub(frame_len))
            }
            Self::StripOrder { found, expected } => {
                write!(f, "a strip starts at column {found}: expected {expected}")
            }
            Self::UnknownSensor { sensor } => {
                write!(f, "the frame is on the grid of a sensor that is not known here: {sensor:08x}")
            }
            Self::PreviousMissing { key, distance, need, have } => {
                let have = Checksum(have);
                write!(
                    f,
                    "the frame before this one is missing: expected {need:08x}, decoded last {have}; it is frame {distance} \
                     since key frame {key}"
                )
            }
            Self::Payload { strip, fault } => write!(f, "payload of strip {strip}: {fault}"),
            Self::Section { kind, fault } => write!(f, "section {kind}: {fault}"),
        }
    }
}

/// A frame's checksum, if there is one.
struct Checksum(Option<u32>);

impl fmt::Display for Checksum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(checksum) => write!(f, "{checksum:08x}"),
            None => f.write_str("none to go on from"),
        }
    }
}

impl fmt::Display for PayloadFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TooShort => f.write_str("ends before all pixels are there"),
            Self::TooLong => f.write_str("goes on after all pixels are there"),
            Self::Malformed => f.write_str("malformed code"),
            Self::TooManyBlocks => f.write_str("more blocks than so few levels can need"),
            Self::LevelRange { found, max } => write!(f, "level {found}: at most {max} expected"),
            Self::Bound { found, max } => write!(f, "levels may be {found} off: at most {max} expected"),
            Self::Rows { found, max } => write!(f, "{found} rows: at most {max} expected"),
        }
    }
}

impl core::error::Error for ConfigError {}
impl core::error::Error for EncodeError {}
impl core::error::Error for DecodeError {}
