//! QEMU's `virt` board: clock and pins.

use core::arch::asm;
use core::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};

use crate::firmware::{Board, Clock};

/// `-icount shift=0` in `tools/emulate.sh`: an instruction takes a nanosecond of the counter's time.
const EMULATED_HZ: u32 = 1_000_000_000;

/// The board's PL061: eight pins. Writing to DATA changes those whose bits are set in the address.
const GPIO: usize = 0x0903_0000;
const GPIO_DIRECTION: usize = GPIO + 0x400;

/// The board: its clock and two of its pins.
pub struct Virt {
    clock: Counter,
    project: Pin,
    code: Pin,
}

impl Virt {
    pub fn new() -> Self {
        let clock = Counter { instructions_per_tick: EMULATED_HZ / ticks_hz() };
        Self { clock, project: Pin::output(0), code: Pin::output(1) }
    }
}

impl Board for Virt {
    type Clock = Counter;
    type Pin = Pin;

    fn clock(&self) -> Counter {
        self.clock
    }

    fn project_pin(&mut self) -> &mut Pin {
        &mut self.project
    }

    fn code_pin(&mut self) -> &mut Pin {
        &mut self.code
    }

    /// Interrupts are masked from reset on, and nothing here ever unmasks them.
    fn undisturbed<R>(&mut self, f: impl FnOnce() -> R) -> R {
        f()
    }
}

/// The core's virtual counter.
#[derive(Clone, Copy)]
pub struct Counter {
    instructions_per_tick: u32,
}

impl Clock for Counter {
    #[allow(clippy::cast_possible_truncation, reason = "a clock may wrap around")]
    fn ticks(self) -> u32 {
        let ticks: u64;
        // SAFETY: reads a register; the barrier keeps the read in its place.
        unsafe { asm!("isb", "mrs {}, cntvct_el0", out(reg) ticks, options(nostack)) };
        ticks as u32
    }

    fn per_tick(self) -> u32 {
        self.instructions_per_tick
    }

    fn unit(self) -> &'static str {
        "instructions"
    }
}

#[allow(clippy::cast_possible_truncation, reason = "the register has 32 bits")]
fn ticks_hz() -> u32 {
    let hz: u64;
    // SAFETY: reads a constant register.
    unsafe { asm!("mrs {}, cntfrq_el0", out(reg) hz, options(nomem, nostack)) };
    hz as u32
}

/// A pin of the board.
pub struct Pin {
    mask: u8,
}

impl Pin {
    fn output(number: u8) -> Self {
        let mask = 1 << number;
        let direction = core::ptr::with_exposed_provenance_mut::<u8>(GPIO_DIRECTION);
        // SAFETY: the register of the directions; one core, no interrupts: nobody comes between read and write.
        unsafe { direction.write_volatile(direction.read_volatile() | mask) };
        Self { mask }
    }

    fn set(&mut self, data: u8) {
        let masked_data = core::ptr::with_exposed_provenance_mut::<u8>(GPIO + (usize::from(self.mask) << 2));
        // SAFETY: the register of this pin alone.
        unsafe { masked_data.write_volatile(data) };
    }
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(0);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(u8::MAX);
        Ok(())
    }
}
