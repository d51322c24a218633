//! Hesai: Pandar40P, Pandar64, PandarXT-32.
//!
//! Frame: y forward (azimuth 0), x right, z up; azimuth grows clockwise, as in Hesai's manuals.
//!
//! Source: the design tables of Hesai's SDK (`HesaiLidar_General_SDK`: elevations, azimuth offsets,
//! firing times). Each unit comes with an angle file of its own, which differs by up to 0.2 degree;
//! load it, or calibrate, where that matters. The manuals give no offsets of the lasers from the
//! axis: 0 here.
//!
//! The packets' azimuth holds at the block's reference time; Hesai's SDK and the Nebula driver
//! place every channel at the block's azimuth plus its offset, without the phase of its firing time.
//! To see what they see, leave `fire_ns` out.

use super::{Beam, SensorGeometry, Spin, beams, fire_ns};
use crate::packet::{Model, ModelFacts};
use core::f32::consts::FRAC_PI_2;

const fn sensor(facts: &ModelFacts, beams: &'static [Beam], fire_ns: &'static [i32]) -> SensorGeometry {
    SensorGeometry { name: facts.name, spin: Spin::of(facts, FRAC_PI_2), beams, fire_ns }
}

const PANDAR40P_FACTS: &ModelFacts = Model::Pandar40p.facts();
const PANDAR64_FACTS: &ModelFacts = Model::Pandar64.facts();
const PANDAR_XT32_FACTS: &ModelFacts = Model::PandarXt32.facts();

/// Pandar40P.
pub static PANDAR40P: SensorGeometry =
    sensor(PANDAR40P_FACTS, &const { beams::<40>(PANDAR40P_FACTS) }, &const { fire_ns::<40>(PANDAR40P_FACTS) });

/// Pandar64.
pub static PANDAR64: SensorGeometry =
    sensor(PANDAR64_FACTS, &const { beams::<64>(PANDAR64_FACTS) }, &const { fire_ns::<64>(PANDAR64_FACTS) });

/// PandarXT-32.
pub static PANDAR_XT32: SensorGeometry =
    sensor(PANDAR_XT32_FACTS, &const { beams::<32>(PANDAR_XT32_FACTS) }, &const { fire_ns::<32>(PANDAR_XT32_FACTS) });
