//! Figures by which a simulated turn is compared with a real one.

use std::fmt;

use flicr::geometry::sensors::hdl64e::BEAMS;
use flicr::simulate::Simulator;

/// Firings of a turn, for the share of empty ones.
const FIRINGS: f64 = 2150.0;
const COLUMNS: usize = 4500;
const ROWS: usize = 64;

/// Figures of one HDL-64E turn, all as floats for the median's sake.
#[derive(Clone, Copy, Debug)]
pub struct Statistics {
    pub points: f64,
    /// Share of the firings of a beam that bring nothing, over all beams.
    pub empty: f64,
    /// Median range difference of neighbours on a beam: all, the upper 16 beams, the lower 32.
    pub step_m: f64,
    pub top_step_m: f64,
    pub low_step_m: f64,
    /// Share of the points that the paper's 4500x64 image loses.
    pub lost: f64,
    /// zlib level 6 on that image at 8 bits.
    pub zlib_len: f64,
    /// Entropy of the intensity's difference between neighbours.
    pub intensity_bits: f64,
    /// Share of returns beyond 40 m.
    pub far: f64,
}

impl Statistics {
    /// Medians over seven turns of as many streets.
    pub fn simulated() -> Self {
        let turns = (1..=7).map(|seed| Simulator::hdl64e(seed).turn(11 * seed));
        median(turns.map(|turn| Self::of(&turn.points)))
    }
}

impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:6.0} points, {:4.1} % empty, {:4.1} % beyond 40 m, neighbours {:4.1} mm apart (top \
             beams {:4.1}, low {:3.1}), paper's 4500x64: {:4.2} % lost, zlib-6 {:5.0} bytes; \
             intensity {:4.2} bits",
            self.points,
            100.0 * self.empty,
            100.0 * self.far,
            1000.0 * self.step_m,
            1000.0 * self.top_step_m,
            1000.0 * self.low_step_m,
            100.0 * self.lost,
            self.zlib_len,
            self.intensity_bits
        )
    }
}

/// The median of each figure.
pub fn median(all: impl Iterator<Item = Statistics>) -> Statistics {
    let all: Vec<Statistics> = all.collect();
    let of = |field: fn(&Statistics) -> f64| middle(all.iter().map(field).collect());
    Statistics {
        points: of(|s| s.points),
        empty: of(|s| s.empty),
        step_m: of(|s| s.step_m),
        top_step_m: of(|s| s.top_step_m),
        low_step_m: of(|s| s.low_step_m),
        lost: of(|s| s.lost),
        zlib_len: of(|s| s.zlib_len),
        intensity_bits: of(|s| s.intensity_bits),
        far: of(|s| s.far),
    }
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

impl Statistics {
    pub fn of(points: &[[f32; 4]]) -> Self {
        let steps = neighbours(points);
        let between = |low: u8, high: u8| {
            let some = steps.iter().filter(|step| (low..high).contains(&step.beam));
            middle(some.map(|step| step.range_m).collect())
        };
        let (image, kept) = paper_image(points);
        let far = points.iter().filter(|point| range_m(point) > 40.0).count();
        Self {
            points: points.len() as f64,
            empty: 1.0 - points.len() as f64 / (FIRINGS * BEAMS.len() as f64),
            step_m: between(0, 64),
            top_step_m: between(0, 16),
            low_step_m: between(32, 64),
            lost: 1.0 - kept as f64 / points.len() as f64,
            zlib_len: miniz_oxide::deflate::compress_to_vec_zlib(&image, 6).len() as f64,
            intensity_bits: entropy_bits(steps.iter().map(|step| step.intensity)),
            far: far as f64 / points.len() as f64,
        }
    }
}

struct Step {
    beam: u8,
    range_m: f64,
    intensity: i32,
}

/// Differences of points that follow each other on a beam, at most 0.25 degrees apart.
fn neighbours(points: &[[f32; 4]]) -> Vec<Step> {
    let beams: Vec<u8> = points.iter().map(beam_of).collect();
    let near = |one: &[f32; 4], other: &[f32; 4]| {
        let turned = azimuth_rad(other) - azimuth_rad(one);
        (0.0..0.25_f64.to_radians()).contains(&turned)
    };
    (1..points.len())
        .filter(|&at| beams[at] == beams[at - 1] && near(&points[at - 1], &points[at]))
        .map(|at| Step {
            beam: beams[at],
            range_m: (range_m(&points[at]) - range_m(&points[at - 1])).abs(),
            intensity: hundredths(&points[at]) - hundredths(&points[at - 1]),
        })
        .collect()
}

fn hundredths(point: &[f32; 4]) -> i32 {
    libm::roundf(point[3] * 100.0) as i32
}

fn range_m(point: &[f32; 4]) -> f64 {
    let [x, y, z, _] = point.map(f64::from);
    libm::sqrt(x * x + y * y + z * z)
}

fn azimuth_rad(point: &[f32; 4]) -> f64 {
    libm::atan2(f64::from(point[1]), f64::from(point[0]))
}

fn beam_of(point: &[f32; 4]) -> u8 {
    let [x, y, z, _] = point.map(f64::from);
    let rho = libm::hypot(x, y);
    let miss = |beam: usize| (z - (f64::from(BEAMS[beam].slope) * rho + f64::from(BEAMS[beam].z_offset_m))).abs();
    let nearest = (0..BEAMS.len()).min_by(|&one, &other| miss(one).total_cmp(&miss(other)));
    nearest.expect("there are beams") as u8
}

/// The image of the paper's authors (8 bits, from the nearest to the farthest; the last point wins
/// a pixel) and the number of pixels it fills.
fn paper_image(points: &[[f32; 4]]) -> (Vec<u8>, usize) {
    let ranges = || points.iter().map(range_m);
    let (low, high) = (ranges().fold(f64::MAX, f64::min), ranges().fold(0.0, f64::max));
    let mut image = vec![0; ROWS * COLUMNS];
    let mut filled = vec![false; ROWS * COLUMNS];
    for point in points {
        let zenith_deg = libm::acos(f64::from(point[2]) / range_m(point)).to_degrees();
        let row = ((zenith_deg - 88.0) / 0.4187).clamp(0.0, 63.0) as usize;
        let azimuth_deg = azimuth_rad(point).to_degrees() + 180.0;
        let column = (azimuth_deg / (360.0 / COLUMNS as f64)) as usize % COLUMNS;
        image[row * COLUMNS + column] = ((range_m(point) - low) / (high - low) * 255.0) as u8;
        filled[row * COLUMNS + column] = true;
    }
    let kept = filled.iter().filter(|&&full| full).count();
    (image, kept)
}

fn entropy_bits(values: impl Iterator<Item = i32>) -> f64 {
    let mut counts = std::collections::BTreeMap::new();
    let mut total = 0.0;
    for value in values {
        *counts.entry(value).or_insert(0.0) += 1.0;
        total += 1.0;
    }
    let bits = |count: &f64| -count / total * libm::log2(count / total);
    counts.values().map(bits).sum()
}
