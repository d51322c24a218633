//! Points to pixels of a sensor's own grid. The same lanes and the same three stages as in `uniform`: arithmetic,
//! look-ups, arithmetic; passes over a block where the target has vectors, one loop on a Cortex-M.
#![allow(unsafe_code, reason = "a search that a sentinel ends, without a comparison of the index a step")]

use crate::geometry::angles::{octant_ratio, unfold_octant};
use crate::geometry::{BINS, BINS_FROM_M, Lattice, Line, Pixels};
#[cfg(not(target_arch = "arm"))]
use crate::kernel::to_index;
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
        (lanes.rho_m[i], lanes.per_rho[i]) = (rho_m, per_rho(lattice, rho_m));
        (lanes.bin[i], lanes.octant[i]) = (bin(lattice, rho_m, z), octant_ratio(y, x));
    }
    for i in 0..BLOCK_LEN {
        lanes.octant[i] = lattice.tables().atan_unit(lanes.octant[i]);
        let start = start(lattice, lanes.bin[i]);
        lanes.put_line(i, find_line(lattice, start, lanes.rho_m[i], block.z[i]));
    }
    for i in 0..BLOCK_LEN {
        let azimuth = unfold_octant(lanes.octant[i], block.y[i], block.x[i]);
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
    for i in 0..BLOCK_LEN {
        let (x, y, z) = (block.x[i], block.y[i], block.z[i]);
        let rho_m = sqrt(x * x + y * y);
        let (per_rho, line) = see(lattice, rho_m, z);
        let azimuth = unfold_octant(lattice.tables().atan_unit(octant_ratio(y, x)), y, x);
        (pixels.pixel[i], pixels.level[i]) = place(lattice, quantizer, line, azimuth, rho_m, per_rho, z);
    }
}

/// The pixel and the level of a point whose line is known.
#[inline(always)]
fn place<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    quantizer: &Quantizer,
    line: &Line,
    azimuth: f32,
    rho_m: f32,
    per_rho: f32,
    z: f32,
) -> (u32, u32) {
    let aside = line.h_offset_m * per_rho;
    let (column, _) = column(lattice.columns_in_turn(), turned(lattice, line, azimuth, aside));
    (line.first_pixel + column, quantizer.rounded(range_m(line, reach_m(line, rho_m, aside), z)))
}

/// 1 / rho, but no more than 1 / the distance at which beams pass the axis.
#[inline(always)]
fn per_rho<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, rho_m: f32) -> f32 {
    let nearest_m = lattice.nearest_axis_m;
    1.0 / if rho_m > nearest_m { rho_m } else { nearest_m }
}

/// Whether a point is of the second fan.
#[inline(always)]
fn is_lower<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, rho_m: f32, z: f32) -> bool {
    z < lattice.split.slope * rho_m + lattice.split.height_m
}

/// Bin of the point's fan; that of the second fan and [`BINS`].
#[inline(always)]
#[cfg(not(target_arch = "arm"))]
fn bin<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, rho_m: f32, z: f32) -> u32 {
    let [first, second] = &lattice.fans;
    let lower = is_lower(lattice, rho_m, z);
    let (height_m, behind_m) =
        if lower { (second.height_m, second.behind_m) } else { (first.height_m, first.behind_m) };
    let (bin, per_slope) = if lower { (second.bin, second.bins_per_slope) } else { (first.bin, first.bins_per_slope) };
    let bin = bin - (z - height_m) / (rho_m + behind_m) * per_slope;
    let last = BINS as u32 - 1;
    let bin = to_index(if rho_m < BINS_FROM_M { 0.0 } else { bin }, last).min(last);
    if lower { bin + BINS as u32 } else { bin }
}

/// 1 / rho as above, and the line that the search begins at.
#[inline(always)]
#[cfg(target_arch = "arm")]
fn begin<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, rho_m: f32, z: f32) -> (f32, u8) {
    let fan = &lattice.fans[usize::from(is_lower(lattice, rho_m, z))];
    if rho_m < BINS_FROM_M {
        return (near_per_rho(lattice, rho_m), fan.starts[0]);
    }
    let bin = fan.bin - (z - fan.height_m) / (rho_m + fan.behind_m) * fan.bins_per_slope;
    (1.0 / rho_m, fan.starts[(bin as usize).min(BINS - 1)])
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
    let (per_rho, start) = (per_rho(lattice, rho_m), start(lattice, bin(lattice, rho_m, z)));
    (per_rho, find_line(lattice, start, rho_m, z))
}

#[inline(always)]
#[cfg(not(target_arch = "arm"))]
fn start<const LINES: usize, const NODES: usize>(lattice: &Lattice<'_, LINES, NODES>, bin: u32) -> u8 {
    let fan = &lattice.fans[usize::from(bin >= BINS as u32)];
    fan.starts[bin as usize % BINS]
}

/// rho in the beam's own vertical plane: sqrt(rho^2 - h^2) by the first terms of its series; what is left out is below a
/// micrometer from half a meter on.
#[inline(always)]
fn reach_m(line: &Line, rho_m: f32, aside: f32) -> f32 {
    rho_m - 0.5 * line.h_offset_m * aside
}

