//! Points to pixels of a sensor's own grid. The same lanes and the same three stages as in `uniform`: arithmetic,
//! look-ups, arithmetic; passes over a block where the target has vectors, one loop on a Cortex-M.
#![allow(unsafe_code, reason = "a search that a sentinel ends, without a comparison of the index a step")]

#[cfg(not(target_arch = "arm"))]
use crate::geometry::angles::AngleTables;
use crate::geometry::angles::octant_ratio;
use crate::geometry::{BINS, BINS_FROM_M, Lattice, Line, Pixels};
#[cfg(not(target_arch = "arm"))]
use crate::kernel::{Lookups, to_index};
use crate::kernel::{sqrt, to_angle};
use crate::point::{BLOCK_LEN, Block};
use crate::quantize::Quantizer;

/// The pixel and the level of every lane.
#[inline(never)]
#[cfg(not(target_arch = "arm"))]
pub(crate) fn project_lattice<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    quantizer: &Quantizer,
    block: &Block,
    pixels: &mut Pixels,
) {
    let mut lanes = Lanes::NEW;
    for i in 0..BLOCK_LEN {
        let (x, y, z) = (block.x[i], block.y[i], block.z[i]);
        let rho_m = sqrt(x * x + y * y);
        let per_rho = per_rho(lattice, rho_m);
        (lanes.rho_m[i], lanes.per_rho[i]) = (rho_m, per_rho);
        lanes.bin[i] = bin(lattice, rho_m, per_rho, z);
        lanes.atan.put(i, AngleTables::<NODES>::atan_place(octant_ratio(y, x)));
    }
    for i in 0..BLOCK_LEN {
        lanes.atan.look_up(i, |node| lattice.tables().atan_ends(node));
        let start = lattice.slopes.starts[lanes.bin[i] as usize % BINS];
        lanes.put_line(i, find_line(lattice, start, lanes.rho_m[i], block.z[i]));
    }
    for i in 0..BLOCK_LEN {
        let azimuth = unfold(lattice, lanes.atan.angle(i), block.y[i], block.x[i]);
        let line = lanes.line(i);
        let at = place(lattice, quantizer, &line, azimuth, lanes.rho_m[i], lanes.per_rho[i], block.z[i]);
        (pixels.pixel[i], pixels.level[i]) = at;
    }
}

/// The pixel and the level of every lane.
#[inline(never)]
#[cfg(target_arch = "arm")]
pub(crate) fn project_lattice<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    quantizer: &Quantizer,
    block: &Block,
    pixels: &mut Pixels,
) {
    // One pointer for all lanes of a point and one for its results: with three arrays and an index, each lane's address
    // would be computed anew.
    let mut lane = (&raw const *block).cast::<f32>();
    let mut result = (&raw mut *pixels).cast::<u32>();
    let end = lane.wrapping_add(BLOCK_LEN);
    while lane != end {
        // SAFETY: a `Block` is three arrays of `BLOCK_LEN` floats one behind the other, `Pixels` two of as many numbers,
        // as `repr(C)` makes sure; `lane` and `result` walk through the first of each.
        let [x, y, z] = unsafe { [*lane, *lane.add(BLOCK_LEN), *lane.add(2 * BLOCK_LEN)] };
        let rho_m = sqrt(x * x + y * y);
        let (per_rho, line) = see(lattice, rho_m, z);
        let (pixel, level) = place(lattice, quantizer, line, azimuth(lattice, y, x), rho_m, per_rho, z);
        // SAFETY: see above.
        unsafe {
            *result = pixel;
            *result.add(BLOCK_LEN) = level;
        }
        (lane, result) = (lane.wrapping_add(1), result.wrapping_add(1));
    }
}

/// The pixel and the level of a point whose line is known.
#[inline(always)]
fn place<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    quantizer: &Quantizer,
    line: &Line,
    azimuth: u32,
    rho_m: f32,
    per_rho: f32,
    z: f32,
) -> (u32, u32) {
    let aside = line.h_turned * per_rho;
    let (column, _) = column(lattice.columns_in_turn(), turned(line, azimuth, aside));
    (line.first_pixel + column, quantizer.rounded(range_m(line, reach_m(lattice, line, rho_m, aside), z)))
}

/// 1 / rho, but no more than 1 / the distance at which beams pass the axis.
#[inline(always)]
fn per_rho<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, rho_m: f32) -> f32 {
    let nearest_m = lattice.nearest_axis_m;
    1.0 / if rho_m > nearest_m { rho_m } else { nearest_m }
}

/// Bin of a point, and what lies beyond the last.
#[inline(always)]
fn unclamped_bin<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    per_rho: f32,
    z: f32,
) -> f32 {
    lattice.slopes.bin - (z - lattice.slopes.height_m) * per_rho * lattice.slopes.bins_per_slope
}

