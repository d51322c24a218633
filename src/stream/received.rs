//! What a receiver gets: the columns of a datagram, and a turn's.

use core::ops::Range;
use std::sync::Arc;
use std::vec::Vec;

use super::datagram::{DatagramError, STORED, StripHeader};
use super::line::{lead, leads};
use crate::coder::context::strip::{StripCode, StripLevels, decode_stored, decode_strip};
use crate::error::PayloadFault;
use crate::geometry::{Beam, SensorGrid, Spread, Turn};
use crate::packet::MAX_COLUMNS;

/// A sensor's grid, kept.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) sensor: u32,
    beams: Vec<Beam>,
    ticks: u32,
    clockwise: bool,
    zero_rad: f32,
    range_unit_m: f32,
    range_from_axis: bool,
}

impl Known {
    pub(super) fn new(grid: &SensorGrid<'_>) -> Self {
        let SensorGrid { ticks, clockwise, zero_rad, range_unit_m, range_from_axis, .. } = *grid;
        let (sensor, beams) = (grid.checksum(), grid.beams.to_vec());
        Self { sensor, beams, ticks, clockwise, zero_rad, range_unit_m, range_from_axis }
    }

    fn grid(&self) -> SensorGrid<'_> {
        let Self { ticks, clockwise, zero_rad, range_unit_m, range_from_axis, .. } = *self;
        SensorGrid { name: "", beams: &self.beams, ticks, clockwise, zero_rad, range_unit_m, range_from_axis }
    }
}

/// One datagram's columns.
#[derive(Debug, Clone)]
pub struct ReceivedStrip {
    pub(super) header: StripHeader,
    sensor: Arc<Known>,
    /// Of its firings: one a column as fired, else all between the first and the last that its columns are of.
    ticks: Vec<u16>,
    /// Firings from the first one to that whose number the first column has.
    behind: u16,
    /// Column by column, each from the highest beam; 0 = no return.
    levels: Vec<u16>,
}

impl StripHeader {
    /// Columns of the turn that it speaks of, those that the stride passed over included.
    pub(super) fn span(&self) -> Range<u16> {
        let columns = self.columns.saturating_mul(self.stride.into());
        self.first_column..self.first_column.saturating_add(columns)
    }

    /// Behind its last column.
    pub(super) fn end(&self) -> u16 {
        self.span().end.saturating_sub(u16::from(self.stride) - 1)
    }
}

impl ReceivedStrip {
    /// Decodes a strip; all bounds that keep the work small are checked before.
    pub(super) fn decode(header: StripHeader, sensor: Arc<Known>, code: &[u8]) -> Result<Self, DatagramError> {
        let wrong = |name, found| Err(DatagramError::Field { name, found });
        if header.columns > 0 && header.end() > MAX_COLUMNS {
            return wrong("last column", header.end().into());
        }
        if header.columns_a_turn > MAX_COLUMNS {
            return wrong("columns a turn", header.columns_a_turn.into());
        }
        // Not more than a turn each way, as phases are.
        let (least, most) = leads(&sensor.grid(), header.columns_a_turn);
        let (before_first, before_others) = match header.columns_a_turn {
            0 => (0, 1),
            _ => (least.abs_diff(most) as usize, header.stride.into()),
        };
        let StripLevels { tick_steps, levels } =
            levels(&header, sensor.beams.len(), [before_first, before_others], code).map_err(DatagramError::Payload)?;
        let mut ticks = Vec::with_capacity(tick_steps.len() + 1);
        let mut tick = u32::from(header.first_tick);
        let steps = core::iter::once(0).chain(tick_steps);
        for step in steps.take(if header.columns == 0 { 0 } else { usize::MAX }) {
            tick += u32::from(step);
            tick -= if tick >= sensor.ticks { sensor.ticks } else { 0 };
            if tick >= sensor.ticks {
                return wrong("tick", tick);
            }
            ticks.push(tick as u16);
        }
        Ok(Self { header, sensor, ticks, behind: most as u16, levels })
    }

    /// The sender's number of the turn; wraps.
    #[must_use]
    pub const fn turn(&self) -> u16 {
        self.header.turn
    }

