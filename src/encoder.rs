//! Wires the stages: points -> range image -> payload -> frame.

mod by_firings;

use crate::beside::Beside;
use crate::coder::{Coder, CoderId, DeflateDefault, OutputFull};
use crate::config::{Config, FrameSettings, GridSettings, LatticeConfig, Settings, quantizer};
use crate::error::{ConfigError, EncodeError};
use crate::firings_config::FiringsConfig;
use crate::fit::GridFit;
use crate::frame::{self, GeometryFields, Header};
use crate::image::{ImageView, ImageViewMut, Level, RangeImage};
use crate::insert::{Along, Numbers, farthest_m, insert};
use crate::packet::Column;
use crate::plane::Planes;
use crate::point::Points;
use crate::quantize::Quantizer;
use crate::returns::{GridReturn, ReturnScale};
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
    pub const WORST_CASE_LEN: usize = frame::worst_case_len::<L, C>(ROWS * COLS);

    /// Output bytes that are enough for every frame of `strips` strips.
    #[must_use]
    pub const fn worst_case_len_in_strips(strips: u16) -> usize {
        frame::worst_case_len_in_strips::<L, C>(ROWS, COLS, strips)
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
pub struct FrameEncoder<'a, L: Level, C, S: FrameSettings = Config> {
    frame: OpenFrame<S>,
    /// Known when the first firing comes.
    scale: Option<ReturnScale>,
    image: ImageViewMut<'a, L>,
    coder: &'a mut C,
}

