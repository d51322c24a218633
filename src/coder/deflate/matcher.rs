//! Match candidates: four small hash tables of recent positions, keyed by 3, 6, 9 and 20 bytes.
//!
//! Range images are periodic, so a 3-byte key has hundreds of earlier places, most of them short matches. The longer
//! keys go straight to the long ones, which lets one entry a key stand for a chain of a hundred. Only pixels that
//! hold a return are entered and looked up: a match that begins with empty pixels is found at the first return
//! behind them and grown to the left.
//!
//! Nothing that a table says is trusted: a candidate counts for the bytes that it really shares.

use super::symbols::{MAX_MATCH, MIN_MATCH, WINDOW};

/// A match of `len` bytes with those `distance` back; there is none if the distance is 0.
#[derive(Clone, Copy)]
pub(super) struct Match {
    pub len: usize,
    pub distance: usize,
}

impl Match {
    /// What it is worth against others at about the same place, in bits or so.
    #[inline(always)]
    pub const fn score(self) -> usize {
        3 * self.len + (WINDOW.ilog2() - (self.distance | 1).ilog2()) as usize
    }
}

/// The low 16 bits of the last positions under a key, newest first.
type Bucket<const WAYS: usize> = [u16; WAYS];

/// The hash tables. `SHORT` (the keys of 3 and 9 bytes) and `LONG` (6 and 20) are powers of two.
pub(super) struct Tables<const SHORT: usize, const LONG: usize, const WAYS: usize> {
    three: [Bucket<WAYS>; SHORT],
    six: [Bucket<WAYS>; LONG],
    nine: [Bucket<WAYS>; SHORT],
    twenty: [Bucket<WAYS>; LONG],
}

/// Bytes that a position needs from itself on to be entered and looked up.
pub(super) const KEY_LEN: usize = 20;

/// A position's buckets as they were before it was entered, and its first four bytes.
pub(super) struct Found<const WAYS: usize> {
    word: u32,
    three: Bucket<WAYS>,
    six: Bucket<WAYS>,
    nine: Bucket<WAYS>,
    twenty: Bucket<WAYS>,
}

impl<const SHORT: usize, const LONG: usize, const WAYS: usize> Tables<SHORT, LONG, WAYS> {
    pub const fn new() -> Self {
        const { assert!(SHORT > 1 && SHORT.is_power_of_two() && LONG > 1 && LONG.is_power_of_two() && WAYS > 0) };
        Self { three: [[0; WAYS]; SHORT], six: [[0; WAYS]; LONG], nine: [[0; WAYS]; SHORT], twenty: [[0; WAYS]; LONG] }
    }

    /// Forgets all positions, so that a frame's bytes do not depend on the frame before.
    pub fn clear(&mut self) {
        self.three.as_flattened_mut().fill(0);
        self.six.as_flattened_mut().fill(0);
        self.nine.as_flattened_mut().fill(0);
        self.twenty.as_flattened_mut().fill(0);
    }

    /// Enters a position under its keys; gives what was there.
    #[inline(always)]
    pub fn enter(&mut self, key: &[u8; KEY_LEN], position: usize) -> Found<WAYS> {
        let word = |i: usize| key.as_chunks().0.get(i).map_or(0, |&bytes| u32::from_le_bytes(bytes));
        let (a, b, c) = (word(0), word(1), word(2));
        let by_8 = a.wrapping_mul(0x85EB_CA6B) ^ b.wrapping_mul(0xC2B2_AE35);
        let from_8_to_20 = c
            .wrapping_mul(0x9E37_79B1)
            .wrapping_add(word(3).wrapping_mul(0x27D4_EB2F))
            .wrapping_add(word(4).wrapping_mul(0x1656_67B1));
        Found {
            word: a,
            three: swap_in(&mut self.three, (a << 8).wrapping_mul(0x9E37_79B1), position),
            six: swap_in(&mut self.six, a.wrapping_mul(0x85EB_CA6B) ^ (b << 16).wrapping_mul(0x9E37_79B1), position),
            nine: swap_in(&mut self.nine, by_8.wrapping_add((c << 24).wrapping_mul(0x9E37_79B1)), position),
            twenty: swap_in(&mut self.twenty, by_8.wrapping_add(from_8_to_20), position),
        }
    }
}

#[inline(always)]
fn swap_in<const N: usize, const WAYS: usize>(
    table: &mut [Bucket<WAYS>; N],
    hash: u32,
    position: usize,
) -> Bucket<WAYS> {
    let bucket = &mut table[(hash >> (32 - N.ilog2())) as usize & (N - 1)];
    let old = *bucket;
    let mut newer = position as u16;
    for place in bucket {
        newer = core::mem::replace(place, newer);
    }
    old
}

/// Where to look for a match, and what is known there already.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    /// The distance of the row above, which is tried before the shortest key; 0 for none.
    pub row: usize,
}

/// A search at one place for a match longer than the best so far.
struct Search<'a> {
    place: Place<'a>,
    /// Bytes that every candidate must have, `word_at` behind its start.
    word: u32,
    word_at: usize,
    best: Match,
}

