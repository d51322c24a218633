//! Times: one for every column, as whole units from the frame's own time. Columns come at even intervals, or nearly so: what
//! is coded is how the distance from a line changes from one to the next, which mostly is nothing.

use super::{PART_HEADER_LEN, SECTION_HEADER_LEN, Strips, put_part};
use crate::coder::context::number::{Chance, Number};
use crate::coder::context::range_coder::{BinaryCoder, RangeEncoder};
use crate::coder::{OutputFull, Sink};

/// Bytes of the body before the first strip's part.
const PREFIX_LEN: usize = 4;
/// Bytes of a part before its code.
const PART_PREFIX_LEN: usize = 16;
/// Fraction bits of the line's slope.
const SLOPE_BITS: u32 = 16;
/// Most units by which a distance changes at once; what is beyond waits for the next column.
const CHANGE_MAX: i64 = 1 << 30;
/// Longest time between a strip's first and last column, units.
const SPAN_MAX: i64 = 1 << 46;
/// Most that a column takes: 34 decisions, none less likely than 2^-12, and 31 bits as they are.
const COLUMN_BYTES_MAX: usize = 56;

/// The times of an image's columns: of the firings, where columns are these.
#[derive(Debug, Clone, Copy)]
pub struct TimesPlane<'a> {
    times_ns: &'a [u64],
    unit_ns: u32,
}

impl<'a> TimesPlane<'a> {
    /// A plane of these times, of the epoch of [`Stamp::timestamp_ns`](crate::Stamp::timestamp_ns) and near it, kept in whole
    /// units of `unit_ns`, so that they are off by at most half of that. 0 where a column's time is not known: it comes back
    /// as if it was on a line with its neighbors. `None` where the unit is 0.
    #[must_use]
    pub const fn new(times_ns: &'a [u64], unit_ns: u32) -> Option<Self> {
        if unit_ns > 0 { Some(Self { times_ns, unit_ns }) } else { None }
    }

    /// Most bytes by which it makes a frame of `columns` columns and `strips` strips longer.
    #[must_use]
    pub const fn worst_case_len(columns: usize, strips: usize) -> usize {
        let part_len = PART_HEADER_LEN + PART_PREFIX_LEN + 1;
        SECTION_HEADER_LEN + PREFIX_LEN + part_len * strips + COLUMN_BYTES_MAX * columns
    }

    /// Columns that there are times for.
    pub(crate) const fn columns(&self) -> usize {
        self.times_ns.len()
    }

    /// Writes the section's body to the front of `out` and gives its length.
    pub(super) fn encode(&self, timestamp_ns: u64, strips: Strips<'_>, out: &mut [u8]) -> Result<usize, OutputFull> {
        Sink::new(out).put_all(&self.unit_ns.to_le_bytes())?;
        let mut at = PREFIX_LEN;
        for (first, columns) in strips {
            let times_ns = self.times_ns.get(first..first + columns).unwrap_or_default();
            at = put_part(out, at, |out| self.encode_part(timestamp_ns, times_ns, out))?;
        }
        Ok(at)
    }

    fn encode_part(&self, timestamp_ns: u64, times_ns: &[u64], out: &mut [u8]) -> Result<usize, OutputFull> {
        let units = |time_ns: u64| self.units(time_ns.wrapping_sub(timestamp_ns).cast_signed());
        let mut known = (0..).zip(times_ns).filter(|&(_, &time_ns)| time_ns != 0);
        let first = known.next();
        let ends = first.map(|first| (first, known.last().unwrap_or(first)));
        let line = ends.map_or(Line::NONE, |((a, &first_ns), (b, &last_ns))| {
            Line::through((a, units(first_ns)), (b, units(last_ns)))
        });
        let (prefix, code) = out.split_first_chunk_mut::<PART_PREFIX_LEN>().ok_or(OutputFull)?;
        *prefix = line.bytes();
        let (mut coder, mut changes, mut off) = (RangeEncoder::new(code), Changes::NEW, 0_i64);
        for (at, &time_ns) in (0..).zip(times_ns) {
            let change = if time_ns == 0 { 0 } else { units(time_ns).wrapping_sub(line.at(at)).saturating_sub(off) };
            off = off.saturating_add(changes.code(&mut coder, change.clamp(-CHANGE_MAX, CHANGE_MAX)));
        }
        Ok(PART_PREFIX_LEN + coder.finish().ok_or(OutputFull)?)
    }

