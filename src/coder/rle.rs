//! Run-length coding over levels, row-major.
//!
//! | control byte | followed by | stands for |
//! |---|---|---|
//! | `0nnnnnnn` | n + 1 levels | these levels |
//! | `10nnnnnn` | one level | n + 2 times this level |
//! | `11nnnnnn` | nothing | n + 1 empty pixels |

use super::{Coder, CoderId, OutputFull, Sink, WorstCase};
use crate::image::{ImageView, Level};

const LITERALS_MAX: usize = 128;
const COPIES_MAX: usize = 65;
const EMPTY_MAX: usize = 64;
const COPIES: u8 = 0b1000_0000;
const EMPTY: u8 = 0b1100_0000;

/// Run-length coding: no state, a handful of instructions a pixel.
///
/// Source: the paper's RLE (section IV-C), with a code of its own for empty pixels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rle;

impl Rle {
    /// A coder without state.
    #[must_use]
    pub const fn new() -> Self {
        Self
    }
}

impl<L: Level> Coder<L> for Rle {
    const ID: CoderId = CoderId::Rle;

    /// Levels that never repeat, each 128 behind a control byte: a run is written only where it is no longer.
    const WORST_CASE: WorstCase = WorstCase {
        bytes_per_level: size_of::<L>(),
        block_len: LITERALS_MAX * size_of::<L>(),
        bytes_per_block: 1,
        gathers: true,
    };

    fn encode(&mut self, image: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
        let (mut rest, out) = image.gathered(out).ok_or(OutputFull)?;
        let mut sink = Sink::new(out);
        while !rest.is_empty() {
            let (literals, from_run) = split(rest, literals_len(rest));
            put_literals(literals, &mut sink)?;
            let (run, after) = split(from_run, run_len(from_run));
            put_run(run, &mut sink)?;
            rest = after;
        }
        Ok(sink.len())
    }
}

/// The first `len` levels and the rest, without a way to panic: all where `len` is too many, which it never is.
fn split<L>(levels: &[L], len: usize) -> (&[L], &[L]) {
    levels.split_at_checked(len).unwrap_or((levels, &[]))
}

/// Levels before the next run that is worth its control byte and the one of the literals behind it.
fn literals_len<L: Level>(levels: &[L]) -> usize {
    let worth_a_run = |w: &[L]| w[0] == w[1] && (w[0] == L::NONE || w.get(2) == Some(&w[0]));
    let in_threes = levels.windows(3).position(worth_a_run);
    in_threes.unwrap_or_else(|| match levels {
        [.., a, b] if *a == L::NONE && *b == L::NONE => levels.len() - 2,
        _ => levels.len(),
    })
}

/// How often the first level repeats; 0 where there is none.
fn run_len<L: Level>(levels: &[L]) -> usize {
    let differs = levels.iter().position(|level| Some(level) != levels.first());
    differs.unwrap_or(levels.len())
}

fn put_literals<L: Level>(levels: &[L], sink: &mut Sink<'_>) -> Result<(), OutputFull> {
    for chunk in levels.chunks(LITERALS_MAX) {
        sink.put(count(chunk.len() - 1))?;
        sink.put_all(bytemuck::cast_slice(chunk))?;
    }
    Ok(())
}

fn put_run<L: Level>(run: &[L], sink: &mut Sink<'_>) -> Result<(), OutputFull> {
    match run.first() {
        None => Ok(()),
        Some(&level) if level == L::NONE => put_empty(run.len(), sink),
        Some(level) => put_copies(run, level, sink),
    }
}

fn put_empty(run_len: usize, sink: &mut Sink<'_>) -> Result<(), OutputFull> {
    let mut left = run_len;
    while left > 0 {
        let len = left.min(EMPTY_MAX);
        sink.put(EMPTY | count(len - 1))?;
        left -= len;
    }
    Ok(())
}

fn put_copies<L: Level>(run: &[L], level: &L, sink: &mut Sink<'_>) -> Result<(), OutputFull> {
    for chunk in run.chunks(COPIES_MAX) {
        if chunk.len() < 2 {
            put_literals(chunk, sink)?;
        } else {
            sink.put(COPIES | count(chunk.len() - 2))?;
            sink.put_all(bytemuck::bytes_of(level))?;
        }
    }
    Ok(())
}

const fn count(n: usize) -> u8 {
    n as u8
}

/// Reads `payload` into `levels`, all of both.
#[cfg(feature = "std")]
pub(crate) fn decode<L: Level>(payload: &[u8], levels: &mut [L]) -> Result<(), crate::error::PayloadFault> {
    let (mut bytes, mut rest) = (payload, levels);
    while let Some((&control, after)) = bytes.split_first() {
        (bytes, rest) = decode_one(control, after, rest)?;
    }
    super::check_len(0, rest.len())
}

#[cfg(feature = "std")]
type Rest<'b, 'l, L> = (&'b [u8], &'l mut [L]);

#[cfg(feature = "std")]
fn decode_one<'b, 'l, L: Level>(
    control: u8,
    bytes: &'b [u8],
    levels: &'l mut [L],
) -> Result<Rest<'b, 'l, L>, crate::error::PayloadFault> {
    use crate::error::PayloadFault::{TooLong, TooShort};
    let n = usize::from(control);
    let (run_len, taken) = match control {
        EMPTY.. => (n - usize::from(EMPTY) + 1, 0),
        COPIES.. => (n - usize::from(COPIES) + 2, size_of::<L>()),
        _ => (n + 1, (n + 1) * size_of::<L>()),
    };
    let (values, after) = bytes.split_at_checked(taken).ok_or(TooShort)?;
    let (run, rest) = levels.split_at_mut_checked(run_len).ok_or(TooLong)?;
    match control {
        EMPTY.. => run.fill(L::NONE),
        COPIES.. => run.fill(bytemuck::pod_read_unaligned(values)),
        _ => bytemuck::cast_slice_mut(run).copy_from_slice(values),
    }
    Ok((after, rest))
}
