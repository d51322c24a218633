//! The HDL-64E's own columns: its beams fire together at about 2150 of 4000 ticks, each beam some ticks to the side.
#![allow(dead_code, reason = "each user takes a part")]

use std::sync::LazyLock;

use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::{ImageView, ImageViewMut, LatticeConfig, Stamp, Store, encode};

pub const ROWS: usize = 64;
const TICKS: usize = 4000;
/// Farthest that a beam is to the side of another, ticks.
const ASIDE_MAX: usize = 140;

static EVERY_TICK: LazyLock<Lattice<'static, 66>> = LazyLock::new(|| Lattice::new(hdl64e::GRID, TICKS).unwrap());

/// Range counts of a turn, row-major, columns that follow the azimuth.
pub struct Turn {
    pub levels: Vec<u16>,
    pub columns: usize,
}

impl Turn {
    pub fn view(&self) -> ImageView<'_, u16> {
        ImageView::new(&self.levels, self.columns).unwrap()
    }
}

/// Turns of one sensor.
pub fn turns<'a>(scans: impl IntoIterator<Item = &'a [[f32; 4]]>) -> Vec<Turn> {
    let mut sides = None;
    let turn = |points: &[[f32; 4]]| {
        let levels = by_tick(points);
        let sides = sides.get_or_insert_with(|| sides_of(&levels));
        compact(&levels, sides)
    };
    scans.into_iter().map(turn).collect()
}

fn by_tick(points: &[[f32; 4]]) -> Vec<u16> {
    let config = LatticeConfig::new(&EVERY_TICK);
    let mut levels = vec![0; ROWS * TICKS];
    let mut out = vec![0; config.worst_case_len::<u16, Store>()];
    let image = ImageViewMut::new(&mut levels, TICKS).unwrap();
    encode(&config, points, Stamp::default(), image, &mut Store::new(), &mut out).unwrap();
    levels
}

fn occupied(levels: &[u16], row: usize) -> impl Iterator<Item = usize> {
    let ticks = levels[row * TICKS..][..TICKS].iter().enumerate();
    ticks.filter(|(_, level)| **level != 0).map(|(tick, _)| tick)
}

/// Ticks that each row is ahead: those by which it meets the rows with more returns best.
fn sides_of(levels: &[u16]) -> Vec<usize> {
    let mut rows: Vec<usize> = (0..ROWS).collect();
    rows.sort_by_key(|&row| std::cmp::Reverse(occupied(levels, row).count()));
    let (mut votes, mut sides) = (vec![0_u32; TICKS], vec![0; ROWS]);
    for (number, row) in rows.into_iter().enumerate() {
        let met = |side: usize| occupied(levels, row).map(|tick| votes[(tick + TICKS - side) % TICKS]).sum::<u32>();
        let around = (0..=2 * ASIDE_MAX).map(|side| (side + TICKS - ASIDE_MAX) % TICKS);
        let best = around.rev().max_by_key(|&side| met(side)).unwrap();
        sides[row] = if number == 0 { 0 } else { best };
        occupied(levels, row).for_each(|tick| votes[(tick + TICKS - sides[row]) % TICKS] += 1);
    }
    sides
}

/// Only the ticks at which something fired, each row turned back to its azimuth by whole columns.
fn compact(levels: &[u16], sides: &[usize]) -> Turn {
    let mut fired = vec![false; TICKS];
    for (row, side) in sides.iter().enumerate() {
        occupied(levels, row).for_each(|tick| fired[(tick + TICKS - side) % TICKS] = true);
    }
    let ticks: Vec<usize> = (0..TICKS).filter(|&tick| fired[tick]).collect();
    let columns = ticks.len();
    let mut turn = Turn { levels: vec![0; ROWS * columns], columns };
    for (row, side) in sides.iter().enumerate() {
        let ahead = (side * columns + TICKS / 2) / TICKS;
        for (column, tick) in ticks.iter().enumerate() {
            turn.levels[row * columns + (column + ahead) % columns] = levels[row * TICKS + (tick + side) % TICKS];
        }
    }
    turn
}
