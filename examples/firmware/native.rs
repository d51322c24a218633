//! A column for each firing: the scan is read twice, first for the ticks that the sensor fired at.
//!
//! A device that reads the sensor's packets has the ticks from them and needs no such pass.

use flicr::coder::{ContextSettings, Step};
use flicr::geometry::{Firings, Lattice, sensors::hdl64e};
use flicr::{Dense, FiringsConfig, FrameEncoder, ImageViewMut, LatticeConfig, Stamp, Store};

use super::host::{PIECE_LEN, Scan, print_line};
use super::job::{CoderName, Job, Usage};
use super::stage::{Board, Clock, Stage};
use super::{Context, Fault, Memory, ROWS, encode_one};

const TICKS: usize = hdl64e::TICKS as usize;
const WORDS: usize = TICKS.div_ceil(32);
/// Room for a firing at every tick.
pub const PIXELS_MAX: usize = ROWS * TICKS;
/// The list of firings takes at most a bit a tick.
pub const FRAME_LEN_MAX: usize = EVERY_TICK.worst_case_len::<u16, Dense>() + TICKS.div_ceil(8);

const EVERY_TICK: LatticeConfig<'static, 66> = LatticeConfig::new(&LATTICE);

/// The HDL-64E's grid on which all lasers fire at the same ticks, in flash.
static LATTICE: Lattice<66> = match Lattice::new(hdl64e::FIRING_GRID, TICKS) {
    Ok(lattice) => lattice,
    Err(_) => panic!("checked at compile time"),
};

pub fn encode<B: Board>(board: &mut B, job: &Job<'_>, step: Step, memory: &mut Memory) -> Result<(), Fault> {
    let Memory { native_levels: levels, frame, piece, context, .. } = memory;
    let firings = find_firings(board, job, levels, piece)?;
    let columns = usize::from(firings.len());
    let levels = levels.get_mut(..ROWS * columns).ok_or(Usage::TooManyColumns)?;
    let image = ImageViewMut::new(levels, columns).ok_or(Usage::TooManyColumns)?;
    let scan = Scan::open(job.scan, piece)?;
    let config = FiringsConfig { every_tick: EVERY_TICK, firings: &firings };
    context.set(ContextSettings::FINE.with_step(step));
    let Context { small, dense, fast } = context;
    match job.coder {
        CoderName::Small => encode_one(board, job, &config, scan, image, small, frame),
        CoderName::Dense => encode_one(board, job, &config, scan, image, dense, frame),
        CoderName::Fast => encode_one(board, job, &config, scan, image, fast, frame),
        _ => Err(Usage::NativeCoder.into()),
    }
}

/// The ticks at which any beam has a return.
fn find_firings<B: Board>(
    board: &mut B,
    job: &Job<'_>,
    levels: &mut [u16; PIXELS_MAX],
    piece: &mut [u8; PIECE_LEN],
) -> Result<Firings<WORDS>, Fault> {
    let mut find = Stage::new();
    let mut scan = Scan::open(job.scan, piece)?;
    let image = ImageViewMut::new(levels, TICKS).ok_or(Usage::TooManyColumns)?;
    let coder = &mut Store::new();
    let start = || FrameEncoder::start(&EVERY_TICK, Stamp::default(), image, coder);
    let mut filling = find.run(board, B::project_pin, start)?;
    while let Some(points) = scan.next_points()? {
        find.run(board, B::project_pin, || filling.insert(&points));
    }
    let firings = find.run(board, B::project_pin, || fired_in(levels))?;
    print_line(format_args!(
        "find {job} firings={} unit={} find={}",
        firings.len(),
        board.clock().unit(),
        find.cost(board.clock()),
    ));
    Ok(firings)
}

/// The columns of an image of all ticks that are not empty.
fn fired_in(levels: &[u16; PIXELS_MAX]) -> Result<Firings<WORDS>, flicr::ConfigError> {
    let mut fired = [false; TICKS];
    for row in levels.chunks_exact(TICKS) {
        fired.iter_mut().zip(row).for_each(|(fired, &level)| *fired |= level > 0);
    }
    Firings::new(hdl64e::TICKS, (0..hdl64e::TICKS).zip(fired).filter(|(_, fired)| *fired).map(|(tick, _)| tick))
}
