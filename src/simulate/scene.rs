//! What stands around the sensor at one moment, sorted by direction so that a ray tests little.

use core::f64::consts::{PI, TAU};
use std::vec;
use std::vec::Vec;

use super::random::Random;
use super::shape::{Form, Ray, Shape, Span};
use super::street::{Filling, KERB_M, Material, Object, Street, ground};

/// Sectors of the full circle.
const SECTORS: usize = 720;
/// Edge of a leaf cell, in meters.
const LEAF_CELL_M: f64 = 0.22;
/// A ray looks into at most so many leaf cells before it is through.
const LEAF_STEPS: usize = 32;

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    pub(super) range_m: f64,
    pub(super) cos_incidence: f64,
    pub(super) material: Material,
}

/// An object with the smallest distance at which a ray can meet it.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    near_m: f64,
    object: u32,
}

/// The objects within reach, by sector of the direction in which they are seen.
#[derive(Debug)]
pub(super) struct Scene {
    street: Street,
    objects: Vec<Object>,
    sectors: Vec<Vec<Candidate>>,
    reach_m: f64,
}

impl Scene {
    /// Sorts the objects around a place; rays may start up to `margin_m` from it.
    pub(super) fn around(street: Street, objects: Vec<Object>, place: [f64; 2], margin_m: f64, reach_m: f64) -> Self {
        let mut sectors = vec![Vec::new(); SECTORS];
        for (object, number) in objects.iter().zip(0..) {
            let corners = object.shape.footprint(margin_m).map(|corner| [corner[0] - place[0], corner[1] - place[1]]);
            let near_m = nearest_m(&corners);
            if near_m < reach_m {
                let candidate = Candidate { near_m, object: number };
                for sector in sectors_of(&corners, near_m) {
                    sectors[sector % SECTORS].push(candidate);
                }
            }
        }
        for sector in &mut sectors {
            sector.sort_by(|one, other| one.near_m.total_cmp(&other.near_m));
        }
        Self { street, objects, sectors, reach_m }
    }

    /// The nearest thing that the ray meets. The random numbers decide what glass lets through.
    pub(super) fn cast(&self, ray: &Ray, random: &mut Random) -> Option<Hit> {
        let mut best = self.cast_ground(ray);
        let flat = libm::sqrt(ray.direction[0] * ray.direction[0] + ray.direction[1] * ray.direction[1]);
        for candidate in &self.sectors[sector_of(ray)] {
            let limit_m = best.map_or(self.reach_m, |hit| hit.range_m);
            if candidate.near_m > limit_m * flat {
                break;
            }
            let object = &self.objects[candidate.object as usize];
            let hit = object.shape.span(ray).and_then(|span| self.surface(object, ray, span, random));
            best = hit.filter(|hit| hit.range_m < limit_m).or(best);
        }
        best
    }

    /// The road, the sidewalks behind their kerbs, and the ground behind them.
    fn cast_ground(&self, ray: &Ray) -> Option<Hit> {
        if ray.direction[2] >= -1e-4 {
            return None;
        }
        let reach = |height_m: f64| (height_m - ray.origin[2]) / ray.direction[2];
        let lowest_m = reach(0.0);
        if lowest_m > 2.0 * self.reach_m {
            return None;
        }
        let there = ray.at(lowest_m);
        let (height_m, _) = ground(there[0], there[1]);
        let top_m = reach(height_m);
        let top = ray.at(top_m);
        let (met_m, material) = ground(top[0], top[1]);
        if met_m < height_m {
            // Still over the road at the kerb's height, below it at the road's: the kerb's face.
            let face_m = (KERB_M * there[1].signum() - ray.origin[1]) / ray.direction[1];
            return Some(Hit {
                range_m: face_m.clamp(top_m, lowest_m),
                cos_incidence: ray.direction[1].abs(),
                material,
            });
        }
        Some(Hit {
            range_m: reach(height_m + self.street.bump_m(top[0], top[1])),
            cos_incidence: -ray.direction[2],
            material,
        })
    }

    fn surface(&self, object: &Object, ray: &Ray, span: Span, random: &mut Random) -> Option<Hit> {
        let hit = Hit { range_m: span.enter_m, cos_incidence: span.cos_incidence, material: object.material };
        match object.filling {
            Filling::Windows(number) if span.side => {
                let height_m = ray.origin[2] + span.enter_m * ray.direction[2];
                Some(window(hit, number, span.along_m, height_m, random))
            }
            Filling::Solid | Filling::Windows(_) => Some(hit),
            Filling::Porous(density) => self.leaf(hit, &object.shape, density, ray, span),
        }
    }

    /// Random numbers that are the same all over a small cube of the street.
    pub(super) fn cell(&self, place: [f64; 3], edge_m: f64) -> Random {
        let cell = place.map(|part| libm::floor(part / edge_m) as i64);
        Random::at(self.street.seed, &cell)
    }

