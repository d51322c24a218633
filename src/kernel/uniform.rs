//! Points to cells of a uniform grid: three passes over lanes, without a branch a point.
//!
//! The first and the last pass are arithmetic on whole lanes, which LLVM turns into vector instructions (NEON,
//! SSE2); table look-ups, which those instruction sets do not have, stand alone between them.

use core::f32::consts::TAU;

use crate::geometry::angles::{half_angle_argument, octant_ratio, unfold_half_angle, unfold_octant};
use crate::geometry::{Cells, UniformGrid};
use crate::kernel::sqrt;
use crate::point::{BLOCK_LEN, Block};

type Lane = [f32; BLOCK_LEN];

/// The cell of every lane.
#[inline(never)]
pub(crate) fn project_uniform<const NODES: usize>(grid: &UniformGrid<NODES>, block: &Block, cells: &mut Cells) {
    let mut azimuth: Lane = [0.0; BLOCK_LEN];
    let mut sine: Lane = [0.0; BLOCK_LEN];
    let mut elevation: Lane = [0.0; BLOCK_LEN];
    to_ratios(block, &mut cells.range_m, &mut azimuth, &mut sine, &mut elevation);
    to_angles(grid, &mut azimuth, &mut elevation);
    to_cells(grid, block, &azimuth, &sine, &elevation, cells);
}

#[inline(always)]
fn to_ratios(block: &Block, range_m: &mut Lane, octant: &mut Lane, sine: &mut Lane, near: &mut Lane) {
    for i in 0..BLOCK_LEN {
        let (x, y, z) = (block.x[i], block.y[i], block.z[i]);
        range_m[i] = sqrt(x * x + y * y + z * z);
        octant[i] = octant_ratio(y, x);
        sine[i] = z / range_m[i];
        near[i] = half_angle_argument(sine[i].abs());
    }
}

#[inline(always)]
fn to_angles<const NODES: usize>(grid: &UniformGrid<NODES>, octant: &mut Lane, near: &mut Lane) {
    let tables = grid.tables();
    for (octant, near) in octant.iter_mut().zip(near) {
        *octant = tables.atan_unit(*octant);
        *near = tables.asin_half(*near);
    }
}

#[inline(always)]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates, which is wanted")]
fn to_cells<const NODES: usize>(
    grid: &UniformGrid<NODES>,
    block: &Block,
    octant: &Lane,
    sine: &Lane,
    near: &Lane,
    cells: &mut Cells,
) {
    use crate::geometry::Projection;
    let view = grid.view();
    let last_column = u32::from(grid.columns()) - 1;
    for i in 0..BLOCK_LEN {
        let from_start = unfold_octant(octant[i], block.y[i], block.x[i]) - view.start_rad;
        let not_negative = if from_start < 0.0 { from_start + TAU } else { from_start };
        let in_turn = if not_negative < TAU { not_negative } else { not_negative - TAU };
        // The product may round up to the column behind the last.
        let column = ((in_turn * grid.columns_per_rad) as u32).min(last_column);
        cells.column[i] = if in_turn < view.span_rad { column } else { Cells::OUT_OF_VIEW };
        let from_top = view.top_rad - unfold_half_angle(near[i], sine[i]);
        cells.row_from_one[i] = (from_top * grid.rows_per_rad + 1.0) as u32;
    }
}
