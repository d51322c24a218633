//! The mirror image of the encoder: frame -> payload -> range image -> points.

use core::array;
use std::vec::Vec;

use crate::coder::context::{Allowed, Recall};
use crate::coder::{self, CoderId};
use crate::error::{DecodeError, HeaderField, LimitKind, PayloadFault};
use crate::frame::{self, BeamsGeometry, ColumnMode, Geometry, Header, ParsedFrame, Strip};
use crate::geometry::{Beam, SensorGrid, Sphere, Spread, Turn, sensors};
use crate::image::{ImageView, ImageViewMut, Level};
use crate::original::{self, FrameReturn};
use crate::parallel;
use crate::plane::decode::DecodedPlanes;
use crate::plane::{IntensityScale, SectionKind};
use crate::previous;
use crate::previous::before::Before;
use crate::quantize::Companding;
use crate::smooth::smooth_row;

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
/// RAM: 1 or 2 bytes a pixel of the largest frame so far, the same again where a frame had several strips,
/// and 16 bytes a row and a column (48 and 16 on a sensor's own grid; another 16 a tick where columns are firings).
///
/// With feature `rayon`, strips are decoded and rows become points on all cores of the pool that it is called in, the global
/// one unless [`install`](https://docs.rs/rayon/latest/rayon/struct.ThreadPool.html#method.install) says another. What comes
/// out is the same.
///
/// Frames on the grid of a [built-in](sensors::ALL) sensor need nothing else, nor do those that carry their beams;
/// [`know`](Self::know) tells it of others.
#[derive(Debug, Default)]
pub struct Decoder {
    limits: Limits,
    levels: Levels,
    /// Of the last frame of several strips, strip by strip.
    gathered: Levels,
    planes: DecodedPlanes,
    before: Before,
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
    planes: &'a DecodedPlanes,
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
        let link = self.before.begin(&parsed, &self.firings)?;
        let memory = if link.is_some() { Some(&mut self.before.levels) } else { None };
        self.levels.decode(&parsed, &mut self.gathered, memory)?;
        if let Some(link) = link {
            self.before.end(link, previous::checksum_of(bytes, bytes.len()));
        }
        match &self.levels {
            Levels::U8(levels) => self.planes.decode(&parsed, levels),
            Levels::U16(levels) => self.planes.decode(&parsed, levels),
        }?;
        Ok(Frame { header, levels: &self.levels, planes: &self.planes, places: &self.places })
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
    /// Made those of the header's levels.
    fn fit(&mut self, header: &Header) {
        let fits_u8 = header.quantizer.level_bits() <= u8::BITS;
        if fits_u8 != matches!(self, Self::U8(_)) {
            *self = if fits_u8 { Self::U8(Vec::new()) } else { Self::U16(Vec::new()) };
        }
    }

    fn decode(
        &mut self,
        parsed: &ParsedFrame<'_>,
        gathered: &mut Self,
        memory: Option<&mut Vec<u16>>,
    ) -> Result<(), DecodeError> {
        self.fit(&parsed.header);
        gathered.fit(&parsed.header);
        match (self, gathered) {
            (Self::U8(levels), Self::U8(gathered)) => decode_levels(parsed, levels, gathered, memory),
            (Self::U16(levels), Self::U16(gathered)) => decode_levels(parsed, levels, gathered, memory),
            _ => Ok(()),
        }
    }
}

fn decode_levels<L: Level>(
    parsed: &ParsedFrame<'_>,
    levels: &mut Vec<L>,
    gathered: &mut Vec<L>,
    memory: Option<&mut Vec<u16>>,
) -> Result<(), DecodeError> {
    let header = &parsed.header;
    let strips = parsed.strips().collect::<Result<Vec<_>, _>>()?;
    let decode = |(number, payload, levels, memory): (u32, &[u8], &mut [L], Option<&mut Vec<u16>>)| {
        let columns = levels.len() / usize::from(header.rows);
        let mut recall =
            memory.and_then(|memory| Some(Recall::new(ImageViewMut::new(memory.as_mut_slice(), columns)?, true)));
        decode_payload(header, payload, levels, recall.as_mut())
            .map_err(|fault| DecodeError::Payload { strip: number, fault })
    };
    if let [strip] = strips[..] {
        emptied(levels, header.pixels());
        return decode((0, strip.payload, levels, memory));
    }
    emptied(gathered, header.pixels());
    let mut memories: Vec<Option<Vec<u16>>> =
        strips.iter().map(|strip| memory.as_deref().map(|memory| cut(memory, header.columns.into(), strip))).collect();
    let (mut pieces, mut rest) = (Vec::with_capacity(strips.len()), gathered.as_mut_slice());
    for ((number, strip), memory) in (0..).zip(&strips).zip(&mut memories) {
        let (own, after) = rest.split_at_mut(usize::from(header.rows) * usize::from(strip.columns));
        pieces.push((number, strip.payload, own, memory.as_mut()));
        rest = after;
    }
    parallel::try_for_each(pieces, decode)?;
    if let Some(memory) = memory {
        let memories: Vec<u16> = memories.into_iter().flatten().flatten().collect();
        place_strips(&strips, &memories, header.columns.into(), memory);
    }
    // Every pixel is written: strips cover all columns.
    levels.resize(header.pixels(), L::NONE);
    place_strips(&strips, gathered, header.columns.into(), levels);
    Ok(())
}

