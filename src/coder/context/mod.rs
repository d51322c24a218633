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
mod priors;
pub(crate) mod range_coder;
mod small;
pub(crate) mod step;
mod surroundings;
#[cfg(feature = "std")]
#[doc(hidden)]
pub mod train;
pub(crate) mod walk;

pub use fast::Fast;
pub use step::Step;
pub use walk::Predictor;

use super::{Coder, CoderId, OutputFull, Sink, WorstCase};
use crate::image::{ImageView, Level};
use beam::{Beams, Filter};
use column::Column;
use dense::DenseModel;
use range_coder::RangeEncoder;
use small::SmallModel;
use walk::{Model, Walk};

/// What a payload says of its code, before it.
const PREFIX_LEN: usize = 6;
/// Tier of a payload whose levels stand as they are, for they would not get shorter.
const STORED: u8 = 3;
#[cfg(feature = "std")]
const TIER_MASK: u8 = 3;
const MEDIAN_EDGE_FLAG: u8 = 4;
const DEAD_ZONE_FLAG: u8 = 8;

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

    /// Keeps levels in steps of this.
    #[must_use]
    pub const fn with_step(self, step: Step) -> Self {
        Self { step, ..self }
    }

    fn walk(self, rows: usize, max_level: u16) -> Walk {
        let Self { step, noise, predictor } = self;
        Walk { step, filter: Filter::new(step, noise), predictor, rows, max_level }
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

/// The small tier: adaptive counts, 1.6 KB of RAM for 64 rows. On KITTI's own grid 6 % (lossless) to 16 % (30 cm) longer
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

/// The dense tier: summed logits, 4.3 KB of RAM for 64 rows and 3.8 KB of tables in flash. The fewest bytes.
pub type Dense<const GROUPS: usize = 8> = ContextCoder<DenseModel, GROUPS>;

/// A model with a number in the format.
trait Tier: Model {
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
    /// The payload; `None` where it does not fit.
    fn code<L: Level>(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Option<usize> {
        let max_level = image.levels().iter().max().map_or(1, |level| level.get().max(1));
        let (prefix, code) = out.split_first_chunk_mut()?;
        *prefix = self.settings.prefix(M::TIER, max_level);
        self.model.start(self.settings);
        self.beams = Beams::new();
        let walk = self.settings.walk(image.rows(), max_level);
        let mut coder = RangeEncoder::new(code);
        let mut column = Column::new();
        for at in 0..image.columns() {
            column.load(image, at);
            walk.column(&mut self.model, &mut self.beams, &mut coder, &mut column);
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
        WorstCase { bytes_per_level: size_of::<L>(), block_len: 1 << 30, bytes_per_block: PREFIX_LEN };

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
        let most = out.len().min(PREFIX_LEN + image.bytes().len());
        let coded = out.get_mut(..most).and_then(|out| self.code(image, out));
        coded.map_or_else(|| store(image, out), Ok)
    }
}

fn store<L: Level>(image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
    let mut sink = Sink::new(out);
    sink.put(STORED)?;
    sink.put_all(image.bytes())?;
    Ok(sink.len())
}

#[cfg(feature = "std")]
mod decode;
#[cfg(feature = "std")]
pub(crate) use decode::{Allowed, decode};
