//! Wires the stages: points -> range image -> payload -> frame.

use crate::coder::{Coder, CoderId};
use crate::config::{Config, LatticeConfig, Settings, quantizer};
use crate::error::{ConfigError, EncodeError};
use crate::fit::GridFit;
use crate::frame::{self, GeometryFields, Header};
use crate::geometry::{OnRows, Projection};
use crate::image::{ImageView, ImageViewMut, Level, RangeImage};
use crate::insert::{farthest_m, insert};
use crate::point::{BLOCK_LEN, Points};
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
    /// How far the points are off the sensor's grid, where [`LatticeConfig::measure`] asked for it.
    pub fit: GridFit,
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
    pub fn encode(
        &mut self,
        config: &impl Settings,
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
    pub fn start<S: Settings>(&mut self, config: &S, stamp: Stamp) -> Result<FrameEncoder<'_, L, C, S>, EncodeError> {
        FrameEncoder::start(config, stamp, self.image.view_mut(), &mut self.coder)
    }
}

/// Encodes a whole scan into a borrowed image of any size: what [`Encoder::encode`] calls.
///
/// # Errors
/// As [`Encoder::encode`].
pub fn encode<L: Level, C: Coder<L>>(
    config: &impl Settings,
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
pub struct FrameEncoder<'a, L: Level, C, S: Settings = Config> {
    frame: OpenFrame<S>,
    image: ImageViewMut<'a, L>,
    coder: &'a mut C,
}

impl<'a, L: Level, C: Coder<L>, S: Settings> FrameEncoder<'a, L, C, S> {
    /// Empties `image` and begins a frame of its size.
    ///
    /// # Errors
    /// As [`Encoder::start`].
    pub fn start(
        config: &S,
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

    /// How far the points are off the sensor's grid so far; empty where that is not measured.
    #[must_use]
    pub fn fit(&self) -> GridFit {
        self.frame.fit.into()
    }

    /// Codes the image and writes the frame to the front of `out`.
    ///
    /// # Errors
    /// [`EncodeError::OutputTooSmall`]; [`ConfigError::CoderRows`]. Nothing in `out` is a frame then.
    pub fn finish(self, out: &mut [u8]) -> Result<Encoded, EncodeError> {
        self.frame.finish(self.image.as_view(), self.coder, out)
    }
}

impl<L: Level, C: Coder<L>, const LINES: usize, const NODES: usize>
    FrameEncoder<'_, L, C, LatticeConfig<'_, LINES, NODES>>
{
    /// Puts points into the image whose beams are known: from a file's ring numbers or its order. Where one of the two
    /// is longer, its rest is left out; points of a row that there is not are counted as out of view or clamped.
    pub fn insert_on_rows(&mut self, points: &[[f32; 3]], rows: &[u16]) {
        let OpenFrame { config, quantizer, tally, fit, .. } = &mut self.frame;
        let lattice = config.lattice;
        for (points, rows) in points.chunks(BLOCK_LEN).zip(rows.chunks(BLOCK_LEN)) {
            let points = &points[..points.len().min(rows.len())];
            insert(points, &OnRows { lattice, rows }, quantizer, config.policy, &mut self.image, tally);
            if config.measure {
                let pairs = points.iter().zip(rows);
                pairs.for_each(|(&point, &row)| fit.add_one(lattice, quantizer, point, Some(row)));
            }
        }
    }
}

/// A frame between its first point and its bytes. The image and the coder are lent to each step, so that a frame can
/// stay open in memory that is not Rust's to borrow (the C ABI's).
#[derive(Debug, Clone, Copy)]
pub(crate) struct OpenFrame<S: Settings = Config> {
    projection: S::Projection,
    quantizer: Quantizer,
    config: S,
    stamp: Stamp,
    tally: Tally,
    fit: S::Fit,
}

impl<S: Settings> OpenFrame<S> {
    /// Empties `image` and begins a frame of its size.
    pub(crate) fn start<L: Level>(
        config: &S,
        stamp: Stamp,
        image: &mut ImageViewMut<'_, L>,
    ) -> Result<Self, EncodeError> {
        Self::begin(config, || None, stamp, image)
    }

    /// Begins a frame with the scale that the configuration and the scan ask for, and puts the scan into `image`.
    pub(crate) fn of_scan<L: Level>(
        config: &S,
        points: &(impl Points + ?Sized),
        stamp: Stamp,
        image: &mut ImageViewMut<'_, L>,
    ) -> Result<Self, EncodeError> {
        let mut frame = Self::begin(config, || Some(farthest_m(points)), stamp, image)?;
        frame.insert(points, image);
        Ok(frame)
    }

    fn begin<L: Level>(
        config: &S,
        farthest_m: impl FnOnce() -> Option<f32>,
        stamp: Stamp,
        image: &mut ImageViewMut<'_, L>,
    ) -> Result<Self, EncodeError> {
        let view = image.as_view();
        let frame = Self::new::<L>(config, farthest_m, stamp, view.rows(), view.columns())?;
        image.clear();
        Ok(frame)
    }

    /// A frame of `rows` x `columns` levels `L`, or what is wrong with the configuration.
    pub(crate) fn new<L: Level>(
        config: &S,
        farthest_m: impl FnOnce() -> Option<f32>,
        stamp: Stamp,
        rows: usize,
        columns: usize,
    ) -> Result<Self, EncodeError> {
        let (found, scale) = config.levels();
        if !(L::BITS_MIN..=L::BITS).contains(&found) {
            return Err(ConfigError::LevelBits { found, min: L::BITS_MIN, max: L::BITS }.into());
        }
        let quantizer = quantizer((found, scale), farthest_m)?;
        let projection = config.projection(rows, columns)?;
        Ok(Self { projection, quantizer, config: *config, stamp, tally: Tally::new(), fit: S::Fit::default() })
    }

    /// Puts points into the image that the frame was started with.
    pub(crate) fn insert<L: Level>(&mut self, points: &(impl Points + ?Sized), image: &mut ImageViewMut<'_, L>) {
        insert(points, &self.projection, &self.quantizer, self.config.policy(), image, &mut self.tally);
        self.config.measure(points, &self.quantizer, &mut self.fit);
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
        let found = image.rows();
        if found > C::ROWS_MAX {
            return Err(ConfigError::CoderRows { found, max: C::ROWS_MAX }.into());
        }
        let (header, have) = (self.header(C::ID, coder.error_max()), out.len());
        let worst_case = frame::worst_case_len::<L, C>(image.levels().len()) + header.more_than_uniform();
        let len = frame::write(header, image, coder, out);
        let len = len.map_err(|_| EncodeError::OutputTooSmall { have, worst_case })?;
        Ok(Encoded { len, tally: self.tally, range_bound_m: header.range_bound_m(), fit: self.fit.into() })
    }

    fn header(&self, coder: CoderId, error_max: u16) -> Header<S::Fields> {
        Header {
            sequence: self.stamp.sequence,
            timestamp_ns: self.stamp.timestamp_ns,
            rows: self.projection.rows(),
            columns: self.projection.columns(),
            quantizer: self.quantizer,
            coder,
            error_max,
            returns: self.tally.returns(),
            geometry: self.config.fields(&self.fit).off_by(f32::from(error_max) * self.quantizer.step_m()),
        }
    }
}
