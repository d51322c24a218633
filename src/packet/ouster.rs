//! Ouster lidar packets: the legacy profile and the three common ones since firmware 2.0.
//!
//! ```text
//! legacy: columns only            others: header, columns, footer
//!
//! column                          header, 32 bytes         column            footer, 32 bytes
//!    0  u64 time, ns                 0  u16 type: 1           0  u64 time       24  u64 checksum
//!    8  u16 measurement id           2  u16 frame id          8  u16 measurement id
//!   10  u16 frame id                 4  initialization,      10  u16 status, bit 0: valid
//!   12  u32 encoder                     serial number, ...   12  pixels
//!   16  pixels of 12 bytes
//!    +  u32 status: all ones if valid
//!
//! pixel: LEGACY                            range & 0xfffff (mm), u16 reflectivity at 4, ...
//!        RNG19_RFL8_SIG16_NIR16            range & 0x7ffff (mm), u8 reflectivity at 4, ...
//!        RNG19_RFL8_SIG16_NIR16_DUAL       twice range & 0x7ffff (mm), u8 reflectivity at 3; ...
//!        RNG15_RFL8_NIR8                   range & 0x7fff (8 mm), u8 reflectivity, u8 ambient
//! ```
//!
//! A packet does not say how many rows or which profile it has: that stands in the sensor's
//! metadata. Source: Ouster's software user manual, "Lidar Data Format"; ouster-sdk. The checksum
//! is CRC-64/XZ by ouster-sdk's code; the shared captures predate it and hold a placeholder, so it
//! was tested on made-up packets only.

use super::bytes::{self, check_marker, le_u16, le_u32, le_u64};
use super::column::{CellFormat, CellShape, Cells, Pick};
use super::{PacketError, ReturnPolicy};

/// Most rows that an Ouster has.
pub const MAX_ROWS: usize = 128;

const LIDAR_PACKET: u16 = 1;

/// Row r is channel r: Ouster sends the highest beam first.
static ROW_OF_CHANNEL: [u8; MAX_ROWS] = {
    let mut rows = [0; MAX_ROWS];
    let mut row = 0;
    while row < MAX_ROWS {
        rows[row] = row as u8;
        row += 1;
    }
    rows
};

/// How an Ouster packs its pixels (`udp_profile_lidar`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum OusterProfile {
    /// `LEGACY`: firmware 1.x, and newer if told to.
    Legacy,
    /// `RNG19_RFL8_SIG16_NIR16`.
    Single,
    /// `RNG19_RFL8_SIG16_NIR16_DUAL`.
    Dual,
    /// `RNG15_RFL8_NIR8`: low data rate.
    LowRate,
}

impl OusterProfile {
    /// The profile by the name it has in the sensor's metadata.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "LEGACY" => Self::Legacy,
            "RNG19_RFL8_SIG16_NIR16" => Self::Single,
            "RNG19_RFL8_SIG16_NIR16_DUAL" => Self::Dual,
            "RNG15_RFL8_NIR8" => Self::LowRate,
            _ => return None,
        })
    }

    /// One range count, in micrometres.
    #[must_use]
    pub const fn range_unit_um(self) -> u16 {
        match self {
            Self::LowRate => 8_000,
            _ => 1_000,
        }
    }

    const fn cell(self) -> (CellFormat, usize) {
        match self {
            Self::Legacy => (CellFormat::OusterLegacy, 12),
            Self::Single => (CellFormat::OusterSingle, 12),
            Self::Dual => (CellFormat::OusterDual, 16),
            Self::LowRate => (CellFormat::OusterLow, 4),
        }
    }

    /// Bytes of (packet header, column header, column footer, packet footer).
    const fn frame(self) -> (usize, usize, usize, usize) {
        match self {
            Self::Legacy => (0, 16, 4, 0),
            _ => (32, 12, 0, 32),
        }
    }
}

