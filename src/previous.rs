//! Frames that go on from the frame before: for sensors that stand still.
//!
//! The encoder keeps the levels of its last frame as the decoder knows them; strips of the next may be coded by what was at the
//! same place, and are where that makes them shorter. Every so many frames a **key frame** needs none before it.

use crate::coder::Coder;
use crate::coder::context::Recall;
use crate::config::FrameSettings;
use crate::encoder::{Encoded, FrameEncoder, OpenFrame};
use crate::error::{ConfigError, EncodeError};
use crate::frame::CHECKSUM_LEN;
use crate::image::{ImageView, ImageViewMut, Level};
use crate::plane::{Planes, SECTION_HEADER_LEN, append_link};

#[cfg(feature = "std")]
pub(crate) mod before;

/// Bytes of what says which frame is the one before; nothing does in a key frame.
pub(crate) const LINK_LEN: usize = 12;

/// What a frame says of the frame before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Link {
    /// Frames since the key frame; 0 for a key frame itself.
    pub distance: u32,
    /// Sequence number of the key frame.
    pub key: u32,
    /// Checksum at the end of the frame before; 0 for a key frame.
    pub checksum: u32,
}

impl Link {
    /// The section's body; a key frame's is empty.
    pub(crate) fn bytes(self) -> [u8; LINK_LEN] {
        bytemuck::cast([self.distance.to_le_bytes(), self.key.to_le_bytes(), self.checksum.to_le_bytes()])
    }

    #[cfg(feature = "std")]
    pub(crate) fn from_bytes(bytes: [u8; LINK_LEN]) -> Self {
        let [distance, key, checksum] = bytemuck::cast::<_, [[u8; 4]; 3]>(bytes).map(u32::from_le_bytes);
        Self { distance, key, checksum }
    }
}

/// An encoder's memory of its last frame, for [`FrameEncoder::finish_after`], in numbers that are the caller's: an array, a
/// vector or a slice.
///
/// RAM: 2 bytes a pixel, and 4 a column where columns are a sensor's firings ([`memory_len`](Self::memory_len)). An array makes
/// it all zeros but for a few bytes.
#[derive(Debug, Clone)]
pub struct Previous<M> {
    /// Levels in rows of `columns_max`; behind them the ticks of the columns, and where each lay before.
    memory: M,
    columns_max: usize,
    every: u32,
    last: Option<Last>,
}

/// The frame that the memory holds.
#[derive(Debug, Clone, Copy)]
struct Last {
    rows: usize,
    columns: usize,
    firings: usize,
    step_m: f32,
    link: Link,
    /// Frames since the last that had to be a key frame.
    since: u32,
    /// Whether the next is tried by this one: this one gained, or had to be a key frame.
    is_tried: bool,
}

/// Bytes by which going on from the frame before makes a frame longer, at most.
pub(crate) const LINK_WORST_CASE_LEN: usize = SECTION_HEADER_LEN + LINK_LEN;

impl<M> Previous<M> {
    /// Bytes by which it makes a frame longer, at most.
    pub const WORST_CASE_LEN: usize = LINK_WORST_CASE_LEN;

    /// Numbers that images of so many rows and up to so many columns take; `by_firings` where columns are a sensor's firings.
    #[must_use]
    pub const fn memory_len(rows: usize, columns_max: usize, by_firings: bool) -> usize {
        (rows + if by_firings { 2 } else { 0 }) * columns_max
    }

    /// Memory for images of up to `columns_max` columns. Every `every`th frame is a key frame (0 counts as 1). What the memory
    /// holds does not matter.
    #[must_use]
    pub const fn new(memory: M, columns_max: usize, every: u32) -> Self {
        Self { memory, columns_max, every, last: None }
    }

    /// Has the next frame be a key frame: when the receiver has lost one.
    pub const fn forget(&mut self) {
        self.last = None;
    }
}

