//! Memory of the caller's: what pointers are checked for before they are used, and how records are read.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use core::ffi::c_void;

use super::context::{CDense, CSmall, FLICR_DENSE_STATE_LEN, FLICR_SMALL_STATE_LEN};
use super::status::flicr_status;
use crate::coder::{Coder, DeflateDefault, DeflateDense, DeflateSmall, Rle, Store};
use crate::point::{Block, Points, StridedPoints, XYZ_LEN, read_xyz};
use crate::returns::GridReturn;

pub(super) type Outcome<T> = Result<T, flicr_status>;

pub(super) fn code(outcome: Outcome<()>) -> flicr_status {
    outcome.err().unwrap_or(flicr_status::Ok)
}

/// Checks where the result is to go, does the work, and writes the result if there is one. The work is told where that
/// is: what it reads or writes must be apart from it.
///
/// # Safety
/// `out` is null or may be written to.
pub(super) unsafe fn deliver<T>(out: *mut T, work: impl FnOnce(Span) -> Outcome<T>) -> flicr_status {
    code(check_place(out).and_then(|()| {
        let result = work(Span { start: out.cast(), len: size_of::<T>() })?;
        // SAFETY: neither null nor misaligned, and the caller's promise.
        unsafe { out.write(result) };
        Ok(())
    }))
}

pub(super) fn check_place<T>(place: *const T) -> Outcome<()> {
    if place.is_null() {
        Err(flicr_status::NullPointer)
    } else if !place.is_aligned() {
        Err(flicr_status::Misaligned)
    } else {
        Ok(())
    }
}

/// # Safety
/// `place` is null or may be read.
pub(super) unsafe fn read<T: Copy>(place: *const T) -> Outcome<T> {
    check_place(place)?;
    // SAFETY: neither null nor misaligned, and the caller's promise.
    Ok(unsafe { place.read() })
}

/// The choice that has this number: C's numbers are those of the enumerations here.
pub(super) fn choose<T: Copy>(choices: &[T], number: u32, otherwise: flicr_status) -> Outcome<T> {
    choices.get(number as usize).copied().ok_or(otherwise)
}

/// Coders that may start as zeros where they are to stay. One that is made elsewhere and moved there goes through the
/// stack, which on a device is smaller than the coder.
///
/// # Safety
/// Zeros must be a value of the type, and code as a new one does.
pub(super) unsafe trait StartsAsZeros: Coder<u8> + Coder<u16> + Sized {
    /// Bytes that are kept for it; the header says them.
    const STATE_LEN: usize = size_of::<Self>();
}

// SAFETY: there is no state.
unsafe impl StartsAsZeros for Store {}
// SAFETY: there is no state.
unsafe impl StartsAsZeros for Rle {}
// SAFETY: numbers only, as the constants below show, and all zero when new, as the type's documentation promises.
unsafe impl StartsAsZeros for DeflateDefault {}
// SAFETY: as above.
unsafe impl StartsAsZeros for DeflateSmall {}
// SAFETY: as above.
unsafe impl StartsAsZeros for DeflateDense {}
// SAFETY: numbers, and a predictor whose number may be 0; before an image all but the settings are set up anew.
unsafe impl StartsAsZeros for CSmall {
    const STATE_LEN: usize = FLICR_SMALL_STATE_LEN;
}
// SAFETY: as above.
unsafe impl StartsAsZeros for CDense {
    const STATE_LEN: usize = FLICR_DENSE_STATE_LEN;
}

// SAFETY: a constant that is no value of its type does not compile.
const _: DeflateDefault = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: DeflateSmall = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: DeflateDense = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: CSmall = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: CDense = unsafe { core::mem::zeroed() };

/// Memory that C lends for one call.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) start: *const u8,
    pub(super) len: usize,
}

impl Span {
    pub(super) const NONE: Self = Self { start: core::ptr::dangling(), len: 0 };

    /// A slice has no more bytes than `isize` counts; a longer one cannot be meant.
    pub(super) fn new(start: *const c_void, len: usize) -> Outcome<Self> {
        check_place(start)?;
        Ok(Self { start: start.cast(), len: len.min(isize::MAX as usize) })
    }

    /// # Safety
    /// The span may be read, and nobody writes to it before the result's last use.
    pub(super) const unsafe fn bytes<'a>(self) -> &'a [u8] {
        // SAFETY: the caller's promise; bytes need no alignment.
        unsafe { core::slice::from_raw_parts(self.start, self.len) }
    }

