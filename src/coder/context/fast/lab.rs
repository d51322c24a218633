//! For the tool that makes the priors and for benchmarks: the coder by itself, and counts of what it codes.

use std::vec::Vec;

use super::super::Allowed;
use super::OutputFull;
use super::band::{Band, GROUP_ROWS, ROWS};
use super::encode::{Rows, Sink, walk};
use super::tile::COLUMNS;
use crate::coder::{ContextSettings, Step};
use crate::error::PayloadFault;
use crate::image::{ImageView, Level};

use super::{band, occupancy, priors, symbol};

/// Contexts of a residual.
pub const CELLS: usize = band::CELLS;
/// Contexts of a nibble.
pub const CONTEXTS: usize = occupancy::CONTEXTS;
/// Values of a nibble.
pub const NIBBLES: usize = priors::NIBBLES;
/// Tables that the cells share.
pub const TABLES: usize = priors::TABLES;
/// Symbols of a table, the last of them the escape.
pub const SYMBOLS: usize = symbol::SYMBOLS;

/// Kinds of steps.
pub const KINDS: usize = priors::KINDS;

/// Which kind of steps has its own assignment of tables to cells.
#[must_use]
pub const fn kind(step: Step) -> usize {
    priors::kind(step.levels())
}

/// Raw bits behind a symbol.
#[must_use]
pub const fn raw_bits(symbol: usize) -> u32 {
    symbol::raw_bits(symbol as u16)
}

/// Decodes a payload of any tier.
///
/// # Errors
/// Where it is malformed.
pub fn decode<L: Level>(payload: &[u8], rows: usize, levels: &mut [L]) -> Result<(), PayloadFault> {
    let max_level = ((1_u32 << L::BITS) - 1) as u16;
    super::super::decode(payload, rows, levels, Allowed { max_level, error_max: u16::MAX }, None)
}

/// How often each symbol comes in each cell, and each nibble in each context.
#[derive(Debug, Clone)]
pub struct Census {
    /// By cell.
    pub symbols: Vec<[u32; SYMBOLS]>,
    /// By context.
    pub nibbles: Vec<[u32; NIBBLES]>,
}

impl Default for Census {
    fn default() -> Self {
        Self { symbols: std::vec![[0; SYMBOLS]; CELLS], nibbles: std::vec![[0; NIBBLES]; CONTEXTS] }
    }
}

impl Census {
    /// Adds an image of at most 64 rows.
    pub fn add(&mut self, image: ImageView<'_, u16>, settings: ContextSettings) {
        let (mut bands, mut tiles) = ([Band::new(0, image.rows())], [[[0; ROWS]; COLUMNS]]);
        let _ = walk(image, &mut bands, &mut tiles, &super::scale(settings, u16::MAX), self);
    }
}

impl Sink for Census {
    fn nibble(&mut self, context: u16, nibble: u8) {
        self.nibbles[usize::from(context)][usize::from(nibble)] += 1;
    }

    fn nibbles_end(&mut self) {}

    fn group(&mut self, group: &Rows<'_>, set: u8) -> Result<(), OutputFull> {
        for row in (0..GROUP_ROWS).filter(|row| set >> row & 1 == 1) {
            self.symbols[usize::from(group.cells[row])][usize::from(group.symbols[row])] += 1;
        }
        Ok(())
    }

    fn column(&mut self, _: usize) -> Result<(), OutputFull> {
        Ok(())
    }
}
