//! What can be wrong with a packet, and how often it was.

use core::fmt;

/// Why a packet was refused. Nothing of a refused packet is used.
///
/// Small and `Copy`: it can cross an interrupt or a queue. `found` and `expected` are the packet's
/// own numbers, so a log line is enough to see what happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PacketError {
    /// No packet of the expected format has this many bytes. `expected` is 0 where any of several
    /// formats would have done.
    Length {
        /// Bytes in the packet.
        found: u32,
        /// Bytes the format takes.
        expected: u32,
    },
    /// A fixed marker (start of packet, block flag, protocol version, packet type) is not there.
    Marker {
        /// Byte offset of the marker.
        at: u16,
        /// What stands there, little endian.
        found: u16,
        /// What should.
        expected: u16,
    },
    /// The packet names a sensor that is unknown (`expected` 0) or not the one of this stream.
    Model {
        /// The product byte or laser count in the packet.
        found: u8,
        /// The one of the stream, or 0.
        expected: u8,
    },
    /// The return-mode byte has no meaning.
    ReturnMode {
        /// The byte.
        found: u8,
    },
    /// A count of blocks, a unit or a status byte in a header or tail that the format does not
    /// allow.
    Field {
        /// Byte offset of the field.
        at: u16,
        /// What stands there.
        found: u8,
        /// What should.
        expected: u8,
    },
    /// An azimuth is 360 degrees or more, jumps, or differs between blocks that share a firing.
    Azimuth {
        /// Block that holds it.
        block: u8,
        /// The azimuth, in ticks.
        found: u16,
        /// What would have been plausible, or the first azimuth that is out of range.
        expected: u16,
    },
    /// An Ouster column's measurement id does not follow, or is past the end of the frame.
    MeasurementId {
        /// Column of the packet.
        column: u8,
        /// Its measurement id.
        found: u16,
        /// What should stand there.
        expected: u16,
    },
    /// The columns of an Ouster packet belong to different frames.
    FrameId {
        /// Frame of the column.
        found: u16,
        /// Frame of the packet.
        expected: u16,
    },
    /// The checksum does not fit; the low halves are shown.
    Crc {
        /// Checksum in the packet.
        found: u32,
        /// Checksum of its bytes.
        expected: u32,
    },
    /// The packet neither follows the one before it nor fits the time that has passed. A second
    /// such packet that fits this one is believed, so a restarted sensor costs one packet.
    Discontinuity {
        /// First azimuth or measurement id of the packet.
        found: u16,
        /// The one that would have followed.
        expected: u16,
    },
    /// The packet is the last one over again.
    Duplicate,
    /// The packet is older than the last one used.
    Late,
}

impl fmt::Display for PacketError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Length { found, expected: 0 } => write!(f, "no known packet has {found} bytes"),
            Self::Length { found, expected } => {
                write!(f, "packet of {found} bytes, expected {expected}")
            }
            Self::Marker { at, found, expected } => {
                write!(f, "marker {found:#06x} at byte {at}, expected {expected:#06x}")
            }
            Self::Model { found, expected: 0 } => write!(f, "unknown sensor model {found:#04x}"),
            Self::Model { found, expected } => {
                write!(f, "sensor model {found:#04x}, expected {expected:#04x}")
            }
            Self::ReturnMode { found } => write!(f, "unknown return mode {found:#04x}"),
            Self::Field { at, found, expected } => write!(f, "byte {at} is {found:#04x}, expected {expected:#04x}"),
            Self::Azimuth { block, found, expected } => {
                write!(f, "azimuth {found} in block {block}, expected {expected}")
            }
            Self::MeasurementId { column, found, expected } => {
                write!(f, "measurement id {found} in column {column}, expected {expected}")
            }
            Self::FrameId { found, expected } => {
                write!(f, "frame id {found} inside a packet of frame id {expected}")
            }
            Self::Crc { found, expected } => {
                write!(f, "checksum {found:#010x}, expected {expected:#010x}")
            }
            Self::Discontinuity { found, expected } => {
                write!(f, "packet starts at {found}, expected {expected}")
            }
            Self::Duplicate => f.write_str("packet received twice"),
            Self::Late => f.write_str("packet older than the last one used"),
        }
    }
}

impl core::error::Error for PacketError {}

/// What became of the packets so far. All counters stop at their maximum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct PacketStats {
    /// Packets used.
    pub used: u32,
    /// Columns given out; both layers of a dual return count once.
    pub columns: u32,
    /// Turns ended.
    pub turns: u32,
    /// Columns that lost, refused or invalid packets left out.
    pub lost_columns: u32,
    /// Columns that the sensor is told not to measure (limited field of view).
    pub blind_columns: u32,
    /// Whole turns of which nothing was received.
    pub lost_turns: u32,
    /// Packets of no known length.
    pub wrong_length: u32,
    /// Packets of an unknown or another sensor.
    pub wrong_model: u32,
    /// Packets with a wrong marker, header, tail, return mode, frame or measurement id, or checksum.
    pub damaged: u32,
    /// Packets with an impossible azimuth.
    pub wrong_azimuth: u32,
    /// Packets that fit neither azimuth nor time of the one before.
    pub discontinuous: u32,
    /// Packets received twice.
    pub duplicate: u32,
    /// Packets that came after a later one.
    pub late: u32,
}

impl PacketStats {
    /// All zero.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            used: 0,
            columns: 0,
            turns: 0,
            lost_columns: 0,
            blind_columns: 0,
            lost_turns: 0,
            wrong_length: 0,
            wrong_model: 0,
            damaged: 0,
            wrong_azimuth: 0,
            discontinuous: 0,
            duplicate: 0,
            late: 0,
        }
    }

    /// Packets that were refused, of whatever kind.
    #[must_use]
    pub const fn refused(&self) -> u32 {
        self.wrong_length
            .saturating_add(self.wrong_model)
            .saturating_add(self.damaged)
            .saturating_add(self.wrong_azimuth)
            .saturating_add(self.discontinuous)
            .saturating_add(self.duplicate)
            .saturating_add(self.late)
    }

    pub(super) fn count_refused(&mut self, error: PacketError) {
        let counter = match error {
            PacketError::Length { .. } => &mut self.wrong_length,
            PacketError::Model { .. } => &mut self.wrong_model,
            PacketError::Azimuth { .. } => &mut self.wrong_azimuth,
            PacketError::Discontinuity { .. } => &mut self.discontinuous,
            PacketError::Duplicate => &mut self.duplicate,
            PacketError::Late => &mut self.late,
            PacketError::Marker { .. }
            | PacketError::ReturnMode { .. }
            | PacketError::Field { .. }
            | PacketError::MeasurementId { .. }
            | PacketError::FrameId { .. }
            | PacketError::Crc { .. } => &mut self.damaged,
        };
        *counter = counter.saturating_add(1);
    }
}
