//! Firmware for Cortex-M that streams: a sensor's packets come in by one UART, datagrams go out by another, as the sensor
//! turns. The receive interrupt puts bytes into a queue; the main loop takes them out.
//!
//! One program for three emulated boards, Cortex-M4F, Cortex-M7 and (built for `thumbv8m.main-none-eabihf`) Cortex-M33;
//! `make live` runs it, or:
//!
//! ```sh
//! tools/cross.sh build --profile firmware --example live_cortex_m --target thumbv7em-none-eabihf
//! FLICR_SERIAL="file:DATAGRAMS tcp:localhost:2401" tools/emulate.sh m7 \
//!     target/cross-rustup/thumbv7em-none-eabihf/firmware/examples/live_cortex_m vlp16:1 uart
//! ```
//!
//! On a board of your own: a `board.x` with its memory, a `Link` of your HAL's UARTs (or its Ethernet) in the place of
//! `uart.rs`, and pins in the place of the lights: one is high while a packet is worked on, one from a strip's first column
//! until its datagram is whole. What things cost is told in cycles there, of the core's own counter; an emulated core counts
//! instructions.
//!
//! With feature `defmt` it logs by a third UART: `tools/defmt.sh` builds it so, and makes text of what comes.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[path = "../live_firmware/mod.rs"]
mod firmware;
#[cfg(all(feature = "defmt", target_arch = "arm", target_os = "none"))]
mod logger;
#[cfg(all(target_arch = "arm", target_os = "none"))]
#[allow(dead_code, reason = "of the other firmware's stages")]
#[path = "../cortex_m/mps2.rs"]
mod mps2;
#[cfg(all(target_arch = "arm", target_os = "none"))]
mod uart;

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod start {
    use static_cell::ConstStaticCell;

    use crate::firmware::{self, Memory};
    use crate::mps2::Mps2;
    use crate::uart::{self, Uarts};

    // All the memory there is, known when linking: nothing is allocated, and nothing large is ever on the stack.
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let code = match (Mps2::take(), MEMORY.try_take(), Uarts::take()) {
            (Some(board), Some(memory), Some(uarts)) => firmware::main(board, || uarts.start(), memory),
            _ => 2,
        };
        semihosting::process::exit(code)
    }

    /// Every interrupt, as the boards number them differently; only one is ever let through.
    #[cortex_m_rt::exception]
    unsafe fn DefaultHandler(_: i16) {
        uart::take_bytes();
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
