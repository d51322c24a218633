//! The mirror image of the encoder: frame -> payload -> range image -> points.

use core::array;
use std::vec::Vec;

use crate::coder::context::Allowed;
use crate::coder::{self, CoderId};
use crate::error::{DecodeError, HeaderField, LimitKind, PayloadFault};
use crate::frame::{self, BeamsGeometry, ColumnMode, Geometry, Header, ParsedFrame};
use crate::geometry::{Beam, SensorGrid, Sphere, Spread, Turn, sensors};
use crate::image::{ImageView, Level};

/// What a decoder may be asked to do; checked before any memory is taken or work begun.
///
/// ```
/// use flicr::Limits;
/// let limits = Limits { pixels: 64 * 4500, ..Limits::default() };
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one frame; 16 MiB by default.
    pub frame_len: usize,
    /// Rows times columns; 4 Mi by default (a 128-beam sensor of 4096 columns has half a Mi).
    pub pixels: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { frame_len: 16 << 20, pixels: 4 << 20 }
    }
}

/// Decodes frames; keeps its memory and the geometry's sines and cosines from one to the next.
///
/// RAM: 1 or 2 bytes a pixel of the largest frame so far, the same again while a frame of several strips is decoded,
/// and 16 bytes a row and a column (48 and 16 on a sensor's own grid).
///
/// Frames on the grid of a [built-in](sensors::ALL) sensor need nothing else, nor do those that carry their beams;
/// [`know`](Self::know) tells it of others.
#[derive(Debug, Default)]
pub struct Decoder {
    limits: Limits,
    levels: Levels,
    places: Places,
    known: Vec<Known>,
    /// Of the last frame, where its columns are firings.
    firings: Vec<u32>,
}

/// Where the pixels of the last frame of either geometry lie.
#[derive(Debug, Default)]
struct Places {
    sphere: Sphere,
    turn: Turn,
}

/// A sensor that the caller has told of.
#[derive(Debug)]
struct Known {
    sensor: u32,
    beams: Vec<Beam>,
}

/// The levels of a decoded image, row-major, 0 = no return.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Levels {
    /// Of up to 8 bits.
    U8(Vec<u8>),
    /// Of 9 to 16 bits.
    U16(Vec<u16>),
}

impl Default for Levels {
    fn default() -> Self {
        Self::U8(Vec::new())
    }
}

/// A decoded frame; its pixels are lent by the [`Decoder`].
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    header: Header,
    levels: &'a Levels,
    places: &'a Places,
}

impl Decoder {
    /// A decoder that refuses frames beyond `limits`.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        Self { limits, ..Self::default() }
    }

    /// Makes a sensor's grid known, for frames that do not carry its beams. Takes 20 bytes a beam.
    pub fn know(&mut self, grid: &SensorGrid<'_>) {
        let sensor = grid.checksum();
        if self.known.iter().all(|known| known.sensor != sensor) {
            self.known.push(Known { sensor, beams: grid.beams.to_vec() });
        }
    }

    /// Decodes `bytes`, which must be exactly one frame.
    ///
    /// # Errors
    /// Any [`DecodeError`]; no partial frame is given.
    pub fn decode(&mut self, bytes: &[u8]) -> Result<Frame<'_>, DecodeError> {
        check_limit(LimitKind::FrameLen, bytes.len(), self.limits.frame_len)?;
        let parsed = frame::parse(bytes)?;
        let header = parsed.header;
        check_limit(LimitKind::Pixels, header.pixels(), self.limits.pixels)?;
        match header.geometry {
            Geometry::Uniform(uniform) => {
                self.places.sphere.prepare(header.rows, header.columns, uniform.view, uniform.placement);
            }
            Geometry::Beams(beams) => self.prepare_turn(&parsed, &beams)?,
        }
        self.levels.decode(&parsed)?;
        Ok(Frame { header, levels: &self.levels, places: &self.places })
    }

    fn prepare_turn(&mut self, parsed: &ParsedFrame<'_>, beams: &BeamsGeometry) -> Result<(), DecodeError> {
        let header = &parsed.header;
        let read;
        let built_in = || sensors::ALL.iter().find(|grid| grid.checksum() == beams.sensor).map(|grid| grid.beams);
        let known = || self.known.iter().find(|known| known.sensor == beams.sensor).map(|known| known.beams.as_slice());
        let found = if beams.table {
            read = beams.read_table(parsed.table())?;
            &read
        } else {
            known().or_else(built_in).ok_or(DecodeError::UnknownSensor { sensor: beams.sensor })?
        };
        // A checksum that fits by chance, or by malice, must not fit a grid of other numbers.
        let grid = beams.grid(found);
        if found.len() != usize::from(header.rows) || grid.checksum() != beams.sensor {
            return Err(DecodeError::Header { field: HeaderField::Sensor, found: beams.sensor });
        }
        beams.read_firings(parsed.firings(), header.columns, &mut self.firings)?;
        let spread = if beams.column_mode == ColumnMode::Even { Spread::Even } else { Spread::At(&self.firings) };
        self.places.turn.prepare(&grid, header.columns, spread, header.quantizer.step_m());
        Ok(())
    }
}

