//! What the streaming firmware shares: sensors' packets come in over a byte stream, datagrams go out as the sensor turns.
//!
//! ```text
//! UART -> interrupt -> queue of bytes -> Deframer -> packets -> StreamEncoder -> write_framed -> UART
//! ```
//!
//! A packet of no bytes says that no more will come; then a line is printed that says what was done, and what it cost.

mod job;
mod link;
mod log;
mod meter;
mod packets;
#[path = "../firmware/stack.rs"]
mod stack;
#[allow(dead_code, reason = "of the other firmware's stages")]
#[path = "../firmware/stage.rs"]
mod stage;

use core::convert::Infallible;
use core::fmt::{self, Write as _};

use embedded_hal::digital::OutputPin;
use flicr::ConfigError;
use flicr::coder::{ContextSettings, SmallModel};
use flicr::control::{Bounds, Budget, Control};
use flicr::geometry::sensors::{hdl64e, velodyne};
use flicr::geometry::{Beam, SensorGrid};
use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::stream::{AlignedHdl64e, AsFired, DATAGRAM_LEN, Deframer, Line, StreamConfig, StreamEncoder, framed_len};
use heapless::String;
use semihosting::io::{self, Write as _};

use job::{Job, Place, SensorName};
pub use link::Link;
use meter::Meter;
use packets::{Hdl64e, Packets, Piece};
pub use stage::{Board, Clock};

/// The longest packet of the sensors here.
const PACKET_LEN_MAX: usize = 1206;
/// Bytes that are taken from the queue at a time.
const PIECE_LEN: usize = 64;
/// As many as fit a turn of theirs at 600 turns a minute.
const HDL64E_COLUMNS: u16 = 2150;

/// Beams as they look at 600 turns a minute, in flash.
static VLP16: [Beam; 16] = velodyne::VLP16.beams_at(600).expect("16 beams");

/// The whole way of a sensor's bytes to datagrams, but for the queue that the interrupt fills.
struct Path<P, const GROUPS: usize, L> {
    deframer: Deframer<PACKET_LEN_MAX>,
    packets: P,
    stream: StreamEncoder<SmallModel, GROUPS, DATAGRAM_LEN, L>,
    control: Option<Control>,
}

impl<P, const GROUPS: usize, L: Line> Path<P, GROUPS, L> {
    const fn new(packets: P) -> Self {
        Self { deframer: Deframer::new(), packets, stream: StreamEncoder::BLANK, control: None }
    }
}

/// All the memory there is: to be kept in a `static`. A device has one sensor, and so one of the three paths.
pub struct Memory {
    vlp16: Path<TurnAssembler, 2, AsFired>,
    hdl64e: Path<Hdl64e, 8, AsFired>,
    aligned: Path<Hdl64e, 8, AlignedHdl64e>,
    meter: Meter,
}

impl Memory {
    pub const fn new() -> Self {
        Self {
            vlp16: Path::new(TurnAssembler::new(Sensor::Spinning(Model::Vlp16), ReturnPolicy::Strongest)),
            hdl64e: Path::new(Hdl64e::new()),
            aligned: Path::new(Hdl64e::new()),
            meter: Meter::new(),
        }
    }
}

/// Why it ended.
#[derive(Debug)]
pub enum Fault {
    Usage(&'static str),
    Host(semihosting::io::Error),
    Config(ConfigError),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(what) => write!(f, "{what}; arguments: SENSOR:STEP[:BYTES_A_SECOND] uart, or ... IN OUT"),
            Self::Host(error) => write!(f, "the host's files: {error:?}"),
            Self::Config(error) => write!(f, "{error}"),
        }
    }
}

impl From<semihosting::io::Error> for Fault {
    fn from(error: semihosting::io::Error) -> Self {
        Self::Host(error)
    }
}

impl From<ConfigError> for Fault {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

/// Does what the command line asks for and gives the exit code.
pub fn main<B: Board, K: Link>(board: &mut B, uart: impl FnOnce() -> K, memory: &mut Memory) -> i32 {
    match stream(board, uart, memory) {
        Ok(()) => 0,
        Err(fault) => {
            print_line(format_args!("error: {fault}"));
            1
        }
    }
}

fn stream<B: Board, K: Link>(board: &mut B, uart: impl FnOnce() -> K, memory: &mut Memory) -> Result<(), Fault> {
    let arguments = job::arguments()?;
    match arguments.parse()? {
        (job, Place::Uart) => stream_over(board, &job, &mut uart(), memory),
        (job, Place::Files { packets, datagrams }) => {
            stream_over(board, &job, &mut link::Files::open(packets, datagrams)?, memory)
        }
    }
}

fn stream_over<B: Board, K: Link>(board: &mut B, job: &Job, link: &mut K, memory: &mut Memory) -> Result<(), Fault> {
    let Memory { vlp16, hdl64e, aligned, meter } = memory;
    match job.sensor {
        SensorName::Vlp16 => vlp16.run(board, job, &velodyne::VLP16.grid_of(&VLP16), link, meter),
        SensorName::Hdl64e => hdl64e.run(board, job, &hdl64e::FIRING_GRID, link, meter),
        SensorName::Hdl64eAligned => aligned.run(board, job, &hdl64e::FIRING_GRID, link, meter),
    }
}

/// What became of the packets.
#[derive(Default)]
struct Told {
    packets: u32,
    refused: u32,
    is_over: bool,
    fault: Option<Fault>,
}

impl<P: Packets, const GROUPS: usize, L: Line> Path<P, GROUPS, L> {
    fn run<B: Board, K: Link>(
        &mut self,
        board: &mut B,
        job: &Job,
        grid: &SensorGrid<'_>,
        link: &mut K,
        meter: &mut Meter,
    ) -> Result<(), Fault> {
        self.start(job, grid)?;
        log::start(job, size_of_val(&self.stream));
        let (told, stack_bytes) = stack::depth_of(|| self.stream_all(board, link, meter));
        self.print(job, &told?, board.clock(), (link.overruns(), stack_bytes), meter);
        Ok(())
    }

