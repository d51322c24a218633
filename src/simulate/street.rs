//! A street without end, made up plot by plot from a seed.
//!
//! x runs along the street, y to its left, z up from the road. Each plot of 14 m draws its houses,
//! gardens, trees and parked cars from its own number, so any stretch can be built alone.

use super::random::Random;
use super::shape::{Form, Shape};
use std::vec::Vec;

/// Length of a plot, in meters.
pub(super) const PLOT_M: f64 = 14.0;
/// Every so many plots another street crosses.
const PLOTS_A_BLOCK: i64 = 6;
/// Distance of the kerb from the street's middle, in meters.
pub(super) const KERB_M: f64 = 6.3;
/// Height of the kerb, in meters.
const KERB_HEIGHT_M: f64 = 0.12;
/// Speed of what comes the other way, in meters a second.
const ONCOMING_M_S: f64 = 11.0;
/// One car comes every so many meters.
const ONCOMING_GAP_M: f64 = 55.0;

/// Streams of random numbers, one for each kind of choice, so that a new choice in one does not
/// move everything else.
#[derive(Clone, Copy)]
enum Topic {
    Block,
    House,
    Garden,
    Tree,
    Parking,
    Sidewalk,
    Walker,
    Traffic,
    Ground,
}

/// What a surface does to the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Material {
    Asphalt,
    Marking,
    Grass,
    Wall,
    Glass,
    Paint,
    DarkPaint,
    Metal,
    Bark,
    Leaf,
    Cloth,
}

/// How a solid is filled.
#[derive(Clone, Copy, Debug)]
pub(super) enum Filling {
    /// The surface is what it seems.
    Solid,
    /// A wall with windows, set apart by the number.
    Windows(i64),
    /// Leaves: this share of small cells is filled.
    Porous(f64),
}

/// A thing in the street.
#[derive(Clone, Copy, Debug)]
pub(super) struct Object {
    pub(super) shape: Shape,
    pub(super) material: Material,
    pub(super) filling: Filling,
}

impl Object {
    fn solid(shape: Shape, material: Material) -> Self {
        Self { shape, material, filling: Filling::Solid }
    }

    fn leaves(center: [f64; 3], half: [f64; 3], density: f64) -> Self {
        Self {
            shape: Shape { center, form: Form::Ellipsoid { half } },
            material: Material::Leaf,
            filling: Filling::Porous(density),
        }
    }
}

/// The heading of things in line with the street.
const AHEAD: [f64; 2] = [1.0, 0.0];

/// A street: its seed is all there is to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Street {
    pub(super) seed: u64,
}

impl Street {
    fn random(self, topic: Topic, place: [i64; 2]) -> Random {
        Random::at(self.seed, &[topic as i64, place[0], place[1]])
    }

    /// Everything between two places along the street, as it stands at a time.
    pub(super) fn objects(self, from_m: f64, to_m: f64, time_s: f64) -> Vec<Object> {
        let mut objects = Vec::new();
        for plot in plots(from_m, to_m) {
            for side in [-1, 1] {
                self.plot(plot, side, time_s, &mut objects);
            }
        }
        self.oncoming(from_m, to_m, time_s, &mut objects);
        objects
    }

    fn plot(self, plot: i64, side: i64, time_s: f64, objects: &mut Vec<Object>) {
        if is_crossing(plot) {
            self.side_street(plot, side, objects);
            return;
        }
        let line_m = self.building_line_m(plot, side);
        let mut random = self.random(Topic::House, [plot, side]);
        if random.chance(0.66) {
            house(&mut random, plot, side, line_m, objects);
        } else {
            self.garden(plot, side, line_m, objects);
        }
        self.trees(plot, side, line_m, objects);
        self.parked_cars(plot, side, objects);
        self.sidewalk(plot, side, line_m, objects);
        self.walker(plot, side, time_s, objects);
    }

    /// How far the houses of a block stand from the street's middle.
    fn building_line_m(self, plot: i64, side: i64) -> f64 {
        let block = plot.div_euclid(PLOTS_A_BLOCK);
        self.random(Topic::Block, [block, side]).between(9.5, 22.0)
    }

