//! What a header says of the geometry: the fields from byte 44 on, written and read side by side.

use super::{CRC, Fields, HEADER_LEN, expect};
use crate::error::{DecodeError, HeaderField};
use crate::geometry::{Beam, Firings, Placement, SensorGrid, UniformView};

const UNIFORM: u8 = 0;
const BEAMS: u8 = 1;
const CORNER_FLAG: u8 = 1;
const CLOCKWISE_FLAG: u8 = 1;
const TABLE_FLAG: u8 = 2;
const FROM_AXIS_FLAG: u8 = 4;
const GEOMETRY_FLAGS: u8 = CLOCKWISE_FLAG | TABLE_FLAG | FROM_AXIS_FLAG;
const EVEN_COLUMNS: u8 = 0;
const FIRINGS_AS_BITS: u8 = 1;
const FIRINGS_AS_STEPS: u8 = 2;
/// More ticks than this are not listed.
const LISTED_TICKS_MAX: u32 = 65_535;

/// The geometry of a frame that was read.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// Rows and columns evenly spaced.
    Uniform(UniformHeader),
    /// The sensor's own beams and ticks.
    Beams(BeamsGeometry),
}

/// A geometry that a header can be written of.
pub trait GeometryFields: Copy {
    /// Flags of byte 5.
    fn flags(&self) -> u8;
    /// Bytes of the whole header.
    fn header_len(&self) -> usize;
    /// The same, where the coder may move points by so many meters more.
    #[must_use]
    fn off_by(self, more_m: f32) -> Self;
    /// Hands out the fields from byte 44 on.
    fn put(&self, put: impl FnMut(&[u8]));
}

/// Evenly spaced rows and columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UniformHeader {
    /// The part of the sphere that the image shows.
    pub view: UniformView,
    /// Where in its pixel a point lies.
    pub placement: Placement,
}

/// The sensor's own grid, to write.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamsHeader<'a> {
    /// The grid.
    pub grid: SensorGrid<'a>,
    /// Most that a point is from where it is decoded, meters; infinite where that was not measured.
    pub point_bound_m: f32,
    /// Whether the header carries the beams.
    pub table: bool,
}

/// The sensor's own grid with a column a firing, to write.
#[derive(Debug, Clone, Copy)]
pub struct FiringsHeader<'a, const WORDS: usize> {
    /// All else.
    pub beams: BeamsHeader<'a>,
    /// The ticks that were fired at.
    pub firings: &'a Firings<WORDS>,
}

/// How the columns lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColumnMode {
    /// Evenly spread over the turn.
    Even,
    /// One a firing; the header has their list.
    Firings {
        /// Whether the list is coded step by step; else it has a bit a tick.
        coded: bool,
        /// Bytes of the list.
        list_len: u16,
    },
}

/// The sensor's own grid, as read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamsGeometry {
    /// [`SensorGrid::checksum`] of the grid.
    pub sensor: u32,
    /// Encoder ticks a turn.
    pub ticks: u32,
    /// Whether ticks grow clockwise.
    pub clockwise: bool,
    /// Azimuth of tick 0, radians.
    pub zero_rad: f32,
    /// One range count, meters.
    pub range_unit_m: f32,
    /// [`SensorGrid::range_from_axis`].
    pub range_from_axis: bool,
    /// Most that a point is from where it is decoded, meters; infinite where that was not measured.
    pub point_bound_m: f32,
    /// Whether the header carries the beams.
    pub table: bool,
    /// How the columns lie.
    pub column_mode: ColumnMode,
}

impl GeometryFields for UniformHeader {
    fn flags(&self) -> u8 {
        if self.placement == Placement::Corner { CORNER_FLAG } else { 0 }
    }

    fn header_len(&self) -> usize {
        HEADER_LEN
    }

    fn off_by(self, _: f32) -> Self {
        self
    }

    fn put(&self, mut put: impl FnMut(&[u8])) {
        put(&[UNIFORM, 0, 0, 0]);
        for angle_rad in [self.view.top_rad, self.view.bottom_rad, self.view.start_rad, self.view.span_rad] {
            put(&angle_rad.to_le_bytes());
        }
    }
}

impl BeamsHeader<'_> {
    /// Bytes of a header without beams.
    pub const HEADER_LEN: usize = 72;
    /// Bytes of a beam.
    pub const BEAM_LEN: usize = 20;
}

impl GeometryFields for BeamsHeader<'_> {
    fn flags(&self) -> u8 {
        0
    }

    fn header_len(&self) -> usize {
        Self::HEADER_LEN + if self.table { Self::BEAM_LEN * self.grid.beams.len() } else { 0 }
    }

    fn put(&self, put: impl FnMut(&[u8])) {
        self.put_with(EVEN_COLUMNS, 0, put);
    }

    fn off_by(self, more_m: f32) -> Self {
        // Both operations may round down, by 2^-24 of the sum each.
        let point_bound_m = (self.point_bound_m + more_m) * if more_m > 0.0 { 1.0 + f32::EPSILON } else { 1.0 };
        Self { point_bound_m, ..self }
    }
}

