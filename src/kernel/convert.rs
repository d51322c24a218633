//! Float to integer, the cheapest way of each target.
//!
//! Between 0 and `max` all give the same. Above `max` a target may give `max` or any number above it: callers make no
//! difference between these.
#![allow(unsafe_code, reason = "x86-64 pays ten instructions for a conversion that saturates on its own")]

/// The whole part of `v` where that is from 0 to `max`, 0 below and for NaN, at least `max` above. `max` must be below
/// 2^24.
#[inline(always)]
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn to_index(v: f32, _max: u32) -> u32 {
    v as u32
}

/// The whole part of `v` where that is from 0 to `max`, 0 below and for NaN, at least `max` above. `max` must be below
/// 2^24.
#[inline(always)]
#[cfg(target_arch = "x86_64")]
pub(crate) fn to_index(v: f32, max: u32) -> u32 {
    let max = (max & 0xff_ffff) as f32;
    let v = if v > 0.0 { v } else { 0.0 };
    let v = if v < max { v } else { max };
    // SAFETY: `v` is from 0 to 2^24, both comparisons being false for NaN.
    unsafe { v.to_int_unchecked::<i32>() as u32 }
}

/// The whole part of `v`, which is between -2^31 and 2^31; 0 for NaN.
#[inline(always)]
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn to_angle(v: f32) -> i32 {
    v as i32
}

/// The whole part of `v`, which is between -2^31 and 2^31; 0 for NaN.
#[inline(always)]
#[cfg(target_arch = "x86_64")]
pub(crate) fn to_angle(v: f32) -> i32 {
    let v = if v.abs() < 2_147_483_520.0 { v } else { 0.0 };
    // SAFETY: `v` is below 2^31 either way, the comparison being false for NaN.
    unsafe { v.to_int_unchecked() }
}
