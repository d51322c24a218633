//! Coders made for range images: columns in the order in which the sensor fires, each pixel predicted from what its
//! beam saw last, every decision coded with the probability that its neighborhood gave it so far.
//!
//! ```text
//! image ──> column ──> residual ──> model ──────────> range coder ──> bytes
//!           levels,    steps off    small: counts      decisions
//!           sets of    prediction   dense: sums of
//!           returns                 logits
//! ```
//!
//! The same code walks a model in both directions (`walk`); what a decision may look at stands in `surroundings`, how
//! likely it is in `small` and `dense`.

pub(crate) mod beam;
pub(crate) mod column;
mod dense;
pub(crate) mod fast;
pub(crate) mod logit;
pub(crate) mod number;
mod priors;
pub(crate) mod range_coder;
mod recall;
mod small;
pub(crate) mod step;
pub(crate) mod strip;
mod strip_priors;
mod surroundings;
pub(crate) mod ticks;
#[cfg(feature = "std")]
#[doc(hidden)]
pub mod train;
#[cfg(feature = "std")]
#[doc(hidden)]
pub mod train_strips;
pub(crate) mod walk;

pub use fast::Fast;
pub use recall::Recall;
pub use step::Step;
pub use walk::Predictor;

use super::{Coder, CoderId, OutputFull, Sink, WorstCase};
use crate::image::{ImageView, Level};
use beam::{Beams, Filter};
use column::Column;
pub use dense::DenseModel;
use range_coder::RangeEncoder;
use recall::Judge;
pub use small::SmallModel;
use walk::{Model, Walk};

/// What a payload says of its code, before it.
const PREFIX_LEN: usize = 6;
/// Tier of a payload whose levels stand as they are, for they would not get shorter.
const STORED: u8 = 3;
#[cfg(feature = "std")]
const TIER_MASK: u8 = 3;
const MEDIAN_EDGE_FLAG: u8 = 4;
const DEAD_ZONE_FLAG: u8 = 8;
const PREVIOUS_FLAG: u8 = 16;

/// How a context coder is to go about an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ContextSettings {
    /// How finely levels are kept.
    pub step: Step,
    /// Levels that are a beam's noise, not a surface: predictions smooth them out. About 4 cm; 0 where levels are as
    /// coarse as that. No level is lost by a wrong one, but bytes are.
    pub noise: u8,
    /// What a level is predicted from.
    pub predictor: Predictor,
}

impl ContextSettings {
    /// For levels of 2 mm, as KITTI's HDL-64E counts.
    pub const FINE: Self = Self { step: Step::LOSSLESS, noise: 20, predictor: Predictor::West };

    /// For levels of decimeters, as 8 bits have.
    pub const COARSE: Self = Self { noise: 0, ..Self::FINE };

    /// As [`FINE`](Self::FINE), for levels of `level_m` meters.
    #[must_use]
    pub fn of_levels(level_m: f32) -> Self {
        Self { noise: crate::kernel::to_index(0.04 / level_m + 0.5, 255) as u8, ..Self::FINE }
    }

    /// With the predictor that makes the shorter frames of images of this size all around in the [`Small`] tier: where
    /// neighbors in a row are far apart or those in a column near, the beam above says what its own beam does not. Saves 4,
    /// 12 and 19 % at 1024, 512 and 256 columns by 64 rows, 6 to 11 % with 128 beams.
    ///
    /// [`Dense`] looks at those neighbors whatever it predicts from, and is served as well or better (up to 7 % at 1024
    /// columns) by [`Predictor::West`], the only one that [`Fast`] has.
    ///
    /// ```
    /// use flicr::coder::{ContextSettings, Predictor};
    /// assert_eq!(ContextSettings::FINE.for_small(64, 2152).predictor, Predictor::West);
    /// assert_eq!(ContextSettings::FINE.for_small(128, 2048).predictor, Predictor::MedianEdge);
    /// ```
    #[must_use]
    pub const fn for_small(self, rows: usize, columns: usize) -> Self {
        let is_steep = columns <= 1024 || rows >= 128;
        Self { predictor: if is_steep { Predictor::MedianEdge } else { Predictor::West }, ..self }
    }

    /// Keeps levels in steps of this.
    #[must_use]
    pub const fn with_step(self, step: Step) -> Self {
        Self { step, ..self }
    }

    fn walk<M: Model>(self, rows: usize, max_level: u16) -> Walk {
        let Self { step, noise, predictor } = self;
        Walk { step, filter: Filter::new(step, noise, max_level, M::REMEMBERS), predictor, rows, max_level }
    }