/// What an Ouster's packets hold, from the sensor's metadata (`data_format`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OusterFormat {
    /// `udp_profile_lidar`.
    pub profile: OusterProfile,
    /// `pixels_per_column`, at most [`MAX_ROWS`].
    pub rows: u8,
    /// `columns_per_packet`.
    pub columns_per_packet: u8,
    /// `columns_per_frame`: ticks and columns a turn.
    pub columns_per_frame: u16,
    /// `column_window`: the first and last measurement id that the sensor sends. The first may be
    /// greater than the last.
    pub window: [u16; 2],
    /// Whether to check the checksum in the packets' footers. Firmware before 3.1 leaves a
    /// placeholder there; the legacy profile has none.
    pub check_crc: bool,
}

impl OusterFormat {
    /// A format that sends the whole turn, 16 columns a packet, checksum unchecked.
    #[must_use]
    pub const fn new(profile: OusterProfile, rows: u8, columns_per_frame: u16) -> Self {
        Self {
            profile,
            rows,
            columns_per_packet: 16,
            columns_per_frame,
            window: [0, columns_per_frame.saturating_sub(1)],
            check_crc: false,
        }
    }

    /// Bytes of a packet.
    #[must_use]
    pub const fn packet_len(&self) -> usize {
        let (header, _, _, footer) = self.profile.frame();
        header + self.columns_per_packet as usize * self.column_len() + footer
    }

    /// The sensor's serial number, as a packet of this format says; `None` in the legacy profile, and where it is 0.
    #[must_use]
    pub fn serial_number(&self, packet: &[u8]) -> Option<u64> {
        let is_said = self.profile != OusterProfile::Legacy && packet.len() == self.packet_len();
        let serial = le_u64(packet, 7) & 0xff_ffff_ffff;
        (is_said && serial != 0).then_some(serial)
    }

    /// Columns a turn, as the encoder counts of a legacy packet's first two columns say (90,112 counts a turn); `None`
    /// in other profiles, and where the counts make no sense.
    #[must_use]
    pub fn columns_by_encoder(&self, packet: &[u8]) -> Option<u32> {
        const COUNTS_PER_TURN: u32 = 90_112;
        if self.profile != OusterProfile::Legacy || packet.len() != self.packet_len() || self.columns_per_packet < 2 {
            return None;
        }
        let [first, second] = [0, self.column_len()].map(|at| le_u32(packet, at + 12));
        let step = second.checked_sub(first)?;
        // Damage is no contradiction: the steps of the sensor's modes are these.
        matches!(step, 22 | 44 | 88 | 176).then(|| COUNTS_PER_TURN / step)
    }

    const fn column_len(&self) -> usize {
        let (_, header, footer, _) = self.profile.frame();
        header + self.rows as usize * self.profile.cell().1 + footer
    }

    /// Whether the sensor is told to measure this column.
    pub(super) const fn sends(&self, id: u16) -> bool {
        let [first, last] = self.window;
        if first <= last { first <= id && id <= last } else { first <= id || id <= last }
    }
}

/// A lidar packet whose frame was checked.
#[derive(Clone, Copy, Debug)]
pub(super) struct OusterPacket<'p> {
    format: OusterFormat,
    columns: &'p [u8],
    pub frame: u16,
    pub first_id: u16,
}

/// Checks a packet of the format's length.
pub(super) fn check<'p>(packet: &'p [u8], format: &OusterFormat) -> Result<OusterPacket<'p>, PacketError> {
    let legacy = format.profile == OusterProfile::Legacy;
    let (header_len, _, _, footer_len) = format.profile.frame();
    if !legacy {
        check_marker(packet, 0, LIDAR_PACKET)?;
    }
    if format.check_crc && !legacy {
        check_crc(packet)?;
    }
    let columns_len = packet.len().saturating_sub(header_len + footer_len);
    let columns = bytes::tail(packet, header_len);
    let columns = columns.get(..columns_len).unwrap_or(&[]);
    let checked = OusterPacket {
        format: *format,
        columns,
        frame: le_u16(packet, if legacy { 10 } else { 2 }),
        first_id: le_u16(columns, 8),
    };
    checked.check_columns()?;
    Ok(checked)
}

