//! The list of firings in a frame: steps from tick to tick by an adaptive binary range coder, forward and inverse side by
//! side. Both walk through the same model; what differs is where a bit comes from.
//!
//! The encoder turns evenly and fires evenly, so that steps alternate between two neighbors in a pattern that drifts.
//! What the last seven steps were tells the next one to a sixth of a bit.

use super::Firings;

/// Steps that are looked back at.
const HISTORY: u32 = 7;
/// A step has at most 16 bits.
const EXPONENTS: usize = 16;
/// Below this, the range gets another byte.
const RANGE_MIN: u32 = 1 << 24;

/// A place that a byte no longer fits, or bytes that no encoder writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fault;

/// The probability that a bit is 1, as seen so far.
#[derive(Clone, Copy)]
struct Probability {
    /// 2^-16.
    one: u16,
    seen: u8,
}

impl Probability {
    const NEW: Self = Self { one: 1 << 15, seen: 0 };
    const SEEN_MAX: i32 = 30;
    /// Weight of the bit after so many, 2^-16: as if each had been seen 0.4 times before.
    const WEIGHTS: [i32; Self::SEEN_MAX as usize + 1] = {
        let (mut weights, mut seen) = ([0; Self::SEEN_MAX as usize + 1], 0);
        while seen <= Self::SEEN_MAX {
            weights[seen as usize] = 655_360 / (10 * seen + 18);
            seen += 1;
        }
        weights
    };

    fn learn(&mut self, bit: bool) {
        let weight = Self::WEIGHTS.get(usize::from(self.seen)).copied().unwrap_or(0);
        let (target, one) = (if bit { 65_535 } else { 0 }, i32::from(self.one));
        let learned = one + (((target - one) * (weight >> 2)) >> 14);
        self.one = learned.clamp(128, 65_535 - 128) as u16;
        self.seen = (self.seen + 1).min(Self::SEEN_MAX as u8);
    }
}

/// Where bits go to, or come from.
trait Bits {
    /// Codes a bit of the given probability of being 1; gives the bit.
    fn bit(&mut self, one: u16, bit: bool) -> Result<bool, Fault>;

    fn learned_bit(&mut self, probability: &mut Probability, bit: bool) -> Result<bool, Fault> {
        let bit = self.bit(probability.one, bit)?;
        probability.learn(bit);
        Ok(bit)
    }
}

struct Writer<'a> {
    out: &'a mut [u8],
    len: usize,
    low: u64,
    range: u32,
}

#[cfg(feature = "std")]
struct Reader<'a> {
    bytes: &'a [u8],
    /// Bytes asked for; those behind the end are 0.
    taken: usize,
    code: u32,
    range: u32,
}

/// The part of the range that stands for 1.
fn ones(range: u32, one: u16) -> u32 {
    (range >> 16) * u32::from(one)
}

impl Bits for Writer<'_> {
    fn bit(&mut self, one: u16, bit: bool) -> Result<bool, Fault> {
        let ones = ones(self.range, one);
        if bit {
            self.range = ones;
        } else {
            self.low += u64::from(ones);
            self.range -= ones;
        }
        while self.range < RANGE_MIN {
            self.put_byte()?;
            self.range <<= 8;
        }
        Ok(bit)
    }
}

#[cfg(feature = "std")]
impl Bits for Reader<'_> {
    fn bit(&mut self, one: u16, _: bool) -> Result<bool, Fault> {
        let ones = ones(self.range, one);
        let bit = self.code < ones;
        if bit {
            self.range = ones;
        } else {
            self.code -= ones;
            self.range -= ones;
        }
        while self.range < RANGE_MIN {
            self.take_byte();
            self.range <<= 8;
        }
        Ok(bit)
    }
}

impl Writer<'_> {
    fn put_byte(&mut self) -> Result<(), Fault> {
        if self.low >> 32 > 0 {
            self.carry();
        }
        *self.out.get_mut(self.len).ok_or(Fault)? = (self.low >> 24) as u8;
        self.len += 1;
        self.low = (self.low & 0x00ff_ffff) << 8;
        Ok(())
    }

    fn carry(&mut self) {
        for byte in self.out.iter_mut().take(self.len).rev() {
            *byte = byte.wrapping_add(1);
            if *byte != 0 {
                break;
            }
        }
    }

    /// Writes what the reader must see to tell the last bit; zeros behind it need not be there.
    fn finish(mut self) -> Result<usize, Fault> {
        let end = self.low + u64::from(self.range);
        let kept = (0..=32).rev().step_by(8).map(|bits| (1_u64 << bits) - 1);
        let shortest = kept.map(|mask| (self.low + mask) & !mask).find(|&value| value < end);
        self.low = shortest.unwrap_or(self.low);
        for _ in 0..4 {
            self.put_byte()?;
        }
        let written = self.out.get(..self.len).unwrap_or_default();
        Ok(written.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1))
    }
}

#[cfg(feature = "std")]
impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let mut reader = Self { bytes, taken: 0, code: 0, range: u32::MAX };
        (0..4).for_each(|_| reader.take_byte());
        reader
    }

    fn take_byte(&mut self) {
        self.code = self.code << 8 | u32::from(self.bytes.get(self.taken).copied().unwrap_or(0));
        self.taken += 1;
    }
}