    pub(super) fn is_apart(&self, other: &Self) -> bool {
        let (a, b) = (self.start.addr(), other.start.addr());
        a.saturating_add(self.len) <= b || b.saturating_add(other.len) <= a
    }
}

/// Checks that no two of the spans share a byte.
pub(super) fn check_apart<const N: usize>(memory: Span, others: [Span; N]) -> Outcome<()> {
    let mut apart = true;
    let mut rest = others.as_slice();
    while let Some((one, behind)) = rest.split_first() {
        apart &= memory.is_apart(one) && behind.iter().all(|other| one.is_apart(other));
        rest = behind;
    }
    if apart { Ok(()) } else { Err(flicr_status::Overlap) }
}

/// Records that start with x, y, z; the last one may end behind them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Records {
    pub(super) span: Span,
    pub(super) count: u32,
    stride: usize,
}

impl Records {
    pub(super) fn new(points: *const c_void, count: usize, stride: usize) -> Outcome<Self> {
        if stride < XYZ_LEN {
            return Err(flicr_status::Stride);
        }
        let Some(gaps) = count.checked_sub(1) else {
            return Ok(Self { span: Span::NONE, count: 0, stride });
        };
        let len = gaps.checked_mul(stride).and_then(|len| len.checked_add(XYZ_LEN));
        let len = len.filter(|&len| isize::try_from(len).is_ok()).ok_or(flicr_status::TooManyPoints)?;
        let count = u32::try_from(count).map_err(|_| flicr_status::TooManyPoints)?;
        Ok(Self { span: Span::new(points, len)?, count, stride })
    }

    /// # Safety
    /// The span may be read, and nobody writes to it before the result's last use.
    pub(super) unsafe fn points<'a>(self) -> Outcome<StridedXyz<'a>> {
        // SAFETY: the caller's promise.
        StridedXyz::new(unsafe { self.span.bytes() }, self.stride).ok_or(flicr_status::Stride)
    }

    /// # Safety
    /// As [`points`](Self::points).
    pub(super) unsafe fn returns(self) -> impl Iterator<Item = GridReturn> {
        // SAFETY: the caller's promise.
        read_returns(unsafe { self.span.bytes() }, self.stride)
    }
}

/// Returns that start their records: tick, count and row, four bytes each.
pub(super) fn read_returns(bytes: &[u8], stride: usize) -> impl Iterator<Item = GridReturn> {
    bytes.chunks(stride.max(1)).filter_map(|record| {
        let (fields, _) = record.get(..XYZ_LEN)?.as_chunks::<4>();
        let field = |at: usize| fields.get(at).copied().map_or(0, u32::from_ne_bytes);
        // No sensor has as many beams as a row's number has room for.
        let row = u16::try_from(field(2)).unwrap_or(u16::MAX);
        Some(GridReturn { tick: field(0), count: field(1), row })
    })
}

/// Records of which the last may end behind x, y, z: [`StridedPoints`] takes whole ones only.
#[derive(Debug, Clone, Copy)]
pub(super) struct StridedXyz<'a> {
    whole: StridedPoints<'a>,
    last: &'a [u8],
}

impl<'a> StridedXyz<'a> {
    pub(super) fn new(bytes: &'a [u8], stride: usize) -> Option<Self> {
        let whole = StridedPoints::new(bytes, stride)?;
        let last = bytes.get(bytes.len() - whole.remainder_len()..)?;
        Some(Self { whole, last })
    }
}

impl Points for StridedXyz<'_> {
    fn for_each_block(&self, mut each: impl FnMut(&Block, usize)) {
        self.whole.for_each_block(&mut each);
        if !self.last.is_empty() {
            let mut block = Block::new();
            let len = block.fill(core::iter::once(read_xyz(self.last)));
            each(&block, len);
        }
    }
}

/// Where a frame is to go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output {
    pub(super) span: Span,
}

impl Output {
    pub(super) fn new(start: *mut c_void, len: usize) -> Outcome<Self> {
        Ok(Self { span: Span::new(start, len)? })
    }

    /// # Safety
    /// The span came from a pointer that may be written through, and nobody else uses it before the result's last
    /// use.
    pub(super) unsafe fn bytes<'a>(self) -> &'a mut [u8] {
        // SAFETY: the caller's promise. What it holds is written before it is read.
        unsafe { core::slice::from_raw_parts_mut(self.span.start.cast_mut(), self.span.len) }
    }
}
