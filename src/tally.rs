//! What became of every point.

/// Points counted by what became of them. Every point that was inserted is in exactly one of
/// [`kept`](Self::kept) and the seven counters of points not kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tally {
    /// Points inserted.
    pub points: u32,
    /// At the origin (or within 1e-22 m of it): the sensor's way of saying that nothing came back.
    pub no_return: u32,
    /// With a coordinate that is NaN or infinite.
    pub not_finite: u32,
    /// Nearer than half a quantizer step.
    pub too_near: u32,
    /// Beyond the quantizer's largest range.
    pub beyond_range: u32,
    /// Outside the geometry's azimuths, or outside its elevations where those are dropped.
    pub out_of_view: u32,
    /// In a pixel that another point was given.
    pub collided: u32,
    /// Of the kept and collided: moved into the first or last row, from outside the elevations.
    pub clamped: u32,
    /// Of the kept and collided: moved into a free column at most six from their own, which another point had
    /// ([`FrameEncoder::insert_on_rows`](crate::FrameEncoder::insert_on_rows) alone does that).
    pub displaced: u32,
}

impl Tally {
    /// Nothing counted.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            points: 0,
            no_return: 0,
            not_finite: 0,
            too_near: 0,
            beyond_range: 0,
            out_of_view: 0,
            collided: 0,
            clamped: 0,
            displaced: 0,
        }
    }

    /// Counts a point without a level: `level` is 0, or more than the largest.
    pub(crate) fn count_refused_point(&mut self, [x, y, z]: [f32; 3], level: u32) {
        let counter = if !(x.is_finite() && y.is_finite() && z.is_finite()) {
            &mut self.not_finite
        } else if level > 0 {
            &mut self.beyond_range
        } else if x * x + y * y + z * z > 0.0 {
            &mut self.too_near
        } else {
            &mut self.no_return
        };
        *counter += 1;
    }

    /// Points that are real returns: all but `no_return` and `not_finite`.
    #[must_use]
    pub const fn returns(&self) -> u32 {
        self.points - self.no_return - self.not_finite
    }

    /// Returns that are not in the image.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        self.too_near + self.beyond_range + self.out_of_view + self.collided
    }

    /// Returns in the image.
    #[must_use]
    pub const fn kept(&self) -> u32 {
        self.returns() - self.lost()
    }
}