fn check_limit(limit: LimitKind, found: usize, allowed: usize) -> Result<(), DecodeError> {
    if found > allowed {
        return Err(DecodeError::Limit { limit, found: found as u64, allowed: allowed as u64 });
    }
    Ok(())
}

impl Levels {
    fn decode(&mut self, parsed: &ParsedFrame<'_>) -> Result<(), DecodeError> {
        let fits_u8 = parsed.header.quantizer.level_bits() <= u8::BITS;
        if fits_u8 != matches!(self, Self::U8(_)) {
            *self = if fits_u8 { Self::U8(Vec::new()) } else { Self::U16(Vec::new()) };
        }
        match self {
            Self::U8(levels) => decode_levels(parsed, levels),
            Self::U16(levels) => decode_levels(parsed, levels),
        }
    }
}

fn decode_levels<L: Level>(parsed: &ParsedFrame<'_>, levels: &mut Vec<L>) -> Result<(), DecodeError> {
    levels.clear();
    levels.resize(parsed.header.pixels(), L::NONE);
    let columns = usize::from(parsed.header.columns);
    let mut strip_levels = Vec::new();
    for (number, strip) in (0..).zip(parsed.strips()) {
        let strip = strip?;
        let fault = |fault| DecodeError::Payload { strip: number, fault };
        let strip_columns = usize::from(strip.columns);
        if strip_columns == columns {
            decode_payload(&parsed.header, strip.payload, levels).map_err(fault)?;
        } else {
            strip_levels.clear();
            strip_levels.resize(usize::from(parsed.header.rows) * strip_columns, L::NONE);
            decode_payload(&parsed.header, strip.payload, &mut strip_levels).map_err(fault)?;
            place_strip(&strip_levels, strip_columns, levels, columns, strip.first_column.into());
        }
    }
    Ok(())
}

fn decode_payload<L: Level>(header: &Header, payload: &[u8], levels: &mut [L]) -> Result<(), PayloadFault> {
    let max = header.quantizer.max_level();
    match header.coder {
        CoderId::Store => coder::store::decode(payload, levels)?,
        CoderId::Rle => coder::rle::decode(payload, levels)?,
        CoderId::Deflate => coder::inflate::decode(payload, levels)?,
        CoderId::Context => {
            let allowed = Allowed { max_level: max, error_max: header.error_max };
            coder::context::decode(payload, header.rows.into(), levels, allowed)?;
        }
    }
    // All levels fit where the pixel type has no more bits than the header allows.
    let too_large = if u32::from(max) + 1 == 1 << L::BITS { None } else { levels.iter().find(|l| l.get() > max) };
    too_large.map_or(Ok(()), |found| Err(PayloadFault::LevelRange { found: found.get(), max }))
}

fn place_strip<L: Level>(strip: &[L], strip_columns: usize, levels: &mut [L], columns: usize, first_column: usize) {
    for (from, to) in strip.chunks_exact(strip_columns).zip(levels.chunks_exact_mut(columns)) {
        to[first_column..first_column + strip_columns].copy_from_slice(from);
    }
}

impl<'a> Frame<'a> {
    /// What the frame says of itself.
    #[must_use]
    pub const fn header(&self) -> &Header {
        &self.header
    }

