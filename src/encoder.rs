//! Wires the stages: points -> range image -> payload -> frame.

mod by_firings;
mod frame;
mod open;

use crate::coder::{Coder, DeflateDefault};
use crate::config::{FrameSettings, Settings};
use crate::error::EncodeError;
use crate::fit::GridFit;
use crate::image::{ImageView, ImageViewMut, Level, RangeImage};
use crate::point::Points;
use crate::tally::Tally;

pub use frame::FrameEncoder;
pub(crate) use open::OpenFrame;

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
    /// How far the points are off the sensor's grid, where [`LatticeConfig::measure`](crate::LatticeConfig::measure) asked for it.
    pub fit: GridFit,
}

impl Encoded {
    /// To be written over.
    pub(crate) const NONE: Self = Self { len: 0, tally: Tally::new(), range_bound_m: 0.0, fit: GridFit::new() };
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

/// The paper's frame of 4500 columns (0.08 degrees each), the largest.
///
/// All six take the coder first (DEFLATE unless told otherwise), then the levels' type (`u8`); the presets' view is the
/// HDL-64E's.
///
/// ```
/// use flicr::{Config, DeflateSmall, Encoder256x64, Stamp};
/// let mut encoder = Encoder256x64::<DeflateSmall>::new(DeflateSmall::new());
/// let mut out = vec![0; Encoder256x64::<DeflateSmall>::WORST_CASE_LEN];
/// let encoded = encoder.encode(&Config::PAPER, [[10.0_f32, 0.0, -1.0]].as_slice(), Stamp::default(), &mut out)?;
/// assert_eq!((encoded.tally.kept(), encoder.image().columns()), (1, 256));
/// # Ok::<(), flicr::EncodeError>(())
/// ```
pub type Encoder4500x64<C = DeflateDefault, L = u8> = Encoder<64, 4500, L, C>;
/// The paper's frame of 4096 columns.
pub type Encoder4096x64<C = DeflateDefault, L = u8> = Encoder<64, 4096, L, C>;
/// The paper's frame of 2048 columns.
pub type Encoder2048x64<C = DeflateDefault, L = u8> = Encoder<64, 2048, L, C>;
/// The paper's frame of 1024 columns.
pub type Encoder1024x64<C = DeflateDefault, L = u8> = Encoder<64, 1024, L, C>;
/// The paper's frame of 512 columns.
pub type Encoder512x64<C = DeflateDefault, L = u8> = Encoder<64, 512, L, C>;
/// The paper's frame of 256 columns, the smallest: for parts with 64 KB of RAM, with
/// [`DeflateSmall`](crate::DeflateSmall).
pub type Encoder256x64<C = DeflateDefault, L = u8> = Encoder<64, 256, L, C>;

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
    /// Output bytes that are enough for every frame of one strip.
    pub const WORST_CASE_LEN: usize = crate::frame::worst_case_len::<L, C>(ROWS * COLS);

    /// Output bytes that are enough for every frame of `strips` strips.
    #[must_use]
    pub const fn worst_case_len_in_strips(strips: u16) -> usize {
        crate::frame::worst_case_len_in_strips::<L, C>(ROWS, COLS, strips)
    }

    /// Encodes a whole scan to the front of `out`.
    ///
    /// # Errors
    /// [`EncodeError::OutputTooSmall`], never with [`WORST_CASE_LEN`](Self::WORST_CASE_LEN) bytes and a frame of one strip;
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
    pub fn encode_into<const N: usize>(
        &mut self,
        config: &impl Settings,
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
    pub fn start<S: FrameSettings>(
        &mut self,
        config: &S,
        stamp: Stamp,
    ) -> Result<FrameEncoder<'_, L, C, S>, EncodeError> {
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
