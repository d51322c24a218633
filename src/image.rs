//! The range image: rows (beams, row 0 the highest) by columns (azimuth), one level a pixel, 0 = no return.

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
}

/// A pixel type: `u8` for levels of 1 to 8 bits, `u16` for 9 to 16. 0 is no return.
pub trait Level: Copy + Eq + Ord + bytemuck::Pod + sealed::Sealed {
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
        ImageView { levels: self.levels.as_flattened(), columns: COLS }
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

/// A borrowed range image of any size; what the coders are written for.
#[derive(Debug, Clone, Copy)]
pub struct ImageView<'a, L: Level> {
    levels: &'a [L],
    columns: usize,
}

impl<'a, L: Level> ImageView<'a, L> {
    /// Levels in rows of `columns`. `None` where they make no whole number of rows.
    #[must_use]
    pub fn new(levels: &'a [L], columns: usize) -> Option<Self> {
        (columns > 0 && levels.len().is_multiple_of(columns)).then_some(Self { levels, columns })
    }

    /// All levels, row-major.
    #[must_use]
    pub const fn levels(&self) -> &'a [L] {
        self.levels
    }

    /// All levels as bytes, row-major, a `u16` low byte first.
    #[must_use]
    pub fn bytes(&self) -> &'a [u8] {
        bytemuck::cast_slice(self.levels)
    }

    /// Pixels in a row.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Rows.
    #[must_use]
    pub const fn rows(&self) -> usize {
        // `new` admits no zero, `RangeImage` may be of zero columns: then there are no rows either.
        match self.levels.len().checked_div(self.columns) {
            Some(rows) => rows,
            None => 0,
        }
    }

    /// Pixels that hold a return.
    #[must_use]
    pub fn occupied(&self) -> usize {
        // As many pixels as a byte counts, so that vectors of bytes are added.
        let occupied = |levels: &[L]| levels.iter().map(|&level| u8::from(level != L::NONE)).sum::<u8>();
        self.levels.chunks(u8::MAX.into()).map(|levels| usize::from(occupied(levels))).sum()
    }
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
        ImageView { levels: self.levels, columns: self.columns }
    }

    /// Takes all returns out.
    pub fn clear(&mut self) {
        self.levels.fill(L::NONE);
    }
}
