//! The ticks that a sensor fired at: the columns of an image that has no empty ones.
//!
//! An HDL-64E fires about 2150 times a turn of 4000 ticks, all lasers at the same ticks once each laser's own angle is
//! counted in its azimuth phase. An image with a column a firing keeps every return, as one with a column a tick does,
//! in half the pixels; the frame then carries the list of ticks, some 45 bytes.

mod code;
#[cfg(feature = "std")]
mod find;
mod lattice;

#[cfg(feature = "std")]
pub(crate) use code::read;
#[cfg(feature = "std")]
pub use find::{FoundFirings, find_firings};
pub use lattice::FiringLattice;
#[cfg(feature = "std")]
pub(crate) use lattice::shift_of;

use crate::error::ConfigError;

const BITS: u32 = u32::BITS;

/// Which ticks of a turn the sensor fired at. `WORDS` is the turn's ticks divided by 32, rounded up: 125 for 4000.
///
/// RAM: 10 bytes a word.
///
/// ```
/// use flicr::geometry::Firings;
/// let firings: Firings<125> = Firings::new(4000, (0..4000).step_by(2))?;
/// assert_eq!(firings.len(), 2000);
/// assert_eq!(firings.nearest(14), (7, 0));
/// assert_eq!(firings.nearest(3999), (1999, 1));
/// # Ok::<(), flicr::ConfigError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Firings<const WORDS: usize> {
    ticks: u16,
    len: u16,
    /// Bit t % 32 of word t / 32 for tick t.
    fired: [u32; WORDS],
    /// Firings before each word's first tick.
    before: [u16; WORDS],
    /// The list as it goes into a frame; nothing where `fired` is no longer.
    coded: [[u8; 4]; WORDS],
    coded_len: u16,
}

impl<const WORDS: usize> Firings<WORDS> {
    /// The list of some ticks, in any order, of a turn of `ticks`; those that come twice count once.
    ///
    /// # Errors
    /// [`ConfigError::Ticks`] where `ticks` is 0, more than 65,535 or more than `WORDS` hold; [`ConfigError::Firings`]
    /// where a tick is beyond the turn, or there is none.
    pub fn new(ticks: u32, fired_at: impl IntoIterator<Item = u32>) -> Result<Self, ConfigError> {
        let max = (WORDS as u32).saturating_mul(BITS).min(u16::MAX.into());
        if ticks == 0 || ticks > max {
            return Err(ConfigError::Ticks { found: ticks, max });
        }
        let mut firings = Self {
            ticks: ticks as u16,
            len: 0,
            fired: [0; WORDS],
            before: [0; WORDS],
            coded: [[0; 4]; WORDS],
            coded_len: 0,
        };
        for tick in fired_at {
            match firings.fired.get_mut((tick / BITS) as usize) {
                Some(word) if tick < ticks => *word |= 1 << (tick % BITS),
                _ => return Err(ConfigError::Firings { tick, ticks }),
            }
        }
        firings.count();
        if firings.len == 0 {
            return Err(ConfigError::Firings { tick: ticks, ticks });
        }
        firings.coded_len = code::write(&mut firings).unwrap_or(0);
        Ok(firings)
    }

    fn count(&mut self) {
        for (before, word) in self.before.iter_mut().zip(&self.fired) {
            *before = self.len;
            self.len += word.count_ones() as u16;
        }
    }

    /// Firings: columns of an image.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "it never is")]
    pub const fn len(&self) -> u16 {
        self.len
    }

    /// Ticks a turn.
    #[must_use]
    pub const fn ticks(&self) -> u32 {
        self.ticks as u32
    }

    /// The ticks, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        ticks_of(&self.fired)
    }

    /// The number of the firing nearest to a tick, and how many ticks away it is; the earlier of two.
    #[must_use]
    #[inline]
    pub fn nearest(&self, tick: u32) -> (u16, u32) {
        match self.at(tick) {
            Some(firing) => (firing, 0),
            None => self.beside(tick),
        }
    }

    /// The number of the firing at a tick, if there is one.
    #[inline]
    fn at(&self, tick: u32) -> Option<u16> {
        let (at, bit) = ((tick / BITS) as usize, 1 << (tick % BITS));
        let (word, before) = (*self.fired.get(at)?, *self.before.get(at)?);
        (word & bit != 0).then(|| before + (word & (bit - 1)).count_ones() as u16)
    }

    /// As [`nearest`](Self::nearest), where nothing was fired at the tick.
    #[cold]
    fn beside(&self, tick: u32) -> (u16, u32) {
        let ticks = self.ticks();
        let tick = if tick < ticks { tick } else { ticks - 1 };
        let around = |off: u32, ahead: bool| {
            let at = if ahead { tick + off } else { tick + ticks - off };
            self.at(if at < ticks { at } else { at - ticks })
        };
        let found = (0..=ticks / 2).find_map(|off| Some((around(off, false).or_else(|| around(off, true))?, off)));
        found.unwrap_or((0, ticks))
    }

    /// How a frame says which ticks these are, and the bytes by which it does.
    pub(crate) fn list_len(&self) -> usize {
        if self.coded_len > 0 { self.coded_len.into() } else { bitmap_len(self.ticks()) }
    }

    /// Whether the list is coded step by step; else it is a bit a tick.
    pub(crate) const fn is_coded(&self) -> bool {
        self.coded_len > 0
    }

    /// Hands out the bytes of the list.
    pub(crate) fn put(&self, mut put: impl FnMut(&[u8])) {
        if self.is_coded() {
            return put(self.coded.as_flattened().get(..self.list_len()).unwrap_or_default());
        }
        let bytes = self.fired.iter().flat_map(|word| word.to_le_bytes());
        bytes.take(self.list_len()).for_each(|byte| put(&[byte]));
    }
}

/// The ticks whose bits are set, ascending.
fn ticks_of(fired: &[u32]) -> impl Iterator<Item = u32> {
    let words = fired.iter().zip((0..).step_by(BITS as usize));
    words.flat_map(|(&word, first)| {
        let mut left = word;
        core::iter::from_fn(move || {
            let bit = (left != 0).then(|| left.trailing_zeros())?;
            left &= left - 1;
            Some(first + bit)
        })
    })
}

/// Bytes of a list that has a bit a tick.
pub(crate) const fn bitmap_len(ticks: u32) -> usize {
    ticks.div_ceil(8) as usize
}