impl<M: AsMut<[u16]>> Previous<M> {
    /// The frame before the next, if that needs not be a key frame; the memory is made ready for its columns.
    fn next(&mut self, next: &Last, settings: &impl FrameSettings) -> Result<Option<Last>, ConfigError> {
        let (memory, columns_max) = (self.memory.as_mut(), self.columns_max);
        let (found, expected) = (memory.len(), Self::memory_len(next.rows, columns_max, next.firings > 0));
        if found < expected || next.columns > columns_max {
            return Err(ConfigError::Plane { found, expected: expected.max(next.rows * next.columns) });
        }
        let (levels, rest) = memory.split_at_mut(next.rows * columns_max);
        let (ticks, map) = rest.split_at_mut(if next.firings > 0 { columns_max } else { 0 });
        let fits = |last: &Last| {
            let is_alike = last.rows == next.rows && last.step_m.to_bits() == next.step_m.to_bits();
            is_alike && (last.columns == next.columns || last.firings > 0) && (last.firings > 0) == (next.firings > 0)
        };
        let last = self.last.take().filter(fits).filter(|last| last.since + 1 < self.every);
        if let Some(last) = &last
            && next.firings > 0
        {
            let (mut places, mut at) = (map.iter_mut(), 0);
            settings.for_each_firing(&mut |tick| {
                at = nearest(ticks.get(..last.firings).unwrap_or_default(), at, tick);
                places.next().into_iter().for_each(|place| *place = at as u16);
            });
            let map = map.get(..next.firings).unwrap_or_default();
            levels.chunks_exact_mut(columns_max).for_each(|row| move_columns(row, map));
        }
        let mut places = ticks.iter_mut();
        settings.for_each_firing(&mut |tick| places.next().into_iter().for_each(|place| *place = tick as u16));
        if last.is_none() {
            levels.fill(0);
        }
        Ok(last)
    }
}

/// Which of the ascending ticks is nearest to one, the earlier of two; from a place on that is not behind it.
pub(crate) fn nearest(ticks: &[u16], from: usize, tick: u32) -> usize {
    let off = |at: usize| ticks.get(at).map(|&other| u32::from(other).abs_diff(tick));
    let mut at = from;
    while let (Some(here), Some(next)) = (off(at), off(at + 1))
        && next < here
    {
        at += 1;
    }
    at
}

/// Gives each column what was at its place in the ascending `map`, in place. Where that lies behind, the first pass reads what
/// none has written, for it goes the same way; where it lies before, so does the second: places that the first has written are
/// none that the second reads, for `map` ascends.
fn move_columns(row: &mut [u16], map: &[u16]) {
    let mut copy = |(to, &from): (usize, &u16), is_behind: bool| {
        let from = usize::from(from);
        if (from > to) == is_behind
            && let Some(&level) = row.get(from)
            && let Some(place) = row.get_mut(to)
        {
            *place = level;
        }
    };
    map.iter().enumerate().for_each(|column| copy(column, true));
    map.iter().enumerate().rev().for_each(|column| copy(column, false));
}

