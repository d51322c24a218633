//! Scans to encode: simulated ones, and some real ones where they are at hand.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use flicr::packet::Model;
use flicr::simulate::Simulator;
use libtest_mimic::Failed;

use crate::board::check_golden;
use crate::captures::payloads;
use crate::common::data;
use crate::firmware::root;
use crate::frames::{self, FRAMES, Frame};
use crate::packets;
use crate::writer::Plan;

/// Where a scan comes from.
#[derive(Clone, Copy)]
pub enum Kind {
    /// Points of a simulated street.
    Simulated,
    /// Points of a file of the shared data.
    Real(&'static str),
    /// The same, of which only the cost on the sensor's own grid is asked: many points are near, where it is highest.
    Near(&'static str),
    /// Made-up packets.
    Packets(Plan),
    /// The packets of a capture of the shared data.
    Capture { file: &'static str, model: Model },
}

/// One of a drive and two of the paper's, the second with fewer beams.
const REAL: [&str; 3] = ["kitti/drive/000000.bin", "kitti/paper/1.bin", "kitti/paper/4.bin"];
/// Of the 30 raw scans, those whose points cost most to project.
const NEAR: [&str; 2] = ["kitti/object/000000.bin", "kitti/object/000002.bin"];
const CAPTURES: [(&str, Model); 3] = [
    ("velodyne/vlp16_dual.pcap", Model::Vlp16),
    ("velodyne/vlp32c_single.pcap", Model::Vlp32c),
    ("hesai/pandar40p_dual.pcap", Model::Pandar40p),
];

/// What is encoded, and what the host makes of it.
pub struct Scan {
    pub name: String,
    pub kind: Kind,
    path: OnceLock<Result<PathBuf, String>>,
    frames: OnceLock<Result<Vec<Vec<u8>>, String>>,
}

/// All scans; those that are not at hand are `is_missing`.
pub fn all() -> Vec<Arc<Scan>> {
    let mut scans = vec![Scan::new("simulated", Kind::Simulated)];
    let plans = [Plan::new(Model::Vlp16, false), Plan::new(Model::Vlp32c, true), Plan::new(Model::Pandar40p, false)];
    scans.extend(plans.map(|plan| {
        let dual = if plan.dual { "dual" } else { "single" };
        Scan::new(&format!("packets/{:?}-{dual}", plan.model), Kind::Packets(plan))
    }));
    scans.extend(REAL.map(|name| Scan::new(name, Kind::Real(name))));
    scans.extend(NEAR.map(|name| Scan::new(name, Kind::Near(name))));
    scans.extend(CAPTURES.map(|(file, model)| Scan::new(file, Kind::Capture { file, model })));
    if scans.iter().any(Scan::is_missing) {
        println!("skipped: no real scans beside the crate or at FLICR_DATA");
    }
    scans.into_iter().map(Arc::new).collect()
}

impl Scan {
    fn new(name: &str, kind: Kind) -> Self {
        Self { name: name.into(), kind, path: OnceLock::new(), frames: OnceLock::new() }
    }

    /// Whether its file is not at hand.
    pub fn is_missing(&self) -> bool {
        match self.kind {
            Kind::Simulated | Kind::Packets(_) => false,
            Kind::Real(file) | Kind::Near(file) | Kind::Capture { file, .. } => {
                data::FOLDER.is_none() || !data::path(file).exists()
            }
        }
    }

    /// What the firmware is told to make of it.
    pub fn jobs(&self) -> std::slice::Iter<'static, Frame> {
        match self.kind {
            Kind::Simulated | Kind::Real(_) => FRAMES.iter(),
            Kind::Near(_) => frames::EVERY_TICK.iter(),
            Kind::Packets(Plan { model, .. }) | Kind::Capture { model, .. } => packets::jobs(model).iter(),
        }
    }

    /// The file that the firmware reads, written when first asked for.
    pub fn path(&self) -> Result<&Path, Failed> {
        let path = self.path.get_or_init(|| match self.kind {
            Kind::Real(file) | Kind::Near(file) => Ok(data::path(file)),
            Kind::Simulated => {
                let turn = Simulator::hdl64e(1).next().expect("the drive has no end");
                write("simulated.bin", &turn.kitti_bytes())
            }
            _ => write(&format!("{}.packets", self.name.replace('/', "-")), &packets::file_of(&self.packets())),
        });
        Ok(path.as_ref()?)
    }

    /// The host's bytes of all [`jobs`](Self::jobs), encoded when first asked for.
    pub fn frames(&self) -> Result<&[Vec<u8>], Failed> {
        let frames = self.frames.get_or_init(|| match self.kind {
            Kind::Simulated | Kind::Real(_) | Kind::Near(_) => {
                let path = self.path().map_err(|error| format!("{:?}", error.message()))?;
                let points = data::read_points(path);
                Ok(self.jobs().map(|frame| frame.encode(&points)).collect())
            }
            Kind::Packets(Plan { model, .. }) | Kind::Capture { model, .. } => {
                let packets = self.packets();
                Ok(self.jobs().map(|frame| packets::encode(frame, model, &packets)).collect())
            }
        });
        Ok(frames.as_ref()?)
    }

    /// Compares with the file of a real scan's frames, which are the same from every board.
    pub fn check_printed(&self, printed: &str) -> Result<(), Failed> {
        let file = format!("{}.out", self.name.trim_end_matches(".bin").replace('/', "-"));
        check_golden(&root().join("tests/qemu").join(file), printed)
    }

    fn packets(&self) -> Vec<Vec<u8>> {
        match self.kind {
            // Two turns and a half, from the middle of one.
            Kind::Packets(plan) => Plan { start_tick: 18_000, ..plan }.packets(4500 / plan.firings_a_packet()),
            Kind::Capture { file, .. } => payloads(file, 2368),
            Kind::Simulated | Kind::Real(_) | Kind::Near(_) => Vec::new(),
        }
    }
}

/// Writes a file for the firmware to read; gives its path.
fn write(name: &str, bytes: &[u8]) -> Result<PathBuf, String> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("qemu-{name}"));
    std::fs::write(&path, bytes).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(path)
}