    /// Levels, row-major, 0 = no return.
    #[must_use]
    pub const fn levels(&self) -> &'a Levels {
        self.levels
    }

    /// The points, x, y, z in meters, row by row from the top, each in order of columns.
    #[must_use]
    pub fn points(&self) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        self.points_into(&mut points);
        points
    }

    /// As [`points`](Self::points), into a vector whose memory is used again.
    pub fn points_into(&self, points: &mut Vec<[f32; 3]>) {
        match self.levels {
            Levels::U8(levels) => self.push_points(levels, points),
            Levels::U16(levels) => self.push_points(levels, points),
        }
    }

    fn push_points<L: Level>(&self, levels: &[L], points: &mut Vec<[f32; 3]>) {
        let quantizer = self.header.quantizer;
        match self.header.geometry {
            Geometry::Uniform(_) => {
                let sphere = &self.places.sphere;
                self.put_rows(levels, points, |row| {
                    let row = sphere.row(row);
                    (sphere.columns(), move |column, level| row.at(column, quantizer.range_m(level)))
                });
            }
            Geometry::Beams(_) => {
                let turn = &self.places.turn;
                self.put_rows(levels, points, |row| {
                    let (columns, row) = turn.row(row);
                    (columns, move |column, level| row.at(column, level))
                });
            }
        }
    }

    /// The returns of all rows in place of what `points` held; `of_row` gives a row's columns and what makes one
    /// of them and a level a point.
    fn put_rows<'c, L: Level, C: 'c, P: Fn(&C, u16) -> [f32; 4]>(
        &self,
        levels: &[L],
        points: &mut Vec<[f32; 3]>,
        of_row: impl Fn(usize) -> (&'c [C], P),
    ) {
        let Some(image) = ImageView::new(levels, self.header.columns.into()) else { return points.clear() };
        let occupied = image.occupied();
        // Not emptied before: what is there need not be zeroed again.
        points.resize(occupied + ROOM, [0.0; 3]);
        let mut room = points.as_flattened_mut();
        for (row, levels) in levels.chunks_exact(image.columns()).enumerate() {
            let (columns, point) = of_row(row);
            let count = put_row(levels, columns, room, point);
            room = room.get_mut(count * 3..).unwrap_or_default();
        }
        points.truncate(occupied);
    }
}

/// Pixels that are reconstructed together, if one of them holds a return.
const CHUNK: usize = 8;
/// Points that there must be room for behind those of an image.
const ROOM: usize = CHUNK + 1;

/// Writes a row's returns to the front of `room` and gives how many. Up to [`ROOM`] points behind them are written over.
///
/// There is no branch a pixel, which would be guessed wrong as often as returns come and go: every pixel's point is
/// computed and written, and the place moves on only behind a return. A fourth coordinate makes it one vector.
fn put_row<L: Level, C>(levels: &[L], columns: &[C], room: &mut [f32], point: impl Fn(&C, u16) -> [f32; 4]) -> usize {
    let (chunks, last_levels) = levels.as_chunks::<CHUNK>();
    let (column_chunks, last_columns) = columns.as_chunks::<CHUNK>();
    let mut count = 0;
    for (levels, columns) in chunks.iter().zip(column_chunks) {
        if *levels != [L::NONE; CHUNK] {
            count += put_chunk(levels, columns, room.get_mut(count * 3..).unwrap_or_default(), &point);
        }
    }
    for (level, column) in last_levels.iter().zip(last_columns) {
        count += put_chunk(&[*level], array::from_ref(column), room.get_mut(count * 3..).unwrap_or_default(), &point);
    }
    count
}

#[inline(always)]
fn put_chunk<L: Level, C, const N: usize>(
    levels: &[L; N],
    columns: &[C; N],
    room: &mut [f32],
    point: impl Fn(&C, u16) -> [f32; 4],
) -> usize {
    let Some(places) = room.first_chunk_mut::<{ 3 * CHUNK + 1 }>() else { return 0 };
    let mut at = 0;
    for (&level, column) in levels.iter().zip(columns) {
        // As it was: said where the compiler, too, can see it, and needs no check.
        let place = at.min(3 * (CHUNK - 1));
        places[place..place + 4].copy_from_slice(&point(column, level.get()));
        at += if level == L::NONE { 0 } else { 3 };
    }
    at / 3
}
