//! The container: header, strips, checksum. `docs/FORMAT.md` is the normative text; this is its one implementation,
//! `write` and `parse` side by side.
//!
//! ```text
//! frame  = header strip... section... crc32
//! strip  = first_column:u16 columns:u16 payload_len:u32 payload
//! ```
//!
//! What sections are, says [`plane`](crate::plane); a frame has them where its flags say so.

use crate::coder::{Coder, CoderId, OutputFull, Sink};
use crate::error::{DecodeError, HeaderField};
use crate::image::{ImageView, Level};
use crate::quantize::{Companding, Quantizer};

mod geometry;

pub use geometry::{BeamsGeometry, BeamsHeader, ColumnMode, FiringsHeader, Geometry, GeometryFields, UniformHeader};

/// First four bytes of every frame.
pub const MAGIC: [u8; 4] = *b"FLCR";
/// The version of the format that this crate writes and reads.
pub const VERSION: u8 = 1;
/// Flag of a frame with sections behind its strips.
const SECTIONS_FLAG: u8 = 2;
/// Flag of a frame whose levels go by the square root of the range.
const SQUARE_ROOT_FLAG: u8 = 4;
/// Where in a header the flags stand.
const FLAGS_AT: usize = 5;
/// Where the header's length stands.
pub(crate) const HEADER_LEN_AT: usize = 6;
/// Where the frame's length stands.
const FRAME_LEN_AT: usize = 8;
/// Where the number of strips stands.
pub(crate) const STRIPS_AT: usize = 30;
/// Bytes of a header with a uniform geometry.
pub const HEADER_LEN: usize = 64;
/// Bytes before each strip's payload.
pub const STRIP_HEADER_LEN: usize = 8;
/// Bytes of the checksum behind the last strip.
pub const CHECKSUM_LEN: usize = 4;
/// Bytes that a frame of one strip needs besides its payload.
pub const OVERHEAD_LEN: usize = HEADER_LEN + STRIP_HEADER_LEN + CHECKSUM_LEN;

/// CRC-32 as in zip and Ethernet: a table of 1 KB on the device, of 16 KB where there is room.
static CRC: crc::Crc<u32, CrcTable> = crc::Crc::<u32, CrcTable>::new(&crc::CRC_32_ISO_HDLC);
#[cfg(not(feature = "std"))]
type CrcTable = crc::Table<1>;
#[cfg(feature = "std")]
type CrcTable = crc::Table<16>;

/// The checksum of frames and datagrams, of runs of bytes as if they were one.
pub(crate) fn checksum_of<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> u32 {
    let mut digest = CRC.digest();
    parts.into_iter().for_each(|part| digest.update(part));
    digest.finalize()
}

/// Everything a decoder must know of a frame but its pixels. `G` is [`Geometry`] where a header was read, one of
/// [`UniformHeader`] and [`BeamsHeader`] where it is to be written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header<G = Geometry> {
    /// The caller's number of the frame.
    pub sequence: u32,
    /// The caller's time of the frame, nanoseconds, of any epoch.
    pub timestamp_ns: u64,
    /// Rows of the image.
    pub rows: u16,
    /// Columns of the image.
    pub columns: u16,
    /// Levels to ranges; carries the step and the error bound.
    pub quantizer: Quantizer,
    /// What coded the strips.
    pub coder: CoderId,
    /// Most levels that the coder changed a level by; 0 for those that lose nothing.
    pub error_max: u16,
    /// Returns that the encoder was given: those in the image and those it lost. What was no return is not counted.
    pub returns: u32,
    /// Where pixels lie in space.
    pub geometry: G,
}

impl<G: Copy> Header<G> {
    /// Pixels of the image.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        self.rows as usize * self.columns as usize
    }

    /// Most that a point's range is off, meters.
    #[must_use]
    pub const fn range_bound_m(&self) -> f32 {
        self.quantizer.range_bound_with_m(self.error_max)
    }
}

impl<G: GeometryFields> Header<G> {
    /// Bytes by which the header is longer than one of a uniform geometry.
    pub(crate) fn more_than_uniform(&self) -> usize {
        self.geometry.header_len() - HEADER_LEN
    }

