//! A file's points from a frame's returns, forward and inverse.
//!
//! ```text
//! body = rule:u8 0 0 0 strangers:u32 code
//! code = (is_missing corrections)... turns (gap record)...
//! ```

use std::collections::HashMap;
use std::vec;
use std::vec::Vec;

use super::corrections::{CORRECTION_MAX, Corrections, Rounded, is_near};
use super::order::{Rule, Turns};
use super::returns::FrameReturn;
use super::{NotExact, POINTS_PER_STRANGER, RECORD_LEN, STRANGERS_MIN};
use crate::coder::check_len;
use crate::coder::context::number::{Chance, Number};
use crate::coder::context::range_coder::{BinaryCoder, RangeDecoder, RangeEncoder};
use crate::error::PayloadFault;

const PREFIX_LEN: usize = 8;

/// A point of a file as a return can tell it.
#[derive(Debug, Clone, Copy)]
struct Told {
    rounded: [Rounded; 3],
    intensity: f32,
}

impl Told {
    fn of([x, y, z, intensity]: [f32; 4]) -> Option<Self> {
        let rounded = [Rounded::of(x)?, Rounded::of(y)?, Rounded::of(z)?];
        Some(Self { rounded, intensity })
    }

    fn xy(&self) -> [f32; 2] {
        [self.rounded[0].coordinate(), self.rounded[1].coordinate()]
    }
}

fn floats(record: &[u8; RECORD_LEN]) -> [f32; 4] {
    bytemuck::cast::<_, [[u8; 4]; 4]>(*record).map(f32::from_le_bytes)
}

/// The section's body.
pub(super) fn encode(returns: &[FrameReturn], records: &[[u8; RECORD_LEN]]) -> Result<Vec<u8>, NotExact> {
    let points: Vec<[f32; 4]> = records.iter().map(floats).collect();
    let matched = Matched::new(returns, &points);
    let strangers = matched.of_point.iter().filter(|found| found.is_none()).count();
    if strangers > STRANGERS_MIN.max(points.len() / POINTS_PER_STRANGER) {
        let at = matched.of_point.iter().position(Option::is_none).unwrap_or(0);
        return Err(NotExact::OffGrid { found: strangers, points: points.len(), first: (at, points[at]) });
    }
    Ok(matched.encode(returns, records, strangers))
}

/// Which return each point of a file is.
struct Matched {
    /// The place of its return, of each point.
    of_point: Vec<Option<u32>>,
    /// The point, of each return.
    told: Vec<Option<Told>>,
}

/// Millimeters that cells for matching are wide: more than a point can be off, so that most have one cell to look into.
const CELL: i32 = 128;
/// Millimeters that a point's number can be off its return, at most, a rounding included.
const OFF_MAX: i32 = CORRECTION_MAX + 1;

impl Matched {
    fn new(returns: &[FrameReturn], points: &[[f32; 4]]) -> Self {
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (place, found) in returns.iter().enumerate() {
            let cell = found.position.map(|part| (part * 1000.0 / f64::from(CELL)).floor() as i32);
            cells.entry(cell).or_default().push(place as u32);
        }
        let mut matched = Self { of_point: vec![None; points.len()], told: vec![None; returns.len()] };
        for (of_point, &point) in matched.of_point.iter_mut().zip(points) {
            let Some(told) = Told::of(point) else { continue };
            let free = |place: &u32| matched.told[*place as usize].is_none();
            let near = around(&told, &cells).filter(free).filter(|&place| told.is(&returns[place as usize]));
            let nearest = near.min_by(|&a, &b| {
                let off = |place: u32| told.square_off(&returns[place as usize]);
                off(a).total_cmp(&off(b))
            });
            if let Some(place) = nearest {
                matched.told[place as usize] = Some(told);
                *of_point = Some(place);
            }
        }
        matched
    }

    /// The returns' turns by the rule that the file's order follows best: of each point that is a return, in the order of the
    /// file.
    fn turns(&self, returns: &[FrameReturn]) -> (Rule, Vec<u32>) {
        let by = |rule: Rule| {
            let mut turn_of = vec![0; returns.len()];
            (0..).zip(sorted(rule, returns, &self.told)).for_each(|(turn, place)| turn_of[place as usize] = turn);
            (rule, self.of_point.iter().flatten().map(|&place| turn_of[place as usize]).collect())
        };
        let steps_back = |turns: &Vec<u32>| turns.windows(2).filter(|pair| pair[1] < pair[0]).count();
        let [first, others @ ..] = Rule::ALL;
        others
            .into_iter()
            .map(by)
            .fold(by(first), |best, other| if steps_back(&other.1) < steps_back(&best.1) { other } else { best })
    }

    fn encode(&self, returns: &[FrameReturn], records: &[[u8; RECORD_LEN]], strangers: usize) -> Vec<u8> {
        let (rule, turns) = self.turns(returns);
        let mut out = vec![0; PREFIX_LEN + 32 * returns.len() + 32 * records.len() + 16];
        let (prefix, code) = out.split_at_mut(PREFIX_LEN);
        prefix[0] = rule as u8;
        prefix[4..].copy_from_slice(&(strangers as u32).to_le_bytes());
        let mut coder = RangeEncoder::new(code);
        let mut model = Model::new();
        model.returns(&mut coder, returns, &self.told);
        Turns::NEW.encode(&mut coder, &turns);
        let mut gap = 0;
        for (of_point, record) in self.of_point.iter().zip(records) {
            if of_point.is_some() {
                gap += 1;
            } else {
                model.stranger(&mut coder, gap, *record);
                gap = 0;
            }
        }
        // There is room: nothing takes more than it was given.
        let len = coder.finish().unwrap_or(0);
        out.truncate(PREFIX_LEN + len);
        out
    }
}