impl<const WORDS: usize> GeometryFields for FiringsHeader<'_, WORDS> {
    fn flags(&self) -> u8 {
        0
    }

    fn header_len(&self) -> usize {
        self.beams.header_len() + self.firings.list_len()
    }

    fn off_by(self, more_m: f32) -> Self {
        Self { beams: self.beams.off_by(more_m), ..self }
    }

    fn put(&self, mut put: impl FnMut(&[u8])) {
        let mode = if self.firings.is_coded() { FIRINGS_AS_STEPS } else { FIRINGS_AS_BITS };
        self.beams.put_with(mode, self.firings.list_len() as u16, &mut put);
        self.firings.put(put);
    }
}

impl BeamsHeader<'_> {
    /// As [`GeometryFields::put`], of columns that lie otherwise.
    fn put_with(&self, column_mode: u8, list_len: u16, mut put: impl FnMut(&[u8])) {
        let table = if self.table { TABLE_FLAG } else { 0 };
        put(&[BEAMS, self.grid.flags() | table, column_mode, 0]);
        put(&self.grid.checksum().to_le_bytes());
        put(&self.grid.ticks.to_le_bytes());
        put(&self.grid.range_unit_m.to_le_bytes());
        put(&self.grid.zero_rad.to_le_bytes());
        put(&self.point_bound_m.to_le_bytes());
        put(&list_len.to_le_bytes());
        put(&[0; 2]);
        if self.table {
            self.grid.beams.iter().for_each(|beam| put(&beam_bytes(beam)));
        }
    }
}

fn beam_bytes(beam: &Beam) -> [u8; BeamsHeader::BEAM_LEN] {
    let fields = [beam.slope, beam.z_offset_m, beam.h_offset_m, beam.azimuth_phase_rad, beam.range_phase_m];
    bytemuck::cast(fields.map(f32::to_le_bytes))
}

#[cfg(feature = "std")]
fn beam_from(bytes: [u8; BeamsHeader::BEAM_LEN]) -> Beam {
    let fields: [[u8; 4]; 5] = bytemuck::cast(bytes);
    let [slope, z_offset_m, h_offset_m, azimuth_phase_rad, range_phase_m] = fields.map(f32::from_le_bytes);
    Beam { slope, z_offset_m, h_offset_m, azimuth_phase_rad, range_phase_m }
}

impl SensorGrid<'_> {
    fn flags(&self) -> u8 {
        let clockwise = if self.clockwise { CLOCKWISE_FLAG } else { 0 };
        clockwise | if self.range_from_axis { FROM_AXIS_FLAG } else { 0 }
    }

    /// CRC-32 of everything but the name: by this a frame says which grid it is on.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        let mut digest = CRC.digest();
        digest.update(&self.ticks.to_le_bytes());
        digest.update(&self.range_unit_m.to_le_bytes());
        digest.update(&self.zero_rad.to_le_bytes());
        digest.update(&u32::from(self.flags()).to_le_bytes());
        self.beams.iter().for_each(|beam| digest.update(&beam_bytes(beam)));
        digest.finalize()
    }
}

/// The geometry, and the length that the header must have with it.
pub(super) fn parse(fields: &mut Fields<'_>, flags: u8, rows: u16) -> Result<(Geometry, usize), DecodeError> {
    if expect(HeaderField::GeometryKind, fields.u8()?, |kind| kind <= BEAMS)? == UNIFORM {
        return Ok((Geometry::Uniform(parse_uniform(fields, flags)?), HEADER_LEN));
    }
    expect(HeaderField::Flags, flags, |flags| flags == 0)?;
    let beams = parse_beams(fields, rows)?;
    let table_len = if beams.table { BeamsHeader::BEAM_LEN * usize::from(rows) } else { 0 };
    let geometry = Geometry::Beams(beams);
    Ok((geometry, BeamsHeader::HEADER_LEN + table_len + geometry.firings_len()))
}

fn parse_uniform(fields: &mut Fields<'_>, flags: u8) -> Result<UniformHeader, DecodeError> {
    let placement = match flags {
        0 => Placement::Center,
        CORNER_FLAG => Placement::Corner,
        _ => return Err(DecodeError::Header { field: HeaderField::Flags, found: flags.into() }),
    };
    expect(HeaderField::Reserved, fields.u8()?, |zero| zero == 0)?;
    expect(HeaderField::Reserved, fields.u16()?, |zero| zero == 0)?;
    let found = fields.u32()?;
    let mut next = || fields.u32().map(f32::from_bits);
    let (bottom_rad, start_rad, span_rad) = (next()?, next()?, next()?);
    let view = UniformView { top_rad: f32::from_bits(found), bottom_rad, start_rad, span_rad };
    match view.check() {
        Ok(()) => Ok(UniformHeader { view, placement }),
        Err(_) => Err(DecodeError::Header { field: HeaderField::GeometryView, found }),
    }
}

