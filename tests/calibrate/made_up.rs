//! Sensors and streets made up for the tests, with nothing borrowed from the crate's own grid code.

use std::f64::consts::TAU;

/// A small generator, so that every run sees the same numbers.
pub struct Random(pub u64);

impl Random {
    /// 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, len: usize) -> usize {
        (self.unit() * len as f64) as usize
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

/// A beam as the design states it, in double precision.
#[derive(Debug, Clone, Copy)]
pub struct TrueBeam {
    pub slope: f64,
    pub z_offset_m: f64,
    pub h_offset_m: f64,
    pub azimuth_phase_rad: f64,
    pub range_phase_m: f64,
}

/// What to make: a sensor and how its files round.
#[derive(Debug, Clone, Copy)]
pub struct Recipe {
    pub beams: usize,
    pub highest: f64,
    pub lowest: f64,
    /// Height of the stack of lasers, and the largest horizontal offset.
    pub z_offset_m: f64,
    pub h_offset_m: f64,
    pub ticks: u32,
    pub unit_m: f64,
    /// Ticks from one firing to the next, on average.
    pub firing_ticks: f64,
    /// Whether a beam's offset takes its points no farther from the axis.
    pub range_from_axis: bool,
    /// Coordinates are rounded to this; 0 = to `f32` only.
    pub rounding_m: f64,
    pub seed: u64,
}

/// A made-up sensor.
pub struct MadeUp {
    pub recipe: Recipe,
    pub beams: Vec<TrueBeam>,
}

/// A point with the place it was made for.
#[derive(Debug, Clone, Copy)]
pub struct Made {
    pub position: [f32; 3],
    pub beam: u16,
    pub tick: u32,
    pub count: i32,
}

impl MadeUp {
    pub fn new(recipe: Recipe) -> Self {
        let mut random = Random(recipe.seed);
        let step = (recipe.highest - recipe.lowest) / (recipe.beams - 1) as f64;
        let tick = TAU / f64::from(recipe.ticks);
        let beams = (0..recipe.beams).map(|row| TrueBeam {
            slope: recipe.highest - step * (row as f64 + random.between(-0.2, 0.2)),
            // From top to bottom, as in a stack of lasers: beams do not cross where points are.
            z_offset_m: recipe.z_offset_m * (1.0 - row as f64 / recipe.beams as f64 + random.between(-0.01, 0.01)),
            h_offset_m: recipe.h_offset_m * random.between(-1.0, 1.0),
            azimuth_phase_rad: tick * random.between(-0.5, 0.5),
            range_phase_m: recipe.unit_m * random.between(-0.5, 0.5),
        });
        Self { recipe, beams: beams.collect() }
    }

    /// One turn in a street of its own.
    pub fn scan(&self, seed: u64) -> Vec<Made> {
        let mut random = Random(seed);
        let street = Street::new(&mut random);
        let mut made = Vec::new();
        let mut turn = random.between(0.0, self.recipe.firing_ticks);
        while turn < f64::from(self.recipe.ticks) {
            for (row, beam) in self.beams.iter().enumerate() {
                let tick = turn as u32;
                let azimuth = f64::from(tick) * TAU / f64::from(self.recipe.ticks) + beam.azimuth_phase_rad;
                let Some(range) = street.range(azimuth, beam.slope, &mut random) else { continue };
                let count = (range / self.recipe.unit_m).round() as i32;
                let position = self.position(beam, azimuth, count);
                made.push(Made { position, beam: row as u16, tick, count });
            }
            turn += self.recipe.firing_ticks;
        }
        made
    }

    /// The model's own formula: a = d cos v - vo sin v, z = d sin v + vo cos v, r = sqrt(a^2 + h^2) or a.
    fn position(&self, beam: &TrueBeam, azimuth: f64, count: i32) -> [f32; 3] {
        let elevation = beam.slope.atan();
        let lift = beam.z_offset_m * elevation.cos();
        let range = f64::from(count) * self.recipe.unit_m + beam.range_phase_m;
        let reach = range * elevation.cos() - lift * elevation.sin();
        let z = range * elevation.sin() + lift * elevation.cos();
        let rho = if self.recipe.range_from_axis { reach } else { reach.hypot(beam.h_offset_m) };
        let theta = azimuth - (beam.h_offset_m / rho).asin();
        [rho * theta.cos(), rho * theta.sin(), z].map(|value| self.round(value))
    }

    fn round(&self, value: f64) -> f32 {
        let step = self.recipe.rounding_m;
        if step > 0.0 { ((value / step).round() * step) as f32 } else { value as f32 }
    }
}

/// Rough ground and walls at many distances.
struct Street {
    height_m: f64,
    tilt: [f64; 2],
    walls: Vec<Option<(f64, f64)>>,
}

impl Street {
    fn new(random: &mut Random) -> Self {
        let wall = |random: &mut Random| {
            let there = random.unit() < 0.6;
            there.then(|| (3.0 * (random.unit() * 3.2).exp(), random.between(-1.0, 20.0)))
        };
        Self {
            height_m: random.between(1.4, 1.9),
            tilt: [random.between(-0.03, 0.03), random.between(-0.03, 0.03)],
            walls: (0..90).map(|_| wall(random)).collect(),
        }
    }

    /// Distance to what a ray from the axis hits first, or none.
    fn range(&self, azimuth: f64, slope: f64, random: &mut Random) -> Option<f64> {
        let dip = self.tilt[0] * azimuth.cos() + self.tilt[1] * azimuth.sin() - slope;
        let ground = if dip > 0.01 { self.height_m / dip } else { f64::INFINITY };
        let sector = (azimuth.rem_euclid(TAU) / TAU * self.walls.len() as f64) as usize;
        let wall = self.walls[sector % self.walls.len()];
        let wall =
            wall.filter(|(distance, top)| distance * slope < *top).map_or(f64::INFINITY, |(distance, _)| distance);
        let reach = ground.min(wall) * random.between(0.97, 1.03);
        let range = reach * slope.hypot(1.0);
        (range < 110.0 && random.unit() < 0.95).then_some(range)
    }
}

/// Only the positions, for the crate.
pub fn positions(made: &[Made]) -> Vec<[f32; 3]> {
    made.iter().map(|point| point.position).collect()
}

/// A 64-beam sensor like the one in KITTI's files: the refusals start from it.
pub const SIXTY_FOUR: Recipe = Recipe {
    beams: 64,
    highest: 0.035,
    lowest: -0.466,
    z_offset_m: 0.2,
    h_offset_m: 0.026,
    ticks: 4000,
    unit_m: 0.002,
    firing_ticks: 1.86,
    range_from_axis: false,
    rounding_m: 0.001,
    seed: 64,
};
