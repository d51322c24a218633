//! The inverse direction of a payload: the prefix is checked, then the same walk as in the forward one.

use super::beam::Beams;
use super::column::Column;
use super::dense::DenseModel;
use super::range_coder::RangeDecoder;
use super::recall::{Judge, Recall};
use super::small::SmallModel;
use super::{
    ContextSettings, DEAD_ZONE_FLAG, MEDIAN_EDGE_FLAG, PREFIX_LEN, PREVIOUS_FLAG, Predictor, STORED, Step, TIER_MASK,
    Tier, fast,
};
use crate::coder::store;
use crate::error::PayloadFault;
use crate::image::{ImageViewMut, Level};

/// Most rows that a payload may have.
const ROWS_MAX: usize = 1024;

/// What the frame allows its payloads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Allowed {
    pub(crate) max_level: u16,
    pub(crate) error_max: u16,
}

/// Reads `payload` into `levels`, all of both; `levels` are those of `rows` rows. Where there is a frame before, it becomes this
/// one.
pub(crate) fn decode<L: Level>(
    payload: &[u8],
    rows: usize,
    levels: &mut [L],
    allowed: Allowed,
    mut recall: Option<&mut Recall<'_>>,
) -> Result<(), PayloadFault> {
    let is_after = payload.first().is_some_and(|kind| kind & PREVIOUS_FLAG != 0);
    let used = if is_after { recall.take() } else { None };
    if is_after && used.is_none() {
        return Err(PayloadFault::Malformed);
    }
    decode_by(payload, rows, levels, allowed, used)?;
    if let Some(recall) = recall {
        recall.store_all(levels.iter().copied(), levels.len().checked_div(rows).unwrap_or(0));
    }
    Ok(())
}

fn decode_by<L: Level>(
    payload: &[u8],
    rows: usize,
    levels: &mut [L],
    allowed: Allowed,
    recall: Option<&mut Recall<'_>>,
) -> Result<(), PayloadFault> {
    let (&kind, rest) = payload.split_first().ok_or(PayloadFault::TooShort)?;
    if kind == STORED {
        return store::decode(rest, levels);
    }
    let (prefix, code) = payload.split_first_chunk().ok_or(PayloadFault::TooShort)?;
    let (settings, max_level) = parse(*prefix, allowed)?;
    let columns = levels.len().checked_div(rows).unwrap_or(0);
    let image = ImageViewMut::new(levels, columns).ok_or(PayloadFault::Malformed)?;
    if recall.is_some() && (kind & MEDIAN_EDGE_FLAG != 0 || kind & TIER_MASK == fast::TIER) {
        return Err(PayloadFault::Malformed);
    }
    let strip = Strip { settings, max_level, code };
    match kind & TIER_MASK {
        SmallModel::TIER => strip.decode_in_groups::<SmallModel, L>(image, recall),
        fast::TIER => strip.decode_fast(image),
        DenseModel::TIER => strip.decode_in_groups::<DenseModel, L>(image, recall),
        _ => Err(PayloadFault::Malformed),
    }
}

fn parse(prefix: [u8; PREFIX_LEN], allowed: Allowed) -> Result<(ContextSettings, u16), PayloadFault> {
    let [kind, noise, s0, s1, m0, m1] = prefix;
    let (levels, max_level) = (u16::from_le_bytes([s0, s1]), u16::from_le_bytes([m0, m1]));
    let has_dead_zone = kind & DEAD_ZONE_FLAG != 0;
    let step = if has_dead_zone { Step::new(levels) } else { Step::exact(levels) };
    let step = step.filter(|step| step.has_dead_zone() == has_dead_zone).ok_or(PayloadFault::Malformed)?;
    if kind & !(TIER_MASK | MEDIAN_EDGE_FLAG | DEAD_ZONE_FLAG | PREVIOUS_FLAG) != 0 || max_level == 0 {
        return Err(PayloadFault::Malformed);
    }
    if max_level > allowed.max_level {
        return Err(PayloadFault::LevelRange { found: max_level, max: allowed.max_level });
    }
    if step.error_max() > allowed.error_max {
        return Err(PayloadFault::Bound { found: step.error_max(), max: allowed.error_max });
    }
    let predictor = if kind & MEDIAN_EDGE_FLAG == 0 { Predictor::West } else { Predictor::MedianEdge };
    Ok((ContextSettings { step, noise, predictor }, max_level))
}

/// A payload whose prefix was read.
struct Strip<'a> {
    settings: ContextSettings,
    max_level: u16,
    code: &'a [u8],
}

impl Strip<'_> {
    /// With memory for as many rows as there are, about.
    fn decode_in_groups<M: Tier, L: Level>(
        &self,
        image: ImageViewMut<'_, L>,
        recall: Option<&mut Recall<'_>>,
    ) -> Result<(), PayloadFault> {
        match image.as_view().rows() {
            0..=64 => self.decode::<M, 8, L>(image, recall),
            65..=128 => self.decode::<M, 16, L>(image, recall),
            129..=ROWS_MAX => self.decode::<M, { ROWS_MAX / 8 }, L>(image, recall),
            found => Err(PayloadFault::Rows { found: found as u16, max: ROWS_MAX as u16 }),
        }
    }

    fn decode_fast<L: Level>(&self, image: ImageViewMut<'_, L>) -> Result<(), PayloadFault> {
        match image.as_view().rows() {
            0..=ROWS_MAX => fast::decode(self.code, image, self.settings, self.max_level),
            found => Err(PayloadFault::Rows { found: found as u16, max: ROWS_MAX as u16 }),
        }
    }

    fn decode<M: Tier, const GROUPS: usize, L: Level>(
        &self,
        mut image: ImageViewMut<'_, L>,
        mut recall: Option<&mut Recall<'_>>,
    ) -> Result<(), PayloadFault> {
        let mut judge = Judge::new(self.settings.noise);
        let mut model = M::NEW;
        model.start(self.settings);
        let mut beams = Beams::<GROUPS>::new();
        let walk = self.settings.walk::<M>(image.as_view().rows(), self.max_level);
        let mut coder = RangeDecoder::new(self.code);
        let mut column = Column::new();
        for at in 0..image.columns() {
            column.clear();
            match &mut recall {
                Some(recall) => {
                    judge.column(&walk, (&mut model, &mut beams), &mut coder, (&mut column, at), recall);
                }
                None => walk.column(&mut model, &mut beams, &mut coder, &mut column),
            }
            if coder.is_past_end() {
                return Err(PayloadFault::TooShort);
            }
            column.store(&mut image, at);
        }
        crate::coder::check_len(self.code.len(), coder.code_len())
    }
}
