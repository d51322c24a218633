//! Intensities: 8 bits a return, as they are or in steps, coded bit by bit from the highest, each with the probability
//! that summed logits give it. Forward and inverse share one walk.
//!
//! What tells most is where the last two intensities of the own beam lie, seen from the number that the next bit decides
//! about; and that number itself, for each laser has its own favorites among them. Beams beside each other say little:
//! sensors balance their lasers by distance and not exactly. Ranges are not looked at, so that it does not matter how
//! they were coded.

use super::scale::IntensityScale;
use super::{PART_HEADER_LEN, SECTION_HEADER_LEN, Strips, put_part};
use crate::coder::context::logit::decide;
use crate::coder::context::range_coder::{BinaryCoder, RangeEncoder};
use crate::coder::{OutputFull, Sink};
use crate::image::{ImageView, Level};

/// Bytes of the body before the first strip's part.
const PREFIX_LEN: usize = 8;
/// Bytes of a part besides its intensities as they are.
const PART_PREFIX_LEN: usize = 2;
/// A part whose intensities are coded.
const CODED: u8 = 0;
/// A part whose intensities stand as they are, for they would not get shorter.
const STORED: u8 = 1;

/// Intensities of 8 bits.
const VALUES: usize = 256;
/// Where an intensity lies, seen from another number.
const SIDES: usize = 16;
/// Bits of an intensity.
const BITS: usize = 8;
/// Classes of a beam's energy.
const ENERGIES: usize = 8;
/// Shift of a decision's error on its way into the logits.
const RATE: u32 = 8;

/// What is remembered of a beam.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    /// The last three intensities, the latest first; zeros before the first.
    last: [u8; 3],
    seen: bool,
    /// 16 x the mean distance of one intensity from the next.
    energy: u16,
}

impl Beam {
    const BLANK: Self = Self { last: [0; 3], seen: false, energy: 80 };

    fn update(&mut self, value: u8) {
        let [west, west2, _] = self.last;
        if self.seen {
            let distance = u16::from(value.abs_diff(west)).min(63);
            self.energy = (7 * self.energy + 16 * distance) / 8;
            self.last = [value, west, west2];
        } else {
            *self = Self { last: [value; 3], seen: true, ..*self };
        }
    }
}

/// Logits that all beams share.
#[derive(Debug, Clone)]
pub(crate) struct Shared {
    west: [[i16; SIDES]; VALUES],
    west2: [[i16; SIDES]; VALUES],
    wests: [[[i16; BITS]; SIDES]; SIDES],
    beside: [[[i16; BITS]; SIDES]; SIDES],
    before: [[[i16; ENERGIES]; SIDES]; SIDES],
}

impl Shared {
    pub(crate) const NEW: Self = Self {
        west: [[0; SIDES]; VALUES],
        west2: [[0; SIDES]; VALUES],
        wests: [[[0; BITS]; SIDES]; SIDES],
        beside: [[[0; BITS]; SIDES]; SIDES],
        before: [[[0; ENERGIES]; SIDES]; SIDES],
    };

    fn clear(&mut self) {
        self.west.as_flattened_mut().fill(0);
        self.west2.as_flattened_mut().fill(0);
        for table in [&mut self.wests, &mut self.beside] {
            table.as_flattened_mut().as_flattened_mut().fill(0);
        }
        self.before.as_flattened_mut().as_flattened_mut().fill(0);
    }
}

/// What a part is coded with, borrowed from memory of any number of rows and classes.
#[derive(Debug)]
pub(crate) struct Model<'a> {
    pub(crate) shared: &'a mut Shared,
    /// Logits by number, of the rows of each class.
    pub(crate) by_class: &'a mut [[i16; VALUES]],
    pub(crate) beams: &'a mut [Beam],
}

