//! Length-limited Huffman codes, built in place.
//!
//! Moffat and Katajainen's in-place method gives the depths; depths over the limit are folded back by
//! moving leaves, which keeps the code complete.

/// A symbol's code: its length in the low byte, its bits, already reversed for LSB-first output, above.
pub(super) type Code = u32;

/// The bits and the length of a code.
#[inline(always)]
pub(super) const fn split(code: Code) -> (u32, u32) {
    (code >> 8, code & 0xFF)
}

/// Longest code of the literal and distance alphabets, RFC 1951 section 3.2.7.
pub(super) const MAX_BITS: usize = 15;

/// Low bits of a node that name its symbol; its weight, parent or depth is above them.
const SYMBOL_BITS: u32 = 9;
const SYMBOL_MASK: u32 = (1 << SYMBOL_BITS) - 1;

/// Leaves by depth.
type Depths = [u32; MAX_BITS + 1];

/// Gives each symbol that occurs a code length of at most `limit` (at most 15) bits, the others 0.
///
/// `nodes` is scratch, at least as long as `counts`; the counts' sum must stay below 2^23.
pub(super) fn lengths(counts: &[u32], limit: usize, nodes: &mut [u32], lens: &mut [u8]) {
    let used = gather(counts, nodes);
    let Some(nodes) = nodes.get_mut(..used) else {
        return;
    };
    sort(nodes);
    let depths = limit_depth(leaf_depths(nodes), limit);
    lens.fill(0);
    spread(nodes, &depths, lens);
}

/// Collects the symbols that occur, those with the fewer bits in their counts first.
fn gather(counts: &[u32], nodes: &mut [u32]) -> usize {
    let mut places = [0; 32];
    for &count in counts {
        add(&mut places, bit_len(count), 1);
    }
    let mut used = 0;
    for place in places.iter_mut().skip(1) {
        let first = used;
        used += *place;
        *place = first;
    }
    for (symbol, &count) in counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
        put(nodes, at(&places, bit_len(count)) as usize, (count << SYMBOL_BITS) | symbol as u32);
        add(&mut places, bit_len(count), 1);
    }
    used as usize
}

/// Bits of a number: 0 of 0, 1 of 1, 2 of 2 and 3.
const fn bit_len(x: u32) -> usize {
    32 - x.leading_zeros() as usize
}

/// Insertion sort: [`gather`] leaves little to move.
fn sort(nodes: &mut [u32]) {
    for i in 1..nodes.len() {
        let node = at(nodes, i);
        let mut j = i;
        while j > 0 && at(nodes, j - 1) > node {
            let greater = at(nodes, j - 1);
            put(nodes, j, greater);
            j -= 1;
        }
        put(nodes, j, node);
    }
}

/// Depths of the Huffman tree's leaves, from the nodes in ascending order, whose weights are used up.
fn leaf_depths(nodes: &mut [u32]) -> Depths {
    let mut depths = Depths::default();
    let n = nodes.len();
    if n < 2 {
        put(&mut depths, 1, n as u32);
        return depths;
    }
    join(nodes);
    set_value(nodes, n - 2, 0);
    for i in (0..n - 2).rev() {
        let parent = value(nodes, i) as usize;
        set_value(nodes, i, value(nodes, parent) + 1);
    }
    count_leaves(nodes, &mut depths);
    depths
}

/// Joins the two lightest nodes until one is left: inner node `i` keeps its parent's place.
fn join(nodes: &mut [u32]) {
    let n = nodes.len();
    let (mut leaf, mut inner) = (0, 0);
    for next in 0..n - 1 {
        let mut weight = 0;
        for _ in 0..2 {
            if leaf >= n || (inner < next && value(nodes, inner) < value(nodes, leaf)) {
                weight += value(nodes, inner);
                set_value(nodes, inner, next as u32);
                inner += 1;
            } else {
                weight += value(nodes, leaf);
                leaf += 1;
            }
        }
        set_value(nodes, next, weight);
    }
}

