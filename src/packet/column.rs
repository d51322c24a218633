//! One firing of all beams, still in the bytes it came in.

use super::bytes;

/// One return, in the sensor's own integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Return {
    /// Index of the firing within its turn.
    pub column: u16,
    /// Row: 0 is the highest beam.
    pub beam: u8,
    /// Azimuth of the column, in the sensor's ticks (0.01 degree, or an Ouster's measurement id).
    pub tick: u16,
    /// Range, in the sensor's range unit. Never 0: that would be no return.
    pub count: u32,
    /// Intensity or reflectivity as the sensor gives it: 8 bits, 16 in Ouster's legacy profile.
    pub intensity: u16,
    /// Time of the column in the sensor's clock, in nanoseconds; see [`Column::time_ns`].
    pub time_ns: u64,
}

/// What one beam measured in one firing. A `count` of 0 is no return.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cell {
    /// Range, in the sensor's range unit; 0 is no return.
    pub count: u32,
    /// Intensity or reflectivity as the sensor gives it.
    pub intensity: u16,
}

/// Which returns of a dual-return sensor to give out. A single-return packet gives the same under
/// each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReturnPolicy {
    /// The stronger of the two.
    ///
    /// Velodyne and Hesai put the *second* strongest where the strongest belongs if the last is
    /// the strongest, so the place in the packet does not tell: the greater intensity does, and
    /// the first block on a tie. Ouster sends the stronger first.
    #[default]
    Strongest,
    /// The farther of the two.
    ///
    /// Found by its range, not by its place: PandarXT-32 firmware exists that sends the two the
    /// other way round than its manual says.
    Last,
    /// Both, as two columns of the same index: layer 0 the strongest, layer 1 the other one.
    /// Layer 1 is empty where the sensor repeats the only return it has.
    Both,
}

/// How a cell is chosen from the two returns of a firing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pick {
    /// There is one return only.
    Only,
    /// The first as sent.
    First,
    /// The second as sent, unless it repeats the first.
    Second,
    /// The one of greater intensity.
    Brighter,
    /// The one that `Brighter` leaves, unless it repeats it.
    Dimmer,
    /// The one of greater range.
    Farther,
}

impl Pick {
    #[inline(always)]
    fn choose(self, first: Cell, second: Cell) -> Cell {
        let by_strength = || if second.strength() > first.strength() { [second, first] } else { [first, second] };
        match self {
            Self::Only | Self::First => first,
            Self::Second => other(second, first),
            Self::Brighter => by_strength()[0],
            Self::Dimmer => {
                let [stronger, weaker] = by_strength();
                other(weaker, stronger)
            }
            Self::Farther => [first, second][usize::from(second.count > first.count)],
        }
    }

    /// The count that [`choose`](Self::choose) chooses, in fewer steps: most sensors repeat the only return that they
    /// have, and no cell is emptier than two empty ones.
    #[inline(always)]
    fn choose_count(self, first: Cell, second: Cell) -> u32 {
        let (a, b) = (first.count, second.count);
        match self {
            Self::Only | Self::First => a,
            Self::Farther => a.max(b),
            Self::Second | Self::Dimmer if a == b => 0,
            Self::Brighter if a == b => a,
            Self::Brighter => {
                let brighter = if second.intensity > first.intensity { b } else { a };
                // Where that is none, the other one.
                if brighter == 0 { a | b } else { brighter }
            }
            Self::Dimmer if a == 0 || b == 0 => 0,
            Self::Dimmer if second.intensity > first.intensity => a,
            Self::Second | Self::Dimmer => b,
        }
    }
}

/// `cell`, or none where it is the same echo as `taken`.
#[inline(always)]
fn other(cell: Cell, taken: Cell) -> Cell {
    if cell.count == taken.count { Cell::default() } else { cell }
}

impl Cell {
    /// Orders returns by intensity, any return before none.
    #[inline(always)]
    fn strength(self) -> u32 {
        if self.count == 0 { 0 } else { u32::from(self.intensity) + 1 }
    }
}

