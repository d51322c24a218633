//! A scan on the sensor's own grid, one column a firing.

use std::path::Path;

use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::{Decoder, ImageView, ImageViewMut, LatticeConfig, Levels, Limits, Stamp, Store, StridedPoints, encode};

const ROWS: usize = 64;
const TICKS: usize = 4000;
/// A beam's ticks are those of the firings, shifted by no more than this.
const SHIFT_MAX: usize = 140;
/// Bytes of a point.
const POINT_LEN: usize = 16;

/// Levels by beam and firing, the beams of a column at nearly the same azimuth.
pub struct Firings {
    levels: Vec<u16>,
    columns: usize,
}

/// Each beam's shift of ticks; it is the sensor's, the same in all scans. Counted from [`SHIFT_MAX`] ticks back.
pub struct Shifts([usize; ROWS]);

impl Shifts {
    /// Finds them in a scan.
    pub fn read(path: &Path) -> Result<Self, String> {
        Ok(Self(align(&ticks(path)?)))
    }
}

/// The levels of a raw KITTI scan at every tick.
fn ticks(path: &Path) -> Result<Vec<u16>, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let bytes = std::fs::read(path).map_err(|error| wrong(&error))?;
    let points = StridedPoints::new(&bytes, POINT_LEN).ok_or_else(|| wrong(&"no points"))?;
    let lattice = Lattice::<66>::new(hdl64e::GRID, TICKS).map_err(|error| wrong(&error))?;
    let config = LatticeConfig::new(&lattice);
    let mut levels = vec![0_u16; ROWS * TICKS];
    let mut out = vec![0; config.worst_case_len::<u16, Store>()];
    let image = ImageViewMut::new(&mut levels, TICKS).ok_or_else(|| wrong(&"no image"))?;
    let encoded = encode(&config, &points, Stamp::default(), image, &mut Store::new(), &mut out);
    let len = encoded.map_err(|error| wrong(&error))?.len;
    let mut decoder = Decoder::new(Limits::default());
    let frame = decoder.decode(&out[..len]).map_err(|error| wrong(&error))?;
    match frame.levels() {
        Levels::U16(levels) => Ok(levels.clone()),
        Levels::U8(_) => Err(wrong(&"levels of 8 bits")),
    }
}

impl Firings {
    /// Reads a raw KITTI scan.
    pub fn read(path: &Path, shifts: &Shifts) -> Result<Self, String> {
        Ok(Self::of_ticks(&ticks(path)?, shifts))
    }

    /// The image.
    pub fn image(&self) -> Option<ImageView<'_, u16>> {
        ImageView::new(&self.levels, self.columns)
    }

    /// Finds the firings among the ticks: those at which, once each beam's shift is taken off, any beam has a return.
    fn of_ticks(levels: &[u16], Shifts(shifts): &Shifts) -> Self {
        let is_return = |row: usize, tick: usize| levels[row * TICKS + tick_of(tick, shifts[row])] != 0;
        let firings: Vec<usize> = (0..TICKS).filter(|&tick| (0..ROWS).any(|row| is_return(row, tick))).collect();
        let columns = firings.len();
        let mut aligned = vec![0; ROWS * columns];
        for (row, &shift) in shifts.iter().enumerate() {
            // Beams fire together but look apart: moved back by as many firings as their shift takes.
            let ahead = (2 * SHIFT_MAX - shift) as f64 - SHIFT_MAX as f64;
            let ahead = (ahead * columns as f64 / TICKS as f64 + columns as f64).round() as usize;
            for column in 0..columns {
                let firing = (column + ahead) % columns;
                aligned[row * columns + column] = levels[row * TICKS + tick_of(firings[firing], shift)];
            }
        }
        Self { levels: aligned, columns }
    }
}

/// The tick of a beam at a firing's tick.
fn tick_of(firing: usize, shift: usize) -> usize {
    (firing + TICKS + shift - SHIFT_MAX) % TICKS
}

/// Each beam's shift against the first, by which most of its returns fall on those of the beams before it.
fn align(levels: &[u16]) -> [usize; ROWS] {
    let beam = |row: usize| &levels[row * TICKS..][..TICKS];
    let occupied = |row: usize| (0..TICKS).filter(move |&tick| beam(row)[tick] != 0);
    let mut rows: Vec<usize> = (0..ROWS).collect();
    rows.sort_by_key(|&row| std::cmp::Reverse(occupied(row).count()));
    let (mut shifts, mut returns) = ([SHIFT_MAX; ROWS], [0_u32; TICKS]);
    for (count, &row) in rows.iter().enumerate() {
        let back = |shift: usize| move |tick: usize| (tick + TICKS + SHIFT_MAX - shift) % TICKS;
        if count > 0 {
            let score = |shift: &usize| occupied(row).map(back(*shift)).map(|tick| returns[tick]).sum::<u32>();
            shifts[row] = (0..=2 * SHIFT_MAX).max_by_key(score).unwrap_or(SHIFT_MAX);
        }
        occupied(row).map(back(shifts[row])).for_each(|tick| returns[tick] += 1);
    }
    shifts
}
