//! What a stream is to be like.

use crate::coder::ContextSettings;
use crate::error::ConfigError;
use crate::geometry::SensorGrid;

/// What a stream is to be like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamConfig<'a> {
    /// The sensor's grid. The receiver must know the same: a built-in one, or one that it is told.
    pub grid: &'a SensorGrid<'a>,
    /// Range counts of the sensor in a level. 1 suits sensors whose counts fit 16 bits: all here but Ouster, whose
    /// millimeters need 4 for ranges of up to 262 m.
    pub counts_a_level: u8,
    /// How finely ranges are kept, in levels, and what they are predicted from.
    pub coder: ContextSettings,
    /// Which of the sender's streams this is, where several go to one receiver from sensors of the same kind. 0 by default.
    pub id: u8,
    /// Of a sensor that gives two returns a beam, which layer is streamed: 0 (the default) the one that the return policy
    /// prefers, 1 the other. Columns of another layer are passed over.
    pub layer: u8,
    /// Firings of a turn, about, where columns are [`Aligned`](super::Aligned): 1 to 8192. Of no use where they are not.
    pub columns_a_turn: u16,
}

impl<'a> StreamConfig<'a> {
    /// A stream of a sensor's columns, in levels of so many of its range counts.
    ///
    /// # Errors
    /// What [`SensorGrid::check`] finds; [`ConfigError::Ticks`] also where a turn has more than 65,536;
    /// [`ConfigError::RangeUnit`] for 0 counts a level.
    pub fn new(grid: &'a SensorGrid<'a>, counts_a_level: u8, coder: ContextSettings) -> Result<Self, ConfigError> {
        let config = Self { grid, counts_a_level, coder, id: 0, layer: 0, columns_a_turn: 0 };
        config.check()?;
        Ok(config)
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        self.grid.check()?;
        if self.grid.ticks > 1 << 16 {
            return Err(ConfigError::Ticks { found: self.grid.ticks, max: 1 << 16 });
        }
        if self.counts_a_level == 0 {
            return Err(ConfigError::RangeUnit { found_m: 0.0 });
        }
        Ok(())
    }
}