/// How a cell lies in the bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CellFormat {
    /// u16 count, u8 intensity (Velodyne, Pandar40P, Pandar64).
    Three,
    /// u16 count, u8 intensity, one more byte (PandarXT).
    Four,
    /// Ouster legacy: 20-bit millimetres, u16 reflectivity, 8 more bytes.
    OusterLegacy,
    /// `RNG19_RFL8_SIG16_NIR16`: 19-bit millimetres, u8 reflectivity at byte 4.
    OusterSingle,
    /// `RNG19_RFL8_SIG16_NIR16_DUAL`: two words of 19-bit millimetres and u8 reflectivity.
    OusterDual,
    /// `RNG15_RFL8_NIR8`: 15 bits of 8 mm, u8 reflectivity, u8 ambient.
    OusterLow,
}

/// The cells of one firing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells<'p> {
    /// From the first cell of the firing on.
    pub bytes: &'p [u8],
    pub shape: &'p CellShape,
}

/// How the cells of a firing lie in its bytes, and which are given: the same for all firings of a packet.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellShape {
    pub format: CellFormat,
    pub pick: Pick,
    /// Bytes from a cell to its second return, where that lies in another block.
    pub to_second: usize,
    /// Bytes from one run of cells to the next; a run has `run_len` cells.
    pub to_next_run: usize,
    pub run_len: usize,
    /// Row of each channel.
    pub beam_of_channel: &'static [u8],
}

/// What takes the cells of a firing, a run of channels at a time.
///
/// A loop of its own for each format and way to choose, so that a device keeps all of it in registers.
pub(crate) trait TakeRun<T> {
    /// The cells of the channels whose rows are `beams`, in the same order; `read` makes of each what is taken.
    fn take_run<const N: usize>(&mut self, beams: &'static [u8], cells: &[[u8; N]], read: impl Fn(&[u8; N]) -> T);

    /// The same of cells that come twice. As three slices, not as an iterator: that would cost a device 15 instructions
    /// a firing to hand over.
    fn take_pairs<const N: usize>(
        &mut self,
        beams: &'static [u8],
        firsts: &[[u8; N]],
        seconds: &[[u8; N]],
        read: impl Fn(&[u8; N], &[u8; N]) -> T,
    );
}

/// Takes cell for cell.
struct Each<F>(F);

impl<T, F: FnMut(u8, T)> TakeRun<T> for Each<F> {
    #[inline(always)]
    fn take_run<const N: usize>(&mut self, beams: &'static [u8], cells: &[[u8; N]], read: impl Fn(&[u8; N]) -> T) {
        beams.iter().zip(cells).for_each(|(&beam, cell)| self.0(beam, read(cell)));
    }

    #[inline(always)]
    fn take_pairs<const N: usize>(
        &mut self,
        beams: &'static [u8],
        firsts: &[[u8; N]],
        seconds: &[[u8; N]],
        read: impl Fn(&[u8; N], &[u8; N]) -> T,
    ) {
        let pairs = firsts.iter().zip(seconds);
        beams.iter().zip(pairs).for_each(|(&beam, (first, second))| self.0(beam, read(first, second)));
    }
}

impl<'p> Cells<'p> {
    /// Calls `each` with the row and the cell of every channel, in the order of the packet.
    #[inline(always)]
    fn for_each(&self, each: impl FnMut(u8, Cell)) {
        self.give(Pick::choose, &mut Each(each));
    }

    /// Gives all counts, in the order of the packet.
    #[inline(always)]
    fn give_counts(&self, taker: &mut impl TakeRun<u32>) {
        self.give(Pick::choose_count, taker);
    }

    /// `choose` makes of two cells what `taker` takes.
    #[inline(always)]
    fn give<T>(&self, choose: impl Fn(Pick, Cell, Cell) -> T + Copy, taker: &mut impl TakeRun<T>) {
        match self.shape.format {
            CellFormat::Three => self.blocks(three, choose, taker),
            CellFormat::Four => self.blocks(four, choose, taker),
            CellFormat::OusterLegacy => self.inline(ouster_legacy, choose, taker),
            CellFormat::OusterSingle => self.inline(ouster_single, choose, taker),
            CellFormat::OusterDual => self.inline(ouster_dual, choose, taker),
            CellFormat::OusterLow => self.inline(ouster_low, choose, taker),
        }
    }

