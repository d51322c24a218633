//! Scans out of files, whatever their format.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flicr::files::{self, Format, PointCloud};

use crate::capture::{CaptureArgs, CapturedTurn, Turns};
use crate::failure::Failure;
use crate::sensors::Asked;

/// What the reading commands say of their input.
pub const SCAN_EXTENSIONS: &str = ".bin, .xyzir.bin, .pcd, .pcap or .pcapng";

/// One turn of a sensor.
#[derive(Debug, Clone, Default)]
pub struct Scan {
    /// As the file has them, points at the origin (no return) included.
    pub cloud: PointCloud,
    /// When the turn began; 0 where the file does not say.
    pub timestamp_ns: u64,
    /// The same in the sensor's integers, where it was packets.
    pub turn: Option<CapturedTurn>,
}

impl Scan {
    /// The points that something was measured at: not at the origin, not NaN. As the library counts them.
    pub fn returns(&self) -> Vec<[f32; 3]> {
        let measured = |&&[x, y, z]: &&[f32; 3]| {
            [x, y, z].iter().all(|coordinate| coordinate.is_finite()) && x * x + y * y + z * z > 0.0
        };
        self.cloud.points.iter().filter(measured).copied().collect()
    }

    /// The file, and the turn where it holds several.
    pub fn name(&self, file: &Path) -> String {
        match &self.turn {
            Some(CapturedTurn { number, layer: 0, .. }) => format!("{} turn {number}", file.display()),
            Some(CapturedTurn { number, .. }) => format!("{} turn {number}, other returns", file.display()),
            None => file.display().to_string(),
        }
    }
}

/// The scans of a file, one after the other: point files hold one each, captures one a turn.
pub enum Scans {
    Cloud { cloud: Option<PointCloud>, complaint: Option<String> },
    Turns { turns: Box<Turns>, args: CaptureArgs, file: PathBuf, found: usize, given: usize },
}

/// Opens a file of scans.
pub fn scans(file: &Path, args: &CaptureArgs, asked: Option<&Asked>) -> Result<Scans, Failure> {
    check_scan_extension(file)?;
    if !is_capture(file) {
        let cloud = files::read(file)?;
        let complaint = five_floats(file, &cloud).then(|| FIVE_FLOATS.to_owned());
        return Ok(Scans::Cloud { cloud: Some(cloud), complaint });
    }
    let turns = Box::new(Turns::open(file, args, asked)?);
    Ok(Scans::Turns { turns, args: args.clone(), file: file.into(), found: 0, given: 0 })
}

const FIVE_FLOATS: &str = "read as five floats a point (every fifth is a ring), not as KITTI's four";

/// Whether a file had rings that its name does not promise.
fn five_floats(file: &Path, cloud: &PointCloud) -> bool {
    Format::of(file) == Some(Format::Kitti) && cloud.rings.is_some()
}

impl Scans {
    /// What was wrong with a capture, as far as it was read, or unusual about a file of points.
    pub fn complaint(&self) -> Option<String> {
        match self {
            Self::Turns { turns, .. } => turns.complaint(),
            Self::Cloud { complaint, .. } => complaint.clone(),
        }
    }
}

impl Iterator for Scans {
    type Item = Result<Scan, Failure>;

    fn next(&mut self) -> Option<Self::Item> {
        let (turns, args, file, found, given) = match self {
            Self::Cloud { cloud, .. } => return cloud.take().map(|cloud| Ok(Scan { cloud, ..Scan::default() })),
            Self::Turns { turns, args, file, found, given } => (turns, args, file, found, given),
        };
        for scan in turns.by_ref() {
            let mut scan = match scan {
                Ok(scan) => scan,
                error => return Some(error),
            };
            let Some(turn) = scan.turn.as_mut().filter(|turn| turn.is_whole || args.partial) else { continue };
            // Both layers of a turn have its number.
            *found += usize::from(turn.layer == 0);
            turn.number = *found - 1;
            if args.turn.is_some_and(|wanted| wanted < turn.number) {
                return None;
            }
            if args.turn.is_none_or(|wanted| wanted == turn.number) {
                *given += 1;
                return Some(Ok(scan));
            }
        }
        if *given > 0 {
            return None;
        }
        // Said once: what follows an error is nothing.
        *given = 1;
        Some(Err(no_turn(file, args, *found)))
    }
}

fn no_turn(file: &Path, args: &CaptureArgs, found: usize) -> Failure {
    match args.turn {
        Some(wanted) if found > 0 => {
            Failure::usage(file, format_args!("no turn {wanted}: found {found} turns, numbered from 0"))
        }
        _ => Failure::data(file, "found no whole turn, expected one (--partial also takes those that are cut)"),
    }
}

/// Whether a file holds packets.
pub fn is_capture(file: &Path) -> bool {
    let extension = file.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    extension.is_some_and(|extension| extension == "pcap" || extension == "pcapng")
}

/// Refuses what [`scans`] would not know how to read, before any work is done.
pub fn check_scan_extension(file: &Path) -> Result<(), Failure> {
    match Format::of(file) {
        Some(Format::Kitti | Format::KittiRing | Format::Pcd) => Ok(()),
        _ if is_capture(file) => Ok(()),
        _ => Err(Failure::usage(file, format_args!("unknown kind of file: expected {SCAN_EXTENSIONS}"))),
    }
}

/// As [`check_scan_extension`], for many.
pub fn check_scan_extensions(files: &[PathBuf]) -> Result<(), Failure> {
    files.iter().try_for_each(|file| check_scan_extension(file))
}

/// Whether a file holds frames: by its name, else by its first bytes.
pub fn holds_frames(file: &Path) -> Result<bool, Failure> {
    if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("flicr")) {
        return Ok(true);
    }
    let mut start = Vec::new();
    let read = File::open(file).and_then(|open| open.take(4).read_to_end(&mut start));
    read.map_err(|error| Failure::data(file, error))?;
    Ok(start == flicr::frame::MAGIC)
}
