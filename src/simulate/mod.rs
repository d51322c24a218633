//! A simulated sensor driving down a made-up street, exact on the sensor's own grid.
//!
//! Real scans belong to others; this stands in for them, so that a fresh clone can run every test
//! and the demo. Rays leave each beam's true origin, meet kerbs, house fronts, parked cars, trees
//! and people, and come back as (firing, beam, tick, count): the integers that a packet carries,
//! and from which the points are made by the very formulas of the sensor's grid. So every turn
//! brings its ground truth along.
//!
//! The same seed gives the same bytes on every machine: integers and [`libm`] only, no host sine.
//!
//! ```
//! use flicr::simulate::Simulator;
//!
//! let mut drive = Simulator::hdl64e(1);
//! let turn = drive.next().unwrap();
//! assert!((105_000..130_000).contains(&turn.points.len()));
//! assert_eq!(turn.points.len(), turn.returns.len());
//! let scan: Vec<u8> = turn.kitti_bytes(); // as a KITTI .bin file
//! assert_eq!(scan.len(), 16 * turn.points.len());
//! ```

use std::vec;
use std::vec::Vec;

mod drive;
mod measure;
mod random;
mod scene;
mod sensor;
mod shape;
mod street;

pub use sensor::Sensor;

use drive::{Drive, Pose};
use measure::{Laser, OwnCar};
use random::Random;
use scene::Scene;
use sensor::Lattice;
use shape::Ray;
use street::Street;

/// Edge of the patches that give no return as a whole, in meters.
const PATCH_M: f64 = 0.3;

/// What the car's own motion does to a turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EgoMotion {
    /// The sensor stands still while it turns, and jumps ahead between turns.
    #[default]
    Frozen,
    /// It moves as it turns, and the points stay as measured: on the grid, slightly bent, as raw
    /// scans are.
    Raw,
    /// It moves as it turns, and the points are moved to where they are seen from at the middle of
    /// the turn: off the grid, as motion-compensated scans are.
    Compensated,
}

/// One measurement, as the integers in which a sensor reports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Return {
    /// Number of the firing (column) in the turn, from 0.
    pub firing: u16,
    /// Beam (row), 0 is the highest.
    pub beam: u8,
    /// Encoder tick that the beam looked along, from 0 up to the sensor's ticks.
    pub tick: u16,
    /// Range in counts.
    pub count: u32,
    /// Intensity in hundredths, 0 to 99.
    pub intensity: u8,
    /// Time since the drive began.
    pub time_ns: u64,
}

/// One full turn of the sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// Number of the turn, from 0.
    pub index: u64,
    /// Time at which it began, since the drive began.
    pub time_ns: u64,
    /// The tick of each firing, in order of time; each beam adds its own shift.
    pub firing_ticks: Vec<u16>,
    /// The returns, beam after beam from the highest, by azimuth from +x over +y.
    pub returns: Vec<Return>,
    /// x, y, z in meters, rounded to a millimeter, and intensity 0 to 0.99; each made of the
    /// return of the same number.
    pub points: Vec<[f32; 4]>,
}

impl Turn {
    /// The points as a KITTI file holds them: x, y, z, intensity as little-endian `f32`.
    #[must_use]
    pub fn kitti_bytes(&self) -> Vec<u8> {
        let floats = self.points.as_flattened().iter();
        floats.flat_map(|float| float.to_le_bytes()).collect()
    }

    /// The returns in the order of time: firing after firing, in each from the highest beam.
    #[must_use]
    pub fn returns_as_fired(&self) -> Vec<Return> {
        let mut returns = self.returns.clone();
        returns.sort_by_key(|found| (found.firing, found.beam));
        returns
    }
}

/// A sensor on a drive: an endless iterator of turns.
#[derive(Clone, Debug)]
pub struct Simulator {
    sensor: Sensor,
    seed: u64,
    ego_motion: EgoMotion,
    speed_m_s: f64,
    next_turn: u64,
}

