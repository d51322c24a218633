//! What a model may look at before a decision: the pixels around, as the decoder knows them by then.
//!
//! Directions are those of the image: the last column is west, the row above north.

use super::beam::{ABOVE, Beam, Near, NearQuad, Sets};

/// Around a group's set of returns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroupSurroundings<'a> {
    /// Where in the image: the group, of so many.
    pub(crate) group: usize,
    pub(crate) groups: usize,
    pub(crate) sets: Sets,
    /// Whether the set of the group above stayed the same in this column; 2 for the first group.
    pub(crate) same_above: u8,
    pub(crate) beams: &'a [Beam],
}

impl GroupSurroundings<'_> {
    /// 36 classes: none, eight or some returns last; same before; same above.
    #[inline(always)]
    pub(crate) fn class(&self) -> usize {
        let kind = match self.sets.west() {
            0 => 0,
            u8::MAX => 1,
            _ => 2,
        };
        (kind * 4 + self.sets.same_before()) * 3 + usize::from(self.same_above).min(2)
    }

    /// Where in the image, in eighths of its height.
    #[inline(always)]
    pub(crate) fn eighth(&self) -> usize {
        (self.group * 8).checked_div(self.groups).unwrap_or(0)
    }

    /// Largest energy in the group.
    #[inline(always)]
    pub(crate) fn energy(&self) -> u16 {
        self.beams.iter().map(|beam| beam.energy).fold(0, u16::max)
    }
}

/// Around a pixel of a group's set of returns: which of the pixels near it are returns, in the lowest bits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SetSurroundings<'a> {
    /// The row in the last three columns, those below it in the bits above.
    pub(crate) west: u32,
    pub(crate) west2: u32,
    pub(crate) west3: u32,
    /// The rows below in the last column.
    pub(crate) south_west: u32,
    /// The row above in this column, the one above that in the next bit.
    pub(crate) north: u32,
    /// The row above in the last column, those below it in the bits above.
    pub(crate) north_west: u32,
    /// Whether a pixel of this group was found to differ from the column before.
    pub(crate) changed: bool,
    pub(crate) beam: &'a Beam,
}

impl SetSurroundings<'_> {
    #[inline(always)]
    pub(crate) fn is_west(&self) -> bool {
        self.west & 1 == 1
    }

    /// 32 classes.
    #[inline(always)]
    pub(crate) fn class(&self) -> usize {
        let pixels = low_bits([self.west, self.north, self.west2, self.south_west]);
        pixels | usize::from(self.changed) << 4
    }

    /// 16 classes of those farther away.
    #[inline(always)]
    pub(crate) fn far_class(&self) -> usize {
        low_bits([self.west, self.north >> 1, self.north_west, self.west3])
    }

    /// Goes on to the next row.
    #[inline(always)]
    pub(crate) fn go_down(&mut self, occupied: bool) {
        for rows in [&mut self.west, &mut self.west2, &mut self.west3, &mut self.south_west, &mut self.north_west] {
            *rows >>= 1;
        }
        self.north = self.north << 1 | u32::from(occupied);
    }
}

/// The number of the lowest bits of these, the first lowest.
#[inline(always)]
fn low_bits(rows: [u32; 4]) -> usize {
    rows.iter().rev().fold(0, |number, &row| number << 1 | (row & 1) as usize)
}

/// Around the flag of a few calm rows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CalmSurroundings<'a> {
    /// The rows' beams and those around them.
    pub(crate) near: &'a NearQuad,
    /// Which of the rows are returns; bit 0 is the first.
    pub(crate) set: u8,
    /// Mean energy of those that are returns.
    pub(crate) energy: u32,
    /// Whether the rows above were active; 2 where they had no flag.
    pub(crate) active_above: u8,
    /// Whether the last residual of the row above was not 0.
    pub(crate) north: bool,
    /// Whether that of the row below was not 0 in the last column.
    pub(crate) south_west: bool,
}

/// Around a return.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    /// Where in the image: the row, of so many.
    pub(crate) row: usize,
    pub(crate) rows: usize,
    /// Its beam and those around it: as they are before this column, where they are not above it.
    pub(crate) near: &'a Near,
    /// What is known of the rows that share a flag.
    pub(crate) flag: Flag,
    /// Whether it is the last return of these rows.
    pub(crate) is_last: bool,
}

impl Surroundings<'_> {
    /// Where in the image, in quarters of its height.
    #[inline(always)]
    pub(crate) fn quarter(&self) -> usize {
        (self.row * 4).checked_div(self.rows).unwrap_or(0)
    }

    /// Whether it is known not to be as predicted: one of the rows is not, and no other is left.
    #[inline(always)]
    pub(crate) fn is_known(&self) -> bool {
        self.is_last && self.flag == Flag::OPEN
    }

    #[inline(always)]
    pub(crate) fn own(&self) -> &Beam {
        &self.near[ABOVE]
    }

    #[inline(always)]
    pub(crate) fn north(&self) -> &Beam {
        &self.near[ABOVE - 1]
    }

    #[inline(always)]
    pub(crate) fn north2(&self) -> &Beam {
        &self.near[ABOVE - 2]
    }

    #[inline(always)]
    pub(crate) fn south_west(&self) -> &Beam {
        &self.near[ABOVE + 1]
    }

    #[inline(always)]
    pub(crate) fn south_west2(&self) -> &Beam {
        &self.near[ABOVE + 2]
    }

    /// What it is predicted to be.
    #[inline(always)]
    pub(crate) fn predicted(&self) -> u16 {
        self.own().predicted
    }

    /// Four times the mean distance of the residuals beside from 0.
    #[inline(always)]
    pub(crate) fn energy(&self) -> u32 {
        (u32::from(self.own().energy) + u32::from(self.south_west().energy)) / 8
    }
}

/// What is known of a few rows before one of their residuals is coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Flag(u8);

impl Flag {
    /// They have no flag.
    pub(crate) const NONE: Self = Self(0);
    /// Not all are 0, those so far were.
    pub(crate) const OPEN: Self = Self(3);

    /// One was seen that is not 0.
    #[inline(always)]
    pub(crate) const fn see(&mut self) {
        self.0 &= 2;
    }

    /// 0 without a flag, 2 where one that is not 0 has been seen, 3 where none has.
    #[inline(always)]
    pub(crate) const fn class(self) -> usize {
        (self.0 & 3) as usize
    }
}

/// 0, 1, 2, 3, then two classes an octave.
#[inline(always)]
pub(crate) const fn half_octave(value: u32) -> usize {
    if value < 4 { value as usize } else { half_octave_of_two(value) }
}

/// The same of a number that is 2 at least; 0 of 1.
#[inline(always)]
pub(crate) const fn half_octave_of_two(value: u32) -> usize {
    let zeros = (value | 1).leading_zeros();
    (2 * (31 - zeros) + (value << zeros >> 30 & 1)) as usize
}

/// Bits of a number; 0 for 0.
#[inline(always)]
pub(crate) const fn octave(value: u32) -> usize {
    (u32::BITS - value.leading_zeros()) as usize
}

/// The number of these bits, the first lowest.
#[inline(always)]
pub(crate) fn bits<const N: usize>(bits: [bool; N]) -> usize {
    bits.iter().rev().fold(0, |number, &bit| number << 1 | usize::from(bit))
}
