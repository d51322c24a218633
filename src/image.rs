//! The range image: rows (beams, row 0 the highest) by columns (azimuth), one level a pixel, 0 = no return.

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
}

/// A pixel type: `u8` for levels of 1 to 8 bits, `u16` for 9 to 16. 0 is no return.
pub trait Level: Copy + Eq + Ord + Send + Sync + bytemuck::Pod + sealed::Sealed {
    /// Most bits a level can have.
    const BITS: u32;
    /// Fewest bits a level can have: with fewer, the smaller type is used.
    const BITS_MIN: u32;
    /// No return.
    const NONE: Self;
    /// The level as a number.
    fn get(self) -> u16;
    /// The number as a level; the bits that do not fit are cut off.
    fn new(level: u16) -> Self;
}

impl Level for u8 {
    const BITS: u32 = 8;
    const BITS_MIN: u32 = 1;
    const NONE: Self = 0;
    fn get(self) -> u16 {
        u16::from(self)
    }
    fn new(level: u16) -> Self {
        level as u8
    }
}

impl Level for u16 {
    const BITS: u32 = 16;
    const BITS_MIN: u32 = 9;
    const NONE: Self = 0;
    fn get(self) -> u16 {
        self
    }
    fn new(level: u16) -> Self {
        level
    }
}

// Coders read and write levels as little-endian bytes; every ARM target in use is little-endian.
#[cfg(target_endian = "big")]
compile_error!("flicr reads levels as little-endian bytes: big-endian targets would write other bytes");

/// Levels of `ROWS` x `COLS` pixels, row-major, row 0 the highest beam. Takes `ROWS * COLS * size_of::<L>()` bytes
/// of RAM, all zero when new, so that a `static` one costs no flash.
///
/// ```
/// use flicr::RangeImage;
/// static IMAGE: RangeImage<64, 256> = RangeImage::new();
/// assert_eq!(core::mem::size_of_val(&IMAGE), 16_384);
/// assert_eq!(IMAGE.view().occupied(), 0);
/// ```
#[derive(Debug, Clone)]
pub struct RangeImage<const ROWS: usize, const COLS: usize, L: Level = u8> {
    levels: [[L; COLS]; ROWS],
}

impl<const ROWS: usize, const COLS: usize, L: Level> RangeImage<ROWS, COLS, L> {
    /// An image without returns.
    #[must_use]
    pub const fn new() -> Self {
        Self { levels: [[L::NONE; COLS]; ROWS] }
    }

    /// The pixels, to read.
    #[must_use]
    pub fn view(&self) -> ImageView<'_, L> {
        ImageView::whole(self.levels.as_flattened(), COLS)
    }

    /// The pixels, to write.
    #[must_use]
    pub fn view_mut(&mut self) -> ImageViewMut<'_, L> {
        ImageViewMut { levels: self.levels.as_flattened_mut(), columns: COLS }
    }
}

impl<const ROWS: usize, const COLS: usize, L: Level> Default for RangeImage<ROWS, COLS, L> {
    fn default() -> Self {
        Self::new()
    }
}

/// A borrowed range image of any size, or a run of its columns; what the coders are written for.
#[derive(Debug, Clone, Copy)]
pub struct ImageView<'a, L: Level> {
    /// From the first pixel to the last.
    levels: &'a [L],
    columns: usize,
    /// Pixels from a row to the next.
    stride: usize,
    rows: usize,
}

impl<'a, L: Level> ImageView<'a, L> {
    /// Levels in rows of `columns`. `None` where they make no whole number of rows.
    #[must_use]
    pub fn new(levels: &'a [L], columns: usize) -> Option<Self> {
        (columns > 0 && levels.len().is_multiple_of(columns)).then(|| Self::whole(levels, columns))
    }

    pub(crate) const fn whole(levels: &'a [L], columns: usize) -> Self {
        // `new` admits no zero, `RangeImage` may be of zero columns: then there are no rows either.
        let rows = match levels.len().checked_div(columns) {
            Some(rows) => rows,
            None => 0,
        };
        Self { levels, columns, stride: columns, rows }
    }

    /// The columns from `first` on, all rows of them. `None` where there are not as many, and where they are none.
    ///
    /// ```
    /// use flicr::RangeImage;
    /// let image = RangeImage::<64, 256>::new();
    /// let strip = image.view().strip(16, 32).unwrap();
    /// assert_eq!((strip.rows(), strip.columns(), strip.pixels()), (64, 32, 2048));
    /// assert!(strip.levels().is_none());
    /// ```
    #[must_use]
    pub fn strip(&self, first: usize, columns: usize) -> Option<Self> {
        let end = first.checked_add(columns).filter(|&end| columns > 0 && end <= self.columns)?;
        let last_row = self.stride * self.rows.checked_sub(1)?;
        Some(Self { levels: self.levels.get(first..last_row + end)?, columns, ..*self })
    }

