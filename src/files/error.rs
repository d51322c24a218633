//! Why a file was not read or written.

use core::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::string::{String, ToString};

/// What a parser met that a well-formed file has not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParseError {
    /// The kind of fault, to tell them apart in code.
    pub fault: Fault,
    /// Byte of the input that the fault was found at.
    pub offset: usize,
    /// What was found there, for people.
    pub found: String,
    /// What was expected, for people.
    pub expected: String,
}

/// Kinds of [`ParseError`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The input's length is not a multiple of a point's.
    Length,
    /// A header line is missing, repeated, unknown or says something it cannot.
    Header,
    /// The fields do not describe points with x, y and z.
    Fields,
    /// The header's numbers of points contradict each other.
    PointCount,
    /// The input ends before its last point.
    Truncated,
    /// The input goes on after its last point.
    TrailingBytes,
    /// A value that is no number, or out of its field's range.
    Value,
    /// Compressed data that no compressor makes.
    Compressed,
}

/// Longest piece of a file that an error repeats.
const QUOTE_LEN: usize = 40;

impl ParseError {
    pub(super) fn new(fault: Fault, offset: usize, found: impl fmt::Display, expected: impl fmt::Display) -> Self {
        Self { fault, offset, found: found.to_string(), expected: expected.to_string() }
    }
}

/// Text of the file in quotes, cut where it is long.
pub(super) fn quote(text: &str) -> String {
    let shown: String = text.chars().take(QUOTE_LEN).collect();
    let cut = if shown.len() < text.len() { "…" } else { "" };
    std::format!("{shown:?}{cut}")
}

/// "1 byte", "2 bytes".
pub(super) fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    std::format!("{count} {noun}{plural}")
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { offset, found, expected, .. } = self;
        write!(f, "at byte {offset}: found {found}, expected {expected}")
    }
}

impl core::error::Error for ParseError {}

/// Why a file was not read or written.
#[derive(Debug)]
#[non_exhaustive]
pub enum FileError {
    /// The operating system's reason.
    Io {
        /// The file.
        path: PathBuf,
        /// The reason.
        error: io::Error,
    },
    /// An extension that stands for no format that can be read, or written.
    Extension {
        /// The file.
        path: PathBuf,
        /// Extensions that can.
        expected: &'static str,
    },
    /// The file is not what its extension says.
    Parse {
        /// The file.
        path: PathBuf,
        /// Where and why not.
        error: ParseError,
    },
}

impl FileError {
    pub(super) fn io(path: &Path, error: io::Error) -> Self {
        Self::Io { path: path.into(), error }
    }

    pub(super) fn extension(path: &Path, expected: &'static str) -> Self {
        Self::Extension { path: path.into(), expected }
    }

    pub(super) fn parse(path: &Path, error: ParseError) -> Self {
        Self::Parse { path: path.into(), error }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Extension { path, expected } => {
                write!(f, "{}: expected a file name that ends in {expected}", path.display())
            }
            Self::Parse { path, error } => write!(f, "{}: {error}", path.display()),
        }
    }
}

impl core::error::Error for FileError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => Some(error),
            Self::Parse { error, .. } => Some(error),
            Self::Extension { .. } => None,
        }
    }
}
