//! RoboSense Helios-16P.
//!
//! Frame: x forward (azimuth 0), y left, z up; azimuth grows clockwise.
//!
//! Source: RoboSense's `rs_driver` (2.5 mm a count, 55.56 us a firing of 16 channels 1.73 us apart,
//! lasers 34.98 mm before the axis in the direction of the column's azimuth); angles of the table
//! that the Nebula driver ships. Every unit sends its own angles in its DIFOP packets: these are one
//! unit's. The driver's sideways lens offset (-15 mm) is not used by its own formula, nor here.

use super::{Beam, SensorGeometry, Spin, math};

/// Elevation of each row and its clockwise azimuth offset, in thousandths of a degree.
const ANGLES_MDEG: [(i32, i32); 16] = [
    (14_940, -4_050),
    (13_030, 3_610),
    (10_920, -4_000),
    (8_900, 3_580),
    (6_960, -3_970),
    (5_460, 3_560),
    (3_980, -3_960),
    (2_670, 3_550),
    (1_330, -3_950),
    (0, 3_550),
    (-1_330, -3_950),
    (-2_670, 3_550),
    (-3_960, -3_960),
    (-5_230, 3_560),
    (-6_630, -3_970),
    (-8_010, 3_570),
];

/// Distance of the lasers from the axis, in metres.
const LENS_M: f64 = 0.034_98;

const PERIOD_NS: u32 = 55_560;

/// A beam that starts `LENS_M` before the axis, along the column's azimuth rather than its own.
const fn beam((elevation, azimuth): (i32, i32)) -> Beam {
    let slope = math::tan_mdeg(elevation);
    // In the beam's own direction the start lies `along` before and `aside` to the right of the axis.
    let along = LENS_M * math::cos_mdeg(azimuth);
    let aside = -LENS_M * math::sin_mdeg(azimuth);
    Beam {
        slope: slope as f32,
        z_offset_m: (-along * slope) as f32,
        h_offset_m: aside as f32,
        azimuth_phase_rad: -math::rad_of_mdeg(azimuth) as f32,
        range_phase_m: (along * math::cos_mdeg(elevation)) as f32,
    }
}

const fn beams() -> [Beam; 16] {
    let mut beams = [beam((0, 0)); 16];
    let mut row = 0;
    while row < 16 {
        beams[row] = beam(ANGLES_MDEG[row]);
        row += 1;
    }
    beams
}

/// The channels fire from row 0 on, 1.73 us apart. Whether channel 1 is row 0 on every unit was not
/// confirmed: the driver sorts its channels by elevation.
#[allow(clippy::cast_possible_wrap)] // below 16
const fn fire_ns() -> [i32; 16] {
    let mut fire = [0; 16];
    let mut row = 0;
    while row < 16 {
        fire[row] = row as i32 * 1_730;
        row += 1;
    }
    fire
}

/// Helios-16P.
pub static HELIOS16P: SensorGeometry = SensorGeometry {
    name: "Helios-16P",
    spin: Spin { ticks_per_turn: 36_000, clockwise: true, zero_rad: 0.0, range_unit_m: 0.0025, period_ns: PERIOD_NS },
    beams: &const { beams() },
    fire_ns: &const { fire_ns() },
};