    /// Formats that keep the second return in a block of its own.
    #[inline(always)]
    fn blocks<const N: usize, T>(
        &self,
        read: impl Fn(&[u8; N]) -> Cell + Copy,
        choose: impl Fn(Pick, Cell, Cell) -> T + Copy,
        taker: &mut impl TakeRun<T>,
    ) {
        // One loop for each way to choose, so that the choice costs nothing inside it.
        match self.shape.pick {
            Pick::Only | Pick::First => self.single(|cell| choose(Pick::Only, read(cell), NONE), taker),
            Pick::Second => self.pairs(|a, b| choose(Pick::Second, read(a), read(b)), taker),
            Pick::Brighter => self.pairs(|a, b| choose(Pick::Brighter, read(a), read(b)), taker),
            Pick::Dimmer => self.pairs(|a, b| choose(Pick::Dimmer, read(a), read(b)), taker),
            Pick::Farther => self.pairs(|a, b| choose(Pick::Farther, read(a), read(b)), taker),
        }
    }

    #[inline(always)]
    fn single<const N: usize, T>(&self, read: impl Fn(&[u8; N]) -> T + Copy, taker: &mut impl TakeRun<T>) {
        self.for_each_run(|cells, beams| taker.take_run(beams, cells.as_chunks().0, read));
    }

    #[inline(always)]
    fn pairs<const N: usize, T>(&self, read: impl Fn(&[u8; N], &[u8; N]) -> T + Copy, taker: &mut impl TakeRun<T>) {
        self.for_each_run(|cells, beams| {
            let seconds = bytes::tail(cells, self.shape.to_second).as_chunks().0;
            taker.take_pairs(beams, cells.as_chunks().0, seconds, read);
        });
    }

    /// Formats that keep both returns of a beam in one cell.
    #[inline(always)]
    fn inline<const N: usize, T>(
        &self,
        read: impl Fn(&[u8; N]) -> [Cell; 2] + Copy,
        choose: impl Fn(Pick, Cell, Cell) -> T + Copy,
        taker: &mut impl TakeRun<T>,
    ) {
        let choose = |cell: &_| {
            let [first, second] = read(cell);
            choose(self.shape.pick, first, second)
        };
        self.single(choose, taker);
    }