impl Model<'_> {
    pub(crate) fn start(&mut self) {
        self.shared.clear();
        self.by_class.as_flattened_mut().fill(0);
        self.beams.fill(Beam::BLANK);
    }

    /// One intensity of row `row` of `rows`, of at most `max`: given in the forward direction, found in the inverse one.
    pub(crate) fn code(&mut self, coder: &mut impl BinaryCoder, (row, rows): (usize, usize), max: u8, value: u8) -> u8 {
        let around = Around::new(self.beams, row);
        let class = (row * self.by_class.len()).checked_div(rows).unwrap_or(0);
        let bits = max.checked_ilog2().map_or(0, |top| top as usize + 1);
        let (mut node, mut found) = (1, 0);
        for place in 0..bits.min(BITS) {
            let bit = 1_u8 << (bits - 1 - place);
            let middle = found | bit;
            if middle <= max && self.decide(coder, &around, (class, node, place), middle, value & bit != 0) {
                found = middle;
            }
            node = 2 * node + usize::from(found & bit != 0);
        }
        if let Some(beam) = self.beams.get_mut(row) {
            beam.update(found);
        }
        found
    }

    /// Whether the intensity is `middle` or more.
    #[inline(always)]
    fn decide(
        &mut self,
        coder: &mut impl BinaryCoder,
        around: &Around,
        (class, node, place): (usize, usize, usize),
        middle: u8,
        decision: bool,
    ) -> bool {
        let [west, west2, west3] = around.own.map(|value| side(value, middle));
        let [north, south_west] = around.beside.map(|value| side(value, middle));
        let (node, place, mut none) = (node % VALUES, place % BITS, 0);
        let by_class = self.by_class.get_mut(class).map_or(&mut none, |class| &mut class[node]);
        let logits = [
            by_class,
            &mut self.shared.west[node][west],
            &mut self.shared.west2[node][west2],
            &mut self.shared.wests[west][west2][place],
            &mut self.shared.beside[north][south_west][place],
            &mut self.shared.before[west][west3][around.energy],
        ];
        decide(coder, logits, RATE, decision)
    }
}

/// What an intensity's decisions look at.
struct Around {
    own: [u8; 3],
    /// The row above in this column or its last, the row below in the last column; the own beam's where there is none.
    beside: [u8; 2],
    energy: usize,
}

impl Around {
    fn new(beams: &[Beam], row: usize) -> Self {
        let of = |row: Option<usize>| row.and_then(|row| beams.get(row)).copied().unwrap_or(Beam::BLANK);
        let own = of(Some(row));
        let beside = [row.checked_sub(1), row.checked_add(1)].map(of);
        let beside = beside.map(|beam| if beam.seen { beam.last[0] } else { own.last[0] });
        let energy = (u16::BITS - (own.energy / 8).leading_zeros()) as usize;
        Self { own: own.last, beside, energy: energy.min(ENERGIES - 1) }
    }
}

/// Where a value lies, seen from a number: below (0 far to 7 just) or not (8 at it to 15 far).
#[inline(always)]
fn side(value: u8, middle: u8) -> usize {
    let far = match value.abs_diff(middle) {
        near @ 0..=2 => near.into(),
        3..=4 => 3,
        5..=7 => 4,
        8..=12 => 5,
        13..=24 => 6,
        _ => 7,
    };
    if value < middle { 7 - far } else { 8 + far }
}

/// Memory to code intensities with, of images of up to `ROWS` rows. `CLASSES` of rows, 1 to 255, have logits of their own: as many
/// as there are rows give the fewest bytes, 8 about 1 % more.
///
/// RAM: 28,672 bytes, 512 a class and 6 a row (about 33 KB for 64 rows and 8 classes). All zeros when new, but for the rows'.
#[derive(Debug, Clone)]
pub struct IntensityCoder<const ROWS: usize, const CLASSES: usize> {
    shared: Shared,
    by_class: [[i16; VALUES]; CLASSES],
    beams: [Beam; ROWS],
}

