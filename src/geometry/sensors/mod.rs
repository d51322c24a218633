//! The sensors that flicr knows from the start.

pub mod hdl64e;

/// One laser of a spinning sensor: how its lattice of (tick, range count) lies in space.
///
/// With tick `t`, range `d = count * unit + range_phase_m`, elevation `v = atan(slope)` and
/// `vo = z_offset_m * cos(v)`:
///
/// ```text
/// theta = t * 360 / ticks + azimuth_phase_deg     a = d cos v - vo sin v
/// x = a cos theta + h sin theta                   y = a sin theta - h cos theta
/// z = d sin v + vo cos v                          h = h_offset_m
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Tangent of the elevation.
    pub slope: f64,
    /// Height over the sensor's origin at which the beam crosses the spin axis, in metres.
    pub z_offset_m: f64,
    /// Sideways distance of the beam from the spin axis, in metres; positive is to the right.
    pub h_offset_m: f64,
    /// Azimuth of tick 0, in degrees.
    pub azimuth_phase_deg: f64,
    /// Range of count 0, in metres.
    pub range_phase_m: f64,
}

impl Beam {
    /// A beam from its five numbers, in the order of the fields.
    #[must_use]
    pub const fn new(
        slope: f64,
        z_offset_m: f64,
        h_offset_m: f64,
        azimuth_phase_deg: f64,
        range_phase_m: f64,
    ) -> Self {
        Self {
            slope,
            z_offset_m,
            h_offset_m,
            azimuth_phase_deg,
            range_phase_m,
        }
    }
}