    /// Writes the header over all of `out`.
    fn put(&self, frame_len: u32, strips: u16, out: &mut [u8]) {
        let header_len = out.len() as u16;
        let mut places = out.iter_mut();
        let mut put = |field: &[u8]| field.iter().zip(places.by_ref()).for_each(|(&from, to)| *to = from);
        put(&MAGIC);
        let square_root = if self.quantizer.companding() == Companding::SquareRoot { SQUARE_ROOT_FLAG } else { 0 };
        put(&[VERSION, self.geometry.flags() | square_root]);
        put(&header_len.to_le_bytes());
        put(&frame_len.to_le_bytes());
        put(&self.sequence.to_le_bytes());
        put(&self.timestamp_ns.to_le_bytes());
        put(&self.rows.to_le_bytes());
        put(&self.columns.to_le_bytes());
        put(&[self.quantizer.level_bits() as u8, self.coder as u8]);
        put(&strips.to_le_bytes());
        put(&self.quantizer.step_m().to_le_bytes());
        put(&self.range_bound_m().to_le_bytes());
        put(&self.returns.to_le_bytes());
        self.geometry.put(put);
    }
}

/// Most bytes that a frame of `pixels` pixels and a uniform geometry can take with coder `C`.
#[must_use]
pub const fn worst_case_len<L: Level, C: Coder<L>>(pixels: usize) -> usize {
    OVERHEAD_LEN + C::WORST_CASE.len(pixels)
}

/// As [`worst_case_len`], cut into `strips` strips (at least one, at most as many as columns).
#[must_use]
pub const fn worst_case_len_in_strips<L: Level, C: Coder<L>>(rows: usize, columns: usize, strips: u16) -> usize {
    let strips = if strips == 0 { 1 } else { strips as usize };
    let (width, wider) = (columns / strips, columns % strips);
    let payloads_len =
        wider * C::WORST_CASE.len(rows * (width + 1)) + (strips - wider) * C::WORST_CASE.len(rows * width);
    let gathered_len = if C::WORST_CASE.gathers && strips > 1 {
        rows * columns.div_ceil(strips) * size_of::<L>() + crate::image::gap::<L>()
    } else {
        0
    };
    OVERHEAD_LEN + (strips - 1) * STRIP_HEADER_LEN + payloads_len + gathered_len
}

/// Writes a frame of `strips` strips (at least one, at most as many as columns), as even as can be, to the front of
/// `out` and gives its length.
///
/// `header` must describe `image`; its `coder` and `error_max` are set to `C`'s.
///
/// # Errors
/// [`OutputFull`] where the frame does not fit `out`; never with [`worst_case_len_in_strips`] bytes and what the header
/// is longer than one of a uniform geometry.
pub fn write<L: Level, C: Coder<L>>(
    header: Header<impl GeometryFields>,
    image: ImageView<'_, L>,
    strips: u16,
    coder: &mut C,
    out: &mut [u8],
) -> Result<usize, OutputFull> {
    write_by(header, image, strips, coder, out, |coder, strip, _, out| coder.encode(strip, out))
}

