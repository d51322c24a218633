//! Where points come from: anything that can hand out blocks of x, y, z lanes.

/// Points in one [`Block`]: a multiple of every vector width in use, and small enough for the stack of a
/// microcontroller (a block and its results take 640 bytes).
pub const BLOCK_LEN: usize = 32;

/// x, y, z of [`BLOCK_LEN`] points in separate lanes, meters, sensor frame (x forward, y left, z up).
#[derive(Debug, Clone)]
#[repr(C)]
pub struct Block {
    /// Forward, meters.
    pub x: [f32; BLOCK_LEN],
    /// Left, meters.
    pub y: [f32; BLOCK_LEN],
    /// Up, meters.
    pub z: [f32; BLOCK_LEN],
}

impl Block {
    /// A block of points at the origin, which are no returns.
    #[must_use]
    pub const fn new() -> Self {
        Self { x: [0.0; BLOCK_LEN], y: [0.0; BLOCK_LEN], z: [0.0; BLOCK_LEN] }
    }

    /// Fills the lanes from `points`, as far as they go, and gives how many were filled; the rest keep what they held.
    #[inline]
    pub fn fill(&mut self, points: impl ExactSizeIterator<Item = [f32; 3]>) -> usize {
        let filled = points.len().min(BLOCK_LEN);
        for (i, point) in (0..BLOCK_LEN).zip(points) {
            [self.x[i], self.y[i], self.z[i]] = point;
        }
        filled
    }
}

impl Default for Block {
    fn default() -> Self {
        Self::new()
    }
}

/// A source of points that can be read any number of times.
///
/// Implemented for slices of `[f32; 3]` (x, y, z) and `[f32; 4]` (x, y, z, and anything, as in KITTI files), and
/// for [`StridedPoints`], which reads x, y, z out of any record layout.
pub trait Points {
    /// Calls `each` with blocks of up to [`BLOCK_LEN`] points, in order; the second argument says how many lanes
    /// of the block hold points.
    fn for_each_block(&self, each: impl FnMut(&Block, usize));
}

impl Points for [[f32; 3]] {
    fn for_each_block(&self, mut each: impl FnMut(&Block, usize)) {
        let mut block = Block::new();
        for points in self.chunks(BLOCK_LEN) {
            let len = block.fill(points.iter().copied());
            each(&block, len);
        }
    }
}

impl Points for [[f32; 4]] {
    fn for_each_block(&self, mut each: impl FnMut(&Block, usize)) {
        let mut block = Block::new();
        for points in self.chunks(BLOCK_LEN) {
            let len = block.fill(points.iter().map(|&[x, y, z, _]| [x, y, z]));
            each(&block, len);
        }
    }
}

/// Bytes of x, y, z.
pub(crate) const XYZ_LEN: usize = 12;

/// Points in records of `stride` bytes, each starting with x, y, z as little-endian `f32`: a ROS `PointCloud2`,
/// a C array of structures, a KITTI file as read.
///
/// ```
/// use flicr::{Points, StridedPoints};
/// let bytes = [0u8; 40]; // two records of 16 bytes, and 8 bytes that are no whole record
/// let points = StridedPoints::new(&bytes, 16).unwrap();
/// assert_eq!((points.len(), points.remainder_len()), (2, 8));
/// assert!(StridedPoints::new(&bytes, 11).is_none()); // x, y, z alone take 12
/// ```
#[derive(Debug, Clone, Copy)]
pub struct StridedPoints<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> StridedPoints<'a> {
    /// `None` where a record could not hold x, y, z: `stride` must be at least 12.
    #[must_use]
    pub const fn new(bytes: &'a [u8], stride: usize) -> Option<Self> {
        if stride < XYZ_LEN { None } else { Some(Self { bytes, stride }) }
    }

    /// Whole records.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.bytes.len() / self.stride
    }

    /// Whether there is no whole record.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes after the last whole record; they are not read.
    #[must_use]
    pub const fn remainder_len(&self) -> usize {
        self.bytes.len() % self.stride
    }
}

impl Points for StridedPoints<'_> {
    fn for_each_block(&self, mut each: impl FnMut(&Block, usize)) {
        let mut block = Block::new();
        // As it was: that it is not 0 is said where the compiler, too, can see it, and needs no check.
        let stride = self.stride.max(XYZ_LEN);
        for records in self.bytes.chunks(stride.saturating_mul(BLOCK_LEN)) {
            // The commonest record, x, y, z and one more float, gets a loop of its own: a known stride saves a tenth.
            let len = match stride {
                16 => block.fill(records.chunks_exact(16).map(read_xyz)),
                stride => block.fill(records.chunks_exact(stride).map(read_xyz)),
            };
            if len > 0 {
                each(&block, len);
            }
        }
    }
}

pub(crate) fn read_xyz(record: &[u8]) -> [f32; 3] {
    match record {
        &[x0, x1, x2, x3, y0, y1, y2, y3, z0, z1, z2, z3, ..] => [
            f32::from_le_bytes([x0, x1, x2, x3]),
            f32::from_le_bytes([y0, y1, y2, y3]),
            f32::from_le_bytes([z0, z1, z2, z3]),
        ],
        // `new` admits no shorter record.
        _ => [0.0; 3],
    }
}
