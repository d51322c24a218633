//! What a stream encoder tells of what it did.

/// What a stream encoder has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StreamTally {
    /// Firings that came in.
    pub firings: u32,
    /// Returns that came in and have a level; those of columns that are not kept are among them.
    pub returns: u64,
    /// Returns beyond the largest level; not kept.
    pub beyond_range: u64,
    /// Columns that are in datagrams, or in the strip that is open.
    pub columns: u32,
    /// Columns that a [stride](super::StreamEncoder::set_stride) passed over.
    pub thinned: u32,
    /// Columns that were [cut](super::StreamEncoder::cut) off.
    pub cut: u32,
    /// Columns that did not fit a datagram alone.
    pub unfit: u32,
    /// Datagrams that went out.
    pub datagrams: u32,
    /// Their bytes.
    pub bytes: u64,
}

impl StreamTally {
    pub(super) const NONE: Self = Self {
        firings: 0,
        returns: 0,
        beyond_range: 0,
        columns: 0,
        thinned: 0,
        cut: 0,
        unfit: 0,
        datagrams: 0,
        bytes: 0,
    };
}

/// What a datagram was, for those who steer a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sent {
    /// Number of its turn.
    pub turn: u16,
    /// Its bytes.
    pub len: u32,
    /// Columns in it.
    pub columns: u16,
    /// Number of the column behind its last.
    pub end_column: u16,
    /// Of its first column, in the sensor's clock, microseconds; wraps.
    pub time_us: u32,
    /// Levels of its step.
    pub step: u16,
    /// From each column's number to the next's.
    pub stride: u8,
    /// Whether the turn ends with it.
    pub is_last: bool,
}

impl Sent {
    pub(super) const NONE: Self =
        Self { turn: 0, len: 0, columns: 0, end_column: 0, time_us: 0, step: 0, stride: 0, is_last: false };
}