/// As [`write`], with what `encode` makes of each strip, whose first column it is told.
pub(crate) fn write_by<L: Level, C: Coder<L>>(
    header: Header<impl GeometryFields>,
    image: ImageView<'_, L>,
    strips: u16,
    coder: &mut C,
    out: &mut [u8],
    mut encode: impl FnMut(&mut C, ImageView<'_, L>, usize, &mut [u8]) -> Result<usize, OutputFull>,
) -> Result<usize, OutputFull> {
    let strips = strips.clamp(1, header.columns.max(1));
    let first_column = |number: u16| (u32::from(header.columns) * u32::from(number) / u32::from(strips)) as u16;
    let mut checked_len = header.geometry.header_len();
    for number in 0..strips {
        let (first, end) = (first_column(number), first_column(number + 1));
        let room = out.get_mut(checked_len..).ok_or(OutputFull)?;
        checked_len +=
            write_strip(image, first, end - first, room, |strip, out| encode(coder, strip, first.into(), out))?;
    }
    let (checked, after) = out.split_at_mut_checked(checked_len).ok_or(OutputFull)?;
    let head = checked.get_mut(..header.geometry.header_len()).ok_or(OutputFull)?;
    let header = Header { coder: C::ID, error_max: coder.error_max(), ..header };
    header.put(to_u32(checked_len + CHECKSUM_LEN)?, strips, head);
    Sink::new(after).put_all(&CRC.checksum(checked).to_le_bytes())?;
    Ok(checked_len + CHECKSUM_LEN)
}

/// Writes one strip of `image` to the front of `out` and gives its length.
fn write_strip<L: Level>(
    image: ImageView<'_, L>,
    first_column: u16,
    columns: u16,
    out: &mut [u8],
    encode: impl FnOnce(ImageView<'_, L>, &mut [u8]) -> Result<usize, OutputFull>,
) -> Result<usize, OutputFull> {
    let (head, payload) = out.split_first_chunk_mut::<STRIP_HEADER_LEN>().ok_or(OutputFull)?;
    let strip = image.strip(first_column.into(), columns.into()).ok_or(OutputFull)?;
    let payload_len = encode(strip, payload)?;
    let ([f0, f1], [c0, c1]) = (first_column.to_le_bytes(), columns.to_le_bytes());
    let [p0, p1, p2, p3] = to_u32(payload_len)?.to_le_bytes();
    *head = [f0, f1, c0, c1, p0, p1, p2, p3];
    Ok(STRIP_HEADER_LEN + payload_len)
}

/// Makes the first `len` bytes of `out`, which are a frame without its checksum and sections behind it, a frame; gives its
/// length.
pub(crate) fn seal_with_sections(out: &mut [u8], len: usize) -> Result<usize, OutputFull> {
    let frame_len = to_u32(len + CHECKSUM_LEN)?.to_le_bytes();
    *out.get_mut(FLAGS_AT).ok_or(OutputFull)? |= SECTIONS_FLAG;
    out.get_mut(FRAME_LEN_AT..FRAME_LEN_AT + 4).ok_or(OutputFull)?.copy_from_slice(&frame_len);
    let (checked, after) = out.split_at_mut_checked(len).ok_or(OutputFull)?;
    Sink::new(after).put_all(&CRC.checksum(checked).to_le_bytes())?;
    Ok(len + CHECKSUM_LEN)
}

fn to_u32(len: usize) -> Result<u32, OutputFull> {
    u32::try_from(len).map_err(|_| OutputFull)
}

/// A frame whose header and checksum have been found right; its payloads have not been looked at.
#[derive(Debug, Clone, Copy)]
pub struct ParsedFrame<'a> {
    /// The header.
    pub header: Header,
    strips: u16,
    has_sections: bool,
    table: &'a [u8],
    firings: &'a [u8],
    body: &'a [u8],
}

/// One run of columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strip<'a> {
    /// First column.
    pub first_column: u16,
    /// Columns.
    pub columns: u16,
    /// The coded levels.
    pub payload: &'a [u8],
}

/// Length of the frame that `bytes` starts with, if it starts with one. For cutting a file of many frames.
///
/// # Errors
/// [`DecodeError::Magic`], [`DecodeError::Version`], [`DecodeError::Truncated`].
pub fn frame_len(bytes: &[u8]) -> Result<usize, DecodeError> {
    let mut fields = Fields { bytes, at: 0 };
    check_start(&mut fields)?;
    fields.at = FRAME_LEN_AT;
    let frame_len = fields.u32()? as usize;
    if bytes.len() < frame_len {
        return Err(DecodeError::Truncated { need: frame_len, have: bytes.len() });
    }
    Ok(frame_len)
}

/// Reads the header of the frame that `bytes` starts with, and nothing behind it: the checksum is *not* looked at.
/// For a receiver that must decide on a frame before all of it is there.
///
/// # Errors
/// Any [`DecodeError`] but those of strips, payload and checksum.
pub fn parse_header(bytes: &[u8]) -> Result<Header, DecodeError> {
    header_fields(bytes).map(|start| start.header)
}

/// Checks that `bytes` are exactly one frame: header, lengths, checksum.
///
/// # Errors
/// Any [`DecodeError`] but those of strips and payload.
pub fn parse(bytes: &[u8]) -> Result<ParsedFrame<'_>, DecodeError> {
    let Start { header, header_len, frame_len, strips, has_sections } = header_fields(bytes)?;
    check_frame_len(frame_len, bytes.len())?;
    let (body, stored) = bytes.split_at(frame_len - CHECKSUM_LEN);
    let stored = Fields { bytes: stored, at: 0 }.u32()?;
    let computed = CRC.checksum(body);
    if stored != computed {
        return Err(DecodeError::Checksum { stored, computed });
    }
    let (head, body) = body.split_at(header_len);
    let behind_fields = head.get(BeamsHeader::HEADER_LEN..).unwrap_or_default();
    let table_len = behind_fields.len() - header.geometry.firings_len().min(behind_fields.len());
    let (table, firings) = behind_fields.split_at(table_len);
    Ok(ParsedFrame { header, strips, has_sections, table, firings, body })
}

