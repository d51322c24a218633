//! Wires the stages: points -> range image -> payload -> frame.

use crate::coder::Coder;
use crate::config::{Config, Scale};
use crate::error::{ConfigError, EncodeError};
use crate::frame::{self, Header};
use crate::geometry::UniformGrid;
use crate::image::{ImageView, ImageViewMut, Level, RangeImage};
use crate::insert::{farthest_m, insert};
use crate::point::Points;
use crate::quantize::Quantizer;
use crate::tally::Tally;

/// What the caller tells the receiver of a frame besides its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamp {
    /// Number of the frame.
    pub sequence: u32,
    /// Time of the frame, nanoseconds, of any epoch.
    pub timestamp_ns: u64,
}

/// An encoded frame's length, and what became of the points.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Encoded {
    /// Bytes written to the front of the output.
    pub len: usize,
    /// What became of every point.
    pub tally: Tally,
    /// Most that a kept point's range is off after decoding, meters.
    pub range_bound_m: f32,
}

/// A range image and a coder's state, to encode frames of `ROWS` x `COLS` without an allocator.
///
/// RAM: `ROWS * COLS * size_of::<L>() + size_of::<C>()` bytes, all zero when new, so that a `static` one lies in
/// `.bss` and costs no flash. `docs/PERFORMANCE.md` lists the sizes.
///
/// ```
/// use flicr::{Config, Encoder, Rle, Stamp};
/// let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
/// let points = [[10.0_f32, 0.0, -1.0], [0.0, 5.0, -0.5]];
/// let mut out = [0; Encoder::<64, 256, u8, Rle>::WORST_CASE_LEN];
/// let encoded = encoder.encode(&Config::UNIFORM, points.as_slice(), Stamp::default(), &mut out)?;
/// assert_eq!(encoded.tally.kept(), 2);
/// # Ok::<(), flicr::EncodeError>(())
/// ```
#[derive(Debug)]
pub struct Encoder<const ROWS: usize, const COLS: usize, L: Level, C> {
    image: RangeImage<ROWS, COLS, L>,
    coder: C,
}

impl<const ROWS: usize, const COLS: usize, L: Level, C> Encoder<ROWS, COLS, L, C> {
    /// An encoder with `coder`'s state.
    #[must_use]
    pub const fn new(coder: C) -> Self {
        Self { image: RangeImage::new(), coder }
    }

    /// The range image of the last frame.
    #[must_use]
    pub fn image(&self) -> ImageView<'_, L> {
        self.image.view()
    }
}

impl<const ROWS: usize, const COLS: usize, L: Level, C: Coder<L>> Encoder<ROWS, COLS, L, C> {
    /// Output bytes that are enough for every frame.
    pub const WORST_CASE_LEN: usize = frame::worst_case_len::<L, C>(ROWS * COLS);

    /// Encodes a whole scan to the front of `out`.
    ///
    /// # Errors
    /// [`EncodeError::OutputTooSmall`], never with [`WORST_CASE_LEN`](Self::WORST_CASE_LEN) bytes;
    /// [`EncodeError::Config`].
    pub fn encode<const NODES: usize>(
        &mut self,
        config: &Config<NODES>,
        points: &(impl Points + ?Sized),
        stamp: Stamp,
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError> {
        encode(config, points, stamp, self.image.view_mut(), &mut self.coder, out)
    }

    /// Begins a frame whose points come piece by piece.
    ///
    /// # Errors
    /// [`EncodeError::ScaleNeedsWholeScan`] unless `config`'s scale is fixed; [`EncodeError::Config`].
    pub fn start<const NODES: usize>(
        &mut self,
        config: &Config<NODES>,
        stamp: Stamp,
    ) -> Result<FrameEncoder<'_, L, C, NODES>, EncodeError> {
        FrameEncoder::start(config, stamp, self.image.view_mut(), &mut self.coder)
    }
}

/// Encodes a whole scan into a borrowed image of any size: what [`Encoder::encode`] calls.
///
/// # Errors
/// As [`Encoder::encode`].
pub fn encode<L: Level, C: Coder<L>, const NODES: usize>(
    config: &Config<NODES>,
    points: &(impl Points + ?Sized),
    stamp: Stamp,
    image: ImageViewMut<'_, L>,
    coder: &mut C,
    out: &mut [u8],
) -> Result<Encoded, EncodeError> {
    let scale = Scale::Fixed { max_range_m: max_range_m(config, points) };
    let mut frame = FrameEncoder::start(&Config { scale, ..*config }, stamp, image, coder)?;
    frame.insert(points);
    frame.finish(out)
}

