//! The beam of each point in a file that holds beam after beam, as KITTI's do, by the points' order.
//!
//! Within a beam azimuths rise, from ahead over the left. Where one falls a new beam may begin; or the sensor moved, and
//! a compensation moved the points past each other. Which it is the heights tell: of all ways in which beams go down, and
//! never up, the file takes the one that its points lie nearest to.

use core::f32::consts::{PI, TAU};
use std::vec;
use std::vec::Vec;

use crate::geometry::{SensorGrid, azimuth_rad};

/// A file whose azimuths fall more often than at one of so many points is not sorted by beam.
const POINTS_A_PIECE: usize = 8;
/// Most that a point can be off a beam, in rows: moved ones are off by more, which says nothing.
const OFF_MAX: f32 = 2.0;
/// Of the points, what share at most may be so far off their beams. Those near the sensor all may.
const FAR_OFF_MAX: f32 = 0.4;
/// Points that are farther tell a beam best, meters.
const FAR_M: f32 = 10.0;
/// Most points of a beam that moved across the start.
const ACROSS: usize = 200;
/// What it takes that a beam saw nothing.
const SKIP: f32 = 100.0;
/// Points that moved past each other do so by less than this, seen from the sensor.
const PAST_RAD: f32 = 0.5;
/// What it takes, in rows of as many points together, to stay on a beam where the azimuth falls by more.
const STAY: f32 = 600.0;
/// What it takes to go on to another where it falls by less.
const LEAVE: f32 = 300.0;

/// The beam of each point; `None` where the file is not sorted by beam.
pub(crate) fn rows_in_order(points: &[[f32; 3]], grid: &SensorGrid<'_>) -> Option<Vec<u16>> {
    let pieces = pieces(points);
    if pieces.len() * POINTS_A_PIECE > points.len() {
        return None;
    }
    let spacing = spacing(grid);
    let costs: Vec<f32> =
        pieces.iter().flat_map(|piece| costs(&points[piece.first..piece.end], grid, spacing)).collect();
    let row_of = descend(&pieces, &costs, grid.beams.len());
    let rows: Vec<u16> =
        pieces.iter().zip(row_of).flat_map(|(piece, row)| vec![row; piece.end - piece.first]).collect();
    let is_far_off = |(&point, &row): (&[f32; 3], &u16)| off(point, grid, row.into(), spacing) >= OFF_MAX;
    let far_off = points.iter().zip(&rows).filter(|pair| is_far_off(*pair)).count();
    (far_off as f32 <= FAR_OFF_MAX * points.len() as f32).then_some(rows)
}

/// Points between which the azimuth does not fall.
#[derive(Debug, Clone, Copy)]
struct Piece {
    first: usize,
    end: usize,
    before: Gap,
    /// Points, from where the azimuth last started over to here and from here to where it next does, the fewer: a point
    /// very near to the sensor starts over all alone.
    between: usize,
}

/// How the azimuth goes on from one piece to the next.
#[derive(Debug, Clone, Copy)]
enum Gap {
    /// It falls as far as points move past each other.
    Little,
    /// It starts over.
    Over,
    /// It rises by more than half a turn.
    Back,
}

impl Gap {
    fn of(rise_rad: f32) -> Option<Self> {
        match rise_rad {
            rise if rise > PI => Some(Self::Back),
            rise if rise >= 0.0 => None,
            rise if rise >= -PAST_RAD => Some(Self::Little),
            _ => Some(Self::Over),
        }
    }
}

impl Piece {
    /// What it takes to stay on the same beam here, and to go on to another.
    fn costs(&self) -> (f32, f32) {
        match self.before {
            Gap::Little | Gap::Back => (0.0, LEAVE),
            Gap::Over => (STAY.min(self.between as f32), 0.0),
        }
    }
}

fn pieces(points: &[[f32; 3]]) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut before = 0.0;
    for (i, &[x, y, _]) in points.iter().enumerate() {
        let azimuth = azimuth_rad(y, x);
        let azimuth = if azimuth < 0.0 { azimuth + TAU } else { azimuth };
        let gap = Gap::of(azimuth - before);
        match (pieces.last_mut(), gap) {
            (Some(piece), None) => piece.end = i + 1,
            (_, gap) => pieces.push(Piece { first: i, end: i + 1, before: gap.unwrap_or(Gap::Little), between: 0 }),
        }
        before = azimuth;
    }
    start_once(&mut pieces);
    count_between(&mut pieces, points.len());
    pieces
}

