//! Scans to encode: the simulated one, and some real ones where they are at hand.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use flicr::simulate::Simulator;
use libtest_mimic::Failed;

use crate::frames::FRAMES;

/// Real scans under `FLICR_DATA`: one of a drive and two of the paper's, the second with fewer beams.
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
    let turn = Simulator::hdl64e(1).next().expect("the drive has no end");
    std::fs::write(&path, turn.kitti_bytes()).expect("the target folder can be written to");
    path
}
