//! What went wrong, in a number and a sentence.
#![allow(unsafe_code, reason = "the name is for C")]

use core::ffi::{CStr, c_char};

use crate::error::{ConfigError, EncodeError};

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
    /// Points, output, encoder and the place of the result share memory.
    Overlap = 5,
    /// A preset that is not in flicr_preset.
    Preset = 6,
    /// Rows and columns must be 1 to 65535 each, with at most 2^30 pixels; a coder may take fewer rows.
    Size = 7,
    /// Level bits must be 1 to 8, on a grid 1 to 16.
    LevelBits = 8,
    /// The largest range must be 0 (the scale follows each frame) or a positive, finite number of meters; on a grid the
    /// step must be such a number.
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
    /// A sensor that is not in flicr_sensor, or lacks what is asked of it: beams in that number, or packets.
    Sensor = 20,
    /// A policy that is not in flicr_return_policy.
    ReturnPolicy = 21,
    /// The beams' slopes must fall from row to row, and their numbers be such as a sensor can have.
    Beam = 22,
    /// A turn has 1 to 2^20 ticks.
    Ticks = 23,
    /// A range unit is more than 0 and at most a meter.
    RangeUnit = 24,
    /// No error: the packet has been taken, and the turn goes on. Nothing has been encoded.
    TurnOpen = 25,
    /// The packet is not one of the sensor's, is damaged, late or doubled. Nothing of it is used.
    PacketRefused = 26,
    /// A step must be 1 to 65535 levels, the noise 0 to 255, the predictor in flicr_predictor.
    Context = 27,
    /// A frame is cut into 1 strip to as many as it has columns.
    Strips = 28,
    /// Aligned columns take more room than there is, or a turn's columns are not 1 to 8192.
    Delay = 29,
    /// A companding that is not in flicr_companding.
    Companding = 30,
    /// In a stream a level must be 1 to 255 whole range units.
    Step = 31,
    /// An intensity's numbers for 1 must be positive and finite, its step 1 to 255, a time's unit not 0.
    Plane = 32,
}

/// A `flicr_status` as it comes from C: any number. The header calls it `flicr_status`, as with those below.
pub type StatusCode = i32;

/// A sentence in English for a status; a sentence for numbers that are none, too. Never null, never to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_status_text(status: StatusCode) -> *const c_char {
    flicr_status::text(status).as_ptr()
}

impl From<ConfigError> for flicr_status {
    fn from(error: ConfigError) -> Self {
        match error {
            ConfigError::Size { .. }
            | ConfigError::ImageSize { .. }
            | ConfigError::CoderRows { .. }
            | ConfigError::Plane { .. }
            | ConfigError::Beams { .. } => Self::Size,
            ConfigError::Beam { .. } => Self::Beam,
            ConfigError::Ticks { .. } | ConfigError::Firings { .. } => Self::Ticks,
            ConfigError::RangeUnit { .. } => Self::RangeUnit,
            ConfigError::Delay { .. } => Self::Delay,
            ConfigError::LevelBits { .. } => Self::LevelBits,
            ConfigError::Strips { .. } => Self::Strips,
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
    const ALL: [(Self, &CStr); 33] = [
        (Self::Ok, c"all is well"),
        (Self::NullPointer, c"a pointer is null"),
        (Self::Misaligned, c"a pointer is not aligned for what it points to"),
        (Self::StateTooSmall, c"the memory for the encoder is too small: FLICR_ENCODER_SIZE says what it takes"),
        (Self::NotInitialized, c"the memory holds no encoder: the functions flicr_encoder_init_... make one"),
        (Self::Overlap, c"points, output, encoder and the place of the result share memory"),
        (Self::Preset, c"no such preset"),
        (Self::Size, c"rows and columns must be 1 to 65535 each, with at most 2^30 pixels; some coders take 128 rows"),
        (Self::LevelBits, c"level bits must be 1 to 8, on a grid 1 to 16"),
        (
            Self::MaxRange,
            c"the largest range must be 0 or a positive, finite number of meters; so must a step, but for 0",
        ),
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
        (Self::Sensor, c"no such sensor, or not with these beams, or its packets are not known"),
        (Self::ReturnPolicy, c"no such policy for returns"),
        (Self::Beam, c"the beams' slopes must fall, and their numbers be such as a sensor can have"),
        (Self::Ticks, c"a turn must have 1 to 2^20 ticks"),
        (Self::RangeUnit, c"a range unit must be more than 0 and at most a meter"),
        (Self::TurnOpen, c"the packet has been taken, and the turn goes on"),
        (Self::PacketRefused, c"the packet is not one of the sensor's, is damaged, late or doubled"),
        (Self::Context, c"a step must be 1 to 65535 levels, the noise 0 to 255, the predictor one that there is"),
        (Self::Strips, c"a frame is cut into 1 strip to as many as it has columns"),
        (Self::Delay, c"aligned columns take more room than there is, or a turn has not 1 to 8192 columns"),
        (Self::Companding, c"no such companding"),
        (Self::Step, c"in a stream a level must be 1 to 255 whole range units"),
        (Self::Plane, c"an intensity's step must be 1 to 255 and its numbers for 1 positive; a unit of time is not 0"),
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