    /// Number of the strip in its turn.
    #[must_use]
    pub const fn number(&self) -> u16 {
        self.header.strip
    }

    /// Which of the sender's streams it is of.
    #[must_use]
    pub const fn stream(&self) -> u8 {
        self.header.id
    }

    /// Checksum of its sensor's grid.
    #[must_use]
    pub const fn sensor(&self) -> u32 {
        self.header.sensor
    }

    /// Beams of its sensor.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.sensor.beams.len()
    }

    /// Ticks of a turn of its sensor.
    #[must_use]
    pub fn ticks_a_turn(&self) -> u32 {
        self.sensor.ticks
    }

    /// Firings that its oldest return has waited until it went out, at most: the strip's own, and where columns are aligned
    /// those of the delay.
    #[must_use]
    pub fn latency(&self) -> usize {
        let firings = self.ticks.len().max(1) - 1;
        let stride = usize::from(self.header.stride);
        if self.is_aligned() { firings + stride } else { (firings + 1) * stride }
    }

    /// Whether the turn ends with it.
    #[must_use]
    pub const fn is_last(&self) -> bool {
        self.header.last
    }

    /// Whether its columns are of what looks one way, not of one firing each.
    #[must_use]
    pub const fn is_aligned(&self) -> bool {
        self.header.columns_a_turn != 0
    }

    /// Number of its first column in the turn.
    #[must_use]
    pub const fn first_column(&self) -> u16 {
        self.header.first_column
    }

    /// From each column's number to the next's: 1 where none was passed over.
    #[must_use]
    pub const fn stride(&self) -> u8 {
        self.header.stride
    }

    /// The tick at which a beam fired in a column of it, both counted from 0; `None` beyond the last.
    #[must_use]
    pub fn tick(&self, column: usize, row: usize) -> Option<u16> {
        let beam = self.sensor.beams.get(row)?;
        self.ticks.get(self.place(column, beam)).copied().filter(|_| column < self.header.columns.into())
    }

    /// Where in `ticks` a beam's firing of a column is.
    fn place(&self, column: usize, beam: &Beam) -> usize {
        if !self.is_aligned() {
            return column;
        }
        let lead = lead(beam, self.sensor.clockwise, self.header.columns_a_turn);
        // Leads are not more than the largest.
        column * usize::from(self.header.stride) + (i32::from(self.behind) - lead).unsigned_abs() as usize
    }

    /// When its first column was fired, in the sensor's clock, microseconds; wraps after 71 minutes.
    #[must_use]
    pub const fn time_us(&self) -> u32 {
        self.header.time_us
    }

    /// Columns with their levels from the highest beam on, 0 = no return. The tick is that of the firing whose number the
    /// column has: of all beams where columns are as fired.
    pub fn columns(&self) -> impl Iterator<Item = (u16, &[u16])> {
        let stride = if self.is_aligned() { self.header.stride.into() } else { 1 };
        let ticks =
            self.ticks.iter().copied().skip(if self.is_aligned() { self.behind.into() } else { 0 }).step_by(stride);
        ticks.zip(self.levels.chunks_exact(self.sensor.beams.len()))
    }

    /// Returns in it.
    #[must_use]
    pub fn returns(&self) -> usize {
        self.levels.iter().filter(|&&level| level != 0).count()
    }

    /// Levels of a step.
    #[must_use]
    pub fn step(&self) -> u16 {
        self.header.settings.step.levels()
    }

    /// Meters between two levels.
    #[must_use]
    pub fn level_m(&self) -> f32 {
        f32::from(self.header.counts_a_level) * self.sensor.range_unit_m
    }

    /// Most that a range is off what the sensor measured, meters: nothing on the sensor's own counts, but for the rounding
    /// of a float.
    #[must_use]
    pub fn range_bound_m(&self) -> f32 {
        let stepped = f32::from(self.header.settings.step.error_max()) * self.level_m();
        let rounded = f32::from(self.header.counts_a_level / 2) * self.sensor.range_unit_m;
        if self.header.tier == STORED { rounded } else { stepped + rounded }
    }

    /// Its points, x, y, z in meters, column by column, each from the highest beam.
    #[must_use]
    pub fn points(&self) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        self.push_points(&mut points);
        points
    }

    fn push_points(&self, points: &mut Vec<[f32; 3]>) {
        let ticks: Vec<u32> = self.ticks.iter().map(|&tick| tick.into()).collect();
        let mut turn = Turn::default();
        // Fewer than 2^16: the window, and stride x columns of at most 8192 each.
        turn.prepare(&self.sensor.grid(), ticks.len() as u16, Spread::AsFired(&ticks), self.level_m());
        let beams = self.sensor.beams.iter().enumerate();
        let rows: Vec<_> = beams.map(|(row, beam)| (turn.row(row), self.place(0, beam))).collect();
        let stride = if self.is_aligned() { self.header.stride.into() } else { 1 };
        for (column, (_, levels)) in self.columns().enumerate() {
            let found = levels.iter().zip(&rows).filter(|(level, _)| **level != 0);
            points.extend(found.map(|(&level, ((columns, row), first))| {
                let [x, y, z, _] = row.at(&columns[first + column * stride], level);
                [x, y, z]
            }));
        }
    }
}