    /// What is seen down a crossing street: a house or trees at its far end.
    fn side_street(self, plot: i64, side: i64, objects: &mut Vec<Object>) {
        let mut random = self.random(Topic::House, [plot, side]);
        let x = plot_middle_m(plot);
        let y = side as f64 * random.between(38.0, 62.0);
        if random.chance(0.5) {
            let shape = Shape::upright([x, y], [11.0, 4.0], [0.0, 9.0], AHEAD);
            objects.push(Object::solid(shape, Material::Wall));
        }
        for _ in 0..4 {
            let near = [x + random.between(-9.0, 9.0), side as f64 * random.between(18.0, 40.0)];
            tree(&mut random, near, objects);
        }
    }

    /// A hedge or fence along the sidewalk, bushes, and trees further back.
    fn garden(self, plot: i64, side: i64, line_m: f64, objects: &mut Vec<Object>) {
        let mut random = self.random(Topic::Garden, [plot, side]);
        let x = plot_middle_m(plot);
        let toward = side as f64;
        if random.chance(0.6) {
            let shape = Shape::upright([x, toward * line_m], [6.6, 0.5], [0.0, 1.5], AHEAD);
            objects.push(Object { shape, material: Material::Leaf, filling: Filling::Porous(0.75) });
        }
        for _ in 0..3 {
            let place = [x + random.between(-6.0, 6.0), toward * (line_m + random.between(2.0, 14.0))];
            if random.chance(0.4) {
                tree(&mut random, place, objects);
            } else {
                bush(&mut random, place, objects);
            }
        }
        let back = [x + random.between(-3.0, 3.0), toward * (line_m + 22.0)];
        let shape = Shape::upright(back, [5.0, 4.0], [0.0, 7.0], AHEAD);
        objects.push(Object::solid(shape, Material::Wall));
    }

    fn trees(self, plot: i64, side: i64, line_m: f64, objects: &mut Vec<Object>) {
        let mut random = self.random(Topic::Tree, [plot, side]);
        let room_m = line_m - KERB_M;
        let planted = if room_m > 6.0 { 2 } else { 1 };
        for _ in 0..planted {
            let place = [
                plot_middle_m(plot) + random.between(-6.5, 6.5),
                side as f64 * (KERB_M + random.between(0.25, 0.75) * room_m),
            ];
            match random.bits() % 8 {
                0..=4 => tree(&mut random, place, objects),
                5 | 6 => bush(&mut random, place, objects),
                _ => {}
            }
        }
    }

    fn parked_cars(self, plot: i64, side: i64, objects: &mut Vec<Object>) {
        let mut random = self.random(Topic::Parking, [plot, side]);
        for slot in [-3.5, 3.5] {
            let place = [
                plot_middle_m(plot) + slot + random.between(-0.8, 0.8),
                side as f64 * (KERB_M - 1.15 + random.between(-0.15, 0.15)),
            ];
            let askew = random.between(-0.03, 0.03);
            if random.chance(0.45) {
                car(&mut random, place, [libm::sqrt(1.0 - askew * askew), askew], objects);
            }
        }
    }

    /// Lamp posts, sign posts and bins.
    fn sidewalk(self, plot: i64, side: i64, line_m: f64, objects: &mut Vec<Object>) {
        let mut random = self.random(Topic::Sidewalk, [plot, side]);
        let x = plot_middle_m(plot) + random.between(-6.0, 6.0);
        let y = side as f64 * (KERB_M + 0.5);
        if (plot + side).rem_euclid(3) == 0 {
            let post = Shape::cylinder([x, y], 0.09, [0.0, 7.0]);
            objects.push(Object::solid(post, Material::Metal));
        }
        if random.chance(0.4) {
            let x = x + 2.5;
            let post = Shape::cylinder([x, y], 0.035, [0.0, 2.7]);
            let plate = Shape::upright([x - 0.06, y], [0.015, 0.3], [2.0, 2.7], AHEAD);
            objects.push(Object::solid(post, Material::Metal));
            objects.push(Object::solid(plate, Material::Metal));
        }
        if random.chance(0.35) {
            let bin = [x - 2.0, side as f64 * (line_m - 0.5)];
            let shape = Shape::upright(bin, [0.3, 0.35], [0.1, 1.15], AHEAD);
            objects.push(Object::solid(shape, Material::DarkPaint));
        }
    }

