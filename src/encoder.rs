//! Wires the stages: points -> range image -> payload -> frame.

use crate::coder::{Coder, CoderId};
use crate::config::{Config, Scale};
use crate::error::{ConfigError, EncodeError};
use crate::frame::{self, Header};
use crate::geometry::{Placement, UniformGrid};
use crate::image::{ImageView, ImageViewMut, Level, RangeImage};
use crate::insert::{Policy, farthest_m, insert};
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

    /// As [`encode`](Self::encode), into a vector of fixed capacity, whose length becomes the frame's: to pass frames on
    /// through a queue.
    ///
    /// ```
    /// use flicr::{Config, Encoder, Rle, Stamp};
    /// let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
    /// let mut frame = heapless::Vec::<u8, 2048>::new();
    /// encoder.encode_into(&Config::UNIFORM, [[10.0_f32, 0.0, -1.0]].as_slice(), Stamp::default(), &mut frame)?;
    /// assert!(frame.starts_with(b"FLCR"));
    /// # Ok::<(), flicr::EncodeError>(())
    /// ```
    ///
    /// # Errors
    /// As [`encode`](Self::encode); the vector is empty then.
    pub fn encode_into<const N: usize, const NODES: usize>(
        &mut self,
        config: &Config<NODES>,
        points: &(impl Points + ?Sized),
        stamp: Stamp,
        out: &mut heapless::Vec<u8, N>,
    ) -> Result<Encoded, EncodeError> {
        // Never fails: the length asked for is the capacity.
        let _ = out.resize_default(N);
        let encoded = self.encode(config, points, stamp, out);
        out.truncate(encoded.map_or(0, |encoded| encoded.len));
        encoded
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
    mut image: ImageViewMut<'_, L>,
    coder: &mut C,
    out: &mut [u8],
) -> Result<Encoded, EncodeError> {
    OpenFrame::of_scan(config, points, stamp, &mut image)?.finish(image.as_view(), coder, out)
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
    frame: OpenFrame<NODES>,
    image: ImageViewMut<'a, L>,
    coder: &'a mut C,
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
        let frame = OpenFrame::start(config, stamp, &mut image)?;
        Ok(Self { frame, image, coder })
    }

    /// Puts points into the image.
    pub fn insert(&mut self, points: &(impl Points + ?Sized)) {
        self.frame.insert(points, &mut self.image);
    }

    /// What became of the points so far.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        self.frame.tally()
    }

    /// Codes the image and writes the frame to the front of `out`.
    ///
    /// # Errors
    /// [`EncodeError::OutputTooSmall`]; nothing in `out` is a frame then.
    pub fn finish(self, out: &mut [u8]) -> Result<Encoded, EncodeError> {
        self.frame.finish(self.image.as_view(), self.coder, out)
    }
}

/// A frame between its first point and its bytes. The image and the coder are lent to each step, so that a frame can
/// stay open in memory that is not Rust's to borrow (the C ABI's).
#[derive(Debug, Clone, Copy)]
pub(crate) struct OpenFrame<const NODES: usize = 257> {
    grid: UniformGrid<NODES>,
    quantizer: Quantizer,
    placement: Placement,
    policy: Policy,
    stamp: Stamp,
    tally: Tally,
}

impl<const NODES: usize> OpenFrame<NODES> {
    /// Empties `image` and begins a frame of its size.
    pub(crate) fn start<L: Level>(
        config: &Config<NODES>,
        stamp: Stamp,
        image: &mut ImageViewMut<'_, L>,
    ) -> Result<Self, EncodeError> {
        let Scale::Fixed { max_range_m } = config.scale else {
            return Err(EncodeError::ScaleNeedsWholeScan);
        };
        let view = image.as_view();
        let frame = Self::new::<L>(config, max_range_m, stamp, view.rows(), view.columns())?;
        image.clear();
        Ok(frame)
    }

    /// Begins a frame with the scale that the configuration and the scan ask for, and puts the scan into `image`.
    pub(crate) fn of_scan<L: Level>(
        config: &Config<NODES>,
        points: &(impl Points + ?Sized),
        stamp: Stamp,
        image: &mut ImageViewMut<'_, L>,
    ) -> Result<Self, EncodeError> {
        let scale = Scale::Fixed { max_range_m: max_range_m(config, points) };
        let mut frame = Self::start(&Config { scale, ..*config }, stamp, image)?;
        frame.insert(points, image);
        Ok(frame)
    }

    /// A frame of `rows` x `columns` levels `L`, or what is wrong with the configuration.
    pub(crate) fn new<L: Level>(
        config: &Config<NODES>,
        max_range_m: f32,
        stamp: Stamp,
        rows: usize,
        columns: usize,
    ) -> Result<Self, ConfigError> {
        if !(L::BITS_MIN..=L::BITS).contains(&config.level_bits) {
            return Err(ConfigError::LevelBits { found: config.level_bits, min: L::BITS_MIN, max: L::BITS });
        }
        let quantizer = Quantizer::new(config.level_bits, max_range_m)?;
        let grid = UniformGrid::with_tables(rows, columns, config.view, config.tables)?;
        let (placement, policy) = (config.placement, config.policy);
        Ok(Self { grid, quantizer, placement, policy, stamp, tally: Tally::new() })
    }

    /// Puts points into the image that the frame was started with.
    pub(crate) fn insert<L: Level>(&mut self, points: &(impl Points + ?Sized), image: &mut ImageViewMut<'_, L>) {
        insert(points, &self.grid, &self.quantizer, self.policy, image, &mut self.tally);
    }

    pub(crate) const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Codes the image and writes the frame to the front of `out`.
    pub(crate) fn finish<L: Level, C: Coder<L>>(
        &self,
        image: ImageView<'_, L>,
        coder: &mut C,
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError> {
        let have = out.len();
        let worst_case = frame::worst_case_len::<L, C>(image.levels().len());
        let len = frame::write(self.header(C::ID), image, coder, out);
        let len = len.map_err(|_| EncodeError::OutputTooSmall { have, worst_case })?;
        Ok(Encoded { len, tally: self.tally, range_bound_m: self.quantizer.range_bound_m() })
    }

    fn header(&self, coder: CoderId) -> Header {
        use crate::geometry::Projection;
        Header {
            sequence: self.stamp.sequence,
            timestamp_ns: self.stamp.timestamp_ns,
            rows: self.grid.rows(),
            columns: self.grid.columns(),
            quantizer: self.quantizer,
            coder,
            returns: self.tally.returns(),
            view: *self.grid.view(),
            placement: self.placement,
        }
    }
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
