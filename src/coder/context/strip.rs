//! One strip, column by column, as a stream needs it: columns come one at a time with their ticks, and one that does not
//! fit any more is taken back. Forward and inverse side by side.
//!
//! A strip is short: what it begins with counts. So its first column, whose beams were never seen, has priors of its own,
//! and so have the others, for columns as fired and aligned ones, by how coarse the steps are.

use super::beam::Beams;
use super::column::Column;
use super::dense::DenseModel;
use super::range_coder::{BinaryCoder, Mark, RangeEncoder};
use super::small::SmallModel;
use super::strip_priors;
use super::ticks::TickTrack;
use super::{ContextSettings, Tier};

/// Which pixels make a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    /// Those of one firing.
    AsFired,
    /// Those that look one way.
    Aligned,
}

/// A tier that knows how strips begin.
pub(crate) trait StripTier: Tier {
    /// Forgets all but what is known of a first column.
    fn open(&mut self, settings: ContextSettings, order: Order);

    /// Behind the first column: forgets all but what is known of the others.
    fn go_on(&mut self, settings: ContextSettings, order: Order);
}

impl StripTier for SmallModel {
    fn open(&mut self, settings: ContextSettings, order: Order) {
        let [first, _] = &strip_priors::SMALL[order as usize][coarseness(settings)];
        self.start_from(first, settings.step, settings.noise);
    }

    fn go_on(&mut self, settings: ContextSettings, order: Order) {
        let [_, others] = &strip_priors::SMALL[order as usize][coarseness(settings)];
        self.start_from(others, settings.step, settings.noise);
    }
}

/// What it learns of the first column is of use for the others.
impl StripTier for DenseModel {
    fn open(&mut self, settings: ContextSettings, _: Order) {
        Tier::start(self, settings);
    }

    fn go_on(&mut self, _: ContextSettings, _: Order) {}
}

/// Classes of steps, which priors and energies depend on.
pub(crate) const COARSENESSES: usize = 4;

/// By a step's share in the noise.
pub(crate) fn coarseness(settings: ContextSettings) -> usize {
    let (step, noise) = (u32::from(settings.step.levels()), u32::from(settings.noise));
    match () {
        () if 8 * step <= noise => 0,
        () if step <= noise => 1,
        () if step <= 4 * noise => 2,
        () => 3,
    }
}

/// Energy of beams behind the first column: what that one's residuals were says little of the next ones.
pub(super) const ENERGY: [u16; COARSENESSES] = [100, 16, 16, 16];

/// A strip that is being coded: the tier's state, and where in the code it stands.
#[derive(Debug, Clone)]
pub(crate) struct StripCoder<M, const GROUPS: usize> {
    model: M,
    beams: Beams<GROUPS>,
    ticks: TickTrack,
    order: Order,
    is_open: bool,
    at: Mark,
}

impl<M: StripTier, const GROUPS: usize> StripCoder<M, GROUPS> {
    /// Memory that is to be started; zeros.
    pub(crate) const NEW: Self = Self {
        model: M::NEW,
        beams: Beams::BLANK,
        ticks: TickTrack::BLANK,
        order: Order::AsFired,
        is_open: false,
        at: Mark::BLANK,
    };

    /// What frames and datagrams call the tier.
    pub(crate) const TIER: u8 = M::TIER;

    /// Begins a strip whose columns are so many ticks apart.
    pub(crate) fn start(&mut self, settings: ContextSettings, order: Order, rate_q10: u32) {
        self.model.open(settings, order);
        self.beams.start();
        self.ticks = TickTrack::new(rate_q10);
        (self.order, self.is_open) = (order, false);
        self.at = Mark::START;
    }

    /// Codes a column into `out`, which holds the strip so far: first ticks, each a number of ticks from the one before;
    /// then its levels, which become those that the decoder will find. Where there is no room for it, gives `false`: then
    /// the strip can be finished without it, and nothing else.
    pub(crate) fn push(
        &mut self,
        settings: ContextSettings,
        rows: usize,
        tick_steps: impl Iterator<Item = u16>,
        column: &mut Column<GROUPS>,
        out: &mut [u8],
    ) -> bool {
        let room = out.len();
        let mut coder = RangeEncoder::from_mark(out, self.at);
        for step in tick_steps {
            self.ticks.code(&mut coder, step);
        }
        settings.walk::<M>(rows, u16::MAX).column(&mut self.model, &mut self.beams, &mut coder, column);
        let end = coder.mark();
        if end.code_len() > room {
            coder.forget();
            return false;
        }
        self.at = end;
        if !self.is_open {
            self.is_open = true;
            self.beams.settle(ENERGY[coarseness(settings)]);
            self.model.go_on(settings, self.order);
        }
        true
    }

