//! The mirror image of the encoder: frame -> payload -> range image -> points.

mod frame;
mod levels;
mod rows;

use std::vec::Vec;

use crate::error::{DecodeError, HeaderField, LimitKind};
use crate::frame::{BeamsGeometry, ColumnMode, Geometry, ParsedFrame};
use crate::geometry::{Beam, SensorGrid, Sphere, Spread, Turn, sensors};
use crate::plane::decode::DecodedPlanes;
use crate::previous;
use crate::previous::before::Before;

pub use frame::Frame;
pub use levels::Levels;

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
        let parsed = crate::frame::parse(bytes)?;
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
