//! Intensities of returns and times of columns, besides ranges.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use core::ffi::c_void;

use super::config::pixels;
use super::memory::{Outcome, Records, Span, check_place};
use super::status::flicr_status;
use crate::image::{ImageView, Level};
use crate::plane::{IntensityCoder, IntensityPlane, IntensityScale, Planes, TimesPlane};

/// Most rows that intensities can have.
pub const FLICR_INTENSITY_ROWS_MAX: usize = 128;
/// Bytes of memory that intensities are coded with.
pub const FLICR_INTENSITY_STATE_LEN: usize = 33_536;
/// Bytes by which intensities make a frame longer, besides FLICR_INTENSITY_STRIP_LEN a strip and one a pixel, at most.
pub const FLICR_INTENSITY_OVERHEAD_LEN: usize = 16;
/// Bytes of these that each strip takes.
pub const FLICR_INTENSITY_STRIP_LEN: usize = 6;
/// Bytes by which times make a frame longer, besides FLICR_TIMES_STRIP_LEN a strip and FLICR_TIMES_COLUMN_LEN a column, at
/// most.
pub const FLICR_TIMES_OVERHEAD_LEN: usize = 12;
/// Bytes of these that each strip takes.
pub const FLICR_TIMES_STRIP_LEN: usize = 21;
/// Bytes of these that each column takes.
pub const FLICR_TIMES_COLUMN_LEN: usize = 56;

/// Classes of rows.
const CLASSES: usize = 8;

type CIntensities = IntensityCoder<FLICR_INTENSITY_ROWS_MAX, CLASSES>;

const _: () = {
    let _: [u8; size_of::<CIntensities>()] = [0; FLICR_INTENSITY_STATE_LEN];
    assert!(FLICR_INTENSITY_OVERHEAD_LEN == IntensityPlane::worst_case_len(0, 0));
    assert!(FLICR_INTENSITY_STRIP_LEN == IntensityPlane::worst_case_len(0, 1) - IntensityPlane::worst_case_len(0, 0));
    assert!(FLICR_TIMES_OVERHEAD_LEN == TimesPlane::worst_case_len(0, 0));
    assert!(FLICR_TIMES_STRIP_LEN == TimesPlane::worst_case_len(0, 1) - TimesPlane::worst_case_len(0, 0));
    assert!(FLICR_TIMES_COLUMN_LEN == TimesPlane::worst_case_len(1, 0) - TimesPlane::worst_case_len(0, 0));
    // A constant that is no value of its type does not compile.
    // SAFETY: so zeros are a coder.
    let _: CIntensities = unsafe { core::mem::zeroed() };
};

/// What a frame is to carry besides ranges: intensities, times, or both. All of it is the caller's memory, used during the
/// calls that it is given to.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct flicr_planes {
    /// A number for each pixel, columns x rows of them, row by row: flicr_insert_lit and flicr_insert_lit_returns put them
    /// there, flicr_finish_with and flicr_finish_returns_with take them from there. Null: no intensities.
    pub intensities: *mut u8,
    /// FLICR_INTENSITY_STATE_LEN bytes at an even address, whatever they hold; not looked at without intensities.
    pub intensity_state: *mut c_void,
    /// Numbers for an intensity of 1: 1 for a sensor's own numbers, 100 for hundredths. Positive and finite.
    pub intensity_per_unit: f32,
    /// Distance of the numbers that are kept, 1 to 255: 1 keeps them as they are, 16 about 4 bits of them.
    pub intensity_step: u32,
    /// A time for each column, nanoseconds of the stamp's epoch; 0 where it is not known. Null: no times.
    pub times_ns: *const u64,
    /// Times are kept in whole units of this, not 0.
    pub time_unit_ns: u32,
}

