//! Returns into the range image: a sensor's own integers, so that neither a coordinate nor a float is needed.
//!
//! The row is the beam, the column follows from the tick, the level from the range count; collisions are settled and
//! everything is counted as for points (`insert`). A point's way to the same pixel is [`Lattice`](crate::geometry::Lattice)'s.

use core::num::{NonZeroU32, NonZeroU64};

use crate::geometry::SensorGrid;
use crate::image::{ImageViewMut, Level};
use crate::insert::{Collision, settle};
use crate::packet::{Column, Return, TakeRun};
use crate::quantize::{Companding, Quantizer};
use crate::tally::Tally;

/// One return in its sensor's own integers: what a frame's image keeps of it. Intensities go along where a frame has a
/// [plane](crate::plane) of them.
///
/// ```
/// use flicr::geometry::sensors::hdl64e;
/// use flicr::{Encoder, GridConfig, GridReturn, Rle, Stamp};
/// let mut encoder: Encoder<64, 500, u16, Rle> = Encoder::new(Rle::new());
/// let mut frame = encoder.start(&GridConfig::new(hdl64e::GRID, 500), Stamp::default())?;
/// frame.insert_returns([GridReturn { row: 3, tick: 800, count: 5000 }, GridReturn { row: 4, tick: 800, count: 0 }]);
/// let mut out = [0; 2000];
/// let tally = frame.finish(&mut out)?.tally;
/// assert_eq!((tally.kept(), tally.no_return), (1, 1));
/// # Ok::<(), flicr::EncodeError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GridReturn {
    /// The beam; row 0 is the highest.
    pub row: u16,
    /// The encoder's tick, less than [`SensorGrid::ticks`](crate::geometry::SensorGrid::ticks).
    pub tick: u32,
    /// Range in [`SensorGrid::range_unit_m`](crate::geometry::SensorGrid::range_unit_m); 0 is no return.
    pub count: u32,
}

impl From<Return> for GridReturn {
    fn from(found: Return) -> Self {
        Self { row: found.beam.into(), tick: found.tick.into(), count: found.count }
    }
}

/// Range counts to levels: level = count x unit / step, rounded, by one integer multiplication.
///
/// The quotient unit / step is an `f32`'s 24 bits, so that the level is off the exact quotient by no more than the
/// quantizer's bound allows for; a count midway between two levels gets either.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CountLevels {
    /// 2^32 x 2 x unit / step, less 2^`shift`.
    factor: u32,
    shift: u32,
    /// Counts beyond are far beyond every level.
    count_max: u32,
}

impl CountLevels {
    /// `unit_m` is a sensor's range unit: positive, at most a meter.
    pub(crate) fn new(unit_m: f32, quantizer: &Quantizer) -> Self {
        let bits = quantizer.steps_in(unit_m).to_bits();
        // Of 2 x quotient = factor x 2^(shift - 32), with the mantissa's bits at the top of the factor.
        let (mantissa, shift) = ((bits << 8) | 1 << 31, (bits >> 23).cast_signed() - 125);
        let factor = if shift < 0 { mantissa >> shift.unsigned_abs().min(31) } else { mantissa };
        let shift = shift.clamp(0, 31).unsigned_abs();
        Self { factor, shift, count_max: u32::MAX >> shift }
    }

    /// The level, 0 where the count is less than half a step, more than the largest where it has none.
    #[inline(always)]
    pub(crate) const fn level(self, count: u32) -> u32 {
        self.level_of_cell(if count < self.count_max { count } else { self.count_max })
    }

    /// The same for the counts of packets, which have at most [`CELL_BITS`], if [`CountLevels::is_for_cells`].
    #[inline(always)]
    const fn level_of_cell(self, count: u32) -> u32 {
        (self.twice(count) + 1) >> 1
    }

    /// Twice the exact level, cut off.
    #[inline(always)]
    const fn twice(self, count: u32) -> u32 {
        (((count << self.shift) as u64 * self.factor as u64) >> 32) as u32
    }

    /// Steps that are shorter than a 1024th of the range unit have no room for a whole count's bits: all that they could
    /// hold is nearer than any sensor measures.
    const fn is_for_cells(self) -> bool {
        self.shift + CELL_BITS <= u32::BITS
    }
}

/// Bits of the longest range count in a packet: an Ouster's.
const CELL_BITS: u32 = 20;