fn check_frame_len(frame_len: usize, have: usize) -> Result<(), DecodeError> {
    match frame_len.cmp(&have) {
        core::cmp::Ordering::Greater => Err(DecodeError::Truncated { need: frame_len, have }),
        core::cmp::Ordering::Less => Err(DecodeError::TrailingBytes { frame_len, have }),
        core::cmp::Ordering::Equal => Ok(()),
    }
}

/// What the start of a frame says.
struct Start {
    header: Header,
    header_len: usize,
    frame_len: usize,
    strips: u16,
    has_sections: bool,
}

fn header_fields(bytes: &[u8]) -> Result<Start, DecodeError> {
    let mut fields = Fields { bytes, at: 0 };
    check_start(&mut fields)?;
    check_have(bytes, HEADER_LEN)?;
    let flags = fields.u8()?;
    let header_len = expect(HeaderField::HeaderLen, fields.u16()?, |len| usize::from(len) >= HEADER_LEN)?;
    let header_len = usize::from(header_len);
    check_have(bytes, header_len)?;
    let least_len = header_len + STRIP_HEADER_LEN + CHECKSUM_LEN;
    let frame_len = expect(HeaderField::FrameLen, fields.u32()?, |len| len as usize >= least_len)?;
    let (sequence, timestamp_ns) = (fields.u32()?, fields.u64()?);
    let rows = expect(HeaderField::Rows, fields.u16()?, |rows| rows > 0)?;
    let columns = expect(HeaderField::Columns, fields.u16()?, |columns| columns > 0)?;
    let level_bits = expect(HeaderField::LevelBits, fields.u8()?, |bits| (1..=16).contains(&bits))?;
    let coder = fields.u8()?;
    let coder =
        CoderId::from_byte(coder).ok_or(DecodeError::Header { field: HeaderField::Coder, found: coder.into() })?;
    let strips = expect(HeaderField::Strips, fields.u16()?, |strips| (1..=columns).contains(&strips))?;
    let is_square_root = flags & SQUARE_ROOT_FLAG != 0;
    let flags = flags & !SQUARE_ROOT_FLAG;
    let companding = if is_square_root { Companding::SquareRoot } else { Companding::None };
    expect(HeaderField::LevelBits, level_bits, |bits| bits <= 8 || !is_square_root)?;
    let (quantizer, error_max) = quantizer_of(coder, (level_bits, companding), fields.u32()?, fields.u32()?)?;
    let returns = fields.u32()?;
    let (has_sections, flags) = (flags & SECTIONS_FLAG != 0, flags & !SECTIONS_FLAG);
    let (geometry, expected_len) = geometry::parse(&mut fields, flags, rows)?;
    expect(HeaderField::HeaderLen, header_len as u32, |len| len as usize == expected_len)?;
    let header = Header { sequence, timestamp_ns, rows, columns, quantizer, coder, error_max, returns, geometry };
    Ok(Start { header, header_len, frame_len: frame_len as usize, strips, has_sections })
}

fn check_have(bytes: &[u8], need: usize) -> Result<(), DecodeError> {
    if bytes.len() < need { Err(DecodeError::Truncated { need, have: bytes.len() }) } else { Ok(()) }
}

fn check_start(fields: &mut Fields<'_>) -> Result<(), DecodeError> {
    let found = fields.u32()?.to_le_bytes();
    if found != MAGIC {
        return Err(DecodeError::Magic { found });
    }
    let found = fields.u8()?;
    if found != VERSION {
        return Err(DecodeError::Version { found, supported: VERSION });
    }
    Ok(())
}

fn quantizer_of(
    coder: CoderId,
    (level_bits, companding): (u8, Companding),
    step_bits: u32,
    bound_bits: u32,
) -> Result<(Quantizer, u16), DecodeError> {
    let quantizer = Quantizer::from_step(level_bits.into(), f32::from_bits(step_bits), companding)
        .ok_or(DecodeError::Header { field: HeaderField::Step, found: step_bits })?;
    let error_max = if coder == CoderId::Context { error_max(&quantizer, f32::from_bits(bound_bits)) } else { 0 };
    let bound = quantizer.range_bound_with_m(error_max).to_bits();
    expect(HeaderField::RangeBound, bound_bits, |bits| bits == bound)?;
    Ok((quantizer, error_max))
}

/// The number of levels that a bound is closest to; that it is exactly that one's is still to be checked.
fn error_max(quantizer: &Quantizer, bound_m: f32) -> u16 {
    let least_m = quantizer.range_bound_m();
    crate::kernel::to_index((bound_m - least_m) / quantizer.apart_m(1) + 0.5, u32::from(u16::MAX)) as u16
}

