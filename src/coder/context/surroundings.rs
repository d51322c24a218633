//! What a model may look at before a decision: the pixels around, as the decoder knows them by then.
//!
//! Directions are those of the image: the last column is west, the row above north.

use super::beam::Beam;

/// Around a group's set of returns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroupSurroundings {
    /// Where in the image, in eighths of its height.
    pub(crate) eighth: usize,
    /// The set in the last column.
    pub(crate) west: u8,
    /// All rows of the group.
    pub(crate) rows: u8,
    /// Whether the set stayed the same in the last column (bit 0) and the one before (bit 1).
    pub(crate) same_before: u8,
    /// Whether that of the group above stayed the same in this column; `None` for the first.
    pub(crate) same_above: Option<bool>,
    /// Largest energy in the group.
    pub(crate) energy: u16,
}

impl GroupSurroundings {
    /// 36 classes: none, all or some returns last; same before; same above.
    #[inline(always)]
    pub(crate) fn class(&self) -> usize {
        let kind = match self.west {
            0 => 0,
            west if west == self.rows => 1,
            _ => 2,
        };
        (kind * 4 + usize::from(self.same_before)) * 3 + trit(self.same_above)
    }
}

/// Around a pixel of a set of returns: which of the pixels near it are returns.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::struct_excessive_bools, reason = "pixels are returns or not")]
pub(crate) struct SetSurroundings {
    pub(crate) west: bool,
    pub(crate) west2: bool,
    pub(crate) west3: bool,
    pub(crate) north: bool,
    pub(crate) north2: bool,
    pub(crate) north_west: bool,
    pub(crate) south_west: bool,
    /// Whether a pixel of this group was found to differ from the column before.
    pub(crate) changed: bool,
    /// Energy of the row's beam.
    pub(crate) energy: u16,
}

impl SetSurroundings {
    /// 32 classes.
    #[inline(always)]
    pub(crate) fn class(&self) -> usize {
        bits([self.west, self.north, self.west2, self.south_west, self.changed])
    }
}

/// Around the flag of a few calm rows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CalmSurroundings {
    /// Sum of the energies of those that are returns.
    pub(crate) energy: u32,
    /// How many they are, 2 to 4.
    pub(crate) returns: u32,
    /// Whether the rows above were active; `None` where they had no flag.
    pub(crate) active_above: Option<bool>,
    /// Whether the last residual of the row above was not 0.
    pub(crate) north: bool,
    /// Whether that of the row below was not 0 in the last column.
    pub(crate) south_west: bool,
}

/// Around a return.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surroundings {
    /// Where in the image, in quarters of its height.
    pub(crate) quarter: usize,
    pub(crate) predicted: u16,
    pub(crate) own: Beam,
    pub(crate) north: Beam,
    pub(crate) north2: Beam,
    pub(crate) south_west: Beam,
    pub(crate) south_west2: Beam,
    /// Energy of the residuals above in this column.
    pub(crate) column_energy: u16,
    /// What is known of the rows that share a flag.
    pub(crate) flag: Flag,
}

impl Surroundings {
    /// Four times the mean distance of the residuals around from 0.
    #[inline(always)]
    pub(crate) fn energy(&self) -> u32 {
        let near = u32::from(self.own.energy) + u32::from(self.column_energy);
        (3 * near + u32::from(self.north.energy) + u32::from(self.south_west.energy)) / 32
    }
}

/// What is known of a few rows before one of their residuals is coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flag {
    /// They have no flag.
    None,
    /// Not all are 0, and one that is not has been seen.
    Seen,
    /// Not all are 0, those so far were.
    Open,
    /// The last of them, which is the one that is not 0.
    Due,
    /// All are 0.
    Calm,
}

/// 0, 1, 2, 3, then two classes an octave.
#[inline(always)]
pub(crate) const fn half_octave(value: u32) -> usize {
    if value < 4 {
        return value as usize;
    }
    let log = value.ilog2();
    (2 * log + (value >> (log - 1) & 1)) as usize
}

/// Bits of a number; 0 for 0.
#[inline(always)]
pub(crate) const fn octave(value: u32) -> usize {
    (u32::BITS - value.leading_zeros()) as usize
}

/// 0 for no, 1 for yes, 2 for neither.
#[inline(always)]
pub(crate) const fn trit(answer: Option<bool>) -> usize {
    match answer {
        Some(yes) => yes as usize,
        None => 2,
    }
}

/// The number of these bits, the first lowest.
#[inline(always)]
pub(crate) fn bits<const N: usize>(bits: [bool; N]) -> usize {
    bits.iter().rev().fold(0, |number, &bit| number << 1 | usize::from(bit))
}