impl Simulator {
    /// KITTI's HDL-64E in the street of this seed; the same as [`Simulator::hdl64e`].
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self::hdl64e(seed)
    }

    /// KITTI's HDL-64E in the street of this seed, at 10 turns and 10 m a second.
    #[must_use]
    pub fn hdl64e(seed: u64) -> Self {
        Self::with_sensor(Sensor::hdl64e(), seed)
    }

    /// Any sensor in the street of this seed, at 10 m a second.
    #[must_use]
    pub fn with_sensor(sensor: Sensor, seed: u64) -> Self {
        Self { sensor, seed, ego_motion: EgoMotion::Frozen, speed_m_s: 10.0, next_turn: 0 }
    }

    /// Sets what the car's own motion does within a turn.
    #[must_use]
    pub fn ego_motion(mut self, ego_motion: EgoMotion) -> Self {
        self.ego_motion = ego_motion;
        self
    }

    /// Sets the speed, in meters a second; 0 is a sensor that stands at the roadside.
    #[must_use]
    pub fn speed(mut self, speed_m_s: f64) -> Self {
        self.speed_m_s = speed_m_s;
        self
    }

    /// The sensor that is simulated.
    #[must_use]
    pub fn sensor(&self) -> &Sensor {
        &self.sensor
    }

    /// The turn of this number, from 0, without those before it.
    #[must_use]
    pub fn turn(&self, index: u64) -> Turn {
        Shot::new(self, index).turn()
    }
}

impl Iterator for Simulator {
    type Item = Turn;

    fn next(&mut self) -> Option<Turn> {
        let turn = self.turn(self.next_turn);
        self.next_turn += 1;
        Some(turn)
    }
}

/// All that one turn needs.
struct Shot<'a> {
    simulator: &'a Simulator,
    index: u64,
    time_ns: u64,
    firing_ticks: Vec<u16>,
    /// One pose for the whole turn, or one for each firing.
    poses: Vec<Pose>,
    middle: Pose,
    scene: Scene,
    own_car: OwnCar,
}

impl<'a> Shot<'a> {
    fn new(simulator: &'a Simulator, index: u64) -> Self {
        let sensor = &simulator.sensor;
        let time_ns = index * sensor.period_ns;
        let mut random = Random::at(simulator.seed, &[-2, index.cast_signed()]);
        let firing_ticks = firing_ticks(sensor, &mut random);
        let drive = Drive::new(simulator.seed, sensor.height_m, simulator.speed_m_s);
        let middle = drive.pose(seconds(time_ns + sensor.period_ns / 2));
        let poses = match simulator.ego_motion {
            EgoMotion::Frozen => vec![middle],
            EgoMotion::Raw | EgoMotion::Compensated => (0..firing_ticks.len() as u64)
                .map(|firing| firing * sensor.period_ns / firing_ticks.len() as u64)
                .map(|into_ns| drive.pose(seconds(time_ns + into_ns)))
                .collect(),
        };
        let scene = surroundings(simulator, &drive, &middle, time_ns);
        Self { simulator, index, time_ns, firing_ticks, poses, middle, scene, own_car: OwnCar::new(sensor.own_car) }
    }

    fn turn(self) -> Turn {
        let mut returns = Vec::new();
        let mut points = Vec::new();
        for (number, beam) in (0..=u8::MAX).zip(self.simulator.sensor.beams.iter()) {
            let lattice = Lattice::new(&self.simulator.sensor, beam);
            let mut seen = self.beam(number, &lattice);
            seen.sort_by(|one, other| one.0.total_cmp(&other.0));
            returns.extend(seen.iter().map(|entry| entry.1));
            points.extend(seen.iter().map(|entry| entry.2));
        }
        Turn { index: self.index, time_ns: self.time_ns, firing_ticks: self.firing_ticks, returns, points }
    }

    /// What one beam sees in the turn: azimuth, return and point of each.
    fn beam(&self, number: u8, lattice: &Lattice) -> Vec<(f64, Return, [f32; 4])> {
        let laser = Laser::new(&self.simulator.sensor, number);
        let firings = (0..=u16::MAX).zip(&self.firing_ticks);
        firings
            .filter_map(|(firing, &firing_tick)| {
                let tick = self.simulator.sensor.beam_tick(number, firing_tick);
                let (range_m, intensity) = self.fire([firing, number.into()], &lattice.ray(tick), &laser)?;
                let found = Return {
                    firing,
                    beam: number,
                    tick: tick as u16,
                    count: lattice.count(range_m),
                    intensity,
                    time_ns: self.fired_ns(firing),
                };
                let position = lattice.position(tick, found.count);
                Some((azimuth_from_ahead(position), found, self.point(firing, position, intensity)))
            })
            .collect()
    }

