//! Firmware for Cortex-M: encodes scans that it reads from the host, and says what that cost.
//!
//! One program for three emulated boards, Cortex-M4F, Cortex-M7 and (built for `thumbv8m.main-none-eabihf`)
//! Cortex-M33:
//!
//! ```sh
//! tools/cross.sh build --profile firmware --example cortex_m --target thumbv7em-none-eabihf
//! tools/emulate.sh m7 target/cross-rustup/thumbv7em-none-eabihf/firmware/examples/cortex_m SCAN.bin OUT 4500:rle:120
//! ```
//!
//! On a board of your own: a `board.x` with its memory, pins of your HAL in place of the lights, and the scan from
//! wherever it comes. A real core counts cycles, an emulated one instructions.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod mps2;

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[path = "../firmware/mod.rs"]
mod firmware;

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod start {
    use static_cell::ConstStaticCell;

    use crate::firmware::{self, Memory};
    use crate::mps2::Mps2;

    // All the memory there is, known when linking: nothing is allocated, and nothing large is ever on the stack.
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let code = match (Mps2::take(), MEMORY.try_take()) {
            (Some(board), Some(memory)) => firmware::main(board, memory),
            _ => 2,
        };
        semihosting::process::exit(code)
    }

    /// A fault ends the emulator, with a code of its own; otherwise it would hang.
    #[cortex_m_rt::exception]
    unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
        semihosting::eprintln!("hard fault at {:#010x}", frame.pc());
        semihosting::process::exit(3)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: see the comment at its top");
    std::process::exit(2);
}
