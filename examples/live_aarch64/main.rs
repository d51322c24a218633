//! Firmware for a bare AArch64 core (QEMU's `virt` board with a Cortex-A53) that streams: packets come in by its UART, and
//! datagrams go out by the same. `live_cortex_m` is the same for microcontrollers, with an interrupt and a queue.
//!
//! ```sh
//! tools/cross.sh build --profile firmware --example live_aarch64 --target aarch64-unknown-none
//! FLICR_SERIAL="tcp:localhost:2401" tools/emulate.sh a53 \
//!     target/cross-rustup/aarch64-unknown-none/firmware/examples/live_aarch64 vlp16:1 uart
//! ```
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_arch = "aarch64", target_os = "none"))]
#[allow(dead_code, reason = "of the other firmware's stages")]
#[path = "../aarch64/virt.rs"]
mod virt;

#[cfg(all(target_arch = "aarch64", target_os = "none"))]
mod uart;

#[cfg(all(target_arch = "aarch64", target_os = "none"))]
#[path = "../live_firmware/mod.rs"]
mod firmware;

#[cfg(all(target_arch = "aarch64", target_os = "none"))]
#[path = "../aarch64/start.rs"]
mod start;

// All the memory there is, known when linking: nothing is allocated, and nothing large is ever on the stack.
#[cfg(all(target_arch = "aarch64", target_os = "none"))]
static MEMORY: static_cell::ConstStaticCell<firmware::Memory> =
    static_cell::ConstStaticCell::new(firmware::Memory::new());

/// Gives the exit code.
#[cfg(all(target_arch = "aarch64", target_os = "none"))]
fn run() -> i32 {
    match MEMORY.try_take() {
        Some(memory) => firmware::main(&mut virt::Virt::new(), uart::Uart::start, memory),
        None => 2,
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: see the comment at its top");
    std::process::exit(2);
}