impl<const ROWS: usize, const CLASSES: usize> IntensityCoder<ROWS, CLASSES> {
    /// A coder.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(CLASSES > 0 && CLASSES < VALUES, "classes are numbered by a byte") };
        Self { shared: Shared::NEW, by_class: [[0; VALUES]; CLASSES], beams: [Beam::BLANK; ROWS] }
    }

    /// A plane of these intensities: a number for every pixel of the image, row-major; those of pixels without a return do
    /// not matter.
    pub fn plane<'a>(&'a mut self, numbers: &'a [u8], scale: IntensityScale) -> IntensityPlane<'a> {
        let Self { shared, by_class, beams } = self;
        IntensityPlane { numbers, scale, model: Model { shared, by_class, beams } }
    }
}

impl<const ROWS: usize, const CLASSES: usize> Default for IntensityCoder<ROWS, CLASSES> {
    fn default() -> Self {
        Self::new()
    }
}

/// Intensities of an image and the memory to code them with.
#[derive(Debug)]
pub struct IntensityPlane<'a> {
    numbers: &'a [u8],
    scale: IntensityScale,
    model: Model<'a>,
}

impl IntensityPlane<'_> {
    /// Most bytes by which it makes a frame of `pixels` pixels and `strips` strips longer.
    #[must_use]
    pub const fn worst_case_len(pixels: usize, strips: usize) -> usize {
        SECTION_HEADER_LEN + PREFIX_LEN + (PART_HEADER_LEN + PART_PREFIX_LEN) * strips + pixels
    }

    /// Most rows that the memory is for.
    pub(crate) const fn rows_max(&self) -> usize {
        self.model.beams.len()
    }

    /// Pixels that there are intensities for.
    pub(crate) const fn pixels(&self) -> usize {
        self.numbers.len()
    }

    /// Writes the section's body to the front of `out` and gives its length.
    pub(super) fn encode<L: Level>(
        mut self,
        image: ImageView<'_, L>,
        strips: Strips<'_>,
        out: &mut [u8],
    ) -> Result<usize, OutputFull> {
        let [p0, p1, p2, p3] = self.scale.per_unit().to_le_bytes();
        let prefix = [self.scale.step(), self.model.by_class.len() as u8, 0, 0, p0, p1, p2, p3];
        Sink::new(out).put_all(&prefix)?;
        let mut at = PREFIX_LEN;
        for (first, columns) in strips {
            at = put_part(out, at, |out| self.encode_part(image, first, columns, out))?;
        }
        Ok(at)
    }

    fn encode_part<L: Level>(
        &mut self,
        image: ImageView<'_, L>,
        first: usize,
        columns: usize,
        out: &mut [u8],
    ) -> Result<usize, OutputFull> {
        let (scale, numbers, rows) = (self.scale, self.numbers, image.rows());
        let levels = image.levels().unwrap_or_default();
        // Column by column: row and steps of each return.
        let pixels =
            (first..first + columns).flat_map(|column| (0..rows).map(move |row| (row, row * image.columns() + column)));
        let returns = pixels.filter(|&(_, at)| levels.get(at).is_some_and(|&level| level != L::NONE));
        let steps = returns.map(|(row, at)| (row, scale.steps(numbers.get(at).copied().unwrap_or(0))));
        let (len, max) = steps.clone().fold((0, 0), |(len, max), (_, steps)| (len + 1, steps.max(max)));
        let (prefix, code) = out.split_first_chunk_mut::<PART_PREFIX_LEN>().ok_or(OutputFull)?;
        *prefix = [CODED, max];
        if max == 0 {
            return Ok(PART_PREFIX_LEN);
        }
        let room = code.len().min(len);
        let coded = code.get_mut(..room).and_then(|code| self.model.encode(steps.clone(), rows, max, code));
        if let Some(len) = coded {
            return Ok(PART_PREFIX_LEN + len);
        }
        *prefix = [STORED, max];
        let mut sink = Sink::new(code);
        for (_, steps) in steps {
            sink.put(steps)?;
        }
        Ok(PART_PREFIX_LEN + sink.len())
    }
}