    /// Calls `each` with the bytes from each run of cells on, and the rows of its channels.
    #[inline(always)]
    fn for_each_run(&self, mut each: impl FnMut(&'p [u8], &'static [u8])) {
        // `max` makes the loop end whatever the format says. Nearly all sensors have one run.
        let (mut cells, mut beams, run_len) = (self.bytes, self.shape.beam_of_channel, self.shape.run_len.max(1));
        loop {
            let (run, others) = beams.split_at_checked(run_len).unwrap_or((beams, &[]));
            each(cells, run);
            if others.is_empty() {
                return;
            }
            (cells, beams) = (bytes::tail(cells, self.shape.to_next_run), others);
        }
    }
}

#[inline(always)]
fn three(cell: &[u8; 3]) -> Cell {
    Cell { count: u32::from(u16::from_le_bytes([cell[0], cell[1]])), intensity: u16::from(cell[2]) }
}

#[inline(always)]
fn four(cell: &[u8; 4]) -> Cell {
    three(&[cell[0], cell[1], cell[2]])
}

const NONE: Cell = Cell { count: 0, intensity: 0 };

#[inline(always)]
fn ouster_legacy(cell: &[u8; 12]) -> [Cell; 2] {
    let count = u32::from_le_bytes([cell[0], cell[1], cell[2], 0]) & 0x000f_ffff;
    let intensity = u16::from_le_bytes([cell[4], cell[5]]);
    [Cell { count, intensity }, NONE]
}

#[inline(always)]
fn range19(word: [u8; 3], reflectivity: u8) -> Cell {
    Cell { count: u32::from_le_bytes([word[0], word[1], word[2], 0]) & 0x0007_ffff, intensity: u16::from(reflectivity) }
}

#[inline(always)]
fn ouster_single(cell: &[u8; 12]) -> [Cell; 2] {
    [range19([cell[0], cell[1], cell[2]], cell[4]), NONE]
}

#[inline(always)]
fn ouster_dual(cell: &[u8; 16]) -> [Cell; 2] {
    [range19([cell[0], cell[1], cell[2]], cell[3]), range19([cell[4], cell[5], cell[6]], cell[7])]
}

#[inline(always)]
fn ouster_low(cell: &[u8; 4]) -> [Cell; 2] {
    let count = u32::from(u16::from_le_bytes([cell[0], cell[1]]) & 0x7fff);
    let intensity = u16::from(cell[2]);
    [Cell { count, intensity }, NONE]
}

/// One firing of all beams: a column of the range image.
///
/// It borrows the packet: nothing was copied or decoded yet. [`for_each_return`] and [`counts`] do
/// that, in a loop made for the packet's format.
///
/// [`for_each_return`]: Column::for_each_return
/// [`counts`]: Column::counts
#[derive(Clone, Copy, Debug)]
pub struct Column<'p> {
    /// Index of the firing within its turn, lost and blind columns counted; an Ouster's
    /// measurement id.
    pub index: u16,
    /// Azimuth at `time_ns`, in the sensor's ticks: 0.01 degree, or an Ouster's measurement id.
    pub tick: u16,
    /// How far the sensor turns from this column to the next, in 1/256 tick.
    ///
    /// With it and a beam's firing time the geometry finds the azimuth at which the beam fired:
    /// `tick + step_q8 / 256 * fire_ns / period_ns` (see
    /// [`ModelFacts::fire_ns`](super::ModelFacts::fire_ns)). 256 for Ouster, whose beams fire
    /// together.
    pub step_q8: u32,
    /// 0, or 1 for the second column that [`ReturnPolicy::Both`] gives of a firing.
    pub layer: u8,
    /// Time of the firing in the sensor's clock, in nanoseconds.
    ///
    /// Velodyne: since the full hour. Hesai: since 1970 in UTC if the packet's date is sound, else
    /// since the full second. Ouster: as the sensor is set up (since power-on, or PTP time).
    pub time_ns: u64,
    pub(super) cells: Cells<'p>,
}

impl Column<'_> {
    /// Beams of the sensor: rows of the range image.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.cells.shape.beam_of_channel.len()
    }

    /// Calls `each` with the row (0 = highest) and the cell of every beam, empty ones included, in
    /// the order in which the packet holds them.
    #[inline]
    pub fn for_each_cell(&self, each: impl FnMut(u8, Cell)) {
        self.cells.for_each(each);
    }

    /// Gives the range counts of all cells, 0 where there is no return.
    #[inline(always)]
    pub(crate) fn give_counts(&self, taker: &mut impl TakeRun<u32>) {
        self.cells.give_counts(taker);
    }

    /// Calls `each` with every return, in the order in which the packet holds them.
    #[inline]
    pub fn for_each_return(&self, mut each: impl FnMut(Return)) {
        self.cells.for_each(|beam, cell| {
            if cell.count != 0 {
                each(Return {
                    column: self.index,
                    beam,
                    tick: self.tick,
                    count: cell.count,
                    intensity: cell.intensity,
                    time_ns: self.time_ns,
                });
            }
        });
    }

    /// Writes the range counts in row order, 0 where there is no return. Rows that `out` does not
    /// have are left away; entries of `out` past the last row stay as they are.
    #[inline]
    pub fn counts(&self, out: &mut [u32]) {
        self.cells.give_counts(&mut Each(|beam, found| {
            if let Some(count) = out.get_mut(usize::from(beam)) {
                *count = found;
            }
        }));
    }
}