fn parse_beams(fields: &mut Fields<'_>, rows: u16) -> Result<BeamsGeometry, DecodeError> {
    expect(HeaderField::Rows, rows, |rows| usize::from(rows) <= SensorGrid::BEAMS_MAX)?;
    let flags = expect(HeaderField::GeometryFlags, fields.u8()?, |flags| flags & !GEOMETRY_FLAGS == 0)?;
    let mode = expect(HeaderField::ColumnMode, fields.u8()?, |mode| mode <= FIRINGS_AS_STEPS)?;
    expect(HeaderField::Reserved, fields.u8()?, |zero| zero == 0)?;
    let sensor = fields.u32()?;
    let ticks = expect(HeaderField::Ticks, fields.u32()?, |ticks| (1..=SensorGrid::TICKS_MAX).contains(&ticks))?;
    let mut float = |field, right: fn(f32) -> bool| {
        expect(field, fields.u32()?, |bits| right(f32::from_bits(bits))).map(f32::from_bits)
    };
    let range_unit_m = float(HeaderField::RangeUnit, |unit_m| unit_m > 0.0 && unit_m <= SensorGrid::RANGE_UNIT_MAX_M)?;
    let zero_rad = float(HeaderField::GeometryView, |zero_rad| zero_rad.abs() <= core::f32::consts::PI)?;
    let point_bound_m = float(HeaderField::PointBound, |bound_m| bound_m >= 0.0)?;
    let list_len = fields.u16()?;
    expect(HeaderField::Reserved, fields.u16()?, |zero| zero == 0)?;
    let column_mode = column_mode(mode, list_len, ticks)?;
    Ok(BeamsGeometry {
        sensor,
        ticks,
        clockwise: flags & CLOCKWISE_FLAG != 0,
        zero_rad,
        range_unit_m,
        range_from_axis: flags & FROM_AXIS_FLAG != 0,
        point_bound_m,
        table: flags & TABLE_FLAG != 0,
        column_mode,
    })
}

/// How the columns lie; a list is as long as it must be, or shorter than that where it is coded.
fn column_mode(mode: u8, list_len: u16, ticks: u32) -> Result<ColumnMode, DecodeError> {
    if mode == EVEN_COLUMNS {
        expect(HeaderField::Firings, list_len, |len| len == 0)?;
        return Ok(ColumnMode::Even);
    }
    expect(HeaderField::Ticks, ticks, |ticks| ticks <= LISTED_TICKS_MAX)?;
    let (coded, bitmap_len) = (mode == FIRINGS_AS_STEPS, crate::geometry::bitmap_len(ticks));
    let right = |len: u16| if coded { (1..bitmap_len).contains(&len.into()) } else { usize::from(len) == bitmap_len };
    let list_len = expect(HeaderField::Firings, list_len, right)?;
    Ok(ColumnMode::Firings { coded, list_len })
}

impl Geometry {
    /// Bytes of the list of firings at the end of the header.
    pub(crate) fn firings_len(&self) -> usize {
        match self {
            Self::Beams(BeamsGeometry { column_mode: ColumnMode::Firings { list_len, .. }, .. }) => (*list_len).into(),
            _ => 0,
        }
    }
}

#[cfg(feature = "std")]
impl BeamsGeometry {
    /// The grid, given its beams.
    pub(crate) fn grid<'a>(&self, beams: &'a [Beam]) -> SensorGrid<'a> {
        let Self { ticks, clockwise, zero_rad, range_unit_m, range_from_axis, .. } = *self;
        SensorGrid { name: "", beams, ticks, clockwise, zero_rad, range_unit_m, range_from_axis }
    }

    /// The ticks of the columns, where these are firings; checked to ascend, to be of the turn, and as many as columns.
    pub(crate) fn read_firings(
        &self,
        list: &[u8],
        columns: u16,
        found: &mut std::vec::Vec<u32>,
    ) -> Result<(), DecodeError> {
        found.clear();
        let ColumnMode::Firings { coded, list_len } = self.column_mode else { return Ok(()) };
        let read = crate::geometry::read_firings(list, coded, self.ticks, columns.into(), found);
        read.map_err(|_| DecodeError::Header { field: HeaderField::Firings, found: list_len.into() })
    }

    /// The beams that a header carries; checked to be those of the sensor that it names.
    pub(crate) fn read_table(&self, table: &[u8]) -> Result<std::vec::Vec<Beam>, DecodeError> {
        use crate::error::ConfigError;
        let (beams, _) = table.as_chunks();
        let beams: std::vec::Vec<Beam> = beams.iter().map(|bytes| beam_from(*bytes)).collect();
        let grid = self.grid(&beams);
        match grid.check() {
            Err(ConfigError::Beam { row }) => {
                return Err(DecodeError::Header { field: HeaderField::Beam, found: row as u32 });
            }
            _ if grid.checksum() == self.sensor => {}
            _ => return Err(DecodeError::Header { field: HeaderField::Sensor, found: self.sensor }),
        }
        Ok(beams)
    }
}
