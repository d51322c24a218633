//! A frame that is open: between its first point and its bytes.

use super::{Encoded, Stamp};
use crate::coder::{Coder, CoderId, OutputFull};
use crate::config::{Config, FrameSettings, GridSettings, Settings, quantizer};
use crate::error::{ConfigError, EncodeError};
use crate::frame::{self, GeometryFields, Header};
use crate::image::{ImageView, ImageViewMut, Level};
use crate::insert::{Along, farthest_m, insert};
use crate::packet::Column;
use crate::plane::Planes;
use crate::point::Points;
use crate::quantize::Quantizer;
use crate::returns::{GridReturn, ReturnScale};
use crate::tally::Tally;

/// A frame between its first point and its bytes. The image and the coder are lent to each step, so that a frame can
/// stay open in memory that is not Rust's to borrow (the C ABI's).
#[derive(Debug, Clone, Copy)]
pub(crate) struct OpenFrame<S: FrameSettings = Config> {
    pub(super) rows: u16,
    pub(super) columns: u16,
    pub(super) projection: S::Projection,
    pub(super) quantizer: Quantizer,
    pub(super) config: S,
    pub(super) stamp: Stamp,
    pub(super) tally: Tally,
    pub(super) fit: S::Fit,
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

    pub(super) fn begin<L: Level>(
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