    /// Rounded.
    const fn units(&self, ns: i64) -> i64 {
        let unit = if self.unit_ns == 0 { 1 } else { self.unit_ns as i64 };
        let whole = ns.div_euclid(unit);
        if 2 * ns.rem_euclid(unit) >= unit { whole + 1 } else { whole }
    }
}

/// Times at even intervals, in units.
#[derive(Debug, Clone, Copy)]
struct Line {
    first: i64,
    /// 2^-16 units a column.
    slope: i64,
}

impl Line {
    /// Where no time is known.
    const NONE: Self = Self { first: 0, slope: 0 };

    /// Through two columns and their times.
    fn through((at, units): (i64, i64), (last_at, last_units): (i64, i64)) -> Self {
        let span = last_units.saturating_sub(units).clamp(-SPAN_MAX, SPAN_MAX);
        let slope = (span << SLOPE_BITS).checked_div(last_at - at).unwrap_or(0);
        let line = Self { first: 0, slope };
        Self { first: units.wrapping_sub(line.at(at)), slope }
    }

    /// The time at a column, rounded.
    const fn at(self, column: i64) -> i64 {
        let beyond = self.slope.wrapping_mul(column).wrapping_add(1 << (SLOPE_BITS - 1)) >> SLOPE_BITS;
        self.first.wrapping_add(beyond)
    }

    fn bytes(self) -> [u8; PART_PREFIX_LEN] {
        bytemuck::cast([self.first.to_le_bytes(), self.slope.to_le_bytes()])
    }
}

/// The probabilities of changes.
struct Changes {
    /// By how many of the last two columns had one.
    is_change: [Chance; 3],
    last: [bool; 2],
    is_less: Chance,
    size: Number,
}

impl Changes {
    const NEW: Self = Self {
        is_change: [Chance::RARE, Chance::EVEN, Chance::EVEN],
        last: [false; 2],
        is_less: Chance::EVEN,
        size: Number::NEW,
    };

    /// One change: given in the forward direction, found in the inverse one.
    fn code(&mut self, coder: &mut impl BinaryCoder, change: i64) -> i64 {
        let [last, before] = self.last;
        let chance = &mut self.is_change[(usize::from(last) + usize::from(before)) % 3];
        let is_change = chance.code(coder, change != 0);
        self.last = [is_change, last];
        if !is_change {
            return 0;
        }
        let is_less = self.is_less.code(coder, change < 0);
        let size = i64::from(self.size.code(coder, change.unsigned_abs().saturating_sub(1) as u32)) + 1;
        if is_less { -size } else { size }
    }
}

#[cfg(feature = "std")]
pub(crate) use inverse::decode;

#[cfg(feature = "std")]
mod inverse {
    use std::vec::Vec;

    use super::super::decode::Parts;
    use super::{Changes, Line, PART_PREFIX_LEN, PREFIX_LEN};
    use crate::coder::check_len;
    use crate::coder::context::range_coder::RangeDecoder;
    use crate::error::PayloadFault;

    /// Reads a section's body: the time of each column.
    pub(crate) fn decode(
        body: &[u8],
        timestamp_ns: u64,
        strips: &[(usize, usize)],
        times_ns: &mut Vec<u64>,
    ) -> Result<(), PayloadFault> {
        let (unit_ns, parts) = body.split_first_chunk::<PREFIX_LEN>().ok_or(PayloadFault::TooShort)?;
        let unit_ns = u32::from_le_bytes(*unit_ns);
        if unit_ns == 0 {
            return Err(PayloadFault::Malformed);
        }
        let mut parts = Parts::new(parts);
        for &(_, columns) in strips {
            let part = parts.next()?;
            let (prefix, code) = part.split_first_chunk::<PART_PREFIX_LEN>().ok_or(PayloadFault::TooShort)?;
            let [first, slope] = bytemuck::cast::<_, [[u8; 8]; 2]>(*prefix).map(i64::from_le_bytes);
            let line = Line { first, slope };
            let (mut coder, mut changes, mut off) = (RangeDecoder::new(code), Changes::NEW, 0_i64);
            for at in (0..).take(columns) {
                off = off.saturating_add(changes.code(&mut coder, 0));
                let units = line.at(at).wrapping_add(off);
                times_ns.push(timestamp_ns.wrapping_add(units.wrapping_mul(unit_ns.into()).cast_unsigned()));
                if coder.is_past_end() {
                    return Err(PayloadFault::TooShort);
                }
            }
            check_len(code.len(), coder.code_len())?;
        }
        parts.finish()
    }
}