fn levels(header: &StripHeader, rows: usize, ticks: [usize; 2], code: &[u8]) -> Result<StripLevels, PayloadFault> {
    let StripHeader { columns, tier, settings, rate_q10, .. } = *header;
    let columns = usize::from(columns);
    if columns == 0 {
        crate::coder::check_len(code.len(), 0)?;
        return Ok(StripLevels::default());
    }
    let strip = StripCode { tier, settings, order: header.order(), rows, columns, ticks, rate_q10 };
    match (tier, columns) {
        (STORED, 1) => decode_stored(strip, code),
        (STORED, _) => Err(PayloadFault::Malformed),
        _ => decode_strip(strip, code),
    }
}

/// A turn that is over.
#[derive(Debug, Clone)]
pub struct ReceivedTurn {
    pub(super) sensor: u32,
    pub(super) stream: u8,
    pub(super) number: u16,
    /// Strips that were sent, where that is known.
    pub(super) sent: Option<u16>,
    pub(super) strips: Vec<ReceivedStrip>,
}

impl ReceivedTurn {
    /// The sender's number of it; wraps.
    #[must_use]
    pub const fn number(&self) -> u16 {
        self.number
    }

    /// Which of the sender's streams it is of.
    #[must_use]
    pub const fn stream(&self) -> u8 {
        self.stream
    }

    /// Checksum of its sensor's grid.
    #[must_use]
    pub const fn sensor(&self) -> u32 {
        self.sensor
    }

    /// Whether all that was sent of it came.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.sent.is_some_and(|sent| usize::from(sent) == self.strips.len())
    }

    /// What came of it, in order.
    #[must_use]
    pub fn strips(&self) -> &[ReceivedStrip] {
        &self.strips
    }

    /// Numbers of the strips that did not come; those behind the last that did are not known where the end is missing.
    pub fn missing(&self) -> impl Iterator<Item = u16> {
        let known = self.sent.unwrap_or_else(|| self.strips.last().map_or(0, |strip| strip.header.strip + 1));
        (0..known).filter(|number| self.strips.binary_search_by_key(number, |strip| strip.header.strip).is_err())
    }

    /// Whether each column of the turn was received, up to the last that was. Those that the sender's stride passed over
    /// count with the one before them; those that it cut off, or never had, were not received.
    #[must_use]
    pub fn mask(&self) -> Vec<bool> {
        let spans = || self.strips.iter().map(|strip| strip.header.span());
        let mut mask = std::vec![false; spans().map(|span| span.end).max().unwrap_or(0).into()];
        spans().for_each(|span| mask[usize::from(span.start)..usize::from(span.end)].fill(true));
        mask
    }

    /// Its points, x, y, z in meters, column by column.
    #[must_use]
    pub fn points(&self) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        self.strips.iter().for_each(|strip| strip.push_points(&mut points));
        points
    }
}
