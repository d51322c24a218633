//! A turn's firings, and what each beam adds to their ticks, found from its points.

use core::f64::consts::TAU;
use std::vec;
use std::vec::Vec;

use crate::error::ConfigError;
use crate::geometry::{Beam, Lattice, Pixels, Projection, SensorGrid};
use crate::point::Points;
use crate::quantize::Quantizer;

/// Lines for the largest sensor.
const LINES: usize = 258;
/// How far beams are looked for beside each other, of a turn: 22 degrees.
const APART: u32 = 16;

/// What [`find_firings`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundFirings {
    /// The grid's beams, with azimuth phases by which all beams fire at the same ticks.
    pub beams: Vec<Beam>,
    /// These ticks, ascending: every return is at one of them.
    pub ticks: Vec<u32>,
}

/// Bits of a turn, twice over, so that a turn can begin at any of them.
struct Turn {
    words: Vec<u64>,
    ticks: u32,
}

/// Finds the ticks that a sensor fired at in a turn, where all beams share them once whole ticks are added to each
/// beam's azimuth phase. `None` where they do not: where that would leave more than half as many ticks again as the
/// fullest beam has returns, or three quarters of all.
///
/// The phases of [`hdl64e::FIRING_GRID`](crate::geometry::sensors::hdl64e::FIRING_GRID) are such already; others' are
/// found by trying.
///
/// ```
/// use flicr::geometry::{find_firings, sensors::hdl64e};
/// use flicr::simulate::Simulator;
/// let scan: Vec<[f32; 3]> = Simulator::hdl64e(1).turn(0).points.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
/// let found = find_firings(scan.as_slice(), &hdl64e::FIRING_GRID)?.expect("they are shared");
/// assert!(found.ticks.len() < 2200);
/// # Ok::<(), flicr::ConfigError>(())
/// ```
///
/// # Errors
/// As [`Lattice::new`] with a column for every tick.
pub fn find_firings(
    points: &(impl Points + ?Sized),
    grid: &SensorGrid<'_>,
) -> Result<Option<FoundFirings>, ConfigError> {
    let ticks = grid.ticks;
    let beams = ticks_of_beams(points, &Lattice::<LINES>::new(*grid, ticks as usize)?);
    let fullest = beams.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let is_shared = |found: &Turn| found.len() > 0 && 2 * found.len() <= 3 * fullest && 4 * found.len() <= 3 * ticks;
    let mut as_they_are = Turn::new(ticks);
    for beam in &beams {
        as_they_are.set(beam, 0);
    }
    let (found, added) =
        if is_shared(&as_they_are) { (as_they_are, vec![0; beams.len()]) } else { align(&beams, ticks) };
    Ok(is_shared(&found).then(|| FoundFirings { beams: turned(grid, &added), ticks: found.iter().collect() }))
}

/// The ticks of each beam's returns, ascending.
fn ticks_of_beams(points: &(impl Points + ?Sized), lattice: &Lattice<'_, LINES>) -> Vec<Vec<u32>> {
    let ticks = usize::from(lattice.columns());
    let mut seen = vec![false; usize::from(lattice.rows()) * ticks];
    let (mut pixels, quantizer) = (Pixels::new(), Quantizer::with_step(16, lattice.grid().range_unit_m));
    let Ok(quantizer) = quantizer else { return Vec::new() };
    points.for_each_block(|block, len| {
        lattice.project(block, &quantizer, &mut pixels);
        for (pixel, level) in pixels.pixel.iter().zip(&pixels.level).take(len) {
            if *level > 0
                && let Some(seen) = seen.get_mut((pixel & !Pixels::CLAMPED) as usize)
            {
                *seen = true;
            }
        }
    });
    let of_row = |row: &[bool]| (0..).zip(row).filter(|(_, seen)| **seen).map(|(tick, _)| tick).collect();
    seen.chunks_exact(ticks).map(of_row).collect()
}

/// The ticks that all beams share, and what is added to each beam's own: beam after beam, the fullest first, goes where
/// most of its ticks are there already.
fn align(beams: &[Vec<u32>], ticks: u32) -> (Turn, Vec<i32>) {
    let mut order: Vec<usize> = (0..beams.len()).collect();
    order.sort_by_key(|&beam| core::cmp::Reverse(beams[beam].len()));
    let (mut shared, mut added) = (Turn::new(ticks), vec![0; beams.len()]);
    let apart = (ticks / APART).cast_signed();
    for beam in order {
        let mut own = Turn::new(ticks);
        own.set(&beams[beam], 0);
        // The nearest first: of equals, the first is taken.
        let near = (0..=apart).flat_map(|shift| [shift, -shift]);
        let best = near.rev().max_by_key(|&shift| shared.in_common(&own, shift));
        added[beam] = if shared.len() == 0 { 0 } else { best.unwrap_or(0) };
        shared.set(&beams[beam], added[beam]);
    }
    (shared, added)
}

/// The grid's beams, when these ticks are added to theirs.
fn turned(grid: &SensorGrid<'_>, added: &[i32]) -> Vec<Beam> {
    let tick_rad = if grid.clockwise { -TAU } else { TAU } / f64::from(grid.ticks);
    let turned = |(beam, &added): (&Beam, &i32)| Beam {
        azimuth_phase_rad: (f64::from(beam.azimuth_phase_rad) - f64::from(added) * tick_rad) as f32,
        ..*beam
    };
    grid.beams.iter().zip(added).map(turned).collect()
}

impl Turn {
    fn new(ticks: u32) -> Self {
        Self { words: vec![0; (2 * ticks as usize).div_ceil(64) + 1], ticks }
    }

    /// Adds ticks, each with `added` to it.
    fn set(&mut self, ticks: &[u32], added: i32) {
        for &tick in ticks {
            let tick = self.around(tick, added);
            for bit in [tick, tick + self.ticks] {
                self.words[bit as usize / 64] |= 1 << (bit % 64);
            }
        }
    }

    fn around(&self, tick: u32, added: i32) -> u32 {
        (i64::from(tick) + i64::from(added)).rem_euclid(self.ticks.into()) as u32
    }

    fn iter(&self) -> impl Iterator<Item = u32> {
        (0..self.ticks).filter(|&tick| self.words[tick as usize / 64] >> (tick % 64) & 1 == 1)
    }

    fn len(&self) -> u32 {
        self.iter().count() as u32
    }

    /// How many of `other`'s ticks are here, when `added` is added to them.
    fn in_common(&self, other: &Self, added: i32) -> u32 {
        let from = self.around(0, added) as usize;
        let (words, last_bits) = (self.ticks as usize / 64, self.ticks % 64);
        let here = |word: usize| {
            let (at, bit) = ((64 * word + from) / 64, (64 * word + from) % 64);
            if bit == 0 { self.words[at] } else { self.words[at] >> bit | self.words[at + 1] << (64 - bit) }
        };
        let whole: u32 = (0..words).map(|word| (here(word) & other.words[word]).count_ones()).sum();
        let rest = if last_bits == 0 { 0 } else { here(words) & other.words[words] & ((1 << last_bits) - 1) };
        whole + rest.count_ones()
    }
}