/// A strip's part of an image, row-major.
fn cut(levels: &[u16], columns: usize, strip: &Strip<'_>) -> Vec<u16> {
    let (first, width) = (usize::from(strip.first_column), usize::from(strip.columns));
    levels.chunks_exact(columns).flat_map(|row| &row[first..first + width]).copied().collect()
}

fn emptied<L: Level>(levels: &mut Vec<L>, len: usize) {
    levels.clear();
    levels.resize(len, L::NONE);
}

/// Puts strips side by side.
fn place_strips<L: Level>(strips: &[Strip<'_>], gathered: &[L], columns: usize, levels: &mut [L]) {
    let rows = levels.len() / columns;
    let rows_a_piece = rows.div_ceil(parallel::pieces(rows));
    let pieces: Vec<_> = levels.chunks_mut(rows_a_piece * columns).enumerate().collect();
    parallel::for_each(pieces, |(piece, levels)| {
        for (row, levels) in (piece * rows_a_piece..).zip(levels.chunks_exact_mut(columns)) {
            for strip in strips {
                let (first, width) = (usize::from(strip.first_column), usize::from(strip.columns));
                levels[first..first + width].copy_from_slice(&gathered[rows * first + row * width..][..width]);
            }
        }
    });
}

fn decode_payload<L: Level>(
    header: &Header,
    payload: &[u8],
    levels: &mut [L],
    recall: Option<&mut Recall<'_>>,
) -> Result<(), PayloadFault> {
    let max = header.quantizer.max_level();
    match header.coder {
        CoderId::Store => coder::store::decode(payload, levels)?,
        CoderId::Rle => coder::rle::decode(payload, levels)?,
        CoderId::Deflate => coder::inflate::decode(payload, levels)?,
        CoderId::Context => {
            let allowed = Allowed { max_level: max, error_max: header.error_max };
            coder::context::decode(payload, header.rows.into(), levels, allowed, recall)?;
        }
    }
    // All levels fit where the pixel type has no more bits than the header allows.
    let too_large = if u32::from(max) + 1 == 1 << L::BITS { None } else { levels.iter().find(|l| l.get() > max) };
    too_large.map_or(Ok(()), |found| Err(PayloadFault::LevelRange { found: found.get(), max }))
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

    /// The intensities' numbers, row-major, 0 where there is no return, and what they mean; `None` where the frame carries
    /// none.
    #[must_use]
    pub fn intensity_plane(&self) -> Option<(&'a [u8], IntensityScale)> {
        let image = &self.planes.intensity;
        image.scale.map(|scale| (image.numbers.as_slice(), scale))
    }

    /// The intensity of each of the [points](Self::points), in the same order; `None` where the frame carries none.
    #[must_use]
    pub fn intensities(&self) -> Option<Vec<f32>> {
        let (numbers, scale) = self.intensity_plane()?;
        let of_number: Vec<f32> = (0..=u8::MAX).map(|number| scale.intensity(number)).collect();
        let of = |is_return: bool, &number: &u8| is_return.then_some(of_number[usize::from(number)]);
        Some(match self.levels {
            Levels::U8(levels) => levels.iter().zip(numbers).filter_map(|(l, n)| of(*l != 0, n)).collect(),
            Levels::U16(levels) => levels.iter().zip(numbers).filter_map(|(l, n)| of(*l != 0, n)).collect(),
        })
    }

    /// The time of each column, nanoseconds of the epoch of the header's time: of each firing in order, where the columns are a
    /// sensor's firings. `None` where the frame carries none.
    #[must_use]
    pub fn column_times_ns(&self) -> Option<&'a [u64]> {
        self.planes.times_ns.as_deref()
    }

    /// The time of each of the [points](Self::points), in the same order; `None` where the frame carries none.
    #[must_use]
    pub fn times_ns(&self) -> Option<Vec<u64>> {
        let times_ns = self.column_times_ns()?;
        let columns = usize::from(self.header.columns);
        let of_row = |row: usize| match self.header.geometry {
            Geometry::Beams(_) => self.places.turn.first_column(row),
            Geometry::Uniform(_) => 0,
        };
        let time = |at: usize| times_ns[(of_row(at / columns) + at % columns) % columns];
        Some(match self.levels {
            Levels::U8(levels) => (0..).zip(levels).filter(|(_, l)| **l != 0).map(|(at, _)| time(at)).collect(),
            Levels::U16(levels) => (0..).zip(levels).filter(|(_, l)| **l != 0).map(|(at, _)| time(at)).collect(),
        })
    }

    /// The bytes of the file that the frame was made from; `None` where it does not tell ([`original::append`]).
    ///
    /// # Errors
    /// [`DecodeError::Section`] where what tells is damaged.
    pub fn original(&self) -> Result<Option<Vec<u8>>, DecodeError> {
        let fault = |fault| DecodeError::Section { kind: SectionKind::Original as u8, fault };
        let body = self.planes.original.as_deref();
        body.map(|body| original::decode(self, body)).transpose().map_err(fault)
    }

    /// The returns, row by row from the top, each in order of columns, with more digits than points have.
    pub(crate) fn returns(&self) -> Vec<FrameReturn> {
        let columns = usize::from(self.header.columns);
        let level = |at: usize| match self.levels {
            Levels::U8(levels) => u16::from(levels[at]),
            Levels::U16(levels) => levels[at],
        };
        let plane = self.intensity_plane();
        let is_square_root = self.header.quantizer.companding() == Companding::SquareRoot;
        let mut returns = Vec::new();
        for at in (0..self.header.pixels()).filter(|&at| level(at) != 0) {
            let (row, column) = (at / columns, at % columns);
            let position = match self.header.geometry {
                Geometry::Uniform(_) => {
                    let (row, columns) = (self.places.sphere.row(row), self.places.sphere.columns());
                    xyz(row.at(&columns[column], self.header.quantizer.range_m(level(at)))).map(f64::from)
                }
                Geometry::Beams(_) => {
                    let (columns, row) = self.places.turn.row(row);
                    let level = u32::from(level(at));
                    row.at_exactly(&columns[column], f64::from(if is_square_root { level * level } else { level }))
                }
            };
            let intensity = plane.map_or(0.0, |(numbers, scale)| scale.intensity(numbers[at]));
            returns.push(FrameReturn { row: row as u16, column: column as u16, position, intensity });
        }
        returns
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

    /// As [`points`](Self::points), with the stairs that a coarse step makes of a surface evened out: each range is moved
    /// towards the mean of up to four pixels on either side in its row, not across edges, by at most the half of its cell
    /// that the frame's [bound](Header::range_bound_m) speaks of. So a range may be off by **twice** that bound; on
    /// average it is nearer.
    ///
    /// For a sensor's own grid with steps of 5 cm and more: on KITTI's scans it gains 0.7 dB at 5 cm, 1.0 at 10 to 31 cm, 1.6
    /// with 8 bits without a dead zone. At 2 cm it costs 0.8 dB, at 1 cm 2.3, for what it smooths there are the things
    /// themselves; with evenly spread rows and columns it does next to nothing, for their errors are sideways.
    /// `docs/PERFORMANCE.md` has the figures.
    #[must_use]
    pub fn smooth_points(&self) -> Vec<[f32; 3]> {
        match self.levels {
            Levels::U8(levels) => self.smooth_points_of(levels),
            Levels::U16(levels) => self.smooth_points_of(levels),
        }
    }

    fn smooth_points_of<L: Level>(&self, levels: &[L]) -> Vec<[f32; 3]> {
        let (columns_len, step_m) = (usize::from(self.header.columns), self.header.quantizer.step_m());
        let cell = 0.5 + f32::from(self.header.error_max);
        let is_square_root = self.header.quantizer.companding() == Companding::SquareRoot;
        let steps = |level: f32| if is_square_root { level * level } else { level };
        let (mut points, mut smoothed) = (Vec::new(), Vec::new());
        for (number, levels) in levels.chunks_exact(columns_len).enumerate() {
            smooth_row(levels, cell, &mut smoothed);
            let returns = smoothed.iter().enumerate().filter(|&(_, &level)| level > 0.0);
            match self.header.geometry {
                Geometry::Uniform(_) => {
                    let (row, columns) = (self.places.sphere.row(number), self.places.sphere.columns());
                    points.extend(returns.map(|(at, &level)| xyz(row.at(&columns[at], steps(level) * step_m))));
                }
                Geometry::Beams(_) => {
                    let (columns, row) = self.places.turn.row(number);
                    points.extend(returns.map(|(at, &level)| xyz(row.at_fraction(&columns[at], steps(level).into()))));
                }
            }
        }
        points
    }

    fn push_points<L: Level>(&self, levels: &[L], points: &mut Vec<[f32; 3]>) {
        let quantizer = self.header.quantizer;
        let is_square_root = quantizer.companding() == Companding::SquareRoot;
        match self.header.geometry {
            Geometry::Uniform(_) => {
                let sphere = &self.places.sphere;
                self.put_rows(levels, points, |row| {
                    let row = sphere.row(row);
                    (sphere.columns(), move |column, level| row.at(column, quantizer.range_m(level)))
                });
            }
            Geometry::Beams(_) if is_square_root => {
                let turn = &self.places.turn;
                self.put_rows(levels, points, |row| {
                    let (columns, row) = turn.row(row);
                    (columns, move |column, level| {
                        row.at_fraction(column, f64::from(u32::from(level) * u32::from(level)))
                    })
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
    fn put_rows<'c, L: Level, C: Sync + 'c, P: Fn(&C, u16) -> [f32; 4]>(
        &self,
        levels: &[L],
        points: &mut Vec<[f32; 3]>,
        of_row: impl Fn(usize) -> (&'c [C], P) + Sync + Send,
    ) {
        let Some(image) = ImageView::new(levels, self.header.columns.into()) else { return points.clear() };
        let rows_a_piece = image.rows().div_ceil(parallel::pieces(image.rows()));
        let pieces =
            levels.chunks(rows_a_piece * image.columns()).filter_map(|levels| ImageView::new(levels, image.columns()));
        let pieces: Vec<_> = pieces.map(|image| (image, image.occupied())).collect();
        let occupied = pieces.iter().map(|(_, occupied)| occupied).sum();
        // Not emptied before: what is there need not be zeroed again.
        points.resize(occupied + ROOM, [0.0; 3]);
        let (mut with_room, mut room) = (Vec::with_capacity(pieces.len()), points.as_flattened_mut());
        for (number, (image, occupied)) in pieces.into_iter().enumerate() {
            let len = if room.len() == 3 * (occupied + ROOM) { room.len() } else { 3 * occupied };
            let (own, after) = room.split_at_mut(len);
            with_room.push((number * rows_a_piece, image, own));
            room = after;
        }
        parallel::for_each(with_room, |(first_row, image, mut room)| {
            for (row, levels) in (first_row..).zip(image.row_levels()) {
                let (columns, point) = of_row(row);
                let count = put_row_within(levels, columns, room, point);
                room = room.get_mut(count * 3..).unwrap_or_default();
            }
        });
        points.truncate(occupied);
    }
}

const fn xyz([x, y, z, _]: [f32; 4]) -> [f32; 3] {
    [x, y, z]
}

/// Pixels that are reconstructed together, if one of them holds a return.
const CHUNK: usize = 8;
/// Points that there must be room for behind those of an image.
const ROOM: usize = CHUNK + 1;

/// As [`put_row`], where behind the row's points there may be none to write over.
fn put_row_within<L: Level, C>(
    levels: &[L],
    columns: &[C],
    room: &mut [f32],
    point: impl Fn(&C, u16) -> [f32; 4],
) -> usize {
    if room.len() >= 3 * (levels.len() + ROOM) {
        return put_row(levels, columns, room, point);
    }
    let count = levels.iter().filter(|&&level| level != L::NONE).count();
    if count == 0 || room.len() >= 3 * (count + ROOM) {
        return put_row(levels, columns, room, point);
    }
    let mut roomy = std::vec![0.0; 3 * (count + ROOM)];
    put_row(levels, columns, &mut roomy, point);
    room[..3 * count].copy_from_slice(&roomy[..3 * count]);
    count
}

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
