//! A sensor of 16 beams in a made-up place: quick to simulate for thousands of turns.
#![allow(dead_code, reason = "each user takes a part")]

use flicr::geometry::{Beam, SensorGrid};

pub const ROWS: usize = 16;
pub const TICKS: u32 = 3600;

static BEAMS: [Beam; ROWS] = {
    let blank = Beam { slope: 0.0, z_offset_m: 0.0, h_offset_m: 0.0, azimuth_phase_rad: 0.0, range_phase_m: 0.0 };
    let (mut beams, mut row) = ([blank; ROWS], 0);
    while row < ROWS {
        beams[row].slope = 0.27 - 0.036 * row as f32;
        // Beams that look up to four columns apart.
        beams[row].azimuth_phase_rad = (row % 4) as f32 * 0.02;
        row += 1;
    }
    beams
};

pub static GRID: SensorGrid<'static> = SensorGrid {
    name: "small",
    beams: &BEAMS,
    ticks: TICKS,
    clockwise: true,
    zero_rad: 0.0,
    range_unit_m: 0.002,
    range_from_axis: false,
};

/// Counts of a column: walls that come and go, a floor, noise, and holes.
pub struct Place {
    state: u64,
    walls: [u32; ROWS],
}

impl Place {
    pub fn new(seed: u64) -> Self {
        Self { state: seed, walls: [5000; ROWS] }
    }

    pub fn random(&mut self, below: u64) -> u64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 33) % below
    }

    pub fn column(&mut self) -> [u32; ROWS] {
        if self.random(20) == 0 {
            let (first, range) = (self.random(ROWS as u64) as usize, 1000 + self.random(20_000) as u32);
            self.walls[first..].iter_mut().for_each(|wall| *wall = range);
        }
        std::array::from_fn(|row| match self.random(30) {
            0 => 0,
            _ => self.walls[row] + self.random(12) as u32,
        })
    }
}

/// The tick of a column of a turn of so many.
pub fn tick(column: usize, columns: usize) -> u16 {
    (column * TICKS as usize / columns) as u16
}