impl<const WAYS: usize> Found<WAYS> {
    /// The best match at `place`, of any length.
    #[inline(always)]
    pub fn search(&self, place: Place<'_>) -> Option<Match> {
        let best = Match { len: MIN_MATCH - 1, distance: 0 };
        self.search_in::<8>(Search { place, word: self.word << 8, word_at: 0, best })
    }

    /// The best match at `place` that is longer than `floor` (at least 3): its last four bytes tell most.
    #[inline(always)]
    pub fn search_longer(&self, place: Place<'_>, floor: usize) -> Option<Match> {
        let word_at = floor - MIN_MATCH;
        let word = load(place.bytes, place.at + word_at)?;
        self.search_in::<0>(Search { place, word, word_at, best: Match { len: floor, distance: 0 } })
    }

    #[inline(always)]
    fn search_in<const IGNORED_BITS: u32>(&self, mut search: Search<'_>) -> Option<Match> {
        search.probe_all::<IGNORED_BITS, WAYS>(self.twenty);
        if search.best.len < KEY_LEN {
            search.probe_all::<IGNORED_BITS, WAYS>(self.nine);
        }
        if search.best.len < 9 {
            search.probe_all::<IGNORED_BITS, WAYS>(self.six);
        }
        if search.best.len < 6 {
            search.probe::<IGNORED_BITS>(search.place.row);
            search.probe_all::<IGNORED_BITS, WAYS>(self.three);
        }
        if search.best.distance > 0 { Some(search.best) } else { None }
    }
}

impl Search<'_> {
    #[inline(always)]
    fn probe_all<const IGNORED_BITS: u32, const WAYS: usize>(&mut self, positions: Bucket<WAYS>) {
        for position in positions {
            self.probe::<IGNORED_BITS>(usize::from((self.place.at as u16).wrapping_sub(position)));
        }
    }

    /// Takes the match at a distance if there is one and it is longer; `IGNORED_BITS` of the word do not count.
    #[inline(always)]
    fn probe<const IGNORED_BITS: u32>(&mut self, distance: usize) {
        let Place { bytes, at, .. } = self.place;
        if distance.wrapping_sub(1) >= at.min(WINDOW) {
            return;
        }
        let Some(there) = load(bytes, at + self.word_at - distance) else {
            return;
        };
        if there << IGNORED_BITS != self.word {
            return;
        }
        let len = equal_len(bytes, at, distance);
        if len > self.best.len {
            self.best = Match { len, distance };
        }
    }
}

/// Four bytes from a place on, as one word.
#[inline(always)]
fn load(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|&word| u32::from_le_bytes(word))
}

/// Bytes of a machine word.
const WORD: usize = size_of::<usize>();

/// How far the bytes at `at` equal those `distance` back, up to [`MAX_MATCH`].
///
/// Called at a dozen places: where flash is scarce one copy does, which Cortex-M also runs faster.
#[cfg_attr(target_pointer_width = "64", inline(always))]
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn equal_len(bytes: &[u8], at: usize, distance: usize) -> usize {
    let (here, there) = (bytes.get(at..), bytes.get(at.wrapping_sub(distance)..));
    let (here, there) = (here.unwrap_or_default(), there.unwrap_or_default());
    let here = here.get(..MAX_MATCH).unwrap_or(here);
    let mut len = 0;
    for (a, b) in here.as_chunks::<WORD>().0.iter().zip(there.as_chunks::<WORD>().0) {
        let different = usize::from_le_bytes(*a) ^ usize::from_le_bytes(*b);
        if different != 0 {
            return len + different.trailing_zeros() as usize / 8;
        }
        len += WORD;
    }
    let rest = here.iter().skip(len).zip(there.iter().skip(len));
    len + rest.take_while(|(a, b)| a == b).count()
}

/// The first place from `at` on that holds a return; the end if none does.
#[inline(always)]
pub(super) fn next_return(bytes: &[u8], at: usize) -> usize {
    let rest = bytes.get(at..).unwrap_or_default();
    let mut skipped = at;
    let (words, last) = rest.as_chunks::<WORD>();
    for &word in words {
        let word = usize::from_le_bytes(word);
        if word != 0 {
            return skipped + word.trailing_zeros() as usize / 8;
        }
        skipped += WORD;
    }
    skipped + last.iter().take_while(|&&byte| byte == 0).count()
}

/// The machine words from `at` on, with their places; the bytes behind the last whole one are left out.
#[inline(always)]
pub(super) fn words(bytes: &[u8], at: usize) -> impl Iterator<Item = (usize, usize)> {
    let rest = bytes.get(at..).unwrap_or_default();
    rest.as_chunks().0.iter().enumerate().map(move |(i, &word)| (at + WORD * i, usize::from_le_bytes(word)))
}

/// The bytes of a word that are not zero, in order of their places.
#[inline(always)]
pub(super) fn returns(word: usize) -> impl Iterator<Item = usize> {
    const LOW: usize = usize::MAX / 255 * 127;
    let mut marks = (((word & LOW) + LOW) | word) & !LOW;
    core::iter::from_fn(move || {
        let place = marks.trailing_zeros() as usize / 8;
        let found = marks != 0;
        marks &= marks.wrapping_sub(1);
        found.then_some(place)
    })
}