    /// All levels, row-major. `None` of a run of columns, whose rows lie apart.
    #[must_use]
    pub const fn levels(&self) -> Option<&'a [L]> {
        if self.stride == self.columns { Some(self.levels) } else { None }
    }

    /// The levels of each row.
    pub fn row_levels(&self) -> impl Iterator<Item = &'a [L]> + use<'a, L> {
        let columns = self.columns;
        // The last row ends with its last pixel.
        self.levels.chunks(self.stride.max(1)).map(move |row| row.get(..columns).unwrap_or(row))
    }

    /// The levels of a column, from row 0.
    #[inline]
    pub(crate) fn column(&self, column: usize) -> impl Iterator<Item = L> + use<'a, L> {
        let (levels, stride, mut at) = (self.levels, self.stride.max(1), column);
        // `skip` and `step_by` take twice the instructions on a Cortex-M.
        core::iter::from_fn(move || {
            let level = levels.get(at).copied();
            at += stride;
            level
        })
    }

    /// All levels as one slice, row-major: these themselves, or where they lie apart a copy at the end of `room`; and the
    /// room that is left. `None` where there is not enough.
    pub(crate) fn gathered<'r>(self, room: &'r mut [u8]) -> Option<(&'r [L], &'r mut [u8])>
    where
        'a: 'r,
    {
        if let Some(levels) = self.levels() {
            return Some((levels, room));
        }
        let len = self.pixels() * size_of::<L>();
        let (room, end) = room.split_at_mut_checked(room.len().checked_sub(len + gap::<L>())?)?;
        let (_, levels, _) = bytemuck::pod_align_to_mut::<u8, L>(end);
        let levels = levels.get_mut(..self.pixels())?;
        for (to, from) in levels.chunks_mut(self.columns.max(1)).zip(self.row_levels()) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        }
        Some((levels, room))
    }

    /// Pixels in a row.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Rows.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Rows times columns.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        self.rows * self.columns
    }

    /// The largest level; 0 where there is no return.
    // Not inlined: it is a loop that needs all registers of a Cortex-M.
    #[inline(never)]
    pub(crate) fn max_level(&self) -> u16 {
        self.row_levels().fold(0, |mut most, row| {
            let (chunks, rest) = row.as_chunks::<8>();
            for levels in chunks {
                // No bit of any is beyond the most so far: then none is.
                if levels.iter().fold(0, |any, level| any | level.get()) > most {
                    most = largest(levels, most);
                }
            }
            largest(rest, most)
        })
    }

    /// Pixels that hold a return.
    #[must_use]
    pub fn occupied(&self) -> usize {
        // As many pixels as a byte counts, so that vectors of bytes are added.
        let occupied = |levels: &[L]| levels.iter().map(|&level| u8::from(level != L::NONE)).sum::<u8>();
        let in_row = |row: &[L]| row.chunks(u8::MAX.into()).map(|levels| usize::from(occupied(levels))).sum::<usize>();
        self.row_levels().map(in_row).sum()
    }
}

/// The largest of some levels and another one.
#[inline(never)]
fn largest<L: Level>(levels: &[L], other: u16) -> u16 {
    levels.iter().fold(other, |most, level| level.get().max(most))
}

/// Bytes that may lie before the first place that is aligned for a level.
pub(crate) const fn gap<L: Level>() -> usize {
    align_of::<L>() - 1
}

/// A borrowed range image of any size, to write.
#[derive(Debug)]
pub struct ImageViewMut<'a, L: Level> {
    levels: &'a mut [L],
    columns: usize,
}

impl<'a, L: Level> ImageViewMut<'a, L> {
    /// Levels in rows of `columns`. `None` where they make no whole number of rows.
    #[must_use]
    pub fn new(levels: &'a mut [L], columns: usize) -> Option<Self> {
        (columns > 0 && levels.len().is_multiple_of(columns)).then_some(Self { levels, columns })
    }

    /// All levels, row-major.
    #[must_use]
    pub fn levels(&mut self) -> &mut [L] {
        self.levels
    }

    /// Pixels in a row.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// The same pixels, to read.
    #[must_use]
    pub fn as_view(&self) -> ImageView<'_, L> {
        ImageView::whole(self.levels, self.columns)
    }

    /// Takes all returns out.
    pub fn clear(&mut self) {
        self.levels.fill(L::NONE);
    }
}
