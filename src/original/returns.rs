//! The returns of a decoded frame, with more digits than its points have.

/// One return of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrameReturn {
    pub(crate) row: u16,
    pub(crate) column: u16,
    /// x, y, z, meters.
    pub(crate) position: [f64; 3],
    pub(crate) intensity: f32,
}
