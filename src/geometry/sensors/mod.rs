//! The sensors that flicr knows from the start.

pub mod hdl64e;

/// One laser of a spinning sensor: how its lattice of (tick, range count) lies in space.
///
/// With tick `t`, range `d = count * unit + range_phase_m`, elevation `v = atan(slope)`, `vo = z_offset_m * cos(v)` and
/// `h = h_offset_m`:
///
/// ```text
/// theta = t * 2 pi / ticks + azimuth_phase_rad    a = d cos v - vo sin v
/// x = a cos theta + h sin theta                   y = a sin theta - h cos theta
/// z = d sin v + vo cos v
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beam {
    /// Tangent of the elevation.
    pub slope: f32,
    /// Height over the sensor's origin at which the beam, prolonged, crosses the spin axis, in meters.
    pub z_offset_m: f32,
    /// Sideways distance of the beam from the spin axis, in meters; positive to the right.
    pub h_offset_m: f32,
    /// Azimuth of tick 0, in radians, counterclockwise seen from above.
    pub azimuth_phase_rad: f32,
    /// Range of count 0, in meters.
    pub range_phase_m: f32,
}