impl<L: Level, C: Coder<L>, S: FrameSettings> FrameEncoder<'_, L, C, S> {
    /// As [`finish_with`](Self::finish_with), and strips are coded by what the frame before had at the same place, if that makes
    /// them shorter: for sensors that stand still, the small and the dense context coder, and receivers that get every frame. A
    /// strip is never longer than without, a frame eight bytes, or [`Previous::WORST_CASE_LEN`] less what its strips save.
    ///
    /// A decoder refuses a frame whose frame before it has not decoded last, until a key frame comes. Takes twice as long,
    /// three times where nothing is gained; where no strip of a frame gained, the frame is a key frame, and none is tried until
    /// the next that must be one.
    ///
    /// ```
    /// use flicr::coder::ContextSettings;
    /// use flicr::geometry::sensors::velodyne;
    /// use flicr::plane::Planes;
    /// use flicr::{Encoder, GridConfig, GridReturn, Previous, Small, Stamp};
    /// let mut encoder: Encoder<16, 900, u16, Small> = Encoder::new(Small::new(ContextSettings::FINE));
    /// let mut previous = Previous::new([0; 16 * 900], 900, 10);
    /// let mut out = vec![0; 30_000];
    /// let mut lens = [0; 2];
    /// for len in &mut lens {
    ///     let mut frame = encoder.start(&GridConfig::new(velodyne::VLP16.grid(), 900), Stamp::default())?;
    ///     let walls = (0..14_400).map(|n| GridReturn { row: n % 16, tick: u32::from(n / 16) * 40, count: 900 + 7919 * u32::from(n) % 800 });
    ///     frame.insert_returns(walls);
    ///     *len = frame.finish_after(&mut previous, Planes::default(), &mut out)?.len;
    /// }
    /// assert!(4 * lens[1] < lens[0]);
    /// # Ok::<(), flicr::EncodeError>(())
    /// ```
    ///
    /// # Errors
    /// As [`finish_with`](Self::finish_with); [`ConfigError::Plane`] where the memory has no room for the image. The next frame is
    /// a key frame then.
    pub fn finish_after(
        self,
        previous: &mut Previous<impl AsMut<[u16]>>,
        planes: Planes<'_>,
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError> {
        let (frame, image, coder) = self.into_parts();
        finish_after(&frame, image.as_view(), coder, previous, planes, out)
    }
}

fn finish_after<L: Level, C: Coder<L>, S: FrameSettings>(
    frame: &OpenFrame<S>,
    image: ImageView<'_, L>,
    coder: &mut C,
    previous: &mut Previous<impl AsMut<[u16]>>,
    planes: Planes<'_>,
    out: &mut [u8],
) -> Result<Encoded, EncodeError> {
    let (settings, key) = (frame.settings(), frame.stamp().sequence);
    let mut firings = 0;
    settings.for_each_firing(&mut |_| firings += 1);
    let link = Link { distance: 0, key, checksum: 0 };
    let (rows, columns, step_m) = (image.rows(), image.columns(), frame.step_m());
    let key = Last { rows, columns, firings, step_m, link, since: 0, is_tried: true };
    let last = previous.next(&key, settings)?;
    let is_tried = last.is_some_and(|last| last.is_tried);
    let columns_max = previous.columns_max;
    let memory = previous.memory.as_mut().get_mut(..rows * columns_max);
    let memory = memory.and_then(|levels| ImageViewMut::new(levels, columns_max));
    let mut recall = Recall::new(memory.ok_or(ConfigError::Plane { found: 0, expected: rows })?, is_tried);
    let encode = |coder: &mut C, strip: ImageView<'_, L>, first: usize, out: &mut [u8]| {
        recall.first = first;
        coder.encode_after(strip, &mut recall, out)
    };
    let encoded = frame.finish_by(image, coder, planes, out, encode)?;
    let next = after(last, key, recall.is_used);
    let too_small = |have: usize| EncodeError::OutputTooSmall { have, worst_case: encoded.len + LINK_WORST_CASE_LEN };
    let have = out.len();
    let link = next.link.bytes();
    let link = if next.link.distance > 0 { link.as_slice() } else { &[] };
    let len = append_link(out, encoded.len, link).map_err(|_| too_small(have))?;
    let checksum = checksum_of(out, len).ok_or(too_small(have))?;
    previous.last = Some(Last { link: Link { checksum, ..next.link }, ..next });
    Ok(Encoded { len, ..encoded })
}

/// What a frame is: one that nothing of the frame before was used in needs none, and says no more than a key frame.
fn after(last: Option<Last>, key: Last, is_used: bool) -> Last {
    match last {
        Some(Last { link, since, .. }) if is_used => {
            Last { link: Link { distance: link.distance + 1, ..link }, since: since + 1, ..key }
        }
        Some(Last { since, .. }) => Last { since: since + 1, is_tried: false, ..key },
        None => key,
    }
}

/// The last four bytes of a frame.
pub(crate) fn checksum_of(bytes: &[u8], len: usize) -> Option<u32> {
    let end = bytes.get(len.checked_sub(CHECKSUM_LEN)?..len)?;
    Some(u32::from_le_bytes(*end.first_chunk()?))
}
