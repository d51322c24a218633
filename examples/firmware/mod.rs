//! What the firmware examples share: a scan comes in from the host in pieces, frames go back out, and what each stage
//! cost is printed. A board brings its clock and its pins.
//!
//! Two lines are printed for every frame. `frame` depends only on the scan and the codec (`qemu.out` beside each
//! example holds those of the test scan); `cost` also on compiler and board.

mod host;
mod job;
mod native;
mod packets;
mod stack;
mod stage;

use core::fmt;

use flicr::coder::{ContextSettings, Fast};
use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::packet::PacketError;
use flicr::{
    Coder, Config, ConfigError, DeflateDefault, DeflateDense, DeflateSmall, Dense, EncodeError, Encoded, FrameEncoder,
    ImageViewMut, LatticeConfig, Level, Rle, Scale, Settings, Small, Stamp, Store, frame,
};

use host::{PIECE_LEN, Scan, print_line, write_frame};
use job::{CoderName, Even, Job, Shape, Usage};
use stage::Stage;
pub use stage::{Board, Clock};

const ROWS: usize = 64;
const COLUMNS_MAX: usize = 4500;
const PIXELS_MAX: usize = ROWS * COLUMNS_MAX;
const FRAME_LEN_MAX: usize = max([
    worst_case_len::<Store>(),
    worst_case_len::<Rle>(),
    worst_case_len::<DeflateDefault>(),
    worst_case_len::<DeflateSmall>(),
    worst_case_len::<DeflateDense>(),
    native::FRAME_LEN_MAX,
]);

const fn worst_case_len<C: Coder<u8>>() -> usize {
    frame::worst_case_len::<u8, C>(PIXELS_MAX)
}

const fn max(lengths: [usize; 6]) -> usize {
    let (mut longest, mut at) = (0, 0);
    while at < lengths.len() {
        if lengths[at] > longest {
            longest = lengths[at];
        }
        at += 1;
    }
    longest
}

/// The HDL-64E's own grid at every tick, in flash.
static LATTICE: Lattice<66> = match Lattice::new(hdl64e::GRID, LATTICE_COLUMNS) {
    Ok(lattice) => lattice,
    Err(_) => panic!("checked at compile time"),
};
const LATTICE_COLUMNS: usize = 4000;

/// All the memory that encoding takes, for the largest frame: to be kept in a `static`. A device that knows its frame
/// size uses `flicr::Encoder<ROWS, COLUMNS, ...>` in its place; one image that is borrowed at any size is for those
/// that switch, as here.
pub struct Memory {
    levels: [u8; PIXELS_MAX],
    native_levels: [u16; native::PIXELS_MAX],
    frame: [u8; FRAME_LEN_MAX],
    piece: [u8; PIECE_LEN],
    store: Store,
    rle: Rle,
    deflate: DeflateDefault,
    deflate_small: DeflateSmall,
    deflate_dense: DeflateDense,
    context: Context,
}

/// The context coders, for both kinds of levels.
struct Context {
    small: Small,
    dense: Dense,
    fast: Fast,
}

impl Context {
    const NEW: Self = Self {
        small: Small::new(ContextSettings::COARSE),
        dense: Dense::new(ContextSettings::COARSE),
        fast: Fast::new(ContextSettings::COARSE),
    };

    fn set(&mut self, settings: ContextSettings) {
        self.small.set(settings);
        self.dense.set(settings);
        self.fast.set(settings);
    }
}

impl Memory {
    #[allow(clippy::large_stack_arrays, reason = "this initializes a static; no stack ever holds it")]
    pub const fn new() -> Self {
        Self {
            levels: [0; PIXELS_MAX],
            native_levels: [0; native::PIXELS_MAX],
            frame: [0; FRAME_LEN_MAX],
            piece: [0; PIECE_LEN],
            store: Store::new(),
            rle: Rle::new(),
            deflate: DeflateDefault::new(),
            deflate_small: DeflateSmall::new(),
            deflate_dense: DeflateDense::new(),
            context: Context::NEW,
        }
    }
}

/// Why no frame came out.
#[derive(Debug)]
enum Fault {
    Usage(Usage),
    Host(semihosting::io::Error),
    TornPoint,
    TornPacket,
    Refused(PacketError),
    Encode(EncodeError),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(usage) => write!(
                f,
                "{usage}; arguments: SCAN OUT_PREFIX FRAME..., frames: COLUMNS:CODER:MAX_RANGE_M or native:CODER:STEP"
            ),
            Self::Host(error) => write!(f, "the host's files: {error:?}"),
            Self::TornPoint => f.write_str("the scan ends inside a point of 16 bytes"),
            Self::TornPacket => f.write_str("the file ends inside a packet"),
            Self::Refused(error) => write!(f, "{error}"),
            Self::Encode(error) => write!(f, "{error}"),
        }
    }
}

impl From<Usage> for Fault {
    fn from(usage: Usage) -> Self {
        Self::Usage(usage)
    }
}

impl From<semihosting::io::Error> for Fault {
    fn from(error: semihosting::io::Error) -> Self {
        Self::Host(error)
    }
}