/// What FLICR_PLANES_WORST_CASE_LEN gives: output bytes that are enough for intensities and times, besides those for the
/// frame without them. 0 where there can be no such frame.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_planes_worst_case_len(columns: u32, rows: u32, strips: u32) -> usize {
    let (Ok(pixels), true) = (pixels(columns, rows), (1..=columns).contains(&strips)) else { return 0 };
    let strips = strips as usize;
    IntensityPlane::worst_case_len(pixels, strips) + TimesPlane::worst_case_len(columns as usize, strips)
}

/// The parts of [`flicr_planes`], of an image's size.
#[derive(Debug, Clone, Copy)]
pub(super) struct LentPlanes {
    planes: flicr_planes,
    numbers: Span,
    state: Span,
    times: Span,
}

impl LentPlanes {
    pub(super) fn new(planes: flicr_planes, pixels: usize, columns: usize) -> Outcome<Self> {
        let (mut numbers, mut state, mut times) = (Span::NONE, Span::NONE, Span::NONE);
        if !planes.intensities.is_null() {
            numbers = Span::new(planes.intensities.cast(), pixels)?;
            check_place(planes.intensity_state.cast::<CIntensities>())?;
            state = Span::new(planes.intensity_state, FLICR_INTENSITY_STATE_LEN)?;
        }
        if !planes.times_ns.is_null() {
            check_place(planes.times_ns)?;
            times = Span::new(planes.times_ns.cast(), size_of::<u64>() * columns)?;
        }
        Ok(Self { planes, numbers, state, times })
    }

    /// All memory that they are.
    pub(super) const fn spans(&self) -> [Span; 3] {
        [self.numbers, self.state, self.times]
    }

    /// Puts the sections behind the frame in the first `len` bytes of `out`; gives the new length.
    ///
    /// # Safety
    /// The spans may be read and the state's written, are apart from all else that is borrowed, and nobody else uses them
    /// meanwhile.
    pub(super) unsafe fn append<L: Level>(
        &self,
        image: ImageView<'_, L>,
        timestamp_ns: u64,
        len: usize,
        out: &mut [u8],
    ) -> Outcome<usize> {
        let mut planes = Planes::default();
        let flicr_planes { intensity_per_unit, intensity_step, time_unit_ns, .. } = self.planes;
        if !self.planes.intensities.is_null() {
            let step = u8::try_from(intensity_step).map_err(|_| flicr_status::Plane)?;
            let scale = IntensityScale::new(intensity_per_unit, step).ok_or(flicr_status::Plane)?;
            // SAFETY: the caller's promise; zeros are a coder, aligned as `new` has found.
            let (coder, numbers) = unsafe {
                self.planes.intensity_state.write_bytes(0, FLICR_INTENSITY_STATE_LEN);
                (&mut *self.planes.intensity_state.cast::<CIntensities>(), self.numbers.bytes())
            };
            planes.intensity = Some(coder.plane(numbers, scale));
        }
        if !self.planes.times_ns.is_null() {
            // SAFETY: the caller's promise; aligned, as `new` has found.
            let times_ns =
                unsafe { core::slice::from_raw_parts(self.planes.times_ns, self.times.len / size_of::<u64>()) };
            planes.times = Some(TimesPlane::new(times_ns, time_unit_ns).ok_or(flicr_status::Plane)?);
        }
        planes.check(image)?;
        planes.append(image, timestamp_ns, len, out).map_err(|_| flicr_status::OutputTooSmall)
    }

    /// Numbers' places.
    ///
    /// # Safety
    /// As [`append`](Self::append), and they may be written.
    pub(super) unsafe fn numbers<'a>(&self) -> Outcome<&'a mut [u8]> {
        check_place(self.planes.intensities)?;
        // SAFETY: the caller's promise.
        Ok(unsafe { core::slice::from_raw_parts_mut(self.planes.intensities, self.numbers.len) })
    }
}

/// A number for each of the records.
pub(super) fn numbers_of(records: &Records, numbers: *const u8) -> Outcome<Span> {
    if records.count == 0 { Ok(Span::NONE) } else { Span::new(numbers.cast(), records.count as usize) }
}