    fn start(&mut self, job: &Job, grid: &SensorGrid<'_>) -> Result<(), Fault> {
        let settings = ContextSettings::FINE.with_step(job.step);
        let config = StreamConfig { columns_a_turn: HDL64E_COLUMNS, ..StreamConfig::new(grid, 1, settings)? };
        self.stream.start(config)?;
        self.control = job.bytes_a_second.map(|bytes| {
            let mut control = Control::new(Budget::BytesASecond(bytes), Bounds { finest: job.step, ..Bounds::USUAL });
            control.begin(&mut self.stream);
            control
        });
        Ok(())
    }

    fn stream_all<B: Board, K: Link>(&mut self, board: &mut B, link: &mut K, meter: &mut Meter) -> Result<Told, Fault> {
        let Self { deframer, packets, stream, control } = self;
        let mut told = Told::default();
        let mut piece = [0; PIECE_LEN];
        while !told.is_over && told.fault.is_none() {
            let len = link.receive(&mut piece)?;
            told.is_over = len == 0;
            deframer.push(piece.get(..len).unwrap_or_default(), |packet| {
                if packet.is_empty() {
                    told.is_over = true;
                    return;
                }
                told.packets += 1;
                meter.go(board.clock());
                let Ok(()) = board.project_pin().set_high();
                let take = |piece: Piece<'_>| {
                    told.fault = take_piece(&piece, stream, control, board, link, meter).err();
                };
                if !packets.push(packet, take) {
                    told.refused += 1;
                    log::refused(told.packets);
                }
                let Ok(()) = board.project_pin().set_low();
                meter.count(board.clock());
            });
        }
        meter.go(board.clock());
        packets.finish(|piece| told.fault = take_piece(&piece, stream, control, board, link, meter).err());
        stream.feed_finish();
        send_all(stream, control, board, link, meter)?;
        match told.fault.take() {
            Some(fault) => Err(fault),
            None => Ok(told),
        }
    }

    fn print(
        &self,
        job: &Job,
        told: &Told,
        clock: impl Clock,
        (overruns, stack_bytes): (u32, usize),
        meter: &mut Meter,
    ) {
        let tally = self.stream.tally();
        let (columns, strip_worst, turns) = (meter.columns(clock), meter.strip_worst(clock), meter.turns(clock));
        print_line(format_args!(
            "live sensor={} step={} packets={} refused={} noise={} overruns={overruns} columns={} datagrams={} bytes={}",
            job.sensor,
            job.step.levels(),
            told.packets,
            told.refused,
            self.deframer.refused(),
            tally.columns,
            tally.datagrams,
            tally.bytes,
        ));
        print_line(format_args!(
            "cost unit={} column_median={} column_worst={} strip_worst={strip_worst} turn_median={} turn_worst={} \
             stack_bytes={stack_bytes} path_bytes={} encoder_bytes={} frame_max={}",
            clock.unit(),
            columns.median,
            columns.worst,
            turns.median,
            turns.worst,
            size_of::<Self>(),
            size_of_val(&self.stream),
            framed_len(DATAGRAM_LEN),
        ));
    }
}

/// Codes what was in a packet; sends the datagrams that it fills.
fn take_piece<B: Board, K: Link, const GROUPS: usize, L: Line>(
    piece: &Piece<'_>,
    stream: &mut StreamEncoder<SmallModel, GROUPS, DATAGRAM_LEN, L>,
    control: &mut Option<Control>,
    board: &mut B,
    link: &mut K,
    meter: &mut Meter,
) -> Result<(), Fault> {
    meter.count(board.clock());
    meter.begin_column();
    let Ok(()) = board.code_pin().set_high();
    meter.go(board.clock());
    piece.feed(stream);
    send_all(stream, control, board, link, meter)?;
    if piece.is_column() {
        meter.end_column(board.clock());
    }
    if piece.is_turn_end() {
        meter.end_turn();
        log::turn(&stream.tally());
    }
    meter.go(board.clock());
    Ok(())
}

/// The pin of a strip goes low when its datagram is whole, and high again with the first column of the next.
fn send_all<B: Board, K: Link, const GROUPS: usize, L: Line>(
    stream: &mut StreamEncoder<SmallModel, GROUPS, DATAGRAM_LEN, L>,
    control: &mut Option<Control>,
    board: &mut B,
    link: &mut K,
    meter: &mut Meter,
) -> Result<(), Fault> {
    let clock = board.clock();
    while let Some(datagram) = stream.next_datagram() {
        meter.count(clock);
        let Ok(()) = board.code_pin().set_low();
        link.send(datagram)?;
        meter.go(clock);
        let cost = meter.end_strip(clock);
        if let Some(control) = control {
            control.sent(stream, cost);
        }
    }
    meter.count(clock);
    Ok(())
}

const LINE_LEN: usize = 320;

/// Prints a line by one call to the host.
fn print_line(line: fmt::Arguments<'_>) {
    let mut text = String::<LINE_LEN>::new();
    let whole = text.write_fmt(line).is_ok() && text.push('\n').is_ok();
    if let Ok(mut stdout) = io::stdout() {
        // There is nobody to tell that telling failed.
        let _ = stdout.write_all(text.as_bytes());
        if !whole {
            let _ = stdout.write_all(b"...\n");
        }
    }
}

/// For links that cannot fail.
impl From<Infallible> for Fault {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}