/// Ticks to columns: the column whose center is nearest, of two the one behind. Exact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TickColumns {
    ticks: u32,
    columns: u16,
    /// Twice the ticks, where all numbers stay below 2^32, as with every sensor in use: a Cortex-M divides these by an
    /// instruction.
    twice: Option<NonZeroU32>,
    last: (u32, u32),
}

impl TickColumns {
    pub(crate) fn new(ticks: u32, columns: u16) -> Self {
        let most = 2 * u64::from(ticks) * u64::from(columns) + u64::from(ticks);
        let twice = NonZeroU32::new(ticks.wrapping_mul(2)).filter(|_| u32::try_from(most).is_ok());
        Self { ticks, columns, twice, last: (0, 0) }
    }

    /// `None` where the sensor has no such tick. Sensors fire many beams at a tick: the last answer is kept.
    #[inline(always)]
    pub(crate) fn column(&mut self, tick: u32) -> Option<u32> {
        if tick != self.last.0 {
            self.last = (tick, self.divide(tick)?);
        }
        Some(self.last.1)
    }

    /// (tick x columns / ticks), rounded, around the turn.
    #[inline(always)]
    fn divide(&self, tick: u32) -> Option<u32> {
        if tick >= self.ticks {
            return None;
        }
        let columns = u32::from(self.columns);
        let column = match self.twice {
            Some(twice) => (2 * tick * columns + self.ticks) / twice,
            None => self.divide_long(tick)?,
        };
        Some(if column < columns { column } else { 0 })
    }

    #[cold]
    #[inline(never)]
    fn divide_long(&self, tick: u32) -> Option<u32> {
        let ticks = u64::from(self.ticks);
        Some(((2 * u64::from(tick) * u64::from(self.columns) + ticks) / NonZeroU64::new(2 * ticks)?) as u32)
    }
}

/// What a frame's returns have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ReturnScale {
    pub(crate) levels: CountLevels,
    pub(crate) columns: TickColumns,
    max_level: u16,
    /// Twice the largest level; 0 where the scale is not for the counts of packets.
    half_levels: u32,
    collision: Collision,
    /// Where levels are not even.
    companded: Option<Quantizer>,
}

impl ReturnScale {
    pub(crate) fn new(grid: &SensorGrid<'_>, quantizer: &Quantizer, columns: u16, collision: Collision) -> Self {
        let levels = CountLevels::new(grid.range_unit_m, quantizer);
        let columns = TickColumns::new(grid.ticks, columns);
        let max_level = quantizer.max_level();
        let half_levels = if levels.is_for_cells() { 2 * u32::from(max_level) } else { 0 };
        let companded = Some(*quantizer).filter(|quantizer| quantizer.companding() != Companding::None);
        Self { levels, columns, max_level, half_levels, collision, companded }
    }

    /// Puts the returns of one firing into `image`, and counts in `tally` what became of each cell; a firing whose tick
    /// the sensor has not is out of view.
    ///
    /// What a Cortex-M spends on packets it spends here: a full cell takes 23 instructions, an empty one 11.
    #[inline(never)]
    pub(crate) fn insert_column<L: Level>(
        &self,
        cells: &Column<'_>,
        image: &mut ImageViewMut<'_, L>,
        tally: &mut Tally,
    ) {
        if self.companded.is_some() {
            return self.insert_companded(cells, image, tally);
        }
        let columns = image.columns();
        // From the column on, so that a row's pixel is a product away.
        let column = self.columns.divide(cells.tick.into());
        let levels = column.and_then(|column| image.levels().get_mut(column as usize..)).unwrap_or(&mut []);
        tally.points += cells.rows() as u32;
        cells.give_counts(&mut ImageColumn { scale: self, levels, columns, tally });
    }

    /// The same where levels are not even, one return after the other.
    #[cold]
    fn insert_companded<L: Level>(&self, cells: &Column<'_>, image: &mut ImageViewMut<'_, L>, tally: &mut Tally) {
        let (tick, mut returns) = (u32::from(cells.tick), 0);
        let column = self.columns.divide(tick);
        cells.for_each_return(|found| {
            returns += 1;
            self.insert_one(found.into(), column, image, tally);
        });
        let empty = (cells.rows() as u32).saturating_sub(returns);
        tally.points += empty;
        tally.no_return += empty;
    }

