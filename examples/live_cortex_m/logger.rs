//! Where `defmt`'s frames go: to the third UART.

use core::cell::UnsafeCell;

use cortex_m::interrupt;
use cortex_m::register::primask;
use defmt::Encoder;

use crate::uart::log_bytes;

struct State {
    encoder: Encoder,
    /// Whether interrupts were on before the frame.
    were_on: bool,
}

struct Shared(UnsafeCell<State>);

// SAFETY: one core, and interrupts are off while a frame is written.
unsafe impl Sync for Shared {}

static STATE: Shared = Shared(UnsafeCell::new(State { encoder: Encoder::new(), were_on: false }));

#[defmt::global_logger]
struct Logger;

// SAFETY: from `acquire` to `release` interrupts are off, so that nobody else comes in between.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        let were_on = primask::read().is_active();
        interrupt::disable();
        // SAFETY: interrupts are off, and no frame is open: `defmt` opens none within another.
        let state = unsafe { &mut *STATE.0.get() };
        state.were_on = were_on;
        state.encoder.start_frame(log_bytes);
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: as in `acquire`.
        let state = unsafe { &mut *STATE.0.get() };
        state.encoder.end_frame(log_bytes);
        if state.were_on {
            // SAFETY: they were on before `acquire`.
            unsafe { interrupt::enable() };
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: as in `acquire`.
        unsafe { &mut *STATE.0.get() }.encoder.write(bytes, log_bytes);
    }
}