impl Told {
    fn is(&self, found: &FrameReturn) -> bool {
        self.intensity.to_bits() == found.intensity.to_bits() && is_near(found.position, self.rounded)
    }

    fn square_off(&self, found: &FrameReturn) -> f64 {
        let off = |(rounded, part): (Rounded, f64)| part * 1000.0 - f64::from(rounded.number);
        self.rounded.into_iter().zip(found.position).map(off).map(|off| off * off).sum()
    }
}

/// The places of the returns that may be near.
fn around<'a>(told: &Told, cells: &'a HashMap<[i32; 3], Vec<u32>>) -> impl Iterator<Item = u32> + 'a {
    let [xs, ys, zs] = told
        .rounded
        .map(|Rounded { number, .. }| (number - OFF_MAX).div_euclid(CELL)..=(number + OFF_MAX).div_euclid(CELL));
    let near = xs.flat_map(move |x| {
        ys.clone().flat_map({
            let zs = zs.clone();
            move |y| zs.clone().map(move |z| [x, y, z])
        })
    });
    near.filter_map(|cell| cells.get(&cell)).flatten().copied()
}

/// The places of those returns that the file has, in the rule's order.
fn sorted(rule: Rule, returns: &[FrameReturn], told: &[Option<Told>]) -> Vec<u32> {
    let there: Vec<u32> = (0..).zip(told).filter_map(|(place, told)| told.map(|_| place)).collect();
    let of_there: Vec<FrameReturn> = there.iter().map(|&place| returns[place as usize]).collect();
    let points: Vec<[f32; 2]> = told.iter().flatten().map(Told::xy).collect();
    rule.sorted(&of_there, &points).into_iter().map(|at| there[at as usize]).collect()
}

struct Model {
    is_missing: Chance,
    corrections: Corrections,
    gap: Number,
}

impl Model {
    const fn new() -> Self {
        Self { is_missing: Chance::RARE, corrections: Corrections::NEW, gap: Number::NEW }
    }

    /// The points of returns: given in the forward direction, found in the inverse one.
    fn returns(
        &mut self,
        coder: &mut impl BinaryCoder,
        returns: &[FrameReturn],
        told: &[Option<Told>],
    ) -> Vec<Option<Told>> {
        let zero = [Rounded { number: 0, is_minus: false }; 3];
        let code = |(found, told): (&FrameReturn, &Option<Told>)| {
            let is_missing = self.is_missing.code(coder, told.is_none());
            (!is_missing).then(|| {
                let rounded = told.map_or(zero, |told| told.rounded);
                let rounded = self.corrections.code(coder, found.position, rounded);
                Told { rounded, intensity: found.intensity }
            })
        };
        returns.iter().zip(told).map(code).collect()
    }

    /// Points between one that no return is and the last such, and its bytes.
    fn stranger(
        &mut self,
        coder: &mut impl BinaryCoder,
        gap: u32,
        record: [u8; RECORD_LEN],
    ) -> (u32, [u8; RECORD_LEN]) {
        (self.gap.code(coder, gap), record.map(|byte| coder.raw(8, byte.into()) as u8))
    }
}

/// The file that a section's body makes of the returns.
pub(super) fn decode(returns: &[FrameReturn], body: &[u8]) -> Result<Vec<u8>, PayloadFault> {
    let (prefix, code) = body.split_first_chunk::<PREFIX_LEN>().ok_or(PayloadFault::TooShort)?;
    let &[rule, 0, 0, 0, s0, s1, s2, s3] = prefix else { return Err(PayloadFault::Malformed) };
    let rule = *Rule::ALL.get(usize::from(rule)).ok_or(PayloadFault::Malformed)?;
    let strangers = u32::from_le_bytes([s0, s1, s2, s3]) as usize;
    // Each takes its bytes: what cannot be there is not begun.
    if strangers > code.len() / RECORD_LEN {
        return Err(PayloadFault::TooShort);
    }
    let (mut coder, mut model) = (RangeDecoder::new(code), Model::new());
    let told = model.returns(&mut coder, returns, &vec![None; returns.len()]);
    let order = sorted(rule, returns, &told);
    let places = Turns::NEW.decode(&mut coder, order.len()).ok_or(PayloadFault::Malformed)?;
    let mut points = places.iter().filter_map(|&turn| told[order[turn as usize] as usize]);
    let mut file = Vec::with_capacity((places.len() + strangers) * RECORD_LEN);
    for _ in 0..strangers {
        let (gap, record) = model.stranger(&mut coder, 0, [0; RECORD_LEN]);
        for _ in 0..gap {
            put(&mut file, &points.next().ok_or(PayloadFault::Malformed)?);
        }
        file.extend_from_slice(&record);
    }
    points.for_each(|told| put(&mut file, &told));
    check_len(code.len(), coder.code_len())?;
    Ok(file)
}

fn put(file: &mut Vec<u8>, told: &Told) {
    let [x, y, z] = told.rounded.map(Rounded::coordinate);
    file.extend([x, y, z, told.intensity].into_iter().flat_map(f32::to_le_bytes));
}
