//! Arm's MPS2 boards' UARTs: packets come in by the second, datagrams go out by the first; the third is for logging.

use core::cell::RefCell;
use core::convert::Infallible;

use cortex_m::interrupt::{self, InterruptNumber, Mutex};
use cortex_m::peripheral::{CPUID, NVIC};
use flicr::stream::write_framed;
use heapless::spsc::{Consumer, Producer, Queue};
use static_cell::ConstStaticCell;

use crate::firmware::{Fault, Link};

/// One less fit into the queue: more than a packet in its frame.
const QUEUE_LEN: usize = 2048;

/// Where a board's image has its UARTs, from Arm's application notes AN386, AN500 and AN505.
struct Map {
    datagrams: usize,
    packets: usize,
    packets_received: Number,
    #[cfg(feature = "defmt")]
    log: usize,
}

const AN386_AN500: Map = Map {
    datagrams: 0x4000_4000,
    packets: 0x4000_5000,
    packets_received: Number(2),
    #[cfg(feature = "defmt")]
    log: 0x4000_6000,
};
/// The secure side, on which the core starts.
const AN505: Map = Map {
    datagrams: 0x5020_0000,
    packets: 0x5020_1000,
    packets_received: Number(34),
    #[cfg(feature = "defmt")]
    log: 0x5020_2000,
};

/// Which of the boards this is: its core tells.
fn map() -> &'static Map {
    const PART: u32 = 0xFFF0;
    const CORTEX_M33: u32 = 0xD210;
    // SAFETY: reading what core this is changes nothing.
    let id = unsafe { (*CPUID::PTR).base.read() };
    if id & PART == CORTEX_M33 { &AN505 } else { &AN386_AN500 }
}

/// An interrupt's number.
#[derive(Clone, Copy)]
struct Number(u16);

// SAFETY: the boards' numbers, which always stand for the same source.
unsafe impl InterruptNumber for Number {
    fn number(self) -> u16 {
        self.0
    }
}

/// A CMSDK APB UART.
struct Uart(usize);

impl Uart {
    const DATA: usize = 0;
    const STATE: usize = 4;
    const CONTROL: usize = 8;
    const INTERRUPT: usize = 12;
    const BAUD_DIVIDER: usize = 16;

    const TRANSMITTER_FULL: u32 = 1;
    const RECEIVER_FULL: u32 = 1 << 1;
    const RECEIVER_OVERRUN: u32 = 1 << 3;
    const TRANSMITS: u32 = 1;
    const RECEIVES: u32 = 1 << 1;
    const INTERRUPTS: u32 = 1 << 3;

    fn register(&self, offset: usize) -> *mut u32 {
        core::ptr::with_exposed_provenance_mut(self.0 + offset)
    }

    fn read(&self, offset: usize) -> u32 {
        // SAFETY: a register of the UART; each is read by one side only, the interrupt's or the main loop's.
        unsafe { self.register(offset).read_volatile() }
    }

    fn write(&self, offset: usize, value: u32) {
        // SAFETY: as in `read`.
        unsafe { self.register(offset).write_volatile(value) };
    }

    fn start(&self, control: u32) {
        // The least there is: as fast as it goes.
        self.write(Self::BAUD_DIVIDER, 16);
        self.write(Self::CONTROL, control);
    }

    fn has(&self, state: u32) -> bool {
        self.read(Self::STATE) & state != 0
    }
}

impl embedded_io::ErrorType for Uart {
    type Error = Infallible;
}

impl embedded_io::Write for Uart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for &byte in bytes {
            while self.has(Self::TRANSMITTER_FULL) {}
            Uart::write(self, Self::DATA, byte.into());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Sends what `defmt` logs.
#[cfg(feature = "defmt")]
pub fn log_bytes(bytes: &[u8]) {
    let mut log = Uart(map().log);
    log.start(Uart::TRANSMITS);
    let Ok(()) = embedded_io::Write::write_all(&mut log, bytes);
}

/// The interrupt's side.
struct Receiver {
    uart: Uart,
    queue: Producer<'static, u8>,
    overruns: u32,
}

static RECEIVER: Mutex<RefCell<Option<Receiver>>> = Mutex::new(RefCell::new(None));
static QUEUE: ConstStaticCell<Queue<u8, QUEUE_LEN>> = ConstStaticCell::new(Queue::new());

/// The receive interrupt. Where the queue is full it stays away until the main loop has made room: what comes meanwhile waits
/// in the sender where the line lets it, and is counted as lost where not.
pub fn take_bytes() {
    interrupt::free(|token| {
        let mut receiver = RECEIVER.borrow(token).borrow_mut();
        let Some(Receiver { uart, queue, overruns }) = receiver.as_mut() else { return };
        uart.write(Uart::INTERRUPT, Uart::RECEIVES);
        if uart.has(Uart::RECEIVER_OVERRUN) {
            *overruns = overruns.saturating_add(1);
            uart.write(Uart::STATE, Uart::RECEIVER_OVERRUN);
        }
        while uart.has(Uart::RECEIVER_FULL) {
            if !queue.ready() {
                NVIC::mask(map().packets_received);
                return;
            }
            // There is room: that was asked.
            let _ = queue.enqueue(uart.read(Uart::DATA) as u8);
        }
    });
}

/// Both UARTs, the main loop's side.
pub struct Uarts {
    datagrams: Uart,
    queue: Consumer<'static, u8>,
}

impl Uarts {
    /// The UARTs, once.
    pub fn take() -> Option<Self> {
        let (producer, consumer) = QUEUE.try_take()?.split();
        let receiver = Receiver { uart: Uart(map().packets), queue: producer, overruns: 0 };
        interrupt::free(|token| RECEIVER.borrow(token).replace(Some(receiver)));
        Some(Self { datagrams: Uart(map().datagrams), queue: consumer })
    }

    /// From here on bytes come in.
    pub fn start(self) -> Self {
        self.datagrams.start(Uart::TRANSMITS);
        Uart(map().packets).start(Uart::RECEIVES | Uart::INTERRUPTS);
        listen();
        self
    }
}

fn listen() {
    // SAFETY: no critical section here leans on this interrupt being off.
    unsafe { NVIC::unmask(map().packets_received) };
}

impl Link for Uarts {
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Fault> {
        let mut len = 0;
        loop {
            for (place, byte) in bytes.iter_mut().zip(core::iter::from_fn(|| self.queue.dequeue())) {
                *place = byte;
                len += 1;
            }
            listen();
            if len > 0 {
                return Ok(len);
            }
            // Asleep until a byte comes; one that has come just now ends the sleep though its interrupt has to wait.
            interrupt::free(|_| {
                if !self.queue.ready() {
                    cortex_m::asm::wfi();
                }
            });
        }
    }

    fn send(&mut self, datagram: &[u8]) -> Result<(), Fault> {
        Ok(write_framed(&mut self.datagrams, datagram)?)
    }

    fn overruns(&self) -> u32 {
        interrupt::free(|token| RECEIVER.borrow(token).borrow().as_ref().map_or(0, |receiver| receiver.overruns))
    }
}
