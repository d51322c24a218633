//! QEMU's `virt` board's UART, a PL011. The board has one that is free to use: packets come in by it, and datagrams go out.
//! It is polled: what comes waits in its FIFO, and behind that in the emulator.

use core::convert::Infallible;

use flicr::stream::write_framed;

use crate::firmware::{Fault, Link};

const BASE: usize = 0x0900_0000;
const DATA: usize = 0;
const ERRORS: usize = 0x04;
const FLAGS: usize = 0x18;
const LINE_CONTROL: usize = 0x2c;
const CONTROL: usize = 0x30;

const RECEIVER_EMPTY: u32 = 1 << 4;
const TRANSMITTER_FULL: u32 = 1 << 5;
const OVERRUN: u32 = 1 << 3;
/// Words of eight bits, the FIFOs in use.
const WORDS: u32 = 0b111 << 4;
/// The UART, its transmitter and its receiver.
const ENABLED: u32 = 1 | 1 << 8 | 1 << 9;

fn register(offset: usize) -> *mut u32 {
    core::ptr::with_exposed_provenance_mut(BASE + offset)
}

fn read(offset: usize) -> u32 {
    // SAFETY: a register of the UART, which nothing else here uses.
    unsafe { register(offset).read_volatile() }
}

fn write(offset: usize, value: u32) {
    // SAFETY: as in `read`.
    unsafe { register(offset).write_volatile(value) };
}

/// The UART, both ways.
pub struct Uart {
    overruns: u32,
}

impl Uart {
    pub fn start() -> Self {
        write(CONTROL, 0);
        write(LINE_CONTROL, WORDS);
        write(CONTROL, ENABLED);
        Self { overruns: 0 }
    }
}

impl embedded_io::ErrorType for Uart {
    type Error = Infallible;
}

impl embedded_io::Write for Uart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for &byte in bytes {
            while read(FLAGS) & TRANSMITTER_FULL != 0 {}
            write(DATA, byte.into());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl Link for Uart {
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Fault> {
        while read(FLAGS) & RECEIVER_EMPTY != 0 {
            core::hint::spin_loop();
        }
        let mut len = 0;
        for place in bytes {
            if read(FLAGS) & RECEIVER_EMPTY != 0 {
                break;
            }
            *place = read(DATA).to_le_bytes()[0];
            len += 1;
        }
        if read(ERRORS) & OVERRUN != 0 {
            self.overruns = self.overruns.saturating_add(1);
            write(ERRORS, 0);
        }
        Ok(len)
    }

    fn send(&mut self, datagram: &[u8]) -> Result<(), Fault> {
        Ok(write_framed(self, datagram)?)
    }

    fn overruns(&self) -> u32 {
        self.overruns
    }
}