    fn prefix(self, tier: u8, max_level: u16) -> [u8; PREFIX_LEN] {
        let median_edge = if self.predictor == Predictor::MedianEdge { MEDIAN_EDGE_FLAG } else { 0 };
        let dead_zone = if self.step.has_dead_zone() { DEAD_ZONE_FLAG } else { 0 };
        let ([s0, s1], [m0, m1]) = (self.step.levels().to_le_bytes(), max_level.to_le_bytes());
        [tier | median_edge | dead_zone, self.noise, s0, s1, m0, m1]
    }
}

/// A context coder for images of up to `8 * GROUPS` rows: what [`Small`] and [`Dense`] have in common. All of its
/// state; no allocator. Every image is coded from the same start.
///
/// A payload that would be longer than its levels is these levels instead.
#[derive(Debug, Clone)]
pub struct ContextCoder<M, const GROUPS: usize> {
    settings: ContextSettings,
    model: M,
    beams: Beams<GROUPS>,
}

/// The small tier, the one for microcontrollers: adaptive counts, 1.8 KB of RAM for 64 rows. On KITTI's own grid 6 % (lossless) to 16 % (30 cm) longer
/// than [`Dense`], at a third of its time.
///
/// ```
/// use flicr::coder::{ContextSettings, Step};
/// use flicr::{Encoder, LatticeConfig, Small, Stamp};
/// use flicr::geometry::{Lattice, sensors::hdl64e};
/// let lattice = Lattice::<66>::new(hdl64e::GRID, 500)?;
/// let config = LatticeConfig::new(&lattice);
/// // 2 cm: ten counts of 2 mm.
/// let settings = ContextSettings::FINE.with_step(Step::new(10).unwrap());
/// let mut encoder: Encoder<64, 500, u16, Small> = Encoder::new(Small::new(settings));
/// let mut out = vec![0; config.worst_case_len::<u16, Small>()];
/// let encoded = encoder.encode(&config, [[10.0_f32, 0.0, -1.0]].as_slice(), Stamp::default(), &mut out)?;
/// assert!(encoded.range_bound_m < 0.014);
/// # Ok::<(), flicr::EncodeError>(())
/// ```
pub type Small<const GROUPS: usize = 8> = ContextCoder<SmallModel, GROUPS>;

/// The dense tier, the one for all others and the command line's default: summed logits, 4 KB of RAM for 64 rows and 2.5 KB of tables in flash. The fewest bytes.
pub type Dense<const GROUPS: usize = 8> = ContextCoder<DenseModel, GROUPS>;

/// A model with a number in the format.
pub(crate) trait Tier: Model {
    const TIER: u8;

    /// A model that has to be started; all zeros.
    const NEW: Self;

    /// Forgets all but the priors.
    fn start(&mut self, settings: ContextSettings);
}

impl Tier for SmallModel {
    const TIER: u8 = 0;
    const NEW: Self = Self::new();

    fn start(&mut self, settings: ContextSettings) {
        self.start(settings.step, settings.noise);
    }
}

impl Tier for DenseModel {
    const TIER: u8 = 1;
    const NEW: Self = Self::new();

    fn start(&mut self, settings: ContextSettings) {
        self.start(settings.step, settings.noise);
    }
}

impl<const GROUPS: usize> Small<GROUPS> {
    /// A coder with these settings.
    #[must_use]
    pub const fn new(settings: ContextSettings) -> Self {
        Self { settings, model: SmallModel::NEW, beams: Beams::BLANK }
    }
}

impl<const GROUPS: usize> Dense<GROUPS> {
    /// A coder with these settings.
    #[must_use]
    pub const fn new(settings: ContextSettings) -> Self {
        Self { settings, model: DenseModel::NEW, beams: Beams::BLANK }
    }
}

impl<M, const GROUPS: usize> ContextCoder<M, GROUPS> {
    /// How it goes about images.
    #[must_use]
    pub const fn settings(&self) -> &ContextSettings {
        &self.settings
    }

    /// Changes that from the next image on.
    pub fn set(&mut self, settings: ContextSettings) {
        self.settings = settings;
    }
}

