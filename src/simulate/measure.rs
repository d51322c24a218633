//! How a sensor sees a hit: whether it notices it at all, with which error, and how bright.

use super::Sensor;
use super::random::Random;
use super::scene::Hit;
use super::shape::{Ray, Shape};
use super::street::Material;
use std::vec::Vec;

/// Share of the largest range from which returns thin out.
const THINNING_FROM: f64 = 0.72;
/// Signal that is always noticed, as reflectivity times the cosine of incidence at 60 m.
const SURE_SIGNAL: f64 = 0.03;
/// Share of the best targets that are seen.
const SEEN_AT_BEST: f64 = 0.998;
/// Range at which the noise is twice that nearby, in meters.
const NOISE_DOUBLES_M: f64 = 60.0;

/// How a material answers.
struct Optics {
    /// Share of the light that comes back, as an intensity from 0 to 1.
    reflectivity: f64,
    /// Deviation of the surface from its ideal shape, in meters.
    roughness_m: f64,
    /// Share of the surface's patches that give no return at all.
    drop_out: f64,
}

fn optics(material: Material) -> Optics {
    let (reflectivity, roughness_m, drop_out) = match material {
        Material::Asphalt => (0.33, 0.001, 0.0005),
        Material::Marking => (0.6, 0.001, 0.0),
        Material::Grass => (0.44, 0.01, 0.002),
        Material::Wall => (0.42, 0.006, 0.004),
        Material::Glass => (0.18, 0.003, 0.4),
        Material::Paint => (0.34, 0.003, 0.015),
        Material::DarkPaint => (0.1, 0.003, 0.1),
        Material::Metal => (0.5, 0.003, 0.01),
        Material::Bark => (0.28, 0.012, 0.01),
        Material::Leaf => (0.38, 0.03, 0.02),
        Material::Cloth => (0.26, 0.012, 0.01),
    };
    Optics { reflectivity, roughness_m, drop_out }
}

/// A laser's own peculiarities, drawn once from its number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Laser {
    /// Factor on the intensity; a few lasers are nearly blind to it.
    gain: f64,
    /// Noise nearby, in meters.
    noise_m: f64,
}

impl Laser {
    pub(super) fn new(sensor: &Sensor, beam: u8) -> Self {
        let mut random = Random::at(0x001A_5E12, &[i64::from(beam)]);
        let faint = random.chance(0.05);
        Self {
            gain: if faint { 0.3 } else { random.between(0.65, 1.15) },
            noise_m: sensor.noise_m * if random.chance(0.1) { 1.8 } else { random.between(0.85, 1.2) },
        }
    }

    /// The range and the intensity (hundredths) that are reported, or nothing.
    /// `patch` belongs to the place that was hit: mirrors and dark spots hide all rays alike.
    pub(super) fn measure(
        &self,
        sensor: &Sensor,
        hit: Hit,
        patch: &mut Random,
        random: &mut Random,
    ) -> Option<(f64, u8)> {
        let optics = optics(hit.material);
        if patch.chance(optics.drop_out) || !random.chance(noticed(sensor, &optics, hit)) {
            return None;
        }
        let electronics_m = self.noise_m * (1.0 + hit.range_m / NOISE_DOUBLES_M);
        let surface_m = optics.roughness_m / hit.cos_incidence.max(0.06);
        let range_m = hit.range_m + electronics_m * random.normal() + surface_m * random.normal();
        let reported = (sensor.min_range_m..sensor.max_range_m).contains(&range_m);
        reported.then(|| (range_m, self.intensity(&optics, hit, patch, random)))
    }

    fn intensity(&self, optics: &Optics, hit: Hit, patch: &mut Random, random: &mut Random) -> u8 {
        // Weak echoes are reported with no intensity at all.
        let weak = 0.02 + 0.002 * hit.range_m;
        if patch.chance(weak) || random.chance(weak) {
            return 0;
        }
        let squareness = 0.75 + 0.25 * hit.cos_incidence;
        let faded = 1.0 - 0.3 * (hit.range_m / 80.0).min(1.0);
        let mean = 100.0 * optics.reflectivity * squareness * faded * self.gain;
        // Most neighbours are nearly alike; speckle makes the others differ.
        let speckle = if random.chance(0.3) { 2.5 } else { 1.0 };
        let spread = speckle * (0.8 + 0.06 * mean);
        libm::round(mean + spread * random.normal()).clamp(0.0, 99.0) as u8
    }
}

/// Probability that a hit is noticed.
fn noticed(sensor: &Sensor, optics: &Optics, hit: Hit) -> f64 {
    let nearness = 60.0 / hit.range_m;
    let signal = optics.reflectivity * hit.cos_incidence * nearness * nearness;
    let thinning_from_m = THINNING_FROM * sensor.max_range_m;
    let beyond = (hit.range_m - thinning_from_m) / (sensor.max_range_m - thinning_from_m);
    let thinned = 1.0 - 0.6 * beyond.clamp(0.0, 1.0);
    (signal / SURE_SIGNAL).min(1.0) * thinned * SEEN_AT_BEST
}

/// What the car's own roof, racks and cameras hide; in the sensor's frame.
#[derive(Debug)]
pub(super) struct OwnCar(Vec<Shape>);

impl OwnCar {
    pub(super) fn new(present: bool) -> Self {
        /// x from, x to, y from, y to, z from, z to, in meters.
        const PARTS_M: [[f64; 6]; 11] = [
            [-1.16, -0.2, -0.47, 0.47, -0.6, -0.3],
            [0.2, 1.03, -0.17, 0.17, -0.6, -0.3],
            [0.2, 0.86, -0.3, 0.3, -0.6, -0.3],
            [-1.02, -0.95, 0.31, 0.39, -0.6, -0.13],
            [-1.02, -0.95, -0.39, -0.31, -0.6, -0.13],
            [0.12, 0.34, -0.74, -0.63, -0.19, -0.1],
            [-0.56, -0.46, 0.58, 0.68, -0.6, -0.2],
            [-0.56, -0.46, -0.68, -0.58, -0.6, -0.2],
            [0.68, 0.76, 0.41, 0.49, -0.6, -0.25],
            [0.68, 0.76, -0.49, -0.41, -0.6, -0.25],
            [-0.7, -0.6, -0.6, 0.6, -0.6, -0.26],
        ];
        let part = |[x0, x1, y0, y1, z0, z1]: [f64; 6]| {
            let center = [f64::midpoint(x0, x1), f64::midpoint(y0, y1)];
            let half = [(x1 - x0) / 2.0, (y1 - y0) / 2.0];
            Shape::upright(center, half, [z0, z1], [1.0, 0.0])
        };
        Self(if present { PARTS_M.map(part).to_vec() } else { Vec::new() })
    }

    pub(super) fn hides(&self, ray: &Ray) -> bool {
        ray.direction[2] < -0.2 && self.0.iter().any(|part| part.span(ray).is_some())
    }
}