impl From<ConfigError> for Fault {
    fn from(error: ConfigError) -> Self {
        Self::Encode(error.into())
    }
}

impl From<EncodeError> for Fault {
    fn from(error: EncodeError) -> Self {
        Self::Encode(error)
    }
}

/// Does what the command line asks for and gives the exit code.
pub fn main<B: Board>(board: &mut B, memory: &mut Memory) -> i32 {
    match encode_all(board, memory) {
        Ok(()) => 0,
        Err(fault) => {
            print_line(format_args!("error: {fault}"));
            1
        }
    }
}

fn encode_all<B: Board>(board: &mut B, memory: &mut Memory) -> Result<(), Fault> {
    let arguments = job::arguments()?;
    for job in arguments.jobs()? {
        let job = job?;
        match job.shape {
            Shape::Even(even) => encode_even(board, &job, even, memory)?,
            Shape::Native(step) => native::encode(board, &job, step, memory)?,
        }
    }
    Ok(())
}

fn encode_even<B: Board>(board: &mut B, job: &Job<'_>, even: Even, memory: &mut Memory) -> Result<(), Fault> {
    let Memory { levels, frame, piece, store, rle, deflate, deflate_small, deflate_dense, context, .. } = memory;
    if let Some(sensor) = packets::sensor_of(job.coder) {
        return packets::encode_turns(board, (job, even), sensor, levels, rle, piece, frame);
    }
    let levels = levels.get_mut(..ROWS * even.columns).ok_or(Usage::TooManyColumns)?;
    let image = ImageViewMut::new(levels, even.columns).ok_or(Usage::TooManyColumns)?;
    let scan = Scan::open(job.scan, piece)?;
    let scale = Scale::Fixed { max_range_m: even.max_range_m };
    let uniform = Config { scale, ..Config::UNIFORM };
    let on_grid = LatticeConfig { scale, level_bits: u8::BITS, ..LatticeConfig::new(&LATTICE) };
    context.set(ContextSettings::COARSE);
    match job.coder {
        CoderName::Store => encode_one(board, job, &uniform, scan, image, store, frame),
        CoderName::Rle => encode_one(board, job, &uniform, scan, image, rle, frame),
        CoderName::Deflate => encode_one(board, job, &uniform, scan, image, deflate, frame),
        CoderName::DeflateSmall => encode_one(board, job, &uniform, scan, image, deflate_small, frame),
        CoderName::DeflateDense => encode_one(board, job, &uniform, scan, image, deflate_dense, frame),
        CoderName::Small => encode_one(board, job, &uniform, scan, image, &mut context.small, frame),
        CoderName::Dense => encode_one(board, job, &uniform, scan, image, &mut context.dense, frame),
        CoderName::Fast => encode_one(board, job, &uniform, scan, image, &mut context.fast, frame),
        CoderName::Lattice => encode_one(board, job, &on_grid, scan, image, rle, frame),
        // Packets: above.
        CoderName::Vlp16 | CoderName::Vlp32c | CoderName::Pandar40p => Ok(()),
    }
}

fn encode_one<B: Board, L: Level, C: Coder<L>>(
    board: &mut B,
    job: &Job<'_>,
    config: &impl Settings,
    mut scan: Scan<'_>,
    image: ImageViewMut<'_, L>,
    coder: &mut C,
    out: &mut [u8],
) -> Result<(), Fault> {
    let (mut project, mut code) = (Stage::new(), Stage::new());
    let pixels = image.as_view().pixels();
    let encoder_len = pixels * size_of::<L>() + size_of::<C>();

    let start = || FrameEncoder::start(config, Stamp::default(), image, coder);
    let mut filling = project.run(board, B::project_pin, start)?;
    while let Some(points) = scan.next_points()? {
        project.run(board, B::project_pin, || filling.insert(&points));
    }
    let encoded = code.run(board, B::code_pin, || filling.finish(out))?;

    let frame = out.get(..encoded.len).unwrap_or_default();
    write_frame(job, frame)?;
    print_frame(job, &encoded, frame);
    print_cost(job, board, (&project, &code), pixels, encoder_len);
    Ok(())
}

fn print_frame(job: &Job<'_>, encoded: &Encoded, frame: &[u8]) {
    let checksum = frame.last_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
    let tally = &encoded.tally;
    print_line(format_args!(
        "frame {job} points={} kept={} bytes={} crc={checksum:08x}",
        tally.points,
        tally.kept(),
        encoded.len,
    ));
}

/// The pixels coded are the whole image's, empty ones too.
fn print_cost<B: Board>(
    job: &Job<'_>,
    board: &B,
    (project, code): (&Stage, &Stage),
    pixels: usize,
    encoder_bytes: usize,
) {
    let clock = board.clock();
    let hundredths_a_pixel = 100 * code.cost(clock) / (pixels as u64).max(1);
    print_line(format_args!(
        "cost {job} unit={} project={} code={} hundredths_a_pixel={hundredths_a_pixel} total={} stack_bytes={} \
         encoder_bytes={encoder_bytes}",
        clock.unit(),
        project.cost(clock),
        code.cost(clock),
        project.cost(clock) + code.cost(clock),
        project.stack_bytes().max(code.stack_bytes()),
    ));
}