#[allow(private_bounds, reason = "the tiers there are")]
impl<M: Tier, const GROUPS: usize> ContextCoder<M, GROUPS> {
    /// The payload; `None` where it does not fit. What comes out of it is shown to `each`, column by column.
    fn code<L: Level>(
        &mut self,
        image: ImageView<'_, L>,
        out: &mut [u8],
        mut each: impl FnMut(usize, &Column<GROUPS>),
    ) -> Option<usize> {
        let max_level = image.max_level().max(1);
        let (prefix, code) = out.split_first_chunk_mut()?;
        *prefix = self.settings.prefix(M::TIER, max_level);
        self.model.start(self.settings);
        self.beams.start();
        let walk = self.settings.walk::<M>(image.rows(), max_level);
        let mut coder = RangeEncoder::new(code);
        let mut column = Column::new();
        for at in 0..image.columns() {
            column.load(image, at);
            walk.column(&mut self.model, &mut self.beams, &mut coder, &mut column);
            each(at, &column);
            if coder.is_full() {
                return None;
            }
        }
        Some(PREFIX_LEN + coder.finish()?)
    }

    /// The same by what was before, which becomes what comes out of it.
    fn code_after<L: Level>(
        &mut self,
        image: ImageView<'_, L>,
        recall: &mut Recall<'_>,
        out: &mut [u8],
    ) -> Option<usize> {
        let settings = ContextSettings { predictor: Predictor::West, ..self.settings };
        let max_level = image.max_level().max(1);
        let (prefix, code) = out.split_first_chunk_mut::<PREFIX_LEN>()?;
        *prefix = settings.prefix(M::TIER, max_level);
        prefix[0] |= PREVIOUS_FLAG;
        self.model.start(settings);
        self.beams.start();
        let walk = settings.walk::<M>(image.rows(), max_level);
        let mut coder = RangeEncoder::new(code);
        let (mut column, mut judge) = (Column::new(), Judge::new(settings.noise));
        for at in 0..image.columns() {
            column.load(image, at);
            judge.column(&walk, (&mut self.model, &mut self.beams), &mut coder, (&mut column, at), recall);
            if coder.is_full() {
                return None;
            }
        }
        Some(PREFIX_LEN + coder.finish()?)
    }
}

#[allow(private_bounds, reason = "the tiers there are")]
impl<L: Level, M: Tier, const GROUPS: usize> Coder<L> for ContextCoder<M, GROUPS> {
    const ID: CoderId = CoderId::Context;

    const WORST_CASE: WorstCase =
        WorstCase { bytes_per_level: size_of::<L>(), block_len: 1 << 30, bytes_per_block: PREFIX_LEN, gathers: false };

    const ROWS_MAX: usize = Column::<GROUPS>::ROWS_MAX;

    fn error_max(&self) -> u16 {
        self.settings.step.error_max()
    }

    /// # Errors
    /// As [`Coder::encode`]; also where the image has more than `8 * GROUPS` rows, which no output is enough for.
    fn encode(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
        if image.rows() > <Self as Coder<L>>::ROWS_MAX {
            return Err(OutputFull);
        }
        let most = out.len().min(PREFIX_LEN + image.pixels() * size_of::<L>());
        let coded = out.get_mut(..most).and_then(|out| self.code(image, out, |_, _| {}));
        coded.map_or_else(|| store(image, out), Ok)
    }

    fn encode_after(
        &mut self,
        image: ImageView<'_, L>,
        recall: &mut Recall<'_>,
        out: &mut [u8],
    ) -> Result<usize, OutputFull> {
        if image.rows() > <Self as Coder<L>>::ROWS_MAX {
            return Err(OutputFull);
        }
        let most = out.len().min(PREFIX_LEN + image.pixels() * size_of::<L>());
        let room = out.get_mut(..most).ok_or(OutputFull)?;
        if recall.is_tried {
            let plain_len = self.code(image, room, |_, _| {}).unwrap_or(most);
            let shorter = room.get_mut(..plain_len).and_then(|room| self.code_after(image, recall, room));
            if let Some(len) = shorter {
                recall.is_used = true;
                return Ok(len);
            }
        }
        if let Some(len) = self.code(image, room, |at, column| recall.store(at, column)) {
            return Ok(len);
        }
        recall.store_all(image.row_levels().flatten().copied(), image.columns());
        store(image, out)
    }
}

fn store<L: Level>(image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
    let mut sink = Sink::new(out);
    sink.put(STORED)?;
    super::store::put(image, &mut sink)?;
    Ok(sink.len())
}

#[cfg(feature = "std")]
mod decode;
#[cfg(feature = "std")]
pub(crate) use decode::{Allowed, decode};
