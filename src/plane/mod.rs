//! What a frame carries besides ranges, in sections behind its strips: an intensity for every return, a time for every
//! column. Each is coded strip by strip, so that a strip's part of a section can be read without the others.
//!
//! ```text
//! frame    = header strip... section... crc32
//! section  = kind:u8 0 0 0 len:u32 body
//! ```
//!
//! Sections are put behind a finished frame, whose flags, length and checksum are then set anew: what codes the ranges
//! knows nothing of them.

mod intensity;
mod scale;
mod times;

pub use intensity::{IntensityCoder, IntensityPlane};
pub use scale::IntensityScale;
pub use times::TimesPlane;

use crate::coder::{OutputFull, Sink};
use crate::error::ConfigError;
use crate::frame::{self, CHECKSUM_LEN, STRIP_HEADER_LEN};
use crate::image::{ImageView, Level};

/// Bytes before a section's body.
pub const SECTION_HEADER_LEN: usize = 8;
/// Bytes before each strip's part of a section.
const PART_HEADER_LEN: usize = 4;

/// The sections there are, in the order in which a frame has them; the number that the frame gives them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[repr(u8)]
pub enum SectionKind {
    /// An intensity for every return.
    Intensity = 1,
    /// A time for every column.
    Times = 2,
    /// What gives the file back that the frame was made from.
    Original = 3,
    /// Which frame is the one before ([`Previous`](crate::Previous)).
    Previous = 4,
}

impl SectionKind {
    /// The section of a number.
    #[must_use]
    pub const fn from_byte(byte: u8) -> Option<Self> {
        match byte {
            1 => Some(Self::Intensity),
            2 => Some(Self::Times),
            3 => Some(Self::Original),
            4 => Some(Self::Previous),
            _ => None,
        }
    }
}

/// What a frame is to carry besides ranges.
///
/// ```
/// use flicr::plane::{IntensityCoder, IntensityScale, Planes};
/// use flicr::{Config, Encoder, Rle, Scale, Stamp};
/// let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
/// let mut intensity_coder = IntensityCoder::<64, 8>::new();
/// let mut intensities = [0; 64 * 256];
///
/// let points = [[10.0_f32, 0.0, -1.0, 0.25], [0.0, 5.0, -0.5, 0.5]];
/// let config = Config { scale: Scale::Fixed { max_range_m: 120.0 }, ..Config::UNIFORM };
/// let mut frame = encoder.start(&config, Stamp::default())?;
/// frame.insert_lit(points.as_slice(), |index| (points[index][3] * 100.0 + 0.5) as u8, &mut intensities);
/// let intensity = intensity_coder.plane(&intensities, IntensityScale::PERCENT);
/// let planes = Planes { intensity: Some(intensity), ..Planes::default() };
/// let mut out = [0; 4000];
/// let encoded = frame.finish_with(planes, &mut out)?;
/// # #[cfg(feature = "std")] {
/// let mut decoder = flicr::Decoder::default();
/// let frame = decoder.decode(&out[..encoded.len])?;
/// assert_eq!(frame.intensities(), Some(vec![0.25, 0.5]));
/// # }
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Planes<'a> {
    /// Intensities of the returns.
    pub intensity: Option<IntensityPlane<'a>>,
    /// Times of the columns.
    pub times: Option<TimesPlane<'a>>,
}

impl Planes<'_> {
    /// Most bytes by which they make a frame of `rows` x `columns` pixels and `strips` strips longer.
    #[must_use]
    pub const fn worst_case_len(&self, rows: usize, columns: usize, strips: usize) -> usize {
        let intensity =
            if self.intensity.is_some() { IntensityPlane::worst_case_len(rows * columns, strips) } else { 0 };
        let times = if self.times.is_some() { TimesPlane::worst_case_len(columns, strips) } else { 0 };
        intensity + times
    }

    /// Whether they are of an image like this.
    pub(crate) fn check<L: Level>(&self, image: ImageView<'_, L>) -> Result<(), ConfigError> {
        if let Some(times) = &self.times
            && times.columns() != image.columns()
        {
            return Err(ConfigError::Plane { found: times.columns(), expected: image.columns() });
        }
        let Some(intensity) = &self.intensity else { return Ok(()) };
        let (found, pixels) = (intensity.pixels(), image.pixels());
        if found != pixels {
            return Err(ConfigError::Plane { found, expected: pixels });
        }
        let (found, max) = (image.rows(), intensity.rows_max());
        if found > max { Err(ConfigError::CoderRows { found, max }) } else { Ok(()) }
    }

    /// Puts the sections behind the frame in the first `len` bytes of `out`, which is `image`'s and of that time; gives the new
    /// length.
    pub(crate) fn append<L: Level>(
        self,
        image: ImageView<'_, L>,
        timestamp_ns: u64,
        len: usize,
        out: &mut [u8],
    ) -> Result<usize, OutputFull> {
        let Self { intensity, times } = self;
        if intensity.is_none() && times.is_none() {
            return Ok(len);
        }
        let mut sections = Sections::open(out, len);
        if let Some(intensity) = intensity {
            sections.put(SectionKind::Intensity, |strips, body| intensity.encode(image, strips, body))?;
        }
        if let Some(times) = times {
            sections.put(SectionKind::Times, |strips, body| times.encode(timestamp_ns, strips, body))?;
        }
        sections.close()
    }
}

