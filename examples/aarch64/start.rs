//! How a bare AArch64 core comes to Rust: to `crate::run`, whose exit code is the emulator's.

use core::arch::global_asm;

// The first code to run: one core, at exception level 1, caches and MMU off, no stack, statics not yet zero.
global_asm!(
    ".pushsection .text.start, \"ax\"",
    ".global _start",
    "_start:",
    // Floating-point and vector registers trap until CPACR_EL1.FPEN says otherwise.
    "mov x0, #(3 << 20)",
    "msr cpacr_el1, x0",
    "adrp x0, exception_vectors",
    "add x0, x0, :lo12:exception_vectors",
    "msr vbar_el1, x0",
    "isb",
    "adrp x0, __stack_top",
    "add x0, x0, :lo12:__stack_top",
    "mov sp, x0",
    "adrp x0, __bss_start",
    "add x0, x0, :lo12:__bss_start",
    "adrp x1, __bss_end",
    "add x1, x1, :lo12:__bss_end",
    "0: cmp x0, x1",
    "b.hs 1f",
    "stp xzr, xzr, [x0], #16",
    "b 0b",
    "1: bl {main}",
    ".popsection",
    // Every exception goes to one place; which one it was, ESR_EL1 tells.
    ".pushsection .text.vectors, \"ax\"",
    ".balign 2048",
    "exception_vectors:",
    ".rept 16",
    ".balign 128",
    "b {exception}",
    ".endr",
    ".popsection",
    main = sym main,
    exception = sym exception,
);

extern "C" fn main() -> ! {
    semihosting::process::exit(crate::run())
}

/// A fault ends the emulator, with a code of its own; otherwise it would hang.
extern "C" fn exception() -> ! {
    let (syndrome, address): (u64, u64);
    // SAFETY: reads two registers.
    unsafe { core::arch::asm!("mrs {}, esr_el1", "mrs {}, elr_el1", out(reg) syndrome, out(reg) address) };
    semihosting::eprintln!("exception at {address:#x}, syndrome {syndrome:#x}");
    semihosting::process::exit(3)
}