/// Range of the largest level. A scan without a point, or with all of them nearer than floats can scale, gets a scale
/// of one meter: its frame is empty and says so.
fn max_range_m<const NODES: usize>(config: &Config<NODES>, points: &(impl Points + ?Sized)) -> f32 {
    match config.scale {
        Scale::Fixed { max_range_m } => max_range_m,
        Scale::PerFrame => {
            let farthest_m = farthest_m(points);
            if Quantizer::new(config.level_bits, farthest_m).is_ok() { farthest_m } else { 1.0 }
        }
    }
}

/// A frame whose points come piece by piece, in a borrowed image of any size.
///
/// ```
/// use flicr::{Config, Encoder, Rle, Scale, Stamp};
/// let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
/// let config = Config { scale: Scale::Fixed { max_range_m: 120.0 }, ..Config::UNIFORM };
/// let mut frame = encoder.start(&config, Stamp { sequence: 7, timestamp_ns: 0 })?;
/// frame.insert([[10.0_f32, 0.0, -1.0]].as_slice());
/// frame.insert([[0.0_f32, 5.0, -0.5, 0.2]].as_slice());
/// let mut out = [0; 1000];
/// assert_eq!(frame.finish(&mut out)?.tally.kept(), 2);
/// # Ok::<(), flicr::EncodeError>(())
/// ```
#[derive(Debug)]
pub struct FrameEncoder<'a, L: Level, C, const NODES: usize = 257> {
    grid: UniformGrid<NODES>,
    quantizer: Quantizer,
    config: Config<NODES>,
    stamp: Stamp,
    image: ImageViewMut<'a, L>,
    coder: &'a mut C,
    tally: Tally,
}

impl<'a, L: Level, C: Coder<L>, const NODES: usize> FrameEncoder<'a, L, C, NODES> {
    /// Empties `image` and begins a frame of its size.
    ///
    /// # Errors
    /// As [`Encoder::start`].
    pub fn start(
        config: &Config<NODES>,
        stamp: Stamp,
        mut image: ImageViewMut<'a, L>,
        coder: &'a mut C,
    ) -> Result<Self, EncodeError> {
        let Scale::Fixed { max_range_m } = config.scale else {
            return Err(EncodeError::ScaleNeedsWholeScan);
        };
        if !(L::BITS_MIN..=L::BITS).contains(&config.level_bits) {
            return Err(ConfigError::LevelBits { found: config.level_bits, min: L::BITS_MIN, max: L::BITS }.into());
        }
        let quantizer = Quantizer::new(config.level_bits, max_range_m)?;
        let view = image.as_view();
        let grid = UniformGrid::with_tables(view.rows(), view.columns(), config.view, config.tables)?;
        image.clear();
        Ok(Self { grid, quantizer, config: *config, stamp, image, coder, tally: Tally::new() })
    }

    /// Puts points into the image.
    pub fn insert(&mut self, points: &(impl Points + ?Sized)) {
        insert(points, &self.grid, &self.quantizer, self.config.policy, &mut self.image, &mut self.tally);
    }

    /// What became of the points so far.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Codes the image and writes the frame to the front of `out`.
    ///
    /// # Errors
    /// [`EncodeError::OutputTooSmall`]; nothing in `out` is a frame then.
    pub fn finish(self, out: &mut [u8]) -> Result<Encoded, EncodeError> {
        let (header, have) = (self.header(), out.len());
        let image = self.image.as_view();
        let worst_case = frame::worst_case_len::<L, C>(image.levels().len());
        let len = frame::write(header, image, self.coder, out);
        let len = len.map_err(|_| EncodeError::OutputTooSmall { have, worst_case })?;
        Ok(Encoded { len, tally: self.tally, range_bound_m: self.quantizer.range_bound_m() })
    }

    fn header(&self) -> Header {
        use crate::geometry::Projection;
        Header {
            sequence: self.stamp.sequence,
            timestamp_ns: self.stamp.timestamp_ns,
            rows: self.grid.rows(),
            columns: self.grid.columns(),
            quantizer: self.quantizer,
            coder: C::ID,
            returns: self.tally.returns(),
            view: self.config.view,
            placement: self.config.placement,
        }
    }
}
