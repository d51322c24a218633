//! Coordinates of a file from those of a return: rounded to the file's digits, and where that is not what the file has,
//! corrected. A coordinate that lies near the middle between two numbers is the one that may round another way.

use crate::coder::context::number::{Chance, Number};
use crate::coder::context::range_coder::BinaryCoder;

/// Numbers a meter.
pub(crate) const PER_M: f64 = 1000.0;
/// Most by which a coordinate is corrected; farther points are none of the return's.
pub(crate) const CORRECTION_MAX: i32 = 8;

/// Classes of nearness to the middle between two numbers.
const MARGINS: usize = 13;
/// Classes of range.
const RANGES: usize = 8;

/// A coordinate as a number of millimeters; minus zero has a sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Rounded {
    pub(crate) number: i32,
    /// Of zero: whether it is minus zero.
    pub(crate) is_minus: bool,
}

impl Rounded {
    /// The number of a file's coordinate; `None` where it is not the `f32` of one.
    pub(crate) fn of(coordinate: f32) -> Option<Self> {
        let number = libm::round(f64::from(coordinate) * PER_M);
        if number.is_nan() || number.abs() > f64::from(1 << 24) {
            return None;
        }
        let rounded = Self { number: number as i32, is_minus: number == 0.0 && coordinate.is_sign_negative() };
        (rounded.coordinate().to_bits() == coordinate.to_bits()).then_some(rounded)
    }

    pub(crate) fn coordinate(self) -> f32 {
        if self.is_minus { -0.0 } else { (f64::from(self.number) / PER_M) as f32 }
    }
}

/// What a return's coordinate says of the file's.
struct Expected {
    number: i32,
    is_minus: bool,
    /// The number that is next nearest lies above.
    is_up: bool,
    margin: usize,
}

impl Expected {
    fn of(coordinate_m: f64) -> Self {
        // A frame's geometry is bounded, but not by what a file can hold.
        let exact = (coordinate_m * PER_M).clamp(-1e9, 1e9);
        let rounded = libm::round(exact);
        let beyond = exact - rounded;
        let margin = ((0.5 - beyond.abs()) * 4096.0) as u32;
        let margin = (u32::BITS - margin.leading_zeros()) as usize;
        Self {
            number: rounded as i32,
            is_minus: exact.is_sign_negative(),
            is_up: beyond > 0.0,
            margin: margin.min(MARGINS - 1),
        }
    }
}

/// The probabilities of corrections.
#[derive(Debug)]
pub(crate) struct Corrections {
    is_off: [[[Chance; MARGINS]; RANGES]; 3],
    is_other: [Chance; MARGINS],
    is_up: Chance,
    distance: Number,
    is_other_sign: Chance,
}

impl Corrections {
    pub(crate) const NEW: Self = Self {
        is_off: [[[Chance::RARE; MARGINS]; RANGES]; 3],
        is_other: [Chance::RARE; MARGINS],
        is_up: Chance::EVEN,
        distance: Number::NEW,
        is_other_sign: Chance::RARE,
    };

    /// The file's coordinates of a return: given in the forward direction, found in the inverse one.
    pub(crate) fn code(
        &mut self,
        coder: &mut impl BinaryCoder,
        position: [f64; 3],
        rounded: [Rounded; 3],
    ) -> [Rounded; 3] {
        let farthest_m = position.into_iter().fold(0.0, |most: f64, part| most.max(part.abs()));
        let range = ((u32::BITS - (farthest_m as u32).leading_zeros()) as usize).min(RANGES - 1);
        let mut found = rounded;
        for (axis, found) in found.iter_mut().enumerate() {
            let expected = Expected::of(position[axis]);
            found.number = self.number(coder, (axis, range), &expected, found.number);
            found.is_minus = found.number == 0
                && self.is_other_sign.code(coder, found.is_minus != expected.is_minus) != expected.is_minus;
        }
        found
    }

    fn number(
        &mut self,
        coder: &mut impl BinaryCoder,
        (axis, range): (usize, usize),
        expected: &Expected,
        number: i32,
    ) -> i32 {
        let off = number.wrapping_sub(expected.number);
        if !self.is_off[axis][range][expected.margin].code(coder, off != 0) {
            return expected.number;
        }
        let next = if expected.is_up { 1 } else { -1 };
        if !self.is_other[expected.margin].code(coder, off != next) {
            return expected.number + next;
        }
        let is_up = self.is_up.code(coder, off > 0);
        let distance = self.distance.code(coder, off.unsigned_abs().saturating_sub(1)).min(1 << 20).cast_signed() + 1;
        if is_up { expected.number + distance } else { expected.number - distance }
    }
}

/// Whether a file's coordinates can be a return's.
pub(crate) fn is_near(position: [f64; 3], rounded: [Rounded; 3]) -> bool {
    position.into_iter().zip(rounded).all(|(coordinate_m, rounded)| {
        Expected::of(coordinate_m).number.wrapping_sub(rounded.number).unsigned_abs() <= CORRECTION_MAX.unsigned_abs()
    })
}
