//! Float to index, the cheapest way of each target; all give the same.
#![allow(unsafe_code, reason = "x86-64 pays ten instructions for a conversion that saturates on its own")]

/// The whole part of `v`, no less than 0 and no more than `max`; NaN gives 0. `max` must be below 2^24.
#[inline(always)]
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn to_index(v: f32, max: u32) -> u32 {
    (v as u32).min(max)
}

/// The whole part of `v`, no less than 0 and no more than `max`; NaN gives 0. `max` must be below 2^24.
#[inline(always)]
#[cfg(target_arch = "x86_64")]
pub(crate) fn to_index(v: f32, max: u32) -> u32 {
    let max = (max & 0xff_ffff) as f32;
    let v = if v > 0.0 { v } else { 0.0 };
    let v = if v < max { v } else { max };
    // SAFETY: `v` is from 0 to 2^24, both comparisons being false for NaN.
    unsafe { v.to_int_unchecked::<i32>() as u32 }
}