/// Bin of a point.
#[inline(always)]
#[cfg(not(target_arch = "arm"))]
fn bin<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    rho_m: f32,
    per_rho: f32,
    z: f32,
) -> u32 {
    let last = BINS as u32 - 1;
    to_index(if rho_m < BINS_FROM_M { 0.0 } else { unclamped_bin(lattice, per_rho, z) }, last).min(last)
}

/// 1 / rho as above, and the line that the search begins at.
#[inline(always)]
#[cfg(target_arch = "arm")]
fn begin<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, rho_m: f32, z: f32) -> (f32, u8) {
    // The square root is in a core register, where it is compared in one instruction.
    if rho_m.to_bits() < BINS_FROM_M.to_bits() {
        return (near_per_rho(lattice, rho_m), lattice.slopes.starts[0]);
    }
    let per_rho = 1.0 / rho_m;
    // Signed, since both limits are then one instruction.
    let bin = (unclamped_bin(lattice, per_rho, z) as i32).clamp(0, const { (BINS - 1).cast_signed() as i32 });
    (per_rho, lattice.slopes.starts[bin as usize])
}

/// Out of the way of the loop, which few points leave.
#[cold]
#[inline(never)]
#[cfg(target_arch = "arm")]
fn near_per_rho<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, rho_m: f32) -> f32 {
    per_rho(lattice, rho_m)
}

/// The line whose row holds (rho, z), searched from one that is not below it.
#[inline(always)]
fn find_line<'a, const LINES: usize, const NODES: usize>(
    lattice: &'a Lattice<'_, LINES, NODES>,
    start: u8,
    rho_m: f32,
    z: f32,
) -> &'a Line {
    let mut line = lattice.lines.as_ptr().wrapping_add(usize::from(start));
    // SAFETY: a search starts in `lines`: `Lattice`, which alone makes them, has no start beyond the line below the
    // last row. That line has no edge (`Edge::NONE`): nothing is less than its height of minus infinity, nor than NaN.
    unsafe {
        while z < (*line).edge.slope * rho_m + (*line).edge.height_m {
            line = line.add(1);
        }
        &*line
    }
}

/// The line of a point and what its place takes.
fn see<'a, const LINES: usize, const NODES: usize>(
    lattice: &'a Lattice<'_, LINES, NODES>,
    rho_m: f32,
    z: f32,
) -> (f32, &'a Line) {
    #[cfg(target_arch = "arm")]
    let (per_rho, start) = begin(lattice, rho_m, z);
    #[cfg(not(target_arch = "arm"))]
    let (per_rho, start) = {
        let per_rho = per_rho(lattice, rho_m);
        (per_rho, lattice.slopes.starts[bin(lattice, rho_m, per_rho, z) as usize % BINS])
    };
    (per_rho, find_line(lattice, start, rho_m, z))
}

/// rho in the beam's own vertical plane: sqrt(rho^2 - h^2) by the first terms of its series; what is left out is below a
/// micrometer from half a meter on.
#[inline(always)]
fn reach_m<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    line: &Line,
    rho_m: f32,
    aside: f32,
) -> f32 {
    rho_m - lattice.half_square_rad * line.h_turned * aside
}

/// The range along the beam, less its phase.
#[inline(always)]
fn range_m(line: &Line, reach_m: f32, z: f32) -> f32 {
    (z * line.sin - line.range_phase_m) + reach_m * line.cos
}

/// The point's azimuth in the sensor's direction, 2^-32 turns. A binary fraction of a turn wraps around by itself.
#[inline(always)]
fn azimuth<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, y: f32, x: f32) -> u32 {
    unfold(lattice, lattice.tables().atan_unit(octant_ratio(y, x)), y, x)
}

/// The octant's angle, radians, put back into the octant of (x, y). As `angles::unfold_octant`, but with whole numbers:
/// half a turn less an angle is all bits but the first turned over, minus an angle all of them, to 2^-32 turns.
#[inline(always)]
fn unfold<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    octant: f32,
    y: f32,
    x: f32,
) -> u32 {
    let octant = to_angle(octant * lattice.turned_per_rad);
    let first_quadrant = if x.abs() < y.abs() { lattice.quarter_turned.wrapping_sub(octant) } else { octant };
    first_quadrant.cast_unsigned() ^ sign_mask(x) >> 1 ^ sign_mask(y)
}

/// All ones below zero.
#[inline(always)]
fn sign_mask(v: f32) -> u32 {
    (v.to_bits().cast_signed() >> 31).cast_unsigned()
}

/// Encoder azimuth from the edge of column 0, in 2^-32 turns; `aside` is the beam's distance from the axis over rho,
/// times 2^-32 turns a radian.
///
/// asin(h / rho) is taken for h / rho: of the HDL-64E, from half a meter on, that is a seventieth of a tick.
#[inline(always)]
fn turned(line: &Line, azimuth: u32, aside: f32) -> u32 {
    azimuth.wrapping_add(to_angle(aside).cast_unsigned()).wrapping_add(line.turned)
}