    /// The first filled cell on the way through the leaves.
    fn leaf(&self, hit: Hit, shape: &Shape, density: f64, ray: &Ray, span: Span) -> Option<Hit> {
        for step in 0..LEAF_STEPS {
            let range_m = span.enter_m + (step as f64 + 0.3) * LEAF_CELL_M;
            if range_m > span.leave_m {
                return None;
            }
            let place = ray.at(range_m);
            let mut random = self.cell(place, LEAF_CELL_M);
            if random.chance(density * thickness(shape, place)) {
                return Some(Hit {
                    range_m: range_m + random.between(-0.1, 0.1),
                    cos_incidence: random.between(0.3, 1.0),
                    ..hit
                });
            }
        }
        None
    }
}

/// How thickly leaves stand at a place in a plant: crowns fray towards their outside.
fn thickness(shape: &Shape, place: [f64; 3]) -> f64 {
    let Form::Ellipsoid { half } = shape.form else {
        return 1.0;
    };
    let outward = [0, 1, 2].map(|axis| (place[axis] - shape.center[axis]) / half[axis]);
    let square = outward[0] * outward[0] + outward[1] * outward[1] + outward[2] * outward[2];
    2.0 * (1.0 - square)
}

/// Sets back what lies in a window; some panes let the light through to the room.
fn window(hit: Hit, number: i64, along_m: f64, height_m: f64, random: &mut Random) -> Hit {
    const BAY_M: f64 = 2.3;
    const STOREY_M: f64 = 2.9;
    let bay = libm::floor(along_m / BAY_M);
    let storey = libm::floor(height_m / STOREY_M);
    let u = along_m / BAY_M - bay;
    let w = height_m / STOREY_M - storey;
    let mut of_window = Random::at(number.cast_unsigned(), &[bay as i64, storey as i64]);
    let sill = if of_window.chance(0.2) { 0.02 } else { 0.32 };
    if !(0.25..0.72).contains(&u) || !(sill..0.78).contains(&w) || of_window.chance(0.15) {
        return hit;
    }
    let recess_m = of_window.between(0.08, 0.25);
    let room_m = if random.chance(0.06) { random.between(0.2, 2.5) } else { 0.0 };
    Hit {
        range_m: hit.range_m + (recess_m + room_m) / hit.cos_incidence.max(0.2),
        material: if of_window.chance(0.6) { Material::Glass } else { hit.material },
        ..hit
    }
}

fn sector_of(ray: &Ray) -> usize {
    let azimuth = libm::atan2(ray.direction[1], ray.direction[0]);
    (sector_at(azimuth).max(0.0) as usize).min(SECTORS - 1)
}

fn sector_at(azimuth: f64) -> f64 {
    libm::floor((azimuth + PI) / TAU * SECTORS as f64)
}

/// Sectors that a convex outline covers, as numbers that may run past the last.
fn sectors_of(corners: &[[f64; 2]; 4], near_m: f64) -> core::ops::RangeInclusive<usize> {
    if near_m <= 0.0 {
        return 0..=SECTORS - 1;
    }
    let first = libm::atan2(corners[0][1], corners[0][0]);
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for corner in corners {
        let turn = libm::atan2(corner[1], corner[0]) - first;
        let turn = if turn > PI {
            turn - TAU
        } else if turn < -PI {
            turn + TAU
        } else {
            turn
        };
        low = low.min(turn);
        high = high.max(turn);
    }
    let from = sector_at(first + low) + SECTORS as f64;
    let to = sector_at(first + high) + SECTORS as f64;
    from as usize..=to as usize
}

/// Distance of the origin from a rectangle; 0 when inside.
fn nearest_m(corners: &[[f64; 2]; 4]) -> f64 {
    let mut inside = true;
    let mut nearest = f64::INFINITY;
    for (number, from) in corners.iter().enumerate() {
        let to = corners[(number + 1) % 4];
        let edge = [to[0] - from[0], to[1] - from[1]];
        // The corners go round clockwise: the inside is to the right of every edge.
        inside &= edge[0] * from[1] - edge[1] * from[0] >= 0.0;
        let along = -(from[0] * edge[0] + from[1] * edge[1]);
        let share = (along / (edge[0] * edge[0] + edge[1] * edge[1])).clamp(0.0, 1.0);
        let foot = [from[0] + share * edge[0], from[1] + share * edge[1]];
        nearest = nearest.min(libm::sqrt(foot[0] * foot[0] + foot[1] * foot[1]));
    }
    if inside { 0.0 } else { nearest }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::{nearest_m, sectors_of};

    #[test]
    fn a_rectangle_around_the_origin_is_in_every_direction() {
        let corners = [[2.0, 1.0], [2.0, -1.0], [-2.0, -1.0], [-2.0, 1.0]];
        assert_eq!(nearest_m(&corners), 0.0);
        assert_eq!(sectors_of(&corners, 0.0).count(), 720);
    }

    #[test]
    fn a_rectangle_behind_covers_sectors_across_the_seam() {
        let corners = [[-4.0, 1.0], [-4.0, -1.0], [-8.0, -1.0], [-8.0, 1.0]];
        assert_eq!(nearest_m(&corners), 4.0);
        let sectors: Vec<usize> = sectors_of(&corners, 4.0).map(|s| s % 720).collect();
        assert!(sectors.contains(&719) && sectors.contains(&0));
        assert!(!sectors.contains(&360) && sectors.len() < 60);
    }
}
