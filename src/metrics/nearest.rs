//! Nearest neighbors by a k-d tree, on all cores.

use std::num::NonZero;
use std::thread;
use std::vec::Vec;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use super::MetricError;

/// Coordinates are widened so that a squared distance is exact to 2^-53 and cannot overflow.
type Tree = ImmutableKdTree<f64, 3>;

/// Below this many queries a thread costs more than it saves.
const QUERIES_PER_THREAD: usize = 4096;

/// For each point of `from`, in order, the squared distance to the nearest point of `to`, m². All coordinates must be
/// finite, and `to` must not be empty.
pub(super) fn squared_distances(from: &[[f32; 3]], to: &[[f32; 3]]) -> Result<Vec<f64>, MetricError> {
    let tree = build(to)?;
    let mut squares_m2 = std::vec![0.0; from.len()];
    let chunk_len = from.len().div_ceil(threads_for(from.len())).max(1);
    let chunks = from.chunks(chunk_len).zip(squares_m2.chunks_mut(chunk_len));
    if chunks.len() == 1 {
        // No thread where none is needed: some std targets have none.
        chunks.for_each(|(queries, squares)| search(&tree, queries, squares));
    } else {
        thread::scope(|scope| {
            for (queries, squares) in chunks {
                scope.spawn(|| search(&tree, queries, squares));
            }
        });
    }
    Ok(squares_m2)
}

fn threads_for(queries: usize) -> usize {
    let available = thread::available_parallelism().map_or(1, NonZero::get);
    available.min(queries / QUERIES_PER_THREAD).max(1)
}

/// Repeated points are left out: they are nobody's nearer neighbor, but a search must look at each of them (a cloud of
/// 120,000 equal points would take half a minute).
fn build(points: &[[f32; 3]]) -> Result<Tree, MetricError> {
    let bits = |point: &[f64; 3]| point.map(f64::to_bits);
    let mut distinct: Vec<_> = points.iter().map(widen).collect();
    distinct.sort_unstable_by_key(bits);
    distinct.dedup_by_key(|point| bits(point));
    Tree::new_from_slice(&distinct)
        .map_err(|_| MetricError::TooManyPoints { found: distinct.len(), most: u32::MAX as usize })
}

fn search(tree: &Tree, queries: &[[f32; 3]], squares_m2: &mut [f64]) {
    for (query, square_m2) in queries.iter().zip(squares_m2) {
        *square_m2 = tree.query(&widen(query)).nearest_one::<SquaredEuclidean<f64>>().execute().distance;
    }
}

fn widen(point: &[f32; 3]) -> [f64; 3] {
    point.map(f64::from)
}