    /// The range and intensity that one laser of one firing reports.
    fn fire(&self, firing_and_beam: [u16; 2], ray: &Ray, laser: &Laser) -> Option<(f64, u8)> {
        if self.own_car.hides(ray) {
            return None;
        }
        let [firing, beam] = firing_and_beam;
        let place = [self.index.cast_signed(), firing.into(), beam.into()];
        let mut random = Random::at(self.simulator.seed, &place);
        let ray = self.pose(firing).ray(ray);
        let hit = self.scene.cast(&ray, &mut random)?;
        let mut patch = self.scene.cell(ray.at(hit.range_m), PATCH_M);
        laser.measure(&self.simulator.sensor, hit, &mut patch, &mut random)
    }

    fn fired_ns(&self, firing: u16) -> u64 {
        self.time_ns + u64::from(firing) * self.simulator.sensor.period_ns / self.firing_ticks.len() as u64
    }

    fn pose(&self, firing: u16) -> &Pose {
        self.poses.get(usize::from(firing)).unwrap_or(&self.poses[0])
    }

    /// The point as it is stored: in millimeters, moved if the motion is to be compensated.
    fn point(&self, firing: u16, position: [f64; 3], intensity: u8) -> [f32; 4] {
        let position = match self.simulator.ego_motion {
            EgoMotion::Compensated => self.middle.point_back(self.pose(firing).point(position)),
            EgoMotion::Frozen | EgoMotion::Raw => position,
        };
        let [x, y, z] = position.map(|part| (libm::round(part * 1000.0) / 1000.0) as f32);
        [x, y, z, (f64::from(intensity) / 100.0) as f32]
    }
}

/// The street around the sensor at the time of a turn.
fn surroundings(simulator: &Simulator, drive: &Drive, middle: &Pose, time_ns: u64) -> Scene {
    let street = Street { seed: simulator.seed };
    let sensor = &simulator.sensor;
    let place = [middle.place[0], middle.place[1]];
    let reach_m = sensor.max_range_m + 5.0;
    let now_s = seconds(time_ns);
    let mut objects = street.objects(place[0] - reach_m, place[0] + reach_m, now_s);
    let gap_m = 17.0 + 4.0 * libm::sin(now_s / 3.0);
    street.leader([place[0] + gap_m, place[1]], &mut objects);
    let moved_m = match simulator.ego_motion {
        EgoMotion::Frozen => 0.0,
        EgoMotion::Raw | EgoMotion::Compensated => drive.speed_m_s * seconds(sensor.period_ns),
    };
    Scene::around(street, objects, place, 0.3 + moved_m, reach_m)
}

/// The encoder's ticks at which a turn's firings happen: evenly spread, rounded down.
fn firing_ticks(sensor: &Sensor, random: &mut Random) -> Vec<u16> {
    let jitter = u64::from(2 * sensor.firings_jitter + 1);
    let more = (random.bits() % jitter) as u32;
    let firings = (sensor.firings + more).saturating_sub(sensor.firings_jitter).clamp(1, sensor.ticks);
    let phase = random.unit();
    let step = f64::from(sensor.ticks) / f64::from(firings);
    (0..firings)
        .map(|firing| {
            let turned = libm::floor((f64::from(firing) + phase) * step) as u32;
            ((sensor.first_tick + turned) % sensor.ticks) as u16
        })
        .collect()
}

/// Azimuth from 0 (+x) over +y up to a full turn, in radians: the order of KITTI's files.
fn azimuth_from_ahead(position: [f64; 3]) -> f64 {
    let azimuth = libm::atan2(position[1], position[0]);
    if azimuth < 0.0 { azimuth + core::f64::consts::TAU } else { azimuth }
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}