fn count_between(pieces: &mut [Piece], points: usize) {
    let over: Vec<usize> = (0..pieces.len()).filter(|&i| matches!(pieces[i].before, Gap::Over)).collect();
    let first = |over: Option<&usize>, pieces: &[Piece]| over.map(|&i| pieces[i].first);
    for (n, &i) in over.iter().enumerate() {
        let last = n.checked_sub(1).and_then(|n| first(over.get(n), pieces)).unwrap_or(0);
        let next = first(over.get(n + 1), pieces).unwrap_or(points);
        pieces[i].between = (pieces[i].first - last).min(next - pieces[i].first);
    }
}

/// Where points moved across the start, azimuths start over twice in one turn, and go back in between: there the beams'
/// border is.
fn start_once(pieces: &mut [Piece]) {
    let big: Vec<usize> = (0..pieces.len()).filter(|&i| !matches!(pieces[i].before, Gap::Little)).collect();
    let mut next = 0;
    while let Some(&[over, back, again]) = big.get(next..next + 3) {
        let is_across = matches!([over, back, again].map(|i| pieces[i].before), [Gap::Over, Gap::Back, Gap::Over])
            && pieces[again].first - pieces[over].first < ACROSS;
        if is_across {
            pieces[over].before = Gap::Little;
            pieces[back].before = Gap::Over;
            pieces[again].before = Gap::Little;
        }
        next += if is_across { 3 } else { 1 };
    }
}

/// Of the slopes of neighboring beams, the median.
fn spacing(grid: &SensorGrid<'_>) -> f32 {
    let mut spacings: Vec<f32> = grid.beams.windows(2).map(|pair| pair[0].slope - pair[1].slope).collect();
    spacings.sort_by(f32::total_cmp);
    spacings.get(spacings.len() / 2).copied().unwrap_or(0.02)
}

/// How far a point is off a beam, in rows.
fn off([x, y, z]: [f32; 3], grid: &SensorGrid<'_>, row: usize, spacing: f32) -> f32 {
    let (rho_m, beam) = (crate::kernel::sqrt(x * x + y * y), &grid.beams[row]);
    // A point that is no return is on all of them.
    if rho_m > 0.0 { ((z - beam.z_offset_m) / rho_m - beam.slope).abs().min(OFF_MAX * spacing) / spacing } else { 0.0 }
}

/// How far off each beam the points are, all together: the nearer ones less, which a meter moves by many rows.
fn costs(points: &[[f32; 3]], grid: &SensorGrid<'_>, spacing: f32) -> Vec<f32> {
    let weight = |[x, y, _]: [f32; 3]| ((x * x + y * y) / (FAR_M * FAR_M)).min(1.0);
    let cost = |row| points.iter().map(|&point| off(point, grid, row, spacing) * weight(point)).sum();
    (0..grid.beams.len()).map(cost).collect()
}

/// The row of each piece, none above that of the piece before, by which the costs are least: dynamic programming.
fn descend(pieces: &[Piece], costs: &[f32], rows: usize) -> Vec<u16> {
    let mut least = vec![0.0_f32; rows];
    let mut came_from: Vec<u16> = Vec::with_capacity(costs.len());
    for (piece, costs) in pieces.iter().zip(costs.chunks(rows)) {
        let (stay, leave) = piece.costs();
        let mut above = (f32::INFINITY, 0);
        let next = (0..rows).map(|row| {
            let from = if least[row] + stay <= above.0 { (least[row] + stay, row as u16) } else { above };
            let skipped = above.0 + SKIP;
            above = if least[row] + leave < skipped { (least[row] + leave, row as u16) } else { (skipped, above.1) };
            came_from.push(from.1);
            from.0 + costs[row]
        });
        least = next.collect();
    }
    let last = (0..rows).min_by(|&a, &b| least[a].total_cmp(&least[b])).unwrap_or(0);
    let mut row = last as u16;
    let mut found = Vec::with_capacity(pieces.len());
    for from in came_from.rchunks(rows) {
        found.push(row);
        row = from[usize::from(row)];
    }
    found.reverse();
    found
}
