//! Why a command failed, and the exit code that says so.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use flicr::files::FileError;

/// Everything that ends a command early.
#[derive(Debug)]
pub enum Failure {
    /// A file that is missing, damaged or not what was expected: exit code 1.
    Data(String),
    /// Something asked for that cannot be: exit code 2, as clap's own.
    Usage(String),
    /// Whoever reads the output has seen enough (`flicr eval ... | head`): no failure at all.
    OutputClosed,
}

impl Failure {
    /// `FILE: what was wrong`, for a file's contents.
    pub fn data(file: &Path, wrong: impl Display) -> Self {
        Self::Data(format!("{}: {wrong}", file.display()))
    }

    /// `FILE: what was wrong`, for a file that should not have been named.
    pub fn usage(file: &Path, wrong: impl Display) -> Self {
        Self::Usage(format!("{}: {wrong}", file.display()))
    }

    /// Says on stderr what was wrong and gives the exit code.
    pub fn report(&self) -> ExitCode {
        match self {
            Self::Data(text) => say(text, 1),
            Self::Usage(text) => say(text, 2),
            Self::OutputClosed => ExitCode::SUCCESS,
        }
    }
}

fn say(text: &str, code: u8) -> ExitCode {
    // Where stderr is closed, the exit code has to do.
    let _ = writeln!(io::stderr(), "flicr: {text}");
    ExitCode::from(code)
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        match error {
            FileError::Extension { .. } => Self::Usage(error.to_string()),
            _ => Self::Data(error.to_string()),
        }
    }
}

/// Of writing to stdout.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::OutputClosed,
            _ => Self::Data(format!("standard output: {error}")),
        }
    }
}
