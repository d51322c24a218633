//! The same work for each of some pieces, none of which sees another: on all cores with feature `rayon`, else one after the
//! other.

use std::vec::Vec;

/// Does the work; what comes first among the pieces is given where it fails for several.
///
/// # Errors
/// That of the first piece that has one.
#[cfg(feature = "rayon")]
pub(crate) fn try_for_each<T: Send, E: Send>(
    pieces: Vec<T>,
    work: impl Fn(T) -> Result<(), E> + Sync + Send,
) -> Result<(), E> {
    use rayon::prelude::*;
    if pieces.len() < 2 {
        return pieces.into_iter().try_for_each(work);
    }
    let done: Vec<_> = pieces.into_par_iter().with_max_len(1).map(work).collect();
    done.into_iter().collect()
}

#[cfg(not(feature = "rayon"))]
pub(crate) fn try_for_each<T, E>(pieces: Vec<T>, work: impl Fn(T) -> Result<(), E>) -> Result<(), E> {
    pieces.into_iter().try_for_each(work)
}

/// Does the work.
#[cfg(feature = "rayon")]
pub(crate) fn for_each<T: Send>(pieces: Vec<T>, work: impl Fn(T) + Sync + Send) {
    use rayon::prelude::*;
    if pieces.len() < 2 { pieces.into_iter().for_each(work) } else { pieces.into_par_iter().for_each(work) }
}

#[cfg(not(feature = "rayon"))]
pub(crate) fn for_each<T>(pieces: Vec<T>, work: impl Fn(T)) {
    pieces.into_iter().for_each(work);
}

/// In how many pieces work of `len` parts is best cut: some for each core, where one may be slower than another.
#[cfg(feature = "rayon")]
pub(crate) fn pieces(len: usize) -> usize {
    let threads = rayon::current_num_threads();
    if threads < 2 { 1 } else { len.clamp(1, 4 * threads) }
}

#[cfg(not(feature = "rayon"))]
pub(crate) const fn pieces(_len: usize) -> usize {
    1
}
