//! Point clouds in files: KITTI `.bin`, PCD and PLY.
//!
//! | extension | format | read | written |
//! |---|---|---|---|
//! | `.bin` | [`kitti`]: x, y, z, intensity; read with rings too ([`kitti::parse_either`]) | yes | yes |
//! | `.xyzir.bin`, `.pcd.bin` (nuScenes) | [`kitti`] with the ring as a fifth number | yes | yes |
//! | `.pcd` | [`pcd`]: ASCII, binary, LZF-compressed | yes | binary |
//! | `.ply` | [`ply`] | no | binary, little-endian |
//!
//! With feature `cli`, `capture` reads pcap and pcapng files, which hold packets instead of points.
//!
//! Every reader takes the bytes and trusts none of them: memory is bounded by their number, not by what a header
//! claims, and an error says where, what was found and what was expected.
//!
//! ```
//! use flicr::files::{PointCloud, kitti, pcd};
//!
//! let cloud = PointCloud { points: vec![[1.0, 2.0, 3.0]], intensities: Some(vec![0.5]), ..Default::default() };
//! let mut bytes = Vec::new();
//! pcd::write(&mut bytes, &cloud)?;
//! assert_eq!(pcd::parse(&bytes)?, cloud);
//! let error = kitti::parse(&[0; 18]).unwrap_err();
//! assert_eq!(error.to_string(), "at byte 16: found 2 bytes after 1 point, expected records of 16 bytes");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "cli")]
pub mod capture;
mod error;
pub mod kitti;
pub mod pcd;
pub mod ply;
mod record;

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::vec::Vec;

pub use error::{Fault, FileError, ParseError};

/// Points with what a file says about them, in the file's order.
///
/// Points that are no return are kept as the file has them: KITTI's at the origin, PCD's with NaN coordinates.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloud {
    /// x, y, z, meters, sensor frame.
    pub points: Vec<[f32; 3]>,
    /// Intensity of each point in the file's own scale. `None` if the file has none, else one a point.
    pub intensities: Option<Vec<f32>>,
    /// Ring (beam) of each point in the file's own order. `None` if the file has none, else one a point.
    pub rings: Option<Vec<u16>>,
}

impl PointCloud {
    /// A point's intensity, 0 where there is none.
    fn intensity(&self, index: usize) -> f32 {
        self.intensities.as_ref().map_or(0.0, |intensities| intensities[index])
    }

    /// A point's ring, 0 where there is none.
    fn ring(&self, index: usize) -> u16 {
        self.rings.as_ref().map_or(0, |rings| rings[index])
    }

    /// Writers index all lists alike.
    fn check_lengths(&self) -> io::Result<()> {
        let points = self.points.len();
        let intensities = self.intensities.as_ref().map_or(points, Vec::len);
        let rings = self.rings.as_ref().map_or(points, Vec::len);
        if (intensities, rings) == (points, points) {
            return Ok(());
        }
        let text =
            std::format!("{intensities} intensities and {rings} rings for {points} points: expected one each a point");
        Err(io::Error::new(io::ErrorKind::InvalidInput, text))
    }
}

/// A file format, known by a file name's extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// `.bin`: [`kitti`].
    Kitti,
    /// `.xyzir.bin` and `.pcd.bin`: [`kitti`] with rings.
    KittiRing,
    /// `.pcd`: [`pcd`].
    Pcd,
    /// `.ply`: [`ply`].
    Ply,
}

impl Format {
    /// The format that a file name's extension stands for, in upper or lower case; `None` for any other.
    ///
    /// ```
    /// use flicr::files::Format;
    /// assert_eq!(Format::of("scans/0.BIN".as_ref()), Some(Format::Kitti));
    /// assert_eq!(Format::of("scans/0.las".as_ref()), None);
    /// ```
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
        let extensions = [
            // The longer first: both end in `.bin`.
            (".xyzir.bin", Self::KittiRing),
            // nuScenes.
            (".pcd.bin", Self::KittiRing),
            (".bin", Self::Kitti),
            (".pcd", Self::Pcd),
            (".ply", Self::Ply),
        ];
        let known = extensions.into_iter().find(|(extension, _)| name.ends_with(extension));
        known.map(|(_, format)| format)
    }
}

/// Reads a file in the format of its extension: `.bin` (with rings or without), `.xyzir.bin`, `.pcd.bin` or `.pcd`.
///
/// # Errors
/// [`FileError::Extension`] for any other, [`FileError::Io`] if the file cannot be read, [`FileError::Parse`] if it is
/// not what its extension says.
pub fn read(path: &Path) -> Result<PointCloud, FileError> {
    let parse = match Format::of(path) {
        Some(Format::Kitti) => kitti::parse_either,
        Some(Format::KittiRing) => kitti::parse_with_rings,
        Some(Format::Pcd) => pcd::parse,
        _ => return Err(FileError::extension(path, ".bin, .xyzir.bin or .pcd")),
    };
    let bytes = fs::read(path).map_err(|error| FileError::io(path, error))?;
    parse(&bytes).map_err(|error| FileError::parse(path, error))
}

/// Writes a file in the format of its extension: `.bin`, `.xyzir.bin`, `.pcd` or `.ply`.
///
/// # Errors
/// [`FileError::Extension`] for any other; [`FileError::Io`] if the file cannot be written, or if the cloud has not one
/// intensity and one ring a point where it has any.
pub fn write(path: &Path, cloud: &PointCloud) -> Result<(), FileError> {
    let write = match Format::of(path) {
        Some(Format::Kitti) => kitti::write,
        Some(Format::KittiRing) => kitti::write_with_rings,
        Some(Format::Pcd) => pcd::write,
        Some(Format::Ply) => ply::write,
        None => return Err(FileError::extension(path, ".bin, .xyzir.bin, .pcd or .ply")),
    };
    cloud
        .check_lengths()
        .and_then(|()| File::create(path))
        .and_then(|file| {
            let mut out = BufWriter::new(file);
            write(&mut out, cloud)?;
            out.flush()
        })
        .map_err(|error| FileError::io(path, error))
}