    /// A pedestrian who paces up and down before the plot.
    fn walker(self, plot: i64, side: i64, time_s: f64, objects: &mut Vec<Object>) {
        let mut random = self.random(Topic::Walker, [plot, side]);
        if !random.chance(0.3) {
            return;
        }
        let phase = random.between(0.0, 40.0) + 1.3 * time_s;
        let along = phase - 40.0 * libm::floor(phase / 40.0);
        let place =
            [plot_middle_m(plot) + (along - 20.0).abs() - 10.0, side as f64 * (KERB_M + random.between(0.9, 2.4))];
        let legs = Shape::cylinder(place, 0.14, [0.12, 0.95]);
        let body = Shape::cylinder(place, 0.23, [0.9, 1.5]);
        let head = Shape { center: [place[0], place[1], 1.65], form: Form::Ellipsoid { half: [0.1, 0.09, 0.13] } };
        for shape in [legs, body, head] {
            objects.push(Object::solid(shape, Material::Cloth));
        }
    }

    fn oncoming(self, from_m: f64, to_m: f64, time_s: f64, objects: &mut Vec<Object>) {
        let driven_m = ONCOMING_M_S * time_s;
        let first = libm::floor((from_m + driven_m) / ONCOMING_GAP_M) as i64;
        let last = libm::floor((to_m + driven_m) / ONCOMING_GAP_M) as i64;
        for number in first..=last {
            let mut random = self.random(Topic::Traffic, [number, 0]);
            let start = number as f64 * ONCOMING_GAP_M + random.between(0.0, 30.0);
            let place = [start - driven_m, 1.9 + random.between(-0.2, 0.2)];
            car(&mut random, place, AHEAD, objects);
        }
    }

    /// The car that drives ahead in the sensor's own lane.
    pub(super) fn leader(self, place: [f64; 2], objects: &mut Vec<Object>) {
        let mut random = self.random(Topic::Traffic, [0, 1]);
        car(&mut random, place, AHEAD, objects);
    }

    /// Height of the ground's unevenness: long waves and small stones, in meters.
    pub(super) fn bump_m(self, x: f64, y: f64) -> f64 {
        let beside = y.abs() > KERB_M + 3.0;
        let (long, short) = if beside { (0.05, 0.02) } else { (0.015, 0.004) };
        long * self.waves(x / 5.0, y / 5.0, 0) + short * self.waves(x / 0.8, y / 0.8, 1)
    }

    /// Smooth noise from -1 to 1 with waves about 1 long, by interpolation on a grid.
    fn waves(self, x: f64, y: f64, octave: i64) -> f64 {
        let (left, below) = (libm::floor(x), libm::floor(y));
        let corner = |dx: i64, dy: i64| {
            let place = [octave, left as i64 + dx, below as i64 + dy];
            Random::at(self.seed ^ Topic::Ground as u64, &place).between(-1.0, 1.0)
        };
        let (u, w) = (ease(x - left), ease(y - below));
        let low = corner(0, 0) * (1.0 - u) + corner(1, 0) * u;
        let high = corner(0, 1) * (1.0 - u) + corner(1, 1) * u;
        low * (1.0 - w) + high * w
    }
}

/// Goes from 0 to 1 without a corner at either end.
fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

fn plots(from_m: f64, to_m: f64) -> core::ops::RangeInclusive<i64> {
    libm::floor(from_m / PLOT_M) as i64..=libm::floor(to_m / PLOT_M) as i64
}

fn plot_middle_m(plot: i64) -> f64 {
    (plot as f64 + 0.5) * PLOT_M
}

fn is_crossing(plot: i64) -> bool {
    plot.rem_euclid(PLOTS_A_BLOCK) == PLOTS_A_BLOCK - 1
}

