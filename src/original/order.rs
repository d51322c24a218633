//! The order of a file's points: that of some rule, but for the few that come before their turn.

use core::cmp::Ordering;
use std::vec;
use std::vec::Vec;

use super::returns::FrameReturn;
use crate::coder::context::number::Number;
use crate::coder::context::range_coder::BinaryCoder;

/// The orders that points may be in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rule {
    /// Row by row from the top, each by azimuth from x over y: KITTI's.
    RowsByAzimuth = 0,
    /// Row by row from the top, each by columns.
    Rows = 1,
    /// Column by column, each from the top.
    Columns = 2,
}

impl Rule {
    pub(crate) const ALL: [Self; 3] = [Self::RowsByAzimuth, Self::Rows, Self::Columns];

    /// The places of points in the order: of returns row by row, with the file's x and y.
    pub(crate) fn sorted(self, returns: &[FrameReturn], points: &[[f32; 2]]) -> Vec<u32> {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let (row, column) = (|at: u32| returns[at as usize].row, |at: u32| returns[at as usize].column);
        match self {
            Self::RowsByAzimuth => order
                .sort_by(|&a, &b| row(a).cmp(&row(b)).then_with(|| by_azimuth(points[a as usize], points[b as usize]))),
            Self::Rows => {}
            Self::Columns => order.sort_by_key(|&at| (column(at), row(at))),
        }
        order
    }
}

/// Quarter of the turn, by the signs, that of zero included; the axis itself last.
fn quarter([x, y]: [f32; 2]) -> u8 {
    match (y.is_sign_negative(), x.is_sign_negative()) {
        _ if x == 0.0 && y == 0.0 => 4,
        (false, false) => 0,
        (false, true) => 1,
        (true, true) => 2,
        (true, false) => 3,
    }
}

/// Exact: products of two `f32` are exact in double precision.
fn by_azimuth(a: [f32; 2], b: [f32; 2]) -> Ordering {
    let quarters = quarter(a).cmp(&quarter(b));
    if quarters != Ordering::Equal || quarter(a) == 4 {
        return quarters;
    }
    let ([ax, ay], [bx, by]) = (a.map(f64::from), b.map(f64::from));
    (ay * bx).partial_cmp(&(ax * by)).unwrap_or(Ordering::Equal)
}

/// Places of points among those that are left.
struct Left {
    /// A Fenwick tree of counts.
    sums: Vec<u32>,
}

impl Left {
    fn all(count: usize) -> Self {
        let sums = (0..=count as u32).map(|at| at & at.wrapping_neg()).collect();
        Self { sums }
    }

    /// How many are left before one.
    fn before(&self, place: usize) -> u32 {
        let (mut at, mut sum) = (place, 0);
        while at > 0 {
            sum += self.sums[at];
            at &= at - 1;
        }
        sum
    }

    fn take(&mut self, place: usize) {
        let mut at = place + 1;
        while at < self.sums.len() {
            self.sums[at] -= 1;
            at += at & at.wrapping_neg();
        }
    }

    /// The place of the one that so many are left before; there is one.
    fn find(&self, mut before: u32) -> usize {
        let mut at = 0;
        let top = (self.sums.len() - 1).checked_ilog2().unwrap_or(0);
        for step in (0..=top).rev().map(|bit| 1 << bit) {
            if let Some(&sum) = self.sums.get(at + step)
                && sum <= before
            {
                (at, before) = (at + step, before - sum);
            }
        }
        at
    }
}

/// The probabilities of an order.
pub(crate) struct Turns {
    in_turn: Number,
    ahead: Number,
}

impl Turns {
    pub(crate) const NEW: Self = Self { in_turn: Number::NEW, ahead: Number::NEW };

    /// Forward: `order` is that of the rule, `place` that of each point in the order of the file.
    pub(crate) fn encode(mut self, coder: &mut impl BinaryCoder, places: &[u32]) {
        let mut left = Left::all(places.len());
        let mut in_turn = 0;
        for &place in places {
            let before = left.before(place as usize);
            left.take(place as usize);
            if before == 0 {
                in_turn += 1;
            } else {
                self.in_turn.code(coder, in_turn);
                self.ahead.code(coder, before - 1);
                in_turn = 0;
            }
        }
        if in_turn > 0 {
            self.in_turn.code(coder, in_turn);
        }
    }

    /// Inverse: the places of `count` points in the order of the file; `None` where they are none.
    pub(crate) fn decode(mut self, coder: &mut impl BinaryCoder, count: usize) -> Option<Vec<u32>> {
        let mut left = Left::all(count);
        let mut is_taken = vec![false; count];
        let (mut places, mut first) = (Vec::with_capacity(count), 0);
        while places.len() < count {
            let in_turn = self.in_turn.code(coder, 0) as usize;
            if in_turn > count - places.len() {
                return None;
            }
            for _ in 0..in_turn {
                while is_taken[first] {
                    first += 1;
                }
                is_taken[first] = true;
                left.take(first);
                places.push(first as u32);
            }
            let still = count - places.len();
            if still == 0 {
                break;
            }
            let ahead = self.ahead.code(coder, 0) as usize + 1;
            if ahead >= still {
                return None;
            }
            let place = left.find(ahead as u32);
            is_taken[place] = true;
            left.take(place);
            places.push(place as u32);
        }
        Some(places)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coder::context::range_coder::{RangeDecoder, RangeEncoder};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_order_comes_back(places in Just((0..300_u32).collect::<Vec<_>>()).prop_shuffle(), swaps in 0..300_usize) {
            // From shuffled altogether to all in turn but a few.
            let mut places = places;
            places[swaps..].sort_unstable();
            let mut out = vec![0; 4000];
            let mut coder = RangeEncoder::new(&mut out);
            Turns::NEW.encode(&mut coder, &places);
            let len = coder.finish().unwrap();
            let mut coder = RangeDecoder::new(&out[..len]);
            prop_assert_eq!(Turns::NEW.decode(&mut coder, places.len()), Some(places));
            prop_assert_eq!(coder.code_len(), len);
        }
    }

    #[test]
    fn azimuths_go_around_from_x_over_y() {
        let around = [
            [1.0, 0.0],
            [2.0, 1.0],
            [0.0, 1.0],
            [-1.0, 3.0],
            [-1.0, 0.0],
            [-1.0, -0.5],
            [-0.0, -3.0],
            [1.0, -9.0],
            [1.0, -0.0],
            [0.0, 0.0],
        ];
        for (at, &a) in around.iter().enumerate() {
            for (other, &b) in around.iter().enumerate() {
                assert_eq!(by_azimuth(a, b), at.cmp(&other), "{a:?} {b:?}");
            }
        }
    }
}
