//! Arm's MPS2 boards: clock and lights.

use core::convert::Infallible;

use cortex_m::peripheral::{CPUID, DCB, DWT, Peripherals};
use embedded_hal::digital::{ErrorType, OutputPin};

use crate::firmware::{Board, Clock};

/// Where a board's image has its peripherals, from Arm's application notes AN386, AN500 and AN505.
struct Map {
    /// CMSDK timer 0: CTRL, VALUE, RELOAD.
    timer: usize,
    timer_hz: u32,
    /// FPGAIO: its first register drives the lights.
    lights: usize,
}

const AN386_AN500: Map = Map { timer: 0x4000_0000, timer_hz: 25_000_000, lights: 0x4002_8000 };
/// The secure side, on which the core starts.
const AN505: Map = Map { timer: 0x5000_0000, timer_hz: 20_000_000, lights: 0x5030_2000 };

/// Which of the boards this is: its core tells.
fn map(cpuid: &CPUID) -> &'static Map {
    const PART: u32 = 0xFFF0;
    const CORTEX_M33: u32 = 0xD210;
    if cpuid.base.read() & PART == CORTEX_M33 { &AN505 } else { &AN386_AN500 }
}

/// `-icount shift=0` in `tools/emulate.sh`: an instruction takes a nanosecond of the timer's time.
const EMULATED_HZ: u32 = 1_000_000_000;

/// The board: its clock and its two lights.
pub struct Mps2 {
    clock: Mps2Clock,
    project: Light,
    code: Light,
}

impl Mps2 {
    /// The board, once.
    pub fn take() -> Option<&'static mut Self> {
        let mut peripherals = Peripherals::take()?;
        let map = map(&peripherals.CPUID);
        let clock = Mps2Clock::start(map, &mut peripherals.DCB, &mut peripherals.DWT);
        let [project, code] = [1, 2].map(|mask| Light { register: map.lights, mask });
        cortex_m::singleton!(: Mps2 = Mps2 { clock, project, code })
    }
}

impl Board for Mps2 {
    type Clock = Mps2Clock;
    type Pin = Light;

    fn clock(&self) -> Mps2Clock {
        self.clock
    }

    fn project_pin(&mut self) -> &mut Light {
        &mut self.project
    }

    fn code_pin(&mut self) -> &mut Light {
        &mut self.code
    }

    fn undisturbed<R>(&mut self, f: impl FnOnce() -> R) -> R {
        cortex_m::interrupt::free(|_| f())
    }
}

/// What the stages are timed with.
#[derive(Clone, Copy)]
pub enum Mps2Clock {
    /// The core's cycle counter. QEMU's does not count.
    Cycles,
    /// The timer at this address, which under emulation counts instructions.
    Timer { address: usize, instructions_per_tick: u32 },
}

impl Mps2Clock {
    fn start(map: &Map, dcb: &mut DCB, dwt: &mut DWT) -> Self {
        dcb.enable_trace();
        dwt.enable_cycle_counter();
        let before = DWT::cycle_count();
        cortex_m::asm::delay(100);
        if DWT::cycle_count() != before {
            return Self::Cycles;
        }
        start_timer(map.timer);
        Self::Timer { address: map.timer, instructions_per_tick: EMULATED_HZ / map.timer_hz }
    }
}

impl Clock for Mps2Clock {
    fn ticks(self) -> u32 {
        match self {
            Self::Cycles => DWT::cycle_count(),
            // SAFETY: reading the timer's value changes nothing. It counts down.
            Self::Timer { address, .. } => unsafe { !timer_register(address, VALUE).read_volatile() },
        }
    }

    fn per_tick(self) -> u32 {
        match self {
            Self::Cycles => 1,
            Self::Timer { instructions_per_tick, .. } => instructions_per_tick,
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::Cycles => "cycles",
            Self::Timer { .. } => "instructions",
        }
    }
}

// Offsets of the timer's registers.
const CONTROL: usize = 0;
const VALUE: usize = 4;
const RELOAD: usize = 8;

fn timer_register(timer: usize, offset: usize) -> *mut u32 {
    core::ptr::with_exposed_provenance_mut(timer + offset)
}

fn start_timer(timer: usize) {
    const ENABLE: u32 = 1;
    // SAFETY: the timer's registers, which nothing else here uses.
    unsafe {
        timer_register(timer, RELOAD).write_volatile(u32::MAX);
        timer_register(timer, VALUE).write_volatile(u32::MAX);
        timer_register(timer, CONTROL).write_volatile(ENABLE);
    }
}

/// A light of the board: a stage that runs can be seen, and measured with an oscilloscope.
pub struct Light {
    register: usize,
    mask: u32,
}

impl Light {
    fn modify(&mut self, change: impl FnOnce(u32) -> u32) {
        let lights = core::ptr::with_exposed_provenance_mut::<u32>(self.register);
        // SAFETY: the register of the lights; with interrupts off nobody comes between read and write.
        cortex_m::interrupt::free(|_| unsafe { lights.write_volatile(change(lights.read_volatile())) });
    }
}

impl ErrorType for Light {
    type Error = Infallible;
}

impl OutputPin for Light {
    fn set_low(&mut self) -> Result<(), Infallible> {
        let mask = self.mask;
        self.modify(|lights| lights & !mask);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        let mask = self.mask;
        self.modify(|lights| lights | mask);
        Ok(())
    }
}