fn expect<T: Copy + Into<u32>>(field: HeaderField, found: T, right: impl Fn(T) -> bool) -> Result<T, DecodeError> {
    if right(found) { Ok(found) } else { Err(DecodeError::Header { field, found: found.into() }) }
}

impl<'a> ParsedFrame<'a> {
    /// The beams that the header carries, 20 bytes each; nothing where it carries none.
    #[must_use]
    pub const fn table(&self) -> &'a [u8] {
        self.table
    }

    /// The list of firings that the header carries, as coded; nothing where it carries none.
    #[must_use]
    pub const fn firings(&self) -> &'a [u8] {
        self.firings
    }

    /// Whether sections follow the strips.
    #[must_use]
    pub const fn has_sections(&self) -> bool {
        self.has_sections
    }

    /// What follows the strips: the sections; nothing where a strip is wrong.
    #[cfg(feature = "std")]
    pub(crate) fn behind_strips(&self) -> &'a [u8] {
        let lens = self.strips().map(|strip| strip.map_or(usize::MAX, |strip| STRIP_HEADER_LEN + strip.payload.len()));
        self.body.get(lens.fold(0, usize::saturating_add)..).unwrap_or_default()
    }

    /// The sections behind the strips, in order: what each is, and its body, which is not looked at.
    ///
    /// # Errors
    /// [`DecodeError::Section`] where one is none that there is or not in its place, [`DecodeError::Truncated`].
    #[cfg(feature = "std")]
    pub fn sections(
        &self,
    ) -> impl Iterator<Item = Result<(crate::plane::SectionKind, &'a [u8]), DecodeError>> + use<'a> {
        crate::plane::decode::sections(if self.has_sections { self.behind_strips() } else { &[] })
    }

    /// What the frame says of the frame before; `None` where it says nothing of it.
    ///
    /// # Errors
    /// As [`sections`](Self::sections).
    #[cfg(feature = "std")]
    pub fn link(&self) -> Result<Option<crate::Link>, DecodeError> {
        crate::previous::before::link_of(self)
    }

    /// The strips in order; checked to cover every column once, and nothing but sections to follow the last.
    pub fn strips(&self) -> impl Iterator<Item = Result<Strip<'a>, DecodeError>> + use<'a> {
        let (header, mut left, mut next_column) = (self.header, self.strips, 0);
        let has_sections = self.has_sections;
        let mut fields = Fields { bytes: self.body, at: 0 };
        core::iter::from_fn(move || {
            left = left.checked_sub(1)?;
            let strip = next_strip(&mut fields, header.columns, &mut next_column, left == 0);
            let strip = strip
                .and_then(|strip| if left == 0 && !has_sections { fields.end().map(|()| strip) } else { Ok(strip) });
            left = if strip.is_err() { 0 } else { left };
            Some(strip)
        })
    }
}

fn next_strip<'a>(
    fields: &mut Fields<'a>,
    columns_in_all: u16,
    next_column: &mut u32,
    last: bool,
) -> Result<Strip<'a>, DecodeError> {
    let (first_column, columns, payload_len) = (fields.u16()?, fields.u16()?, fields.u32()?);
    if u32::from(first_column) != *next_column {
        return Err(DecodeError::StripOrder { found: first_column.into(), expected: *next_column });
    }
    *next_column += u32::from(columns);
    let columns_in_all = u32::from(columns_in_all);
    let fits = if last { *next_column == columns_in_all } else { *next_column < columns_in_all };
    expect(HeaderField::StripColumns, columns, |columns| columns > 0 && fits)?;
    let payload = fields.take(payload_len as usize)?;
    Ok(Strip { first_column, columns, payload })
}

/// A cursor over little-endian fields.
#[derive(Debug)]
struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    fn take(&mut self, len: usize) -> Result<&'a [u8], DecodeError> {
        let need = self.at.saturating_add(len);
        let field = self.bytes.get(self.at..need);
        let field = field.ok_or(DecodeError::Truncated { need, have: self.bytes.len() })?;
        self.at = need;
        Ok(field)
    }

    fn end(&self) -> Result<(), DecodeError> {
        let (frame_len, have) = (self.at, self.bytes.len());
        if frame_len < have { Err(DecodeError::TrailingBytes { frame_len, have }) } else { Ok(()) }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], DecodeError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn u8(&mut self) -> Result<u8, DecodeError> {
        self.array().map(|[byte]| byte)
    }

    fn u16(&mut self) -> Result<u16, DecodeError> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, DecodeError> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, DecodeError> {
        self.array().map(u64::from_le_bytes)
    }
}
