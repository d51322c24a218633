//! How deep the stack gets, by painting what lies below it and looking which paint is gone.

use core::arch::asm;

/// How far below the stack pointer is painted: four times what the codec may use.
const PAINTED_BYTES: usize = 16 * 1024;
const WORDS: usize = PAINTED_BYTES / size_of::<u32>();
const PAINT: u32 = 0xF11C_4A57;

/// Runs `f` and gives the bytes of stack that it and its callees took, at most [`PAINTED_BYTES`].
pub fn depth_of<R>(f: impl FnOnce() -> R) -> (R, usize) {
    let bottom = paint();
    let result = call(f);
    (result, unpainted_bytes(bottom))
}

/// Keeps `f`'s locals out of the frame that paints.
#[inline(never)]
fn call<R>(f: impl FnOnce() -> R) -> R {
    f()
}

/// Paints below its own frame and gives the lowest address painted.
#[inline(never)]
fn paint() -> *mut u32 {
    let bottom = stack_pointer().wrapping_sub(WORDS);
    for word in 0..WORDS {
        // SAFETY: nothing lives below the stack pointer, interrupts are off, and the linker scripts leave megabytes
        // between it and the statics.
        unsafe { bottom.add(word).write_volatile(PAINT) };
    }
    bottom
}

#[inline(never)]
fn unpainted_bytes(bottom: *const u32) -> usize {
    // SAFETY: as in `paint`, which wrote all of these words.
    let still_painted = |word: &usize| unsafe { bottom.add(*word).read_volatile() } == PAINT;
    PAINTED_BYTES - (0..WORDS).take_while(still_painted).count() * size_of::<u32>()
}

#[inline(always)]
fn stack_pointer() -> *mut u32 {
    let pointer: *mut u32;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags)) };
    pointer
}
