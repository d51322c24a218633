//! The fast tier: static rANS over whole columns. All that a pixel's probabilities depend on comes from earlier
//! columns, so that the rows of a column go through side by side, in vectors where the target has them; only table
//! look-ups and the entropy coder go pixel by pixel, four states in turn.
//!
//! ```text
//! image -> tile -> occupancy ------------------> nibbles --> tokens -> rANS words
//!          of      band: contexts, residuals --> symbols --> (table,    (backwards)
//!          columns       closed loop                |        symbol)
//!                                                   +------> raw bits of the size
//! ```
//!
//! Behind the prefix come blocks, one behind the other: columns (u16, 0 for all that are left), unless 0 the body's
//! length (u32), body. A body is raw bits, words, states.

pub(crate) mod band;
#[cfg(feature = "std")]
mod decode;
mod encode;
#[cfg(feature = "std")]
#[doc(hidden)]
pub mod lab;
mod noise;
mod occupancy;
mod priors;
mod rans;
mod raw;
mod symbol;
mod tile;

use super::super::{Coder, CoderId, OutputFull, WorstCase};
use super::{ContextSettings, PREFIX_LEN, Predictor};
use crate::image::{ImageView, Level};
use band::{Band, ROWS, Scale};
use encode::{Blocks, GROUPS_MAX, Group};
use tile::{COLUMNS, Tile};

/// What a payload's prefix calls this tier.
pub(super) const TIER: u8 = 2;
/// Head of the last block: its columns, 0.
const LAST_HEAD_LEN: usize = 2;
/// Head of another block: its columns and its length.
const BLOCK_HEAD_LEN: usize = LAST_HEAD_LEN + 4;
/// Most columns of a block that is not the last.
const COLUMNS_MAX: u16 = u16::MAX;

/// The fast tier: static rANS over whole columns, for processors with vectors; several times as fast as
/// [`Small`](super::Small), and at most some percent longer. For images of up to `64 * BANDS` rows.
///
/// RAM: 3.4 KB a band, and 16 bytes for each of `GROUPS` groups of eight tokens. Those are kept until they are coded
/// from the last to the first: an image takes one and one for every eight rows with returns a column and band. With less
/// room the payload gets 22 bytes longer each time it is used up; 20,000 are enough for a turn of an HDL-64E. The state
/// is large: it belongs in a `Box` or a `static`.
///
/// Predictions are from the west, whatever the settings say.
///
/// ```
/// use flicr::coder::{Coder, ContextSettings, Fast};
/// use flicr::RangeImage;
/// let mut fast: Fast<1, 100> = Fast::new(ContextSettings::FINE);
/// let image = RangeImage::<16, 400, u16>::new();
/// let mut out = [0; 16 * 400 * 2 + 6];
/// assert!(fast.encode(image.view(), &mut out)? < 400);
/// # Ok::<(), flicr::OutputFull>(())
/// ```
#[derive(Debug, Clone)]
pub struct Fast<const BANDS: usize = 1, const GROUPS: usize = 20_000> {
    settings: ContextSettings,
    bands: [Band; BANDS],
    tiles: [Tile; BANDS],
    tokens: [Group; GROUPS],
}

impl<const BANDS: usize, const GROUPS: usize> Fast<BANDS, GROUPS> {
    const FITS: () = assert!(GROUPS >= BANDS * GROUPS_MAX, "room for the tokens of a column: 11 groups a band");

    /// A coder with these settings.
    #[must_use]
    pub const fn new(settings: ContextSettings) -> Self {
        const { Self::FITS };
        Self { settings, bands: [Band::EMPTY; BANDS], tiles: [[[0; ROWS]; COLUMNS]; BANDS], tokens: [[0; _]; GROUPS] }
    }

    /// How it goes about images.
    #[must_use]
    pub const fn settings(&self) -> &ContextSettings {
        &self.settings
    }

    /// Changes that from the next image on.
    pub fn set(&mut self, settings: ContextSettings) {
        self.settings = settings;
    }

    /// The payload; [`OutputFull`] where it does not fit.
    fn code<L: Level>(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
        let max_level = image.max_level().max(1);
        let settings = ContextSettings { predictor: Predictor::West, ..self.settings };
        let (prefix, code) = out.split_first_chunk_mut::<PREFIX_LEN>().ok_or(OutputFull)?;
        *prefix = settings.prefix(TIER, max_level);
        let bands = self.bands.get_mut(..image.rows().div_ceil(ROWS)).ok_or(OutputFull)?;
        begin(bands, image.rows());
        self.tiles = [[[0; ROWS]; COLUMNS]; BANDS];
        let mut blocks = Blocks::new(code, priors::tables(settings.step.levels()), &mut self.tokens);
        encode::walk(image, bands, &mut self.tiles[..bands.len()], &scale(settings, max_level), &mut blocks)?;
        Ok(PREFIX_LEN + blocks.finish()?)
    }
}

impl<L: Level, const BANDS: usize, const GROUPS: usize> Coder<L> for Fast<BANDS, GROUPS> {
    const ID: CoderId = CoderId::Context;

    const WORST_CASE: WorstCase =
        WorstCase { bytes_per_level: size_of::<L>(), block_len: 1 << 30, bytes_per_block: PREFIX_LEN, gathers: false };

    const ROWS_MAX: usize = ROWS * BANDS;

    fn error_max(&self) -> u16 {
        self.settings.step.error_max()
    }

    /// # Errors
    /// As [`Coder::encode`]; also where the image has more than `64 * BANDS` rows, which no output is enough for.
    fn encode(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
        if image.rows() > <Self as Coder<L>>::ROWS_MAX {
            return Err(OutputFull);
        }
        let most = out.len().min(PREFIX_LEN + image.pixels() * size_of::<L>());
        match self.code(image, out.get_mut(..most).ok_or(OutputFull)?) {
            Ok(len) => Ok(len),
            Err(OutputFull) => super::store(image, out),
        }
    }
}

const fn scale(settings: ContextSettings, max_level: u16) -> Scale {
    Scale::new(settings.step, settings.noise, max_level)
}

fn begin(bands: &mut [Band], rows: usize) {
    for (number, band) in bands.iter_mut().enumerate() {
        *band = Band::new(number * ROWS, rows);
    }
}

/// Shows neighboring bands their edges.
#[inline]
fn meet(bands: &mut [Band]) {
    let mut rest = bands;
    while let [above, below @ ..] = rest {
        if let Some(below) = below.first_mut() {
            Band::meet(above, below);
        }
        rest = below;
    }
}

/// Reads blocks into `image`, all of both.
#[cfg(feature = "std")]
pub(super) fn decode<L: Level>(
    code: &[u8],
    mut image: crate::image::ImageViewMut<'_, L>,
    settings: ContextSettings,
    max_level: u16,
) -> Result<(), crate::error::PayloadFault> {
    if settings.predictor != Predictor::West {
        return Err(crate::error::PayloadFault::Malformed);
    }
    let rows = image.as_view().rows();
    let mut bands = std::vec![Band::EMPTY; rows.div_ceil(ROWS)];
    let mut tiles = std::vec![[[0; ROWS]; COLUMNS]; bands.len()];
    begin(&mut bands, rows);
    let tables = priors::tables(settings.step.levels());
    decode::walk(code, &mut image, &mut bands, &mut tiles, &scale(settings, max_level), tables)
}
