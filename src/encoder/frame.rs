//! A frame whose points and returns come piece by piece.

use super::{Encoded, OpenFrame, Stamp};
use crate::beside::Beside;
use crate::coder::Coder;
use crate::config::{Config, FrameSettings, GridSettings, LatticeConfig, Settings};
use crate::error::EncodeError;
use crate::firings_config::FiringsConfig;
use crate::fit::GridFit;
use crate::image::{ImageViewMut, Level};
use crate::insert::{Numbers, farthest_m};
use crate::packet::Column;
use crate::plane::Planes;
use crate::point::Points;
use crate::returns::{GridReturn, ReturnScale};
use crate::tally::Tally;

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
    /// As [`Encoder::start`](crate::Encoder::start).
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
    /// [`EncodeError::OutputTooSmall`]; [`ConfigError::CoderRows`](crate::ConfigError::CoderRows). Nothing in `out` is a frame then.
    pub fn finish(self, out: &mut [u8]) -> Result<Encoded, EncodeError> {
        self.frame.finish(self.image.as_view(), self.coder, out)
    }

    /// As [`finish`](Self::finish), with planes besides the ranges. They take at most
    /// [`worst_case_len`](Planes::worst_case_len) bytes more.
    ///
    /// # Errors
    /// As [`finish`](Self::finish); [`ConfigError::Plane`](crate::ConfigError::Plane) where a plane is not of the image's size,
    /// [`ConfigError::CoderRows`](crate::ConfigError::CoderRows) where its coder has not as many rows.
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
