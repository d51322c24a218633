//! The host's files and terminal, by semihosting.

use core::fmt;

use flicr::StridedPoints;
use heapless::{CString, String};
use semihosting::fs::{self, File};
use semihosting::io::{self, Read, Write};

use super::Fault;
use super::job::{Job, Usage};

/// Bytes of a point in a scan: x, y, z and intensity as little-endian `f32`, as in KITTI's files.
const POINT_LEN: usize = 16;
/// Bytes of a scan that are read at a time.
pub const PIECE_LEN: usize = 2048 * POINT_LEN;
const LINE_LEN: usize = 256;
const PATH_LEN: usize = 256;

/// A scan that is read piece by piece, so that it need not fit into the board's memory.
pub struct Scan<'a> {
    file: File,
    piece: &'a mut [u8; PIECE_LEN],
}

impl<'a> Scan<'a> {
    pub fn open(path: &str, piece: &'a mut [u8; PIECE_LEN]) -> Result<Self, Fault> {
        Ok(Self { file: File::open(c_path(path)?)?, piece })
    }

    /// The next points; `None` behind the last.
    pub fn next_points(&mut self) -> Result<Option<StridedPoints<'_>>, Fault> {
        let len = fill(&mut self.file, self.piece)?;
        let points = StridedPoints::new(self.piece.get(..len).unwrap_or_default(), POINT_LEN);
        match points {
            Some(points) if points.remainder_len() > 0 => Err(Fault::TornPoint),
            points => Ok(points.filter(|points| !points.is_empty())),
        }
    }
}

/// Packets that are read one by one: each its length, two bytes, little endian, and its payload.
pub struct Packets<'a> {
    file: File,
    packet: &'a mut [u8; PIECE_LEN],
}

impl<'a> Packets<'a> {
    pub fn open(path: &str, packet: &'a mut [u8; PIECE_LEN]) -> Result<Self, Fault> {
        Ok(Self { file: File::open(c_path(path)?)?, packet })
    }

    /// The next payload; `None` behind the last.
    pub fn next_packet(&mut self) -> Result<Option<&[u8]>, Fault> {
        let mut len = [0; 2];
        if fill(&mut self.file, &mut len)? < len.len() {
            return Ok(None);
        }
        let packet = self.packet.get_mut(..usize::from(u16::from_le_bytes(len))).ok_or(Fault::TornPacket)?;
        let read = fill(&mut self.file, packet)?;
        if read == packet.len() { Ok(Some(packet)) } else { Err(Fault::TornPacket) }
    }
}

/// Reads until `buffer` is full or the file ends.
fn fill(file: &mut File, buffer: &mut [u8]) -> io::Result<usize> {
    let mut len = 0;
    while let Some(rest) = buffer.get_mut(len..).filter(|rest| !rest.is_empty()) {
        match file.read(rest)? {
            0 => break,
            read => len += read,
        }
    }
    Ok(len)
}

/// Writes a frame where the job wants it: `OUT_PREFIX-COLUMNS-CODER.flicr`, or
/// `OUT_PREFIX-native-CODER-STEP.flicr`.
pub fn write_frame(job: &Job<'_>, frame: &[u8]) -> Result<(), Fault> {
    Ok(fs::write(frame_path(job)?, frame)?)
}

/// The same file, for frames one behind the other.
pub fn create_frames(job: &Job<'_>) -> Result<File, Fault> {
    Ok(File::create(frame_path(job)?)?)
}

fn frame_path(job: &Job<'_>) -> Result<CString<PATH_LEN>, Usage> {
    let mut path = String::<PATH_LEN>::new();
    write_path(job, &mut path).map_err(|_| Usage::PathTooLong)?;
    c_path(&path)
}

fn write_path(job: &Job<'_>, path: &mut impl fmt::Write) -> fmt::Result {
    write!(path, "{}-", job.out_prefix)?;
    job.write_name(path)?;
    path.write_str(".flicr")
}

fn c_path(path: &str) -> Result<CString<PATH_LEN>, Usage> {
    CString::from_bytes_truncating_at_nul(path.as_bytes()).map_err(|_| Usage::PathTooLong)
}

/// Prints a line by one call to the host; by `println!` each number would be a call of its own.
pub fn print_line(line: fmt::Arguments<'_>) {
    let mut text = String::<LINE_LEN>::new();
    let whole = fmt::write(&mut text, line).is_ok() && text.push('\n').is_ok();
    if let Ok(mut stdout) = io::stdout() {
        // There is nobody to tell that telling failed.
        let _ = stdout.write_all(text.as_bytes());
        if !whole {
            let _ = stdout.write_all(b"...\n");
        }
    }
}