/// Whether a place is up on the kerb, and what it is made of.
pub(super) fn ground(x: f64, y: f64) -> (f64, Material) {
    let crossing = is_crossing(libm::floor(x / PLOT_M) as i64);
    if y.abs() < KERB_M || crossing {
        (0.0, paving(x, y))
    } else if y.abs() < KERB_M + 3.0 {
        (KERB_HEIGHT_M, Material::Asphalt)
    } else {
        (KERB_HEIGHT_M, Material::Grass)
    }
}

/// A dashed line along the middle, asphalt elsewhere.
fn paving(x: f64, y: f64) -> Material {
    let dash = x - 9.0 * libm::floor(x / 9.0) < 4.0;
    if dash && y.abs() < 0.08 { Material::Marking } else { Material::Asphalt }
}

fn house(random: &mut Random, plot: i64, side: i64, line_m: f64, objects: &mut Vec<Object>) {
    const DEPTH_M: f64 = 10.0;
    let setback_m = if random.chance(0.5) { 0.0 } else { random.between(0.2, 1.6) };
    let gap_m = if random.chance(0.35) { random.between(1.0, 4.0) } else { 0.0 };
    let height_m = random.between(5.5, 14.0);
    let front = side as f64 * (line_m + setback_m);
    let place = [plot_middle_m(plot) - gap_m / 2.0, front + side as f64 * DEPTH_M / 2.0];
    let half = [(PLOT_M - gap_m) / 2.0, DEPTH_M / 2.0];
    objects.push(Object {
        shape: Shape::upright(place, half, [0.0, height_m], AHEAD),
        material: Material::Wall,
        filling: Filling::Windows(2 * plot + side),
    });
    if random.chance(0.45) {
        // A bay, a porch or a balcony.
        let x = plot_middle_m(plot) + random.between(-4.0, 3.0);
        let low_m = if random.chance(0.5) { 0.0 } else { 2.6 };
        let shape = Shape::upright([x, front], [1.4, 0.9], [low_m, low_m + 2.9], AHEAD);
        objects.push(Object::solid(shape, Material::Wall));
    }
}

fn tree(random: &mut Random, place: [f64; 2], objects: &mut Vec<Object>) {
    let radius = random.between(0.1, 0.28);
    let across = random.between(1.4, 3.2);
    let middle_m = random.between(3.0, 4.8);
    let tall = random.between(1.6, 3.2);
    let trunk = Shape::cylinder(place, radius, [0.0, middle_m]);
    objects.push(Object::solid(trunk, Material::Bark));
    let center = [place[0], place[1], middle_m];
    objects.push(Object::leaves(center, [across, across, tall], 0.3));
}

fn bush(random: &mut Random, place: [f64; 2], objects: &mut Vec<Object>) {
    let across = random.between(0.6, 1.6);
    let tall = random.between(0.6, 1.5);
    let center = [place[0], place[1], 0.8 * tall];
    let density = random.between(0.35, 0.7);
    objects.push(Object::leaves(center, [across * 1.3, across, tall], density));
}

/// A car of a body and a cabin; some are vans.
fn car(random: &mut Random, place: [f64; 2], heading: [f64; 2], objects: &mut Vec<Object>) {
    let half_length = random.between(1.9, 2.4);
    let half_width = random.between(0.83, 0.93);
    let van = random.chance(0.15);
    let paint = if random.chance(0.35) { Material::DarkPaint } else { Material::Paint };
    let bonnet_m = if van { 1.1 } else { 0.88 };
    let half = [half_length, half_width];
    let body = Shape::upright(place, half, [0.22, bonnet_m], heading);
    objects.push(Object::solid(body, paint));
    let back = [place[0] - 0.25 * heading[0], place[1] - 0.25 * heading[1]];
    if van {
        let half = [half_length * 0.8, half_width - 0.05];
        let load = Shape::upright(back, half, [bonnet_m, 2.0], heading);
        objects.push(Object::solid(load, paint));
    } else {
        // Round as car windows are; cars stand too straight for its heading to matter.
        let form = Form::Ellipsoid { half: [half_length * 0.62, half_width - 0.06, 0.62] };
        let center = [back[0], back[1], bonnet_m];
        objects.push(Object::solid(Shape { center, form }, Material::Glass));
    }
}