/// CRC-64/XZ of everything before the last eight bytes.
fn check_crc(packet: &[u8]) -> Result<(), PacketError> {
    const CRC: crc::Crc<u64> = crc::Crc::<u64>::new(&crc::CRC_64_XZ);
    let Some((body, sum)) = packet.split_last_chunk() else {
        return Ok(());
    };
    let (found, expected) = (u64::from_le_bytes(*sum), CRC.checksum(body));
    if found == expected {
        return Ok(());
    }
    Err(PacketError::Crc { found: found as u32, expected: expected as u32 })
}

impl<'p> OusterPacket<'p> {
    /// Columns in the packet.
    pub fn len(&self) -> u16 {
        u16::from(self.format.columns_per_packet)
    }

    /// Measurement ids count up by one through the packet, and all columns are of one frame.
    fn check_columns(&self) -> Result<(), PacketError> {
        let end = self.format.columns_per_frame;
        for nth in 0..self.len() {
            let column = self.bytes(nth);
            let (found, expected) = (le_u16(column, 8), self.first_id.wrapping_add(nth));
            if found != expected || found >= end {
                return Err(PacketError::MeasurementId { column: nth as u8, found, expected: expected.min(end) });
            }
            self.check_column(column)?;
        }
        Ok(())
    }

    fn check_column(&self, column: &[u8]) -> Result<(), PacketError> {
        if self.format.profile != OusterProfile::Legacy {
            return Ok(());
        }
        let frame = le_u16(column, 10);
        if frame != self.frame {
            return Err(PacketError::FrameId { found: frame, expected: self.frame });
        }
        match self.legacy_status(column) {
            0 | u32::MAX => Ok(()),
            status => Err(PacketError::Field { at: 0, found: status as u8, expected: 0xff }),
        }
    }

    fn legacy_status(&self, column: &[u8]) -> u32 {
        le_u32(column, self.format.column_len().saturating_sub(4))
    }

    fn bytes(&self, nth: u16) -> &'p [u8] {
        let len = self.format.column_len();
        let bytes = bytes::tail(self.columns, usize::from(nth) * len);
        bytes.get(..len).unwrap_or(&[])
    }

    /// Time of column `nth`, in nanoseconds.
    pub fn time_ns(&self, nth: u16) -> u64 {
        le_u64(self.bytes(nth), 0)
    }

    /// Whether the sensor vouches for column `nth`.
    pub fn is_valid(&self, nth: u16) -> bool {
        let column = self.bytes(nth);
        match self.format.profile {
            OusterProfile::Legacy => self.legacy_status(column) == u32::MAX,
            _ => le_u16(column, 10) & 1 == 1,
        }
    }

    /// The cells of the `nth` column. `shape` is the packet's.
    pub fn cells<'s>(&self, nth: u16, shape: &'s CellShape) -> Cells<'s>
    where
        'p: 's,
    {
        let (_, header_len, footer_len, _) = self.format.profile.frame();
        let column = self.bytes(nth);
        let pixels = column.len().saturating_sub(header_len + footer_len);
        Cells { bytes: bytes::tail(column, header_len).get(..pixels).unwrap_or(&[]), shape }
    }

    /// How the cells of every column lie.
    pub fn shape(&self, pick: Pick) -> CellShape {
        let rows = usize::from(self.format.rows);
        CellShape {
            format: self.format.profile.cell().0,
            pick,
            to_second: 0,
            to_next_run: 0,
            run_len: rows,
            beam_of_channel: ROW_OF_CHANNEL.get(..rows).unwrap_or(&ROW_OF_CHANNEL),
        }
    }

    /// How to choose the cells of the layers that `policy` asks for.
    pub fn picks(&self, policy: ReturnPolicy) -> &'static [Pick] {
        match policy {
            _ if self.format.profile != OusterProfile::Dual => &[Pick::Only],
            ReturnPolicy::Strongest => &[Pick::First],
            ReturnPolicy::Last => &[Pick::Farther],
            ReturnPolicy::Both => &[Pick::First, Pick::Second],
        }
    }
}