/// Counts the leaves of each depth: the places that the inner nodes, root last, leave free.
fn count_leaves(nodes: &[u32], depths: &mut Depths) {
    let mut inner = nodes.iter().rev().skip(1).map(|node| node >> SYMBOL_BITS).peekable();
    let (mut places, mut depth, mut left) = (1u32, 0, nodes.len() as u32);
    while left > 0 && places > 0 {
        let mut taken = 0;
        while inner.next_if_eq(&depth).is_some() {
            taken += 1;
        }
        let leaves = places.saturating_sub(taken).min(left);
        let slot = (depth as usize).min(MAX_BITS);
        add(depths, slot, leaves.cast_signed());
        left -= leaves;
        places = 2 * taken;
        depth += 1;
    }
}

/// Pulls leaves deeper than `limit` up to it, then pushes others down until the code is complete again.
///
/// `depths` counts what is deeper than [`MAX_BITS`] at that depth.
fn limit_depth(mut depths: Depths, limit: usize) -> Depths {
    for depth in limit + 1..=MAX_BITS {
        let deeper = at(&depths, depth).cast_signed();
        add(&mut depths, limit, deeper);
        add(&mut depths, depth, -deeper);
    }
    let mut taken: u32 = depths.iter().take(limit + 1).enumerate().map(|(d, &leaves)| leaves << (limit - d)).sum();
    while taken > 1 << limit {
        let Some(depth) = (1..limit).rev().find(|&d| at(&depths, d) > 0) else {
            break;
        };
        add(&mut depths, limit, -1);
        add(&mut depths, depth, -1);
        add(&mut depths, depth + 1, 2);
        taken -= 1;
    }
    depths
}

/// Gives the rarest symbols, which come first in `nodes`, the longest codes.
fn spread(nodes: &[u32], depths: &Depths, lens: &mut [u8]) {
    let mut rarest_first = nodes.iter();
    for (depth, &leaves) in depths.iter().enumerate().rev() {
        for node in rarest_first.by_ref().take(leaves as usize) {
            if let Some(len) = lens.get_mut((node & SYMBOL_MASK) as usize) {
                *len = depth as u8;
            }
        }
    }
}

/// The canonical codes of RFC 1951 section 3.2.2, from their lengths.
pub(super) fn assign(lens: &[u8], codes: &mut [Code]) {
    let mut next = first_codes(lens);
    for (code, &len) in codes.iter_mut().zip(lens) {
        *code = 0;
        if let (1.., Some(next)) = (len, next.get_mut(usize::from(len))) {
            *code = (next.reverse_bits() >> (32 - len) << 8) | u32::from(len);
            *next += 1;
        }
    }
}

/// The first code of each length.
fn first_codes(lens: &[u8]) -> Depths {
    let mut depths = Depths::default();
    for &len in lens.iter().filter(|&&len| len > 0) {
        add(&mut depths, len.into(), 1);
    }
    let mut code = 0;
    for slot in depths.iter_mut().skip(1) {
        let first = code;
        code = (code + *slot) << 1;
        *slot = first;
    }
    depths
}

/// A node's weight, parent or depth.
#[inline(always)]
fn value(nodes: &[u32], i: usize) -> u32 {
    at(nodes, i) >> SYMBOL_BITS
}

/// Sets a node's weight, parent or depth and leaves its symbol.
#[inline(always)]
fn set_value(nodes: &mut [u32], i: usize, value: u32) {
    if let Some(node) = nodes.get_mut(i) {
        *node = (value << SYMBOL_BITS) | (*node & SYMBOL_MASK);
    }
}

/// `a[i]`; 0 outside, which no caller reaches: a read that cannot panic.
#[inline(always)]
fn at(a: &[u32], i: usize) -> u32 {
    a.get(i).copied().unwrap_or(0)
}

/// `a[i] = value`; nothing outside, which no caller reaches.
#[inline(always)]
fn put(a: &mut [u32], i: usize, value: u32) {
    if let Some(slot) = a.get_mut(i) {
        *slot = value;
    }
}

