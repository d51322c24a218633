//! The square root, correctly rounded on every target: IEEE 754 leaves no choice, so all of these are equal.
#![allow(unsafe_code, reason = "one machine instruction that core has no stable name for")]

/// Square root of `v`; NaN below zero.
#[inline(always)]
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
pub(crate) fn sqrt(v: f32) -> f32 {
    let mut bits = v.to_bits();
    // rustc hands out single-precision registers only where there are double-precision ones, which a Cortex-M4F does
    // not have: the value goes through a core register, and s0 is named as overwritten.
    // SAFETY: hard-float targets have these instructions; they read and write one core register and s0.
    unsafe {
        core::arch::asm!(
            "vmov s0, {0}",
            "vsqrt.f32 s0, s0",
            "vmov {0}, s0",
            inout(reg) bits,
            out("s0") _,
            options(pure, nomem, nostack, preserves_flags),
        );
    }
    f32::from_bits(bits)
}

/// Square root of `v`; NaN below zero.
#[inline(always)]
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
pub(crate) fn sqrt(v: f32) -> f32 {
    use core::arch::aarch64::{vdup_n_f32, vget_lane_f32, vsqrt_f32};
    // SAFETY: NEON is enabled for the whole build. LLVM knows these as its own square root, so it still vectorizes
    // the loop around them.
    #[allow(unused_unsafe, reason = "newer compilers know that these are safe here")]
    unsafe {
        vget_lane_f32::<0>(vsqrt_f32(vdup_n_f32(v)))
    }
}

/// Square root of `v`; NaN below zero.
#[inline(always)]
#[cfg(target_arch = "x86_64")]
pub(crate) fn sqrt(v: f32) -> f32 {
    use core::arch::x86_64::{_mm_cvtss_f32, _mm_set_ss, _mm_sqrt_ss};
    // SAFETY: SSE2 is part of x86-64. As above, LLVM sees through these.
    #[allow(unused_unsafe, reason = "newer compilers know that these are safe here")]
    unsafe {
        _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(v)))
    }
}

/// Square root of `v`; NaN below zero.
#[inline(always)]
#[cfg(not(any(
    all(target_arch = "arm", target_abi = "eabihf"),
    all(target_arch = "aarch64", target_feature = "neon"),
    target_arch = "x86_64"
)))]
pub(crate) fn sqrt(v: f32) -> f32 {
    libm::sqrtf(v)
}
