//! Where the sensor is while the car drives.

use core::f64::consts::TAU;

use super::random::Random;
use super::shape::Ray;

/// Distance of the sensor's lane from the street's middle, in meters.
const LANE_M: f64 = -1.9;

/// A smooth drive down the street, with the small sway of hands and springs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive {
    pub(super) speed_m_s: f64,
    height_m: f64,
    start_m: f64,
    phases: [f64; 4],
    slope: [f64; 2],
}

impl Drive {
    pub(super) fn new(seed: u64, height_m: f64, speed_m_s: f64) -> Self {
        let mut random = Random::at(seed, &[-1]);
        Self {
            speed_m_s,
            height_m,
            start_m: random.between(0.0, 500.0),
            phases: [(); 4].map(|()| random.between(0.0, TAU)),
            // The street rises or falls a little under the car, and leans to a side.
            slope: [random.between(-0.004, 0.004), random.between(-0.006, 0.006)],
        }
    }

    pub(super) fn pose(&self, time_s: f64) -> Pose {
        // At the roadside it stands on a mast.
        let moved_s = if self.speed_m_s > 0.0 { time_s } else { 0.0 };
        let sway = |number: usize, period_s: f64| libm::sin(TAU * moved_s / period_s + self.phases[number]);
        let yaw = 0.012 * sway(0, 7.0);
        let pitch = self.slope[0] + 0.003 * sway(1, 1.7);
        let roll = self.slope[1] + 0.003 * sway(2, 2.3);
        let place = [self.start_m + self.speed_m_s * time_s, LANE_M + 0.2 * sway(3, 9.0), self.height_m];
        Pose::new(place, yaw, pitch, roll)
    }
}

/// Place and attitude of the sensor in the street.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    pub(super) place: [f64; 3],
    /// Rows turn a vector of the sensor's frame into the street's.
    turn: [[f64; 3]; 3],
}

impl Pose {
    fn new(place: [f64; 3], yaw: f64, pitch: f64, roll: f64) -> Self {
        let (sy, cy) = libm::sincos(yaw);
        let (sp, cp) = libm::sincos(pitch);
        let (sr, cr) = libm::sincos(roll);
        let turn = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ];
        Self { place, turn }
    }

    fn turned(&self, vector: [f64; 3]) -> [f64; 3] {
        self.turn.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
    }

    fn turned_back(&self, vector: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            self.turn[0][axis] * vector[0] + self.turn[1][axis] * vector[1] + self.turn[2][axis] * vector[2]
        })
    }

    /// A ray of the sensor's frame, in the street.
    pub(super) fn ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.point(ray.origin), direction: self.turned(ray.direction) }
    }

    /// A point of the sensor's frame, in the street.
    pub(super) fn point(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.turned(point);
        [0, 1, 2].map(|axis| turned[axis] + self.place[axis])
    }

    /// A point of the street, in the sensor's frame.
    pub(super) fn point_back(&self, point: [f64; 3]) -> [f64; 3] {
        self.turned_back([0, 1, 2].map(|axis| point[axis] - self.place[axis]))
    }
}

#[cfg(test)]
mod tests {
    use super::Drive;

    #[test]
    fn a_point_goes_to_the_street_and_back() {
        let pose = Drive::new(7, 1.73, 10.0).pose(3.0);
        let point = [12.0, -7.0, 0.5];
        let back = pose.point_back(pose.point(point));
        for axis in 0..3 {
            assert!((back[axis] - point[axis]).abs() < 1e-12);
        }
    }
}
