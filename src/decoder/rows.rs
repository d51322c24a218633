//! Rows of levels to points.

use core::array;
use std::vec::Vec;

use crate::image::{ImageView, Level};
use crate::parallel;

/// Pixels that are reconstructed together, if one of them holds a return.
const CHUNK: usize = 8;
/// Points that there must be room for behind those of an image.
const ROOM: usize = CHUNK + 1;

/// The returns of all rows in place of what `points` held; `of_row` gives a row's columns and what makes one
/// of them and a level a point.
pub(super) fn put_rows<'c, L: Level, C: Sync + 'c, P: Fn(&C, u16) -> [f32; 4]>(
    levels: &[L],
    columns: usize,
    points: &mut Vec<[f32; 3]>,
    of_row: impl Fn(usize) -> (&'c [C], P) + Sync + Send,
) {
    let Some(image) = ImageView::new(levels, columns) else { return points.clear() };
    let rows_a_piece = image.rows().div_ceil(parallel::pieces(image.rows()));
    let pieces =
        levels.chunks(rows_a_piece * image.columns()).filter_map(|levels| ImageView::new(levels, image.columns()));
    let pieces: Vec<_> = pieces.map(|image| (image, image.occupied())).collect();
    let occupied = pieces.iter().map(|(_, occupied)| occupied).sum();
    // Not emptied before: what is there need not be zeroed again.
    points.resize(occupied + ROOM, [0.0; 3]);
    let (mut with_room, mut room) = (Vec::with_capacity(pieces.len()), points.as_flattened_mut());
    for (number, (image, occupied)) in pieces.into_iter().enumerate() {
        let len = if room.len() == 3 * (occupied + ROOM) { room.len() } else { 3 * occupied };
        let (own, after) = room.split_at_mut(len);
        with_room.push((number * rows_a_piece, image, own));
        room = after;
    }
    parallel::for_each(with_room, |(first_row, image, mut room)| {
        for (row, levels) in (first_row..).zip(image.row_levels()) {
            let (columns, point) = of_row(row);
            let count = put_row_within(levels, columns, room, point);
            room = room.get_mut(count * 3..).unwrap_or_default();
        }
    });
    points.truncate(occupied);
}

/// As [`put_row`], where behind the row's points there may be none to write over.
fn put_row_within<L: Level, C>(
    levels: &[L],
    columns: &[C],
    room: &mut [f32],
    point: impl Fn(&C, u16) -> [f32; 4],
) -> usize {
    if room.len() >= 3 * (levels.len() + ROOM) {
        return put_row(levels, columns, room, point);
    }
    let count = levels.iter().filter(|&&level| level != L::NONE).count();
    if count == 0 || room.len() >= 3 * (count + ROOM) {
        return put_row(levels, columns, room, point);
    }
    let mut roomy = std::vec![0.0; 3 * (count + ROOM)];
    put_row(levels, columns, &mut roomy, point);
    room[..3 * count].copy_from_slice(&roomy[..3 * count]);
    count
}

/// Writes a row's returns to the front of `room` and gives how many. Up to [`ROOM`] points behind them are written over.
///
/// There is no branch a pixel, which would be guessed wrong as often as returns come and go: every pixel's point is
/// computed and written, and the place moves on only behind a return. A fourth coordinate makes it one vector.
fn put_row<L: Level, C>(levels: &[L], columns: &[C], room: &mut [f32], point: impl Fn(&C, u16) -> [f32; 4]) -> usize {
    let (chunks, last_levels) = levels.as_chunks::<CHUNK>();
    let (column_chunks, last_columns) = columns.as_chunks::<CHUNK>();
    let mut count = 0;
    for (levels, columns) in chunks.iter().zip(column_chunks) {
        if *levels != [L::NONE; CHUNK] {
            count += put_chunk(levels, columns, room.get_mut(count * 3..).unwrap_or_default(), &point);
        }
    }
    for (level, column) in last_levels.iter().zip(last_columns) {
        count += put_chunk(&[*level], array::from_ref(column), room.get_mut(count * 3..).unwrap_or_default(), &point);
    }
    count
}

#[inline(always)]
fn put_chunk<L: Level, C, const N: usize>(
    levels: &[L; N],
    columns: &[C; N],
    room: &mut [f32],
    point: impl Fn(&C, u16) -> [f32; 4],
) -> usize {
    let Some(places) = room.first_chunk_mut::<{ 3 * CHUNK + 1 }>() else { return 0 };
    let mut at = 0;
    for (&level, column) in levels.iter().zip(columns) {
        // As it was: said where the compiler, too, can see it, and needs no check.
        let place = at.min(3 * (CHUNK - 1));
        places[place..place + 4].copy_from_slice(&point(column, level.get()));
        at += if level == L::NONE { 0 } else { 3 };
    }
    at / 3
}
