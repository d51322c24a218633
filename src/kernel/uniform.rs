//! Points to pixels of a uniform grid, without a branch a point.
//!
//! Three stages, each written once for one lane. Where the target has vectors, the stages are passes over whole
//! blocks: arithmetic in the first and the last, which LLVM turns into vector instructions (NEON, SSE2), and between
//! them nothing but loads from tables, which those instruction sets do not have. A Cortex-M has no vectors but few registers:
//! there the stages are one loop, and nothing goes through memory in between. Same operations, same results.

use core::f32::consts::TAU;

#[cfg(not(target_arch = "arm"))]
use crate::geometry::angles::AngleTables;
use crate::geometry::angles::{half_angle_argument, octant_ratio, unfold_half_angle, unfold_octant};
use crate::geometry::{Pixels, UniformGrid};
#[cfg(not(target_arch = "arm"))]
use crate::kernel::Lookups;
use crate::kernel::{sqrt, to_index};
use crate::point::{BLOCK_LEN, Block};
use crate::quantize::Quantizer;

/// The pixel and the level of every lane.
#[inline(never)]
pub(crate) fn project_uniform<const NODES: usize>(
    grid: &UniformGrid<NODES>,
    quantizer: &Quantizer,
    block: &Block,
    pixels: &mut Pixels,
) {
    if grid.is_plain {
        project::<NODES, true>(grid, quantizer, block, pixels);
    } else {
        project::<NODES, false>(grid, quantizer, block, pixels);
    }
}

#[inline(always)]
#[cfg(not(target_arch = "arm"))]
fn project<const NODES: usize, const PLAIN: bool>(
    grid: &UniformGrid<NODES>,
    quantizer: &Quantizer,
    block: &Block,
    pixels: &mut Pixels,
) {
    let mut sine = [0.0; BLOCK_LEN];
    let (mut atan, mut asin) = (Lookups::NEW, Lookups::NEW);
    for (i, sine) in sine.iter_mut().enumerate() {
        let (x, y, z) = (block.x[i], block.y[i], block.z[i]);
        let (range_m, octant, near);
        (range_m, octant, *sine, near) = to_ratios::<PLAIN>(x, y, z);
        pixels.level[i] = quantizer.rounded(range_m);
        atan.put(i, AngleTables::<NODES>::atan_place(octant));
        asin.put(i, AngleTables::<NODES>::asin_place(near));
    }
    for i in 0..BLOCK_LEN {
        atan.look_up(i, |node| grid.tables().atan_ends(node));
        asin.look_up(i, |node| grid.tables().asin_ends(node));
    }
    for (i, &sine) in sine.iter().enumerate() {
        let azimuth = unfold_octant(atan.angle(i), block.y[i], block.x[i]);
        pixels.pixel[i] = to_pixel::<NODES, PLAIN>(grid, azimuth, unfold_elevation::<PLAIN>(asin.angle(i), sine));
    }
}

#[inline(always)]
#[cfg(target_arch = "arm")]
fn project<const NODES: usize, const PLAIN: bool>(
    grid: &UniformGrid<NODES>,
    quantizer: &Quantizer,
    block: &Block,
    pixels: &mut Pixels,
) {
    for i in 0..BLOCK_LEN {
        let (x, y, z) = (block.x[i], block.y[i], block.z[i]);
        let (range_m, octant, sine, near) = to_ratios::<PLAIN>(x, y, z);
        let (octant, near) = (grid.tables().atan_unit(octant), grid.tables().asin_half(near));
        let azimuth = unfold_octant(octant, y, x);
        pixels.level[i] = quantizer.rounded(range_m);
        pixels.pixel[i] = to_pixel::<NODES, PLAIN>(grid, azimuth, unfold_elevation::<PLAIN>(near, sine));
    }
}

/// The range; min(|x|, |y|) / max(|x|, |y|); z / range; and what the arc sine's table has of that.
#[inline(always)]
fn to_ratios<const PLAIN: bool>(x: f32, y: f32, z: f32) -> (f32, f32, f32, f32) {
    let range_m = sqrt(x * x + y * y + z * z);
    let sine = z / range_m;
    let near = if PLAIN { sine.abs() } else { half_angle_argument(sine.abs()) };
    (range_m, octant_ratio(y, x), sine, near)
}

#[inline(always)]
fn unfold_elevation<const PLAIN: bool>(near: f32, sine: f32) -> f32 {
    if PLAIN { near.copysign(sine) } else { unfold_half_angle(near, sine) }
}

#[inline(always)]
fn to_pixel<const NODES: usize, const PLAIN: bool>(grid: &UniformGrid<NODES>, azimuth: f32, elevation: f32) -> u32 {
    let from_start = azimuth - grid.view().start_rad;
    let in_turn = if !PLAIN && from_start < 0.0 { from_start + TAU } else { from_start };
    let column = to_index(in_turn * grid.columns_per_rad, grid.last_column + 1);
    // All around, no product reaches the column behind the last.
    let column = if !PLAIN && column > grid.last_column { Pixels::OUT_OF_VIEW } else { column };
    let from_top = (grid.view().top_rad - elevation) * grid.rows_per_rad;
    let row = to_index(from_top, grid.last_row + 1);
    let below = if row > grid.last_row { Pixels::CLAMPED } else { 0 };
    // The sign bit of a point above the view is the mark of a clamped one.
    let above = from_top.to_bits() & Pixels::CLAMPED;
    (row.min(grid.last_row) * (grid.last_column + 1) + column) | below | above
}