/// Whole columns, and 2^-32 columns beyond.
#[inline(always)]
fn column(columns: u16, turned: u32) -> (u32, u32) {
    let product = u64::from(turned) * u64::from(columns);
    ((product >> 32) as u32, product as u32)
}

/// How far a point is from the middle of its pixel and from its level, meters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Miss {
    pub(crate) across_m: f32,
    pub(crate) around_m: f32,
    pub(crate) along_m: f32,
    /// Distance from the axis.
    pub(crate) rho_m: f32,
    /// From the middle of its pixel in the sensor's direction, of which `around_m` is made.
    pub(crate) columns_off: f32,
}

/// The pixel and the steps of a point whose row is known.
pub(crate) fn place_on_row<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    quantizer: &Quantizer,
    [x, y, z]: [f32; 3],
    row: u16,
) -> (u32, u32) {
    let rho_m = sqrt(x * x + y * y);
    place(lattice, quantizer, lattice.line(row), azimuth(lattice, y, x), rho_m, per_rho(lattice, rho_m), z)
}

/// What [`project_lattice`] leaves behind of a point, or [`place_on_row`] where its row is known; `None` where it has no
/// level.
pub(crate) fn miss_lattice<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    quantizer: &Quantizer,
    [x, y, z]: [f32; 3],
    row: Option<u16>,
) -> Option<Miss> {
    let rho_m = sqrt(x * x + y * y);
    let (per_rho, line) = match row {
        Some(row) => (per_rho(lattice, rho_m), lattice.line(row)),
        None => see(lattice, rho_m, z),
    };
    let aside = line.h_turned * per_rho;
    let reach_m = reach_m(lattice, line, rho_m, aside);
    let range_m = range_m(line, reach_m, z);
    let level = quantizer.level(range_m).ok()?;
    let (_, beyond) = column(lattice.columns_in_turn(), turned(line, azimuth(lattice, y, x), aside));
    let columns_off = beyond as f32 * (0.5_f32 / (1_u32 << 31) as f32) - 0.5;
    let radians_off = columns_off * core::f32::consts::TAU / f32::from(lattice.columns_in_turn());
    // What `turned` leaves out of the arc sine, of whichever sign.
    let aside_rad = aside / lattice.turned_per_rad;
    let left_out = (libm::asinf(aside_rad) - aside_rad).abs();
    // Where the series are no longer exact; nothing that a sensor measures is there.
    let beside_axis_m = if rho_m < 0.25 { 4.0 * lattice.nearest_axis_m } else { 0.0 };
    Some(Miss {
        across_m: z * line.cos - reach_m * line.sin - lattice.z_offset_m(line) * line.cos,
        around_m: (radians_off.abs() + left_out) * rho_m + beside_axis_m,
        along_m: range_m - quantizer.range_m(level),
        rho_m,
        columns_off,
    })
}

/// What is handed from pass to pass.
#[cfg(not(target_arch = "arm"))]
struct Lanes {
    rho_m: [f32; BLOCK_LEN],
    per_rho: [f32; BLOCK_LEN],
    atan: Lookups,
    bin: [u32; BLOCK_LEN],
    sin: [f32; BLOCK_LEN],
    cos: [f32; BLOCK_LEN],
    h_turned: [f32; BLOCK_LEN],
    range_phase_m: [f32; BLOCK_LEN],
    turned: [u32; BLOCK_LEN],
    first_pixel: [u32; BLOCK_LEN],
}

#[cfg(not(target_arch = "arm"))]
impl Lanes {
    const NEW: Self = Self {
        rho_m: [0.0; BLOCK_LEN],
        per_rho: [0.0; BLOCK_LEN],
        atan: Lookups::NEW,
        bin: [0; BLOCK_LEN],
        sin: [0.0; BLOCK_LEN],
        cos: [0.0; BLOCK_LEN],
        h_turned: [0.0; BLOCK_LEN],
        range_phase_m: [0.0; BLOCK_LEN],
        turned: [0; BLOCK_LEN],
        first_pixel: [0; BLOCK_LEN],
    };

    #[inline(always)]
    fn put_line(&mut self, i: usize, line: &Line) {
        (self.sin[i], self.cos[i]) = (line.sin, line.cos);
        (self.h_turned[i], self.range_phase_m[i]) = (line.h_turned, line.range_phase_m);
        (self.turned[i], self.first_pixel[i]) = (line.turned, line.first_pixel);
    }

    #[inline(always)]
    fn line(&self, i: usize) -> Line {
        Line {
            edge: crate::geometry::Edge::NONE,
            sin: self.sin[i],
            cos: self.cos[i],
            h_turned: self.h_turned[i],
            range_phase_m: self.range_phase_m[i],
            turned: self.turned[i],
            first_pixel: self.first_pixel[i],
        }
    }
}
