//! Points to the pixels of an image with a column a firing.

use core::f64::consts::TAU;

use super::Firings;
use crate::error::ConfigError;
use crate::geometry::{Lattice, Pixels, Projection};
use crate::point::{BLOCK_LEN, Block};
use crate::quantize::Quantizer;

/// A sensor's own grid, but of all ticks only those that it fired at: column `(j + shift) % columns` of a row is its
/// firing `j`. The shift, of each beam, is what its azimuth phase is in columns, so that a column of the image looks one
/// way, as near as can be.
///
/// A return at a tick that is not listed goes to the nearest that is; the frame's bound says so where it is measured.
///
/// RAM: 2 bytes a line and two references.
#[derive(Debug, Clone, Copy)]
pub struct FiringLattice<'a, const LINES: usize, const WORDS: usize, const NODES: usize = 257> {
    lattice: &'a Lattice<'a, LINES, NODES>,
    firings: &'a Firings<WORDS>,
    shifts: [u16; LINES],
}

impl<'a, const LINES: usize, const WORDS: usize, const NODES: usize> FiringLattice<'a, LINES, WORDS, NODES> {
    /// The firings of one turn on a lattice with a column for every tick.
    ///
    /// # Errors
    /// [`ConfigError::Ticks`] where the lattice has not a column a tick, or `firings` is of a turn of other ticks.
    pub fn new(lattice: &'a Lattice<'a, LINES, NODES>, firings: &'a Firings<WORDS>) -> Result<Self, ConfigError> {
        let grid = lattice.grid();
        for found in [u32::from(lattice.columns()), firings.ticks()] {
            if found != grid.ticks {
                return Err(ConfigError::Ticks { found, max: grid.ticks });
            }
        }
        let mut shifts = [0; LINES];
        for (shift, beam) in shifts.iter_mut().zip(grid.beams) {
            *shift = shift_of(beam.azimuth_phase_rad, grid.clockwise, firings.len());
        }
        Ok(Self { lattice, firings, shifts })
    }

    /// The pixel of a pixel among all ticks, and how many ticks away it lies; the mark is kept.
    fn pixel(&self, pixel: u32) -> (u32, u32) {
        let (mark, pixel) = (pixel & Pixels::CLAMPED, pixel & !Pixels::CLAMPED);
        let (ticks, columns) = (self.firings.ticks().max(1), u32::from(self.firings.len()));
        let row = pixel / ticks;
        let (firing, off) = self.firings.nearest(pixel % ticks);
        let column = u32::from(firing) + u32::from(self.shifts.get(row as usize).copied().unwrap_or(0));
        let column = if column >= columns { column - columns } else { column };
        (mark | (row * columns + column), off)
    }

    /// Columns by which a row's firings are moved on.
    pub(crate) fn shift(&self, row: usize) -> usize {
        self.shifts.get(row).copied().unwrap_or(0).into()
    }

    /// The column of a return, and how many ticks its firing is away; `None` where the sensor has no such tick.
    pub(crate) fn column(&self, row: u16, tick: u32) -> Option<(u32, u32)> {
        let (ticks, columns) = (self.firings.ticks(), u32::from(self.firings.len()));
        if tick >= ticks {
            return None;
        }
        // Below both numbers: no product is beyond that of rows and ticks.
        let (pixel, off) = self.pixel(u32::from(row) * ticks + tick);
        Some((pixel % columns.max(1), off))
    }

    /// How many ticks each point of a block is away from the firing that it goes to.
    pub(crate) fn ticks_off(&self, block: &Block, quantizer: &Quantizer) -> [u32; BLOCK_LEN] {
        let mut pixels = Pixels::new();
        self.lattice.project(block, quantizer, &mut pixels);
        pixels.pixel.map(|pixel| self.pixel(pixel).1)
    }
}

/// Columns by which a beam looks ahead of azimuth phase 0, from 0 to `columns` - 1: rounded, halves to even.
pub(crate) fn shift_of(azimuth_phase_rad: f32, clockwise: bool, columns: u16) -> u16 {
    let turns = f64::from(azimuth_phase_rad) / TAU;
    let turns = if clockwise { -turns } else { turns };
    // A phase is at most a turn either way.
    let shift = libm::rint(turns * f64::from(columns)) as i32 % i32::from(columns).max(1);
    let shift = if shift < 0 { shift + i32::from(columns) } else { shift };
    shift as u16
}

impl<const LINES: usize, const WORDS: usize, const NODES: usize> Projection for FiringLattice<'_, LINES, WORDS, NODES> {
    fn rows(&self) -> u16 {
        self.lattice.rows()
    }

    fn columns(&self) -> u16 {
        self.firings.len()
    }

    fn project(&self, block: &Block, quantizer: &Quantizer, pixels: &mut Pixels) {
        self.lattice.project(block, quantizer, pixels);
        for pixel in &mut pixels.pixel {
            *pixel = self.pixel(*pixel).0;
        }
    }
}
