//! Velodyne: VLP-16, Puck Hi-Res, VLP-32C, HDL-32E, VLS-128.
//!
//! Frame: x forward (azimuth 0), y left, z up; azimuth grows clockwise.
//!
//! The lasers sit some centimetres off the axis, so that a beam prolonged crosses it at another
//! height; Velodyne gives that as a vertical correction, z = range * sin(elevation) + correction.
//! For all of these the correction is -lens * tan(elevation), the lens being the distance from the
//! axis.
//!
//! Sources, by sensor:
//! - VLP-16: user manual 63-9243 Rev E, chapter 9 (elevations, firing times, corrections: 11.2 mm at
//!   -15 degrees, which is a lens at 41.91 mm).
//! - Puck Hi-Res: the same manual's timing; elevations of VeloView's calibration file. The lens is
//!   taken to be the VLP-16's; `velodyne_decoder`'s corrections differ from that by up to 0.4 mm.
//! - VLP-32C: user manual 63-9325 Rev C, chapter 9; lens 42.4 mm.
//! - HDL-32E: 63-9277 Rev D (timing) and VeloView's calibration file (elevations); lens 28.95 mm.
//! - VLS-128: VeloView's calibration file; timing from the ROS driver (8/3 us a group, 20 groups a
//!   cycle); lens 58.63 mm. Newer firmware is said to take 2.89 us a group: not confirmed.
//!
//! The lenses of all but the VLP-16 were read off `velodyne_decoder` 3.1's output, not found in a
//! manual.

use super::{Beam, SensorGeometry, Spin, beams, fire_ns, math};
use crate::packet::{Model, ModelFacts};

const fn sensor(facts: &ModelFacts, beams: &'static [Beam], fire_ns: &'static [i32]) -> SensorGeometry {
    SensorGeometry { name: facts.name, spin: Spin::of(facts, 0.0), beams, fire_ns }
}

const VLP16_FACTS: &ModelFacts = Model::Vlp16.facts();
const PUCK_HI_RES_FACTS: &ModelFacts = Model::PuckHiRes.facts();
const VLP32C_FACTS: &ModelFacts = Model::Vlp32c.facts();
const HDL32E_FACTS: &ModelFacts = Model::Hdl32e.facts();
const VLS128_FACTS: &ModelFacts = Model::Vls128.facts();

/// Row-order beams of a model whose lasers lie `lens_m` from the axis.
const fn raised<const N: usize>(facts: &ModelFacts, lens_m: f64) -> [Beam; N] {
    let mut beams: [Beam; N] = beams(facts);
    let mut channel = 0;
    while channel < N {
        let elevation = facts.elevation_mdeg[channel];
        let beam = &mut beams[facts.beam_of_channel[channel] as usize];
        let z_m = -lens_m * math::tan_mdeg(elevation);
        beam.z_offset_m = z_m as f32;
        // The correction adds to z; the model counts its range from the foot of the perpendicular
        // from the origin on the beam.
        beam.range_phase_m = (z_m * math::sin_mdeg(elevation)) as f32;
        channel += 1;
    }
    beams
}

/// VLP-16 and Puck LITE.
pub static VLP16: SensorGeometry =
    sensor(VLP16_FACTS, &const { raised::<16>(VLP16_FACTS, 0.041_91) }, &const { fire_ns::<16>(VLP16_FACTS) });

/// Puck Hi-Res.
pub static PUCK_HI_RES: SensorGeometry = sensor(
    PUCK_HI_RES_FACTS,
    &const { raised::<16>(PUCK_HI_RES_FACTS, 0.041_91) },
    &const { fire_ns::<16>(PUCK_HI_RES_FACTS) },
);

/// VLP-32C.
pub static VLP32C: SensorGeometry =
    sensor(VLP32C_FACTS, &const { raised::<32>(VLP32C_FACTS, 0.042_4) }, &const { fire_ns::<32>(VLP32C_FACTS) });

/// HDL-32E.
pub static HDL32E: SensorGeometry =
    sensor(HDL32E_FACTS, &const { raised::<32>(HDL32E_FACTS, 0.028_95) }, &const { fire_ns::<32>(HDL32E_FACTS) });

/// VLS-128.
pub static VLS128: SensorGeometry =
    sensor(VLS128_FACTS, &const { raised::<128>(VLS128_FACTS, 0.058_63) }, &const { fire_ns::<128>(VLS128_FACTS) });
