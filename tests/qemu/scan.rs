//! Scans to encode: the simulated one, and some real ones where they are at hand.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use libtest_mimic::Failed;

use crate::frames::FRAMES;

/// Real scans under `FLICR_DATA`: one of a drive, the two kinds of the paper's (one with fewer beams), another sensor's.
const REAL: [&str; 3] = ["kitti/drive/000000.bin", "kitti/paper/1.bin", "kitti/paper/4.bin"];

/// Points of 16 bytes in a file, and what the host makes of them.
pub struct Scan {
    pub name: String,
    pub path: PathBuf,
    pub is_simulated: bool,
    frames: OnceLock<Result<Vec<Vec<u8>>, String>>,
}

/// All scans there are.
pub fn all() -> Vec<Arc<Scan>> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let data = std::env::var_os("FLICR_DATA").map_or_else(beside, PathBuf::from);
    let mut scans = vec![Scan::new("simulated", simulated(), true)];
    scans
        .extend(REAL.map(|name| Scan::new(name, data.join(name), false)).into_iter().filter(|scan| scan.path.exists()));
    if scans.len() == 1 {
        println!("skipped: no real scans in {}", data.display());
    }
    scans.into_iter().map(Arc::new).collect()
}

impl Scan {
    fn new(name: &str, path: PathBuf, is_simulated: bool) -> Self {
        Self { name: name.into(), path, is_simulated, frames: OnceLock::new() }
    }

    /// The host's bytes of all [`FRAMES`], encoded when first asked for.
    pub fn frames(&self) -> Result<&[Vec<u8>], Failed> {
        let encode_all = |points: Vec<_>| FRAMES.iter().map(|frame| frame.encode(&points)).collect();
        Ok(self.frames.get_or_init(|| self.points().map(encode_all)).as_ref()?)
    }

    fn points(&self) -> Result<Vec<[f32; 4]>, String> {
        let bytes = std::fs::read(&self.path).map_err(|error| format!("{}: {error}", self.path.display()))?;
        let (points, rest) = bytes.as_chunks::<16>();
        if !rest.is_empty() {
            return Err(format!("{} is no whole number of points", self.path.display()));
        }
        let float = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        Ok(points.iter().map(|point| [0, 4, 8, 12].map(|at| float(&point[at..]))).collect())
    }
}

/// Writes the simulated scan and gives its path.
fn simulated() -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("qemu-simulated.bin");
    let bytes: Vec<u8> = stand_in().as_flattened().iter().flat_map(|float| float.to_le_bytes()).collect();
    std::fs::write(&path, bytes).expect("the target folder can be written to");
    path
}

fn stand_in() -> Vec<[f32; 4]> {
    let beam = |beam: u16| (2.0 - 0.4187 * f64::from(beam)).to_radians();
    let firing = |firing: u16| (0.18 * f64::from(firing)).to_radians();
    let rays = (0..64).flat_map(|row| (0..2000).map(move |column| (beam(row), firing(column))));
    rays.filter_map(|(elevation, azimuth)| {
        let (up, forward, left) = (
            libm::sin(elevation),
            libm::cos(elevation) * libm::cos(azimuth),
            libm::cos(elevation) * libm::sin(azimuth),
        );
        let ground = if up < 0.0 { -1.73 / up } else { f64::INFINITY };
        let wall = 8.0 / left.abs();
        let range = ground.min(wall);
        (range < 110.0).then_some([(range * forward) as f32, (range * left) as f32, (range * up) as f32, 0.5])
    })
    .collect()
}