    /// Puts one return into `image`'s column; `None` counts it as out of view. Gives the pixel, if that keeps it.
    #[inline(always)]
    pub(crate) fn insert_one<L: Level>(
        &self,
        found: GridReturn,
        column: Option<u32>,
        image: &mut ImageViewMut<'_, L>,
        tally: &mut Tally,
    ) -> Option<usize> {
        tally.points += 1;
        if found.count == 0 {
            tally.no_return += 1;
            return None;
        }
        let steps = self.levels.level(found.count);
        let level = self.companded.map_or(steps, |quantizer| quantizer.level_of_steps(steps));
        if level.wrapping_sub(1) >= u32::from(self.max_level) {
            tally.count_refused(level);
            return None;
        }
        let pixel = column.map(|column| usize::from(found.row) * image.columns() + column as usize);
        let level = L::new(level as u16);
        let is_kept = put(pixel.and_then(|pixel| image.levels().get_mut(pixel)), level, self.collision, tally);
        pixel.filter(|_| is_kept)
    }
}

/// An image from one of its columns on.
struct ImageColumn<'a, L> {
    scale: &'a ReturnScale,
    levels: &'a mut [L],
    columns: usize,
    tally: &'a mut Tally,
}

impl<L: Level> TakeRun<u32> for ImageColumn<'_, L> {
    // A function of its own: within the caller, its loops would have to share registers with each other.
    #[inline(never)]
    fn take_run<const N: usize>(&mut self, beams: &'static [u8], cells: &[[u8; N]], read: impl Fn(&[u8; N]) -> u32) {
        let Self { scale, levels, columns, tally } = self;
        let (scale, columns) = (**scale, *columns);
        for (&row, cell) in beams.iter().zip(cells) {
            scale.take(row, read(cell), levels, columns, tally);
        }
    }

    #[inline(never)]
    fn take_pairs<const N: usize>(
        &mut self,
        beams: &'static [u8],
        firsts: &[[u8; N]],
        seconds: &[[u8; N]],
        read: impl Fn(&[u8; N], &[u8; N]) -> u32,
    ) {
        // Two at a time: there are three slices to go on in.
        const AT_A_TIME: usize = 2;
        let Self { scale, levels, columns, tally } = self;
        let (scale, columns) = (**scale, *columns);
        let (beams, last_beam) = beams.as_chunks::<AT_A_TIME>();
        let (firsts, last_first) = firsts.as_chunks::<AT_A_TIME>();
        let (seconds, last_second) = seconds.as_chunks::<AT_A_TIME>();
        for ((beams, firsts), seconds) in beams.iter().zip(firsts).zip(seconds) {
            for ((&row, first), second) in beams.iter().zip(firsts).zip(seconds) {
                scale.take(row, read(first, second), levels, columns, tally);
            }
        }
        for ((&row, first), second) in last_beam.iter().zip(last_first).zip(last_second) {
            scale.take(row, read(first, second), levels, columns, tally);
        }
    }
}

impl ReturnScale {
    /// One cell of a firing, into the image from its column on.
    #[inline(always)]
    fn take<L: Level>(&self, row: u8, count: u32, levels: &mut [L], columns: usize, tally: &mut Tally) {
        // As `level_of_cell`, but that one comparison finds levels of 0 and beyond the last before they are rounded.
        if count == 0 {
            tally.no_return += 1;
            return;
        }
        let twice = self.levels.twice(count);
        if twice.wrapping_sub(1) < self.half_levels {
            let pixel = levels.get_mut(usize::from(row).wrapping_mul(columns));
            put(pixel, L::new(((twice + 1) >> 1) as u16), self.collision, tally);
        } else {
            tally.count_refused(twice);
        }
    }
}

impl Tally {
    /// A return whose level is none or beyond the largest.
    #[inline(always)]
    fn count_refused(&mut self, level: u32) {
        if level == 0 {
            self.too_near += 1;
        } else {
            self.beyond_range += 1;
        }
    }
}

/// A return into its pixel, if there is one; whether that keeps it. Not a call: a loop with one has half of the registers.
#[inline(always)]
fn put<L: Level>(pixel: Option<&mut L>, level: L, collision: Collision, tally: &mut Tally) -> bool {
    match pixel {
        Some(pixel) if *pixel == L::NONE => {
            *pixel = level;
            true
        }
        Some(pixel) => {
            tally.collided += 1;
            let old = *pixel;
            *pixel = settle(collision, old, level);
            *pixel != old
        }
        None => {
            tally.out_of_view += 1;
            false
        }
    }
}