/// What is known of the next step.
struct Model {
    /// The most common step; the list begins with it.
    base: i32,
    /// A bit a step: whether it was another than `base`.
    history: usize,
    is_other: [Probability; 1 << HISTORY],
    is_less: Probability,
    is_longer: [Probability; EXPONENTS],
}

impl Model {
    /// Codes the most common step.
    fn new(bits: &mut impl Bits, base: u32) -> Result<Self, Fault> {
        let mut model = Self::NEW;
        model.base = model.size(bits, base)?;
        model.is_longer = Self::NEW.is_longer;
        Ok(model)
    }

    const NEW: Self = {
        Self {
            base: 0,
            history: 0,
            is_other: [Probability::NEW; 1 << HISTORY],
            is_less: Probability::NEW,
            is_longer: [Probability::NEW; EXPONENTS],
        }
    };

    /// Codes a step; gives it. A reader's may be any number.
    fn step(&mut self, bits: &mut impl Bits, step: i32) -> Result<i32, Fault> {
        let more = step - self.base;
        let probability = self.is_other.get_mut(self.history).ok_or(Fault)?;
        let is_other = bits.learned_bit(probability, more != 0)?;
        self.history = (self.history << 1 | usize::from(is_other)) & ((1 << HISTORY) - 1);
        if !is_other {
            return Ok(self.base);
        }
        let is_less = bits.learned_bit(&mut self.is_less, more < 0)?;
        let size = self.size(bits, more.unsigned_abs())?;
        Ok(self.base + if is_less { -size } else { size })
    }

    /// A number from 1 on: the position of its highest bit in unary, then the bits below.
    fn size(&mut self, bits: &mut impl Bits, size: u32) -> Result<i32, Fault> {
        let exponent = size.checked_ilog2().unwrap_or(0);
        let mut found = 0;
        while bits.learned_bit(self.is_longer.get_mut(found as usize).ok_or(Fault)?, found < exponent)? {
            found += 1;
        }
        let mut value = 1;
        for place in (0..found).rev() {
            value = value << 1 | i32::from(bits.bit(1 << 15, size >> place & 1 == 1)?);
        }
        Ok(value)
    }
}

/// Codes the list; gives its length. `None` where a bit a tick is no longer.
pub(super) fn write<const WORDS: usize>(firings: &mut Firings<WORDS>) -> Option<u16> {
    let fired = firings.fired;
    let most = super::bitmap_len(firings.ticks()) - 1;
    let out = firings.coded.as_flattened_mut().get_mut(..most)?;
    let mut writer = Writer { out, len: 0, low: 0, range: u32::MAX };
    let (mut model, mut before) = (Model::new(&mut writer, common_step(&fired)).ok()?, -1);
    for tick in super::ticks_of(&fired) {
        model.step(&mut writer, tick.cast_signed() - before).ok()?;
        before = tick.cast_signed();
    }
    let len = writer.finish().ok()?;
    // A list of no bytes would pass for none.
    (len > 0).then_some(len as u16)
}

/// The step that more than half of all are, if there is one; else one of them.
fn common_step(fired: &[u32]) -> u32 {
    let (mut common, mut votes, mut before) = (1, 0_u32, 0);
    for tick in super::ticks_of(fired).skip(1) {
        let step = (tick - before).max(1);
        before = tick;
        if step == common {
            votes += 1;
        } else if votes == 0 {
            (common, votes) = (step, 1);
        } else {
            votes -= 1;
        }
    }
    common
}

/// The inverse: appends the ticks of `len` firings.
#[cfg(feature = "std")]
pub(crate) fn read(
    bytes: &[u8],
    is_coded: bool,
    ticks: u32,
    len: u32,
    found: &mut std::vec::Vec<u32>,
) -> Result<(), Fault> {
    let from = found.len();
    if is_coded {
        read_steps(bytes, ticks, len, found)?;
    } else if bytes.len() == super::bitmap_len(ticks) {
        let bits = bytes.iter().flat_map(|byte| (0..8).map(move |bit| byte >> bit & 1 == 1));
        found.extend((0..).zip(bits).filter(|(_, fired)| *fired).map(|(tick, _)| tick));
    }
    let found = &found[from..];
    let right = found.len() == len as usize && found.last().is_some_and(|&last| last < ticks);
    if right { Ok(()) } else { Err(Fault) }
}

#[cfg(feature = "std")]
fn read_steps(bytes: &[u8], ticks: u32, len: u32, found: &mut std::vec::Vec<u32>) -> Result<(), Fault> {
    let mut reader = Reader::new(bytes);
    let (mut model, mut before) = (Model::new(&mut reader, 0)?, -1_i32);
    for _ in 0..len {
        let tick = before + model.step(&mut reader, 0)?;
        if tick <= before || tick >= ticks.cast_signed() {
            return Err(Fault);
        }
        found.push(tick.cast_unsigned());
        before = tick;
    }
    if reader.taken < bytes.len() || bytes.last() == Some(&0) { Err(Fault) } else { Ok(()) }
}