/// `a[i] += by`.
#[inline(always)]
fn add(a: &mut [u32], i: usize, by: i32) {
    if let Some(slot) = a.get_mut(i) {
        *slot = slot.wrapping_add_signed(by);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec;
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    const SYMBOLS: usize = 289;

    fn lengths_of(counts: &[u32], limit: usize) -> [u8; SYMBOLS] {
        let (mut nodes, mut lens) = ([0; SYMBOLS], [0; SYMBOLS]);
        lengths(counts, limit, &mut nodes, &mut lens);
        lens
    }

    fn cost(counts: &[u32], lens: &[u8]) -> u64 {
        counts.iter().zip(lens).map(|(&count, &len)| u64::from(count) * u64::from(len)).sum()
    }

    /// The least cost of any code of at most `limit` bits: package-merge, by its definition.
    fn least_cost(counts: &[u32], limit: usize) -> u64 {
        let mut coins: Vec<u64> = counts.iter().filter(|&&count| count > 0).map(|&count| count.into()).collect();
        coins.sort_unstable();
        let wanted = 2 * coins.len() - 2;
        let mut row = coins.clone();
        for _ in 1..limit {
            row = row.chunks_exact(2).map(|pair| pair.iter().sum()).chain(coins.iter().copied()).collect();
            row.sort_unstable();
        }
        row.iter().take(wanted).sum()
    }

    fn check(counts: &[u32], limit: usize) -> u64 {
        let lens = lengths_of(counts, limit);
        assert!(counts.iter().zip(&lens).all(|(&count, &len)| (count > 0) == (len > 0)));
        let taken: u64 = lens.iter().filter(|&&len| len > 0).map(|&len| 1 << (limit - usize::from(len))).sum();
        assert_eq!(taken, 1 << limit, "not complete");
        cost(counts, &lens)
    }

    #[test]
    fn one_symbol_has_one_bit_and_none_has_none() {
        assert_eq!(lengths_of(&[0, 5, 0], 15)[..3], [0, 1, 0]);
        assert_eq!(lengths_of(&[0, 0], 15), [0; SYMBOLS]);
    }

    #[test]
    fn codes_are_those_of_the_standards_example() {
        let mut codes = [0; 8];
        assign(&[3, 3, 3, 3, 3, 2, 4, 4], &mut codes);
        let bits = codes.map(|code| (split(code).0.reverse_bits() >> (32 - split(code).1), split(code).1));
        assert_eq!(bits, [(2, 3), (3, 3), (4, 3), (5, 3), (6, 3), (0, 2), (14, 4), (15, 4)]);
    }

    #[test]
    fn fibonacci_counts_stay_within_the_limit() {
        let mut counts = vec![1, 1];
        while counts.len() < 28 {
            counts.push(counts[counts.len() - 1] + counts[counts.len() - 2]);
        }
        let (cost, least) = (check(&counts, 15), least_cost(&counts, 15));
        assert!(cost as f64 <= 1.01 * least as f64, "{cost} bits, {least} would do");
    }

    proptest! {
        #[test]
        fn unlimited_codes_are_optimal(counts in prop::collection::vec(0_u32..40, 2..SYMBOLS)) {
            prop_assume!(counts.iter().filter(|&&count| count > 0).count() >= 2);
            prop_assert_eq!(check(&counts, 15), least_cost(&counts, 15));
        }

        #[test]
        fn limited_codes_are_complete_and_nearly_optimal(
            (limit, counts) in prop_oneof![
                (Just(15), prop::collection::vec(prop::option::of((0..18_u32).prop_map(|e| 1 << e)), 2..=SYMBOLS)),
                (Just(7), prop::collection::vec(prop::option::of((0..9_u32).prop_map(|e| 1 << e)), 2..=19)),
            ],
        ) {
            let counts: Vec<u32> = counts.iter().map(|count| count.unwrap_or(0)).collect();
            prop_assume!(counts.iter().filter(|&&count| count > 0).count() >= 2);
            let (cost, least) = (check(&counts, limit), least_cost(&counts, limit));
            prop_assert!(cost as f64 <= 1.04 * least as f64, "{cost} bits, {least} would do");
        }
    }
}
