//! A spinning sensor's own grid: its beams, its encoder, its range counter.
//!
//! A [`Sensor`] says where every return can lie; [`Grid::locate`] finds a
//! point's cell on that grid, [`Grid::position`] is its inverse. Both work in
//! `f64`: they are the desk's exact reference, not the device's hot path.
//! [`Sensor::to_toml`] and [`Sensor::from_toml`] are the file form that
//! [`calibrate`](mod@crate::calibrate) writes.

use std::string::String;
use std::vec::Vec;

mod file;
mod grid;

pub use file::SensorFileError;
pub use grid::{Cell, Grid, Miss};

pub use crate::geometry::Beam;
use crate::geometry::SensorGrid;

/// A sensor's grid: every return lies on (beam, encoder tick, range count).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sensor {
    /// What the sensor is called; any text, may be empty.
    pub name: String,
    /// Beams from the highest slope (beam 0, the top row) to the lowest.
    pub beams: Vec<Beam>,
    /// Encoder ticks a turn.
    pub ticks_per_turn: u32,
    /// Length of one range count, metres.
    pub range_unit_m: f32,
    /// Whether ranges count from the spin axis; see [`SensorGrid::range_from_axis`].
    pub range_from_axis: bool,
}

impl Sensor {
    /// The same, to project points with and to tell a decoder of. Ticks grow counterclockwise from +x.
    #[must_use]
    pub fn grid(&self) -> SensorGrid<'_> {
        SensorGrid {
            name: &self.name,
            beams: &self.beams,
            ticks: self.ticks_per_turn,
            clockwise: false,
            zero_rad: 0.0,
            range_unit_m: self.range_unit_m,
            range_from_axis: self.range_from_axis,
        }
    }
}
