//! The sensors that flicr knows from the start.
//!
//! A packet gives a column's azimuth tick and each beam's range count; these tables say where that
//! is. The angles and firing times stand once, as integers, in [`crate::packet::Model::facts`];
//! here they become meters and radians, at compile time.

pub mod hdl64e;
pub mod hesai;
mod math;
#[cfg(feature = "cli")]
pub mod ouster;
pub mod robosense;
pub mod velodyne;

use crate::packet::ModelFacts;
use core::f64::consts::PI;

pub use super::Beam;
use super::SensorGrid;

/// Those whose beams measure on one grid of encoder ticks: what a decoder finds by their checksum.
pub static ALL: [&SensorGrid<'static>; 2] = [&hdl64e::GRID, &hdl64e::FIRING_GRID];

/// How a sensor's ticks lie in the x-y plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// Ticks a turn.
    pub ticks_per_turn: u32,
    /// Whether ticks grow clockwise, seen from above.
    pub clockwise: bool,
    /// Angle of tick 0 from the x axis, in radians, counterclockwise.
    pub zero_rad: f32,
    /// One range count, in meters.
    pub range_unit_m: f32,
    /// Time from column to column, in nanoseconds.
    pub period_ns: u32,
}

/// A sensor with its beams in row order: row 0 is the highest.
#[derive(Clone, Copy, Debug)]
pub struct SensorGeometry {
    /// As printed on the sensor.
    pub name: &'static str,
    /// The frame.
    pub spin: Spin,
    /// The beams.
    pub beams: &'static [Beam],
    /// When each beam fires, in nanoseconds from the column's time, in row order.
    pub fire_ns: &'static [i32],
}

impl SensorGeometry {
    /// The grid of the columns' own ticks: what the sensor would measure on if all beams fired at once. The azimuths of
    /// beams that fire `f` nanoseconds later are off by what the sensor turns meanwhile, at 600 turns a minute
    /// 0.0036 degrees a microsecond; [`beams_at`](Self::beams_at) has that in.
    #[must_use]
    pub const fn grid(&self) -> SensorGrid<'static> {
        self.grid_of(self.beams)
    }

    /// The sensor's grid with other beams: those of [`beams_at`](Self::beams_at), or a unit's own.
    #[must_use]
    pub const fn grid_of<'a>(&self, beams: &'a [Beam]) -> SensorGrid<'a> {
        let Spin { ticks_per_turn, clockwise, zero_rad, range_unit_m, .. } = self.spin;
        SensorGrid {
            name: self.name,
            beams,
            ticks: ticks_per_turn,
            clockwise,
            zero_rad,
            range_unit_m,
            range_from_axis: false,
        }
    }

    /// The beams as they look while the sensor makes `turns_per_minute`: each further on by what the sensor turns from
    /// the column's time to the beam's. `None` unless `N` is the number of beams.
    ///
    /// A sensor that turns 1 % faster or slower is off by 0.002 degrees at the last beam of a VLP-16.
    ///
    /// ```
    /// use flicr::geometry::{Beam, SensorGrid, sensors::velodyne};
    /// static BEAMS: [Beam; 16] = velodyne::VLP16.beams_at(600).expect("16 beams");
    /// static GRID: SensorGrid = velodyne::VLP16.grid_of(&BEAMS);
    /// ```
    #[must_use]
    pub const fn beams_at<const N: usize>(&self, turns_per_minute: u32) -> Option<[Beam; N]> {
        if N != self.beams.len() {
            return None;
        }
        let mut beams = [Beam::ZERO; N];
        let _ = self.fill_beams_at(turns_per_minute, &mut beams);
        Some(beams)
    }

    /// As [`beams_at`](Self::beams_at), into the front of `out`; gives what it wrote, `None` where `out` is too short.
    #[must_use]
    pub const fn fill_beams_at<'a>(&self, turns_per_minute: u32, out: &'a mut [Beam]) -> Option<&'a [Beam]> {
        let Some((out, _)) = out.split_at_mut_checked(self.beams.len()) else { return None };
        let turns_per_ns = turns_per_minute as f64 / 60e9;
        let rad_per_ns = turns_per_ns * if self.spin.clockwise { -2.0 * PI } else { 2.0 * PI };
        let mut row = 0;
        while row < out.len() && row < self.beams.len() && row < self.fire_ns.len() {
            out[row] = self.beams[row];
            let phase_rad = self.beams[row].azimuth_phase_rad as f64 + rad_per_ns * self.fire_ns[row] as f64;
            out[row].azimuth_phase_rad = phase_rad as f32;
            row += 1;
        }
        Some(out)
    }
}

impl Spin {
    /// Angle, in radians counterclockwise from the x axis, at which a beam fires.
    ///
    /// `step_q8` is the column's ([`Column::step_q8`](crate::packet::Column::step_q8)); `fire_ns`
    /// the beam's. A beam that fires later looks further: the phase grows with the rotation rate.
    #[must_use]
    pub fn theta_rad(&self, tick: u16, step_q8: u32, fire_ns: i32, beam: &Beam) -> f64 {
        let late = f64::from(step_q8) / 256.0 * f64::from(fire_ns) / f64::from(self.period_ns);
        let turned = (f64::from(tick) + late) * 2.0 * PI / f64::from(self.ticks_per_turn);
        let turned = if self.clockwise { -turned } else { turned };
        f64::from(self.zero_rad) + turned + f64::from(beam.azimuth_phase_rad)
    }

    /// A column's angle: the spin of all Velodyne and Hesai sensors.
    const fn of(facts: &ModelFacts, zero_rad: f32) -> Self {
        Self {
            ticks_per_turn: facts.ticks_per_turn as u32,
            clockwise: true,
            zero_rad,
            range_unit_m: facts.range_unit_um as f32 * 1e-6,
            period_ns: facts.period_ns,
        }
    }
}

/// Row-order beams of a model whose lasers all leave the axis at one point.
const fn beams<const N: usize>(facts: &ModelFacts) -> [Beam; N] {
    let mut beams = [Beam::ZERO; N];
    let mut channel = 0;
    while channel < N {
        let beam = &mut beams[facts.beam_of_channel[channel] as usize];
        beam.slope = math::tan_mdeg(facts.elevation_mdeg[channel]) as f32;
        // The model's offsets are clockwise.
        beam.azimuth_phase_rad = -math::rad_of_mdeg(facts.azimuth_mdeg[channel]) as f32;
        channel += 1;
    }
    beams
}

/// Row-order firing times of a model.
const fn fire_ns<const N: usize>(facts: &ModelFacts) -> [i32; N] {
    let mut fire = [0; N];
    let mut channel = 0;
    while channel < N {
        fire[facts.beam_of_channel[channel] as usize] = facts.fire_ns[channel];
        channel += 1;
    }
    fire
}