    /// Codes the first column anew, its levels as they are: where the model makes it longer than that. Where there is no
    /// room for it, gives `false`.
    pub(crate) fn store(
        &mut self,
        rows: usize,
        rate_q10: u32,
        tick_steps: impl Iterator<Item = u16>,
        column: &Column<GROUPS>,
        out: &mut [u8],
    ) -> bool {
        let room = out.len();
        let (mut coder, mut ticks) = (RangeEncoder::from_mark(out, Mark::START), TickTrack::new(rate_q10));
        for step in tick_steps {
            ticks.code(&mut coder, step);
        }
        for &level in column.levels.as_flattened().iter().take(rows) {
            coder.raw(16, level.into());
        }
        self.at = coder.mark();
        self.at.code_len() <= room
    }

    /// Ends the code in `out` and gives its length.
    pub(crate) fn finish(&self, out: &mut [u8]) -> usize {
        // Every column was checked to leave room for the end.
        RangeEncoder::from_mark(out, self.at).finish().unwrap_or(0)
    }
}

#[cfg(feature = "std")]
pub(crate) use inverse::{decode_stored, decode_strip};

#[cfg(feature = "std")]
mod inverse {
    use std::vec::Vec;

    use super::super::range_coder::{BinaryCoder, RangeDecoder};
    use super::super::{dense::DenseModel, small::SmallModel};
    use super::{Beams, Column, ContextSettings, ENERGY, Order, StripCoder, StripTier, TickTrack, coarseness};
    use crate::error::PayloadFault;

    /// A decoded strip.
    #[derive(Debug, Default)]
    pub(crate) struct StripLevels {
        /// Distance of each tick but the first from the one before.
        pub(crate) tick_steps: Vec<u16>,
        /// Column by column, each from row 0.
        pub(crate) levels: Vec<u16>,
    }

    /// What a datagram says of its code.
    #[derive(Debug, Clone, Copy)]
    pub(crate) struct StripCode {
        pub(crate) tier: u8,
        pub(crate) settings: ContextSettings,
        pub(crate) order: Order,
        pub(crate) rows: usize,
        pub(crate) columns: usize,
        /// Ticks before the first column, and before each other one.
        pub(crate) ticks: [usize; 2],
        pub(crate) rate_q10: u32,
    }

    /// All columns of a strip, which is all of `code`.
    pub(crate) fn decode_strip(strip: StripCode, code: &[u8]) -> Result<StripLevels, PayloadFault> {
        match strip.tier {
            StripCoder::<SmallModel, 8>::TIER => in_groups::<SmallModel>(strip, code),
            StripCoder::<DenseModel, 8>::TIER => in_groups::<DenseModel>(strip, code),
            _ => Err(PayloadFault::Malformed),
        }
    }

    /// A strip of one column that stands as it is.
    pub(crate) fn decode_stored(strip: StripCode, code: &[u8]) -> Result<StripLevels, PayloadFault> {
        let mut ticks = TickTrack::new(strip.rate_q10);
        let mut coder = RangeDecoder::new(code);
        let tick_steps = (0..strip.ticks[0]).map(|_| ticks.code(&mut coder, 0)).collect();
        let levels = (0..strip.rows).map(|_| coder.raw(16, 0) as u16).collect();
        crate::coder::check_len(code.len(), coder.code_len())?;
        Ok(StripLevels { tick_steps, levels })
    }

    fn in_groups<M: StripTier>(strip: StripCode, code: &[u8]) -> Result<StripLevels, PayloadFault> {
        match strip.rows {
            0..=64 => decode::<M, 8>(strip, code),
            65..=128 => decode::<M, 16>(strip, code),
            found => Err(PayloadFault::Rows { found: found as u16, max: 128 }),
        }
    }

    fn decode<M: StripTier, const GROUPS: usize>(strip: StripCode, code: &[u8]) -> Result<StripLevels, PayloadFault> {
        let StripCode { settings, rows, columns, ticks: [before_first, before_others], .. } = strip;
        let mut model = M::NEW;
        model.open(settings, strip.order);
        let (mut beams, mut ticks) = (Beams::<GROUPS>::new(), TickTrack::new(strip.rate_q10));
        let walk = settings.walk::<M>(rows, u16::MAX);
        let (mut coder, mut column) = (RangeDecoder::new(code), Column::<GROUPS>::new());
        let mut found = StripLevels::default();
        for at in 0..columns {
            let steps = if at == 0 { before_first } else { before_others };
            for _ in 0..steps {
                found.tick_steps.push(ticks.code(&mut coder, 0));
            }
            column.clear();
            walk.column(&mut model, &mut beams, &mut coder, &mut column);
            if coder.is_past_end() {
                return Err(PayloadFault::TooShort);
            }
            found.levels.extend_from_slice(&column.levels.as_flattened()[..rows]);
            if at == 0 {
                beams.settle(ENERGY[coarseness(settings)]);
                model.go_on(settings, strip.order);
            }
        }
        crate::coder::check_len(code.len(), coder.code_len())?;
        Ok(found)
    }
}

#[cfg(feature = "std")]
pub(crate) use inverse::{StripCode, StripLevels};
