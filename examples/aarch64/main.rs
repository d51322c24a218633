//! Firmware for a bare AArch64 core (QEMU's `virt` board with a Cortex-A53): encodes scans that it reads from the host,
//! and says what that cost. `cortex_m` is the same for microcontrollers.
//!
//! ```sh
//! tools/cross.sh build --profile firmware --example aarch64 --target aarch64-unknown-none
//! tools/emulate.sh a53 target/cross-rustup/aarch64-unknown-none/firmware/examples/aarch64 SCAN.bin OUT 4500:rle:120
//! ```
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_arch = "aarch64", target_os = "none"))]
mod virt;

#[cfg(all(target_arch = "aarch64", target_os = "none"))]
#[path = "../firmware/mod.rs"]
mod firmware;

#[cfg(all(target_arch = "aarch64", target_os = "none"))]
mod start;

// All the memory there is, known when linking: nothing is allocated, and nothing large is ever on the stack.
#[cfg(all(target_arch = "aarch64", target_os = "none"))]
static MEMORY: static_cell::ConstStaticCell<firmware::Memory> =
    static_cell::ConstStaticCell::new(firmware::Memory::new());

/// Gives the exit code.
#[cfg(all(target_arch = "aarch64", target_os = "none"))]
fn run() -> i32 {
    match MEMORY.try_take() {
        Some(memory) => firmware::main(&mut virt::Virt::new(), memory),
        None => 2,
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: see the comment at its top");
    std::process::exit(2);
}