/// The range along the beam, less its phase.
#[inline(always)]
fn range_m(line: &Line, reach_m: f32, z: f32) -> f32 {
    reach_m * line.cos + z * line.sin - line.range_phase_m
}

/// Encoder azimuth from the edge of column 0, in 2^-32 turns. A binary fraction of a turn wraps around by itself.
///
/// asin(h / rho) is taken for h / rho: of the HDL-64E, from half a meter on, that is a seventieth of a tick.
#[inline(always)]
fn turned<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    line: &Line,
    azimuth: f32,
    aside: f32,
) -> u32 {
    // Halved, so that the sum of both angles, which is beyond half a turn at times, has room.
    let half_turned = to_angle((azimuth + aside) * lattice.half_turned_per_rad);
    (half_turned.cast_unsigned() << 1).wrapping_add(line.turned)
}

/// Whole columns, and 2^-32 columns beyond.
#[inline(always)]
fn column(columns: u16, turned: u32) -> (u32, u32) {
    let product = u64::from(turned) * u64::from(columns);
    ((product >> 32) as u32, product as u32)
}

/// How far a point is from the middle of its pixel and from its level, meters.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::struct_field_names, reason = "units")]
pub(crate) struct Miss {
    pub(crate) across_m: f32,
    pub(crate) around_m: f32,
    pub(crate) along_m: f32,
    /// Distance from the axis.
    pub(crate) rho_m: f32,
}

/// The pixel and the level of a point whose row is known.
pub(crate) fn place_on_row<const LINES: usize, const NODES: usize>(
    lattice: &Lattice<'_, LINES, NODES>,
    quantizer: &Quantizer,
    [x, y, z]: [f32; 3],
    row: u16,
) -> (u32, u32) {
    let rho_m = sqrt(x * x + y * y);
    let azimuth = unfold_octant(lattice.tables().atan_unit(octant_ratio(y, x)), y, x);
    place(lattice, quantizer, lattice.line(row), azimuth, rho_m, per_rho(lattice, rho_m), z)
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
    let azimuth = unfold_octant(lattice.tables().atan_unit(octant_ratio(y, x)), y, x);
    let aside = line.h_offset_m * per_rho;
    let reach_m = reach_m(line, rho_m, aside);
    let range_m = range_m(line, reach_m, z);
    let level = quantizer.level(range_m).ok()?;
    let (_, beyond) = column(lattice.columns_in_turn(), turned(lattice, line, azimuth, aside));
    let columns_off = beyond as f32 * (0.5_f32 / (1_u32 << 31) as f32) - 0.5;
    let radians_off = columns_off * core::f32::consts::TAU / f32::from(lattice.columns_in_turn());
    // What `turned` leaves out of the arc sine, of whichever sign.
    let left_out = (libm::asinf(aside) - aside).abs();
    // Where the series are no longer exact; nothing that a sensor measures is there.
    let beside_axis_m = if rho_m < 0.25 { 4.0 * lattice.nearest_axis_m } else { 0.0 };
    Some(Miss {
        across_m: z * line.cos - reach_m * line.sin - lattice.z_offset_m(line) * line.cos,
        around_m: (radians_off.abs() + left_out) * rho_m + beside_axis_m,
        along_m: range_m - quantizer.range_m(level),
        rho_m,
    })
}

/// What is handed from pass to pass.
#[cfg(not(target_arch = "arm"))]
struct Lanes {
    rho_m: [f32; BLOCK_LEN],
    per_rho: [f32; BLOCK_LEN],
    octant: [f32; BLOCK_LEN],
    bin: [u32; BLOCK_LEN],
    sin: [f32; BLOCK_LEN],
    cos: [f32; BLOCK_LEN],
    h_offset_m: [f32; BLOCK_LEN],
    range_phase_m: [f32; BLOCK_LEN],
    turned: [u32; BLOCK_LEN],
    first_pixel: [u32; BLOCK_LEN],
}

#[cfg(not(target_arch = "arm"))]
impl Lanes {
    const NEW: Self = Self {
        rho_m: [0.0; BLOCK_LEN],
        per_rho: [0.0; BLOCK_LEN],
        octant: [0.0; BLOCK_LEN],
        bin: [0; BLOCK_LEN],
        sin: [0.0; BLOCK_LEN],
        cos: [0.0; BLOCK_LEN],
        h_offset_m: [0.0; BLOCK_LEN],
        range_phase_m: [0.0; BLOCK_LEN],
        turned: [0; BLOCK_LEN],
        first_pixel: [0; BLOCK_LEN],
    };

    #[inline(always)]
    fn put_line(&mut self, i: usize, line: &Line) {
        (self.sin[i], self.cos[i]) = (line.sin, line.cos);
        (self.h_offset_m[i], self.range_phase_m[i]) = (line.h_offset_m, line.range_phase_m);
        (self.turned[i], self.first_pixel[i]) = (line.turned, line.first_pixel);
    }

    #[inline(always)]
    fn line(&self, i: usize) -> Line {
        Line {
            edge: crate::geometry::Edge::NONE,
            sin: self.sin[i],
            cos: self.cos[i],
            h_offset_m: self.h_offset_m[i],
            range_phase_m: self.range_phase_m[i],
            turned: self.turned[i],
            first_pixel: self.first_pixel[i],
        }
    }
}