impl<'a, L: Level, C: Coder<L>, S: FrameSettings> FrameEncoder<'a, L, C, S> {
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
        Ok(Self { frame, scale: None, image, coder })
    }

    /// As [`start`](Self::start), with the scale that `config` and these points ask for; they are yet to be inserted.
    ///
    /// # Errors
    /// [`EncodeError::Config`].
    pub fn start_for(
        config: &S,
        points: &(impl Points + ?Sized),
        stamp: Stamp,
        mut image: ImageViewMut<'a, L>,
        coder: &'a mut C,
    ) -> Result<Self, EncodeError>
    where
        S: Settings,
    {
        let frame = OpenFrame::begin(config, || Some(farthest_m(points)), stamp, &mut image)?;
        Ok(Self { frame, scale: None, image, coder })
    }

    /// Puts points into the image.
    pub fn insert(&mut self, points: &(impl Points + ?Sized))
    where
        S: Settings,
    {
        self.frame.insert(points, &mut self.image, ());
    }

    /// As [`insert`](Self::insert), with an intensity for each point: `number_of` gives that of the point at an index of
    /// `points`, and where a pixel keeps the point, it goes into `plane`, which has a number for every pixel. To be
    /// finished by [`finish_with`](Self::finish_with).
    pub fn insert_lit(&mut self, points: &(impl Points + ?Sized), number_of: impl FnMut(usize) -> u8, plane: &mut [u8])
    where
        S: Settings,
    {
        self.frame.insert(points, &mut self.image, Numbers { of: number_of, first: 0, plane });
    }

    /// Puts returns into the image, in their sensor's own integers: each into the pixel that its point would get, its
    /// level within a rounding of the range count. Returns on a beam or tick that the grid does not have are counted as
    /// out of view, those of count 0 as no return.
    pub fn insert_returns<R: Into<GridReturn>>(&mut self, returns: impl IntoIterator<Item = R>)
    where
        S: GridSettings,
    {
        self.frame.insert_returns(returns, &mut self.image);
    }

    /// As [`insert_returns`](Self::insert_returns), with an intensity for each return, which goes into `plane` as with
    /// [`insert_lit`](Self::insert_lit).
    pub fn insert_lit_returns<R: Into<GridReturn>>(
        &mut self,
        returns: impl IntoIterator<Item = (R, u8)>,
        plane: &mut [u8],
    ) where
        S: GridSettings,
    {
        let returns = returns.into_iter().map(|(found, number)| (found.into(), number));
        self.frame.insert_returns_with(returns, &mut self.image, |pixel, number| keep(plane, pixel, number));
    }

    /// Puts one firing of a sensor's packet into the image: as [`insert_returns`](Self::insert_returns) does its cells,
    /// in a loop made for the packet's format. A whole stream of packets is [`PacketEncoder`](crate::PacketEncoder)'s.
    ///
    /// ```
    /// use flicr::geometry::sensors::velodyne;
    /// use flicr::packet::{Event, ReturnPolicy, Sensor, TurnAssembler};
    /// use flicr::{Encoder, GridConfig, Rle, Stamp};
    /// let mut encoder: Encoder<16, 1800, u16, Rle> = Encoder::new(Rle::new());
    /// let mut frame = encoder.start(&GridConfig::new(velodyne::VLP16.grid(), 1800), Stamp::default())?;
    /// let mut turns = TurnAssembler::new(Sensor::Auto, ReturnPolicy::Strongest);
    /// # let datagram = [0; 100];
    /// let _ = turns.push(&datagram, |event| {
    ///     if let Event::Column(column) = event {
    ///         frame.insert_column(&column);
    ///     }
    /// });
    /// # Ok::<(), flicr::EncodeError>(())
    /// ```
    pub fn insert_column(&mut self, column: &Column<'_>)
    where
        S: GridSettings,
    {
        let scale = self.scale.get_or_insert_with(|| self.frame.return_scale());
        self.frame.insert_column(column, scale, &mut self.image);
    }

    /// The frame, its image and its coder.
    pub(crate) fn into_parts(self) -> (OpenFrame<S>, ImageViewMut<'a, L>, &'a mut C) {
        (self.frame, self.image, self.coder)
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

    /// As [`finish`](Self::finish), with planes besides the ranges. They take at most
    /// [`worst_case_len`](Planes::worst_case_len) bytes more.
    ///
    /// # Errors
    /// As [`finish`](Self::finish); [`ConfigError::Plane`] where a plane is not of the image's size,
    /// [`ConfigError::CoderRows`] where its coder has not as many rows.
    pub fn finish_with(self, planes: Planes<'_>, out: &mut [u8]) -> Result<Encoded, EncodeError> {
        self.frame.finish_with(self.image.as_view(), self.coder, planes, out)
    }
}

/// A number into the plane, for a return that a pixel keeps.
fn keep(plane: &mut [u8], pixel: usize, number: u8) {
    if let Some(kept) = plane.get_mut(pixel) {
        *kept = number;
    }
}

impl<L: Level, C: Coder<L>, const LINES: usize, const NODES: usize>
    FrameEncoder<'_, L, C, LatticeConfig<'_, LINES, NODES>>
{
    /// Puts points into the image whose beams are known: from a file's ring numbers or its order. Where one of the two
    /// is longer, its rest is left out; points of a row that there is not are counted as out of view or clamped.
    ///
    /// It is meant for scans off the sensor's grid: a point whose pixel is taken goes into the nearest free one, at
    /// most six columns away, is counted as displaced, and measured where it then is. Where none is free, the policy
    /// says which of the points the pixel keeps.
    pub fn insert_on_rows(&mut self, points: &[[f32; 3]], rows: &[u16]) {
        self.insert_on_rows_with(points, rows, |_, _| {});
    }

    /// As [`insert_on_rows`](Self::insert_on_rows), with intensities as with [`insert_lit`](Self::insert_lit).
    pub fn insert_lit_on_rows(
        &mut self,
        points: &[[f32; 3]],
        rows: &[u16],
        mut number_of: impl FnMut(usize) -> u8,
        plane: &mut [u8],
    ) {
        self.insert_on_rows_with(points, rows, |index, pixel| keep(plane, pixel, number_of(index)));
    }

    /// `keep` is told of each point that a pixel keeps.
    fn insert_on_rows_with(&mut self, points: &[[f32; 3]], rows: &[u16], mut keep: impl FnMut(usize, usize)) {
        let OpenFrame { config, quantizer, tally, fit, .. } = &mut self.frame;
        let fit = if config.measure { Some(fit) } else { None };
        let mut inserter = Beside {
            lattice: config.lattice,
            quantizer,
            policy: config.policy,
            levels: self.image.levels(),
            tally,
            fit,
        };
        for (index, (&point, &row)) in points.iter().zip(rows).enumerate() {
            if let Some(pixel) = inserter.insert(point, row) {
                keep(index, pixel);
            }
        }
    }
}

impl<L: Level, C: Coder<L>, const LINES: usize, const WORDS: usize, const NODES: usize>
    FrameEncoder<'_, L, C, FiringsConfig<'_, LINES, WORDS, NODES>>
{
    /// Puts returns into the image, in their sensor's own integers: each into the pixel that its point would get, its
    /// level within a rounding of the range count. Returns on a beam or tick that the grid does not have are counted as
    /// out of view, those of count 0 as no return.
    pub fn insert_fired<R: Into<GridReturn>>(&mut self, returns: impl IntoIterator<Item = R>) {
        self.insert_fired_with(returns.into_iter().map(|found| (found.into(), ())), |_, ()| {});
    }

    /// As [`insert_fired`](Self::insert_fired), with an intensity for each return, which goes into `plane` as with
    /// [`insert_lit`](Self::insert_lit).
    pub fn insert_lit_fired<R: Into<GridReturn>>(
        &mut self,
        returns: impl IntoIterator<Item = (R, u8)>,
        plane: &mut [u8],
    ) {
        let returns = returns.into_iter().map(|(found, number)| (found.into(), number));
        self.insert_fired_with(returns, |pixel, number| keep(plane, pixel, number));
    }

    /// `keep` is told of each return that a pixel keeps, and what goes along with it.
    fn insert_fired_with<A>(
        &mut self,
        returns: impl IntoIterator<Item = (GridReturn, A)>,
        mut keep: impl FnMut(usize, A),
    ) {
        let lattice = self.frame.projection;
        let grid = self.frame.config.every_tick.lattice.grid();
        let collision = self.frame.config.policy().collision;
        let scale = ReturnScale::new(grid, &self.frame.quantizer, self.frame.columns, collision);
        let mut off_grid = false;
        for (found, along) in returns {
            let (at, off) = lattice.column(found.row, found.tick).unzip();
            if let Some(pixel) = scale.insert_one(found, at, &mut self.image, &mut self.frame.tally) {
                keep(pixel, along);
            }
            off_grid |= off.is_some_and(|off| off > 0);
        }
        self.frame.fit.add_returns(&self.frame.quantizer, !off_grid);
    }
}

/// A frame between its first point and its bytes. The image and the coder are lent to each step, so that a frame can
/// stay open in memory that is not Rust's to borrow (the C ABI's).
#[derive(Debug, Clone, Copy)]
pub(crate) struct OpenFrame<S: FrameSettings = Config> {
    rows: u16,
    columns: u16,
    projection: S::Projection,
    quantizer: Quantizer,
    config: S,
    stamp: Stamp,
    tally: Tally,
    fit: S::Fit,
}

impl<S: FrameSettings> OpenFrame<S> {
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
    ) -> Result<Self, EncodeError>
    where
        S: Settings,
    {
        let mut frame = Self::begin(config, || Some(farthest_m(points)), stamp, image)?;
        frame.insert(points, image, ());
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
        let (found, scale, companding) = config.levels();
        if !(L::BITS_MIN..=L::BITS).contains(&found) {
            return Err(ConfigError::LevelBits { found, min: L::BITS_MIN, max: L::BITS }.into());
        }
        let quantizer = quantizer((found, scale, companding), farthest_m)?;
        let projection = config.projection(rows, columns)?;
        let (rows, columns) = (rows as u16, columns as u16);
        let strips = config.strips();
        if !(1..=columns).contains(&strips) {
            return Err(ConfigError::Strips { found: strips, max: columns }.into());
        }
        let (tally, fit) = (Tally::new(), S::Fit::default());
        Ok(Self { rows, columns, projection, quantizer, config: *config, stamp, tally, fit })
    }

    /// Puts points into the image that the frame was started with.
    pub(crate) fn insert<L: Level>(
        &mut self,
        points: &(impl Points + ?Sized),
        image: &mut ImageViewMut<'_, L>,
        along: impl Along,
    ) where
        S: Settings,
    {
        insert(points, &self.projection, &self.quantizer, self.config.policy(), image, &mut self.tally, along);
        self.config.measure(points, &self.quantizer, &mut self.fit);
    }

    /// Puts returns into the image that the frame was started with.
    pub(crate) fn insert_returns<L: Level, R: Into<GridReturn>>(
        &mut self,
        returns: impl IntoIterator<Item = R>,
        image: &mut ImageViewMut<'_, L>,
    ) where
        S: GridSettings,
    {
        self.insert_returns_with(returns.into_iter().map(|found| (found.into(), ())), image, |_, ()| {});
    }

    /// `keep` is told of each return that a pixel keeps, and what goes along with it.
    pub(crate) fn insert_returns_with<L: Level, A>(
        &mut self,
        returns: impl IntoIterator<Item = (GridReturn, A)>,
        image: &mut ImageViewMut<'_, L>,
        mut keep: impl FnMut(usize, A),
    ) where
        S: GridSettings,
    {
        let mut scale = self.return_scale();
        for (found, along) in returns {
            let at = scale.columns.column(found.tick);
            if let Some(pixel) = scale.insert_one(found, at, image, &mut self.tally) {
                keep(pixel, along);
            }
        }
        self.config.measure_returns(&self.quantizer, &mut self.fit);
    }

    /// Puts one firing into the image that the frame was started with. `scale` is the frame's.
    #[inline(always)]
    pub(crate) fn insert_column<L: Level>(
        &mut self,
        column: &Column<'_>,
        scale: &ReturnScale,
        image: &mut ImageViewMut<'_, L>,
    ) where
        S: GridSettings,
    {
        scale.insert_column(column, image, &mut self.tally);
        self.config.measure_returns(&self.quantizer, &mut self.fit);
    }

    /// The same for all frames of one configuration.
    pub(crate) fn return_scale(&self) -> ReturnScale
    where
        S: GridSettings,
    {
        ReturnScale::new(self.config.grid(), &self.quantizer, self.columns, self.config.policy().collision)
    }

    /// Begins the next frame of the same kind in the same image.
    pub(crate) fn restart<L: Level>(&mut self, image: &mut ImageViewMut<'_, L>) {
        image.clear();
        (self.stamp, self.tally, self.fit) = (Stamp::default(), Tally::new(), S::Fit::default());
    }

    pub(crate) const fn settings(&self) -> &S {
        &self.config
    }

    /// Range of level 1.
    pub(crate) const fn step_m(&self) -> f32 {
        self.quantizer.step_m()
    }

    pub(crate) const fn stamp(&self) -> Stamp {
        self.stamp
    }

    /// To be set before the frame is finished.
    pub(crate) const fn stamp_mut(&mut self) -> &mut Stamp {
        &mut self.stamp
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
        self.write(image, coder, out, |coder, strip, _, out| coder.encode(strip, out))
    }

    fn write<L: Level, C: Coder<L>>(
        &self,
        image: ImageView<'_, L>,
        coder: &mut C,
        out: &mut [u8],
        encode: impl FnMut(&mut C, ImageView<'_, L>, usize, &mut [u8]) -> Result<usize, OutputFull>,
    ) -> Result<Encoded, EncodeError> {
        let found = image.rows();
        if found > C::ROWS_MAX {
            return Err(ConfigError::CoderRows { found, max: C::ROWS_MAX }.into());
        }
        let (header, have) = (self.header(C::ID, coder.error_max()), out.len());
        let strips = self.config.strips();
        let worst_case = frame::worst_case_len_in_strips::<L, C>(found, image.columns(), strips);
        let worst_case = worst_case + header.more_than_uniform();
        let len = frame::write_by(header, image, strips, coder, out, encode);
        let len = len.map_err(|_| EncodeError::OutputTooSmall { have, worst_case })?;
        Ok(Encoded { len, tally: self.tally, range_bound_m: header.range_bound_m(), fit: self.fit.into() })
    }

    /// As [`finish`](Self::finish), with planes besides the ranges.
    pub(crate) fn finish_with<L: Level, C: Coder<L>>(
        &self,
        image: ImageView<'_, L>,
        coder: &mut C,
        planes: Planes<'_>,
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError> {
        self.finish_by(image, coder, planes, out, |coder, strip, _, out| coder.encode(strip, out))
    }

    /// The same with what `encode` makes of each strip, whose first column it is told.
    pub(crate) fn finish_by<L: Level, C: Coder<L>>(
        &self,
        image: ImageView<'_, L>,
        coder: &mut C,
        planes: Planes<'_>,
        out: &mut [u8],
        encode: impl FnMut(&mut C, ImageView<'_, L>, usize, &mut [u8]) -> Result<usize, OutputFull>,
    ) -> Result<Encoded, EncodeError> {
        planes.check(image)?;
        let have = out.len();
        let more = planes.worst_case_len(image.rows(), image.columns(), self.config.strips().into());
        let encoded = self.write(image, coder, out, encode).map_err(|error| match error {
            EncodeError::OutputTooSmall { have, worst_case } => {
                EncodeError::OutputTooSmall { have, worst_case: worst_case + more }
            }
            other => other,
        })?;
        let worst_case = encoded.len + more;
        let len = planes.append(image, self.stamp.timestamp_ns, encoded.len, out);
        Ok(Encoded { len: len.map_err(|_| EncodeError::OutputTooSmall { have, worst_case })?, ..encoded })
    }

    fn header(&self, coder: CoderId, error_max: u16) -> Header<S::Fields> {
        Header {
            sequence: self.stamp.sequence,
            timestamp_ns: self.stamp.timestamp_ns,
            rows: self.rows,
            columns: self.columns,
            quantizer: self.quantizer,
            coder,
            error_max,
            returns: self.tally.returns(),
            geometry: self.config.fields(&self.fit).off_by(self.quantizer.apart_m(error_max)),
        }
    }
}