impl Model<'_> {
    /// The code; `None` where it does not fit.
    fn encode(
        &mut self,
        steps: impl Iterator<Item = (usize, u8)>,
        rows: usize,
        max: u8,
        out: &mut [u8],
    ) -> Option<usize> {
        self.start();
        let mut coder = RangeEncoder::new(out);
        for (row, steps) in steps {
            self.code(&mut coder, (row, rows), max, steps);
            if coder.is_full() {
                return None;
            }
        }
        coder.finish()
    }
}

#[cfg(feature = "std")]
pub(crate) use inverse::{IntensityImage, decode};

#[cfg(feature = "std")]
mod inverse {
    use std::vec;
    use std::vec::Vec;

    use super::super::decode::Parts;
    use super::{Beam, CODED, IntensityScale, Model, PREFIX_LEN, STORED, Shared, VALUES};
    use crate::coder::check_len;
    use crate::coder::context::range_coder::RangeDecoder;
    use crate::error::PayloadFault;

    /// A number for every pixel, row-major; 0 where there is no return.
    #[derive(Debug, Default)]
    pub(crate) struct IntensityImage {
        pub(crate) numbers: Vec<u8>,
        pub(crate) scale: Option<IntensityScale>,
    }

    /// Reads a section's body; `is_return` tells of each pixel whether it holds one.
    pub(crate) fn decode(
        body: &[u8],
        rows: usize,
        strips: &[(usize, usize)],
        is_return: &[bool],
        image: &mut IntensityImage,
    ) -> Result<(), PayloadFault> {
        let (prefix, parts) = body.split_first_chunk::<PREFIX_LEN>().ok_or(PayloadFault::TooShort)?;
        let &[step, classes, 0, 0, p0, p1, p2, p3] = prefix else { return Err(PayloadFault::Malformed) };
        let scale = IntensityScale::new(f32::from_le_bytes([p0, p1, p2, p3]), step).ok_or(PayloadFault::Malformed)?;
        if classes == 0 {
            return Err(PayloadFault::Malformed);
        }
        image.scale = Some(scale);
        image.numbers.clear();
        image.numbers.resize(is_return.len(), 0);
        let columns_in_all = is_return.len().checked_div(rows).unwrap_or(0);
        let (mut shared, mut beams) = (std::boxed::Box::new(Shared::NEW), vec![Beam::BLANK; rows]);
        let mut by_class = vec![[0; VALUES]; classes.into()];
        let mut model = Model { shared: &mut shared, by_class: &mut by_class, beams: &mut beams };
        let mut parts = Parts::new(parts);
        for &(first, columns) in strips {
            let part = parts.next()?;
            let pixels = (first..first + columns)
                .flat_map(|column| (0..rows).map(move |row| (row, row * columns_in_all + column)));
            let returns = pixels.filter(|&(_, at)| is_return[at]);
            model.decode_part(part, rows, scale, returns, &mut image.numbers)?;
        }
        parts.finish()
    }

    impl Model<'_> {
        fn decode_part(
            &mut self,
            part: &[u8],
            rows: usize,
            scale: IntensityScale,
            returns: impl Iterator<Item = (usize, usize)> + Clone,
            numbers: &mut [u8],
        ) -> Result<(), PayloadFault> {
            let (&[kind, max], code) = part.split_first_chunk().ok_or(PayloadFault::TooShort)?;
            match kind {
                CODED if max == 0 => check_len(code.len(), 0),
                CODED => {
                    self.start();
                    let mut coder = RangeDecoder::new(code);
                    for (row, at) in returns {
                        numbers[at] = scale.number(self.code(&mut coder, (row, rows), max, 0));
                        if coder.is_past_end() {
                            return Err(PayloadFault::TooShort);
                        }
                    }
                    check_len(code.len(), coder.code_len())
                }
                STORED => {
                    check_len(code.len(), returns.clone().count())?;
                    returns.zip(code).for_each(|((_, at), &steps)| numbers[at] = scale.number(steps));
                    Ok(())
                }
                _ => Err(PayloadFault::Malformed),
            }
        }
    }
}
