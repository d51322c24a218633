//! `.flicr` files: one frame or more, back to back.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use flicr::{DecodeError, frame};

use crate::failure::Failure;

/// A file of frames, cut but not decoded.
pub struct FrameFile {
    path: PathBuf,
    bytes: Vec<u8>,
    cuts: Vec<Range<usize>>,
    /// Why the file could not be cut to its end.
    damage: Option<DecodeError>,
}

impl FrameFile {
    /// Reads a file and cuts it at the lengths its frames give themselves, as far as these can be believed.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = fs::read(path).map_err(|error| Failure::data(path, error))?;
        if bytes.is_empty() {
            return Err(Failure::data(path, "found no bytes, expected a frame"));
        }
        let (mut cuts, mut damage, mut at) = (Vec::new(), None, 0);
        while at < bytes.len() && damage.is_none() {
            match cut_one(&bytes[at..]) {
                Ok(len) => cuts.push(at..at + len),
                Err(error) => damage = Some(error),
            }
            at = cuts.last().map_or(at, |cut: &Range<usize>| cut.end);
        }
        Ok(Self { path: path.into(), bytes, cuts, damage })
    }

    /// As [`read`](Self::read), where a file that is damaged anywhere is of no use.
    pub fn read_whole(path: &Path) -> Result<Self, Failure> {
        let file = Self::read(path)?;
        file.check_end()?;
        Ok(file)
    }

    /// Frames.
    pub fn len(&self) -> usize {
        self.cuts.len()
    }

    /// Number, first byte and bytes of each frame.
    pub fn frames(&self) -> impl Iterator<Item = (usize, usize, &[u8])> {
        self.cuts.iter().enumerate().map(|(number, cut)| (number, cut.start, &self.bytes[cut.clone()]))
    }

    /// The bytes of one frame.
    pub fn frame(&self, number: usize) -> Result<&[u8], Failure> {
        let frame = self.cuts.get(number).map(|cut| &self.bytes[cut.clone()]);
        frame.ok_or_else(|| {
            let wrong = format!("no frame {number}: found {} frames, numbered from 0", self.len());
            Failure::Usage(format!("{}: {wrong}", self.path.display()))
        })
    }

    /// Whether the frames reach to the end of the file.
    pub fn check_end(&self) -> Result<(), Failure> {
        self.damage.map_or(Ok(()), |error| Err(self.damaged(self.len(), error)))
    }

    /// What is wrong with a frame, and where in the file it begins.
    pub fn damaged(&self, number: usize, error: DecodeError) -> Failure {
        let at = self.cuts.get(number).map(|cut| cut.start);
        let at = at.or_else(|| self.cuts.last().map(|cut| cut.end)).unwrap_or_default();
        Failure::data(&self.path, format_args!("frame {number} at byte {at}: {error}"))
    }
}

/// Length of the frame that `bytes` starts with. Its checksum is looked at: a damaged length would put the blame on the
/// frame behind.
fn cut_one(bytes: &[u8]) -> Result<usize, DecodeError> {
    let len = frame::frame_len(bytes)?;
    frame::parse(bytes.get(..len).unwrap_or_default())?;
    Ok(len)
}
