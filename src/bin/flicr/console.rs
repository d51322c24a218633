//! What the user sees besides files: lines on stdout, and progress on stderr where a terminal watches.

use std::fmt::Display;
use std::io::{self, Write};

use indicatif::{ProgressBar, ProgressStyle};

use crate::failure::Failure;

/// A bar of `len` steps on stderr; hidden, and silent, where stderr is no terminal.
pub fn progress(len: usize, doing: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} [{bar:40}] {pos}/{len}, {eta} left");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(len as u64).with_style(style.progress_chars("=> ")).with_message(doing)
}

/// One line on stdout, above the bar.
pub fn line(bar: &ProgressBar, text: impl Display) -> Result<(), Failure> {
    bar.suspend(|| writeln!(io::stdout(), "{text}"))?;
    Ok(())
}

/// Something worth knowing on stderr, above the bar: what was chosen, what was passed over.
pub fn note(bar: &ProgressBar, text: impl Display) {
    // Where stderr is closed, nobody wants to know.
    bar.suspend(|| drop(writeln!(io::stderr(), "note: {text}")));
}

/// For commands that have a file to finish, whoever reads their lines.
pub fn line_if_read(bar: &ProgressBar, text: impl Display) -> Result<(), Failure> {
    match line(bar, text) {
        Err(Failure::OutputClosed) => Ok(()),
        result => result,
    }
}
