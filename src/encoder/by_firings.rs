//! A frame with a column for every tick, cut down to the ticks at which the sensor fired: no list of them is needed before.

use super::{Encoded, FrameEncoder, OpenFrame};
use crate::coder::Coder;
use crate::config::LatticeConfig;
use crate::error::{ConfigError, EncodeError};
use crate::firings_config::FiringsConfig;
use crate::geometry::{FiringLattice, Firings};
use crate::image::{ImageView, ImageViewMut, Level};

/// Ticks that are looked at together.
const BITS: usize = u32::BITS as usize;

impl<L: Level, C: Coder<L>, const LINES: usize, const NODES: usize>
    FrameEncoder<'_, L, C, LatticeConfig<'_, LINES, NODES>>
{
    /// As [`finish`](Self::finish), with a column for each tick at which there was a return, where that leaves at least a
    /// quarter of them out: the frame that [`FiringsConfig`] makes of the same scan and ticks, from one pass over
    /// the points in place of two. Beams that fire at the same ticks are needed, as those of
    /// [`hdl64e::FIRING_GRID`](crate::geometry::sensors::hdl64e::FIRING_GRID); other scans become frames of all ticks.
    ///
    /// The image is moved together. `WORDS` is the turn's ticks divided by 32, rounded up; takes 10 bytes a word of
    /// stack.
    ///
    /// ```
    /// use flicr::geometry::{Lattice, sensors::hdl64e};
    /// use flicr::{FrameEncoder, ImageViewMut, LatticeConfig, Rle, Stamp};
    /// let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, 4000)?;
    /// let mut levels = vec![0_u16; 64 * 4000];
    /// let image = ImageViewMut::new(&mut levels, 4000).unwrap();
    /// let mut coder = Rle::new();
    /// let mut frame = FrameEncoder::start(&LatticeConfig::new(&lattice), Stamp::default(), image, &mut coder)?;
    /// frame.insert([[10.0_f32, 0.0, -1.0], [0.0, 10.0, -1.0]].as_slice());
    /// let mut out = [0; 1000];
    /// let encoded = frame.finish_by_firings::<125>(&mut out)?;
    /// assert_eq!(flicr::frame::parse_header(&out[..encoded.len]).unwrap().columns, 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`finish`](Self::finish); [`ConfigError::Ticks`] where the image has not a column a tick, or `WORDS` are too few;
    /// [`ConfigError::Strips`] where there are more strips than firings.
    pub fn finish_by_firings<const WORDS: usize>(self, out: &mut [u8]) -> Result<Encoded, EncodeError> {
        let (frame, mut image, coder) = self.into_parts();
        let every_tick = frame.config;
        let ticks = every_tick.lattice.grid().ticks;
        let fired_at = ticks_with_returns(image.as_view());
        if fired_at.clone().count() as u64 * 4 > u64::from(ticks) * 3 || fired_at.clone().next().is_none() {
            return frame.finish(image.as_view(), coder, out);
        }
        let firings = Firings::<WORDS>::new(ticks, fired_at)?;
        let lattice = FiringLattice::new(every_tick.lattice, &firings)?;
        let columns = firings.len();
        if every_tick.strips > columns {
            return Err(ConfigError::Strips { found: every_tick.strips, max: columns }.into());
        }
        let frame = OpenFrame {
            rows: frame.rows,
            columns,
            projection: lattice,
            quantizer: frame.quantizer,
            config: FiringsConfig { every_tick, firings: &firings },
            stamp: frame.stamp,
            tally: frame.tally,
            fit: frame.fit,
        };
        frame.finish(moved_together(&mut image, &firings, &lattice), coder, out)
    }
}

/// The columns that have a return in any row, ascending.
fn ticks_with_returns<L: Level>(image: ImageView<'_, L>) -> impl Iterator<Item = u32> + Clone {
    (0..image.columns()).step_by(BITS).flat_map(move |first| {
        let fired = fired(&image, first);
        (0..BITS).filter(move |bit| fired >> bit & 1 == 1).map(move |bit| (first + bit) as u32)
    })
}

/// Bit t for column `first` + t.
fn fired<L: Level>(image: &ImageView<'_, L>, first: usize) -> u32 {
    let mut largest = [L::NONE; BITS];
    for levels in image.row_levels() {
        let levels = levels.get(first..).unwrap_or_default();
        largest.iter_mut().zip(levels).for_each(|(largest, &level)| *largest = (*largest).max(level));
    }
    largest.iter().rev().fold(0, |fired, &level| fired << 1 | u32::from(level != L::NONE))
}

/// The columns of the firings alone, each row turned by its beam's shift.
fn moved_together<'a, L: Level, const LINES: usize, const WORDS: usize, const NODES: usize>(
    image: &'a mut ImageViewMut<'_, L>,
    firings: &Firings<WORDS>,
    lattice: &FiringLattice<'_, LINES, WORDS, NODES>,
) -> ImageView<'a, L> {
    let (ticks, columns) = (image.columns(), usize::from(firings.len()));
    let rows = image.as_view().rows();
    let levels = image.levels();
    for row in 0..rows {
        let mut to = row * columns;
        // `for_each` and no `for`: the iterator then is two plain loops.
        firings.iter().for_each(|tick| {
            let level = levels.get(row * ticks + tick as usize).copied().unwrap_or(L::NONE);
            // Never behind what is still to be read: a row has fewer firings than ticks.
            if let Some(to) = levels.get_mut(to) {
                *to = level;
            }
            to += 1;
        });
        if let Some(row_levels) = levels.get_mut(row * columns..to) {
            row_levels.rotate_right(lattice.shift(row) % row_levels.len().max(1));
        }
    }
    ImageView::whole(levels.get(..rows * columns).unwrap_or_default(), columns)
}