/// Behind a frame's strips, where sections are added.
struct Sections<'a> {
    out: &'a mut [u8],
    /// Bytes so far, without the checksum.
    len: usize,
}

impl<'a> Sections<'a> {
    fn open(out: &'a mut [u8], frame_len: usize) -> Self {
        Self { out, len: frame_len.saturating_sub(CHECKSUM_LEN) }
    }

    /// Adds a section, whose body `write` puts at the front of what it is lent.
    fn put(
        &mut self,
        kind: SectionKind,
        write: impl FnOnce(Strips<'_>, &mut [u8]) -> Result<usize, OutputFull>,
    ) -> Result<(), OutputFull> {
        let (frame, rest) = self.out.split_at_mut_checked(self.len).ok_or(OutputFull)?;
        let (head, body) = rest.split_at_mut_checked(SECTION_HEADER_LEN).ok_or(OutputFull)?;
        let body_len = write(Strips::of(frame), body)?;
        let [l0, l1, l2, l3] = u32::try_from(body_len).map_err(|_| OutputFull)?.to_le_bytes();
        head.copy_from_slice(&[kind as u8, 0, 0, 0, l0, l1, l2, l3]);
        self.len += SECTION_HEADER_LEN + body_len;
        Ok(())
    }

    fn close(self) -> Result<usize, OutputFull> {
        frame::seal_with_sections(self.out, self.len)
    }
}

/// Puts the section that says which frame is the one before behind all others of a frame; gives the frame's new length.
pub(crate) fn append_link(out: &mut [u8], frame_len: usize, link: &[u8]) -> Result<usize, OutputFull> {
    let mut sections = Sections::open(out, frame_len);
    sections.put(SectionKind::Previous, |_, body| Sink::new(body).put_all(link).map(|()| link.len()))?;
    sections.close()
}

/// Puts a section behind all others of a frame.
#[cfg(feature = "std")]
pub(crate) fn append_section(frame: &mut std::vec::Vec<u8>, kind: SectionKind, body: &[u8]) {
    let len = frame.len();
    frame.resize(len + SECTION_HEADER_LEN + body.len(), 0);
    let mut sections = Sections::open(frame, len);
    let put = sections.put(kind, |_, room| {
        room.get_mut(..body.len()).ok_or(OutputFull)?.copy_from_slice(body);
        Ok(body.len())
    });
    // It fits: there is room for exactly that.
    let _ = put.and_then(|()| sections.close());
}

/// First column and columns of each strip of a frame that this crate wrote.
#[derive(Debug, Clone)]
pub(crate) struct Strips<'a> {
    frame: &'a [u8],
    left: u16,
}

impl<'a> Strips<'a> {
    fn of(frame: &'a [u8]) -> Self {
        let u16_at = |at: usize| match frame.get(at..at + 2) {
            Some(&[low, high]) => u16::from_le_bytes([low, high]),
            _ => 0,
        };
        let (header_len, left) = (u16_at(frame::HEADER_LEN_AT), u16_at(frame::STRIPS_AT));
        Self { frame: frame.get(header_len.into()..).unwrap_or_default(), left }
    }
}

impl Iterator for Strips<'_> {
    type Item = (usize, usize);

    fn next(&mut self) -> Option<(usize, usize)> {
        self.left = self.left.checked_sub(1)?;
        let (&[f0, f1, c0, c1, p0, p1, p2, p3], rest) = self.frame.split_first_chunk::<STRIP_HEADER_LEN>()?;
        self.frame = rest.get(u32::from_le_bytes([p0, p1, p2, p3]) as usize..)?;
        Some((u16::from_le_bytes([f0, f1]).into(), u16::from_le_bytes([c0, c1]).into()))
    }
}

/// Puts each strip's part behind its length.
pub(crate) fn put_part(
    out: &mut [u8],
    at: usize,
    write: impl FnOnce(&mut [u8]) -> Result<usize, OutputFull>,
) -> Result<usize, OutputFull> {
    let (head, body) = out.get_mut(at..).and_then(|out| out.split_at_mut_checked(PART_HEADER_LEN)).ok_or(OutputFull)?;
    let len = write(body)?;
    head.copy_from_slice(&u32::try_from(len).map_err(|_| OutputFull)?.to_le_bytes());
    Ok(at + PART_HEADER_LEN + len)
}

#[cfg(feature = "std")]
pub(crate) mod decode;
