//! Emulated boards: what runs on them, and what it prints.

use std::path::Path;

use libtest_mimic::Failed;

pub use crate::boards::Board;
use crate::boards::boards;
use crate::firmware::{root, run, tool};

pub static BOARDS: [Board; 4] = boards("cortex_m", "aarch64");

impl Board {
    /// Runs the firmware and gives what it printed.
    pub fn run(
        &'static self,
        scan: &Path,
        out_prefix: &Path,
        frames: impl Iterator<Item = String>,
    ) -> Result<String, Failed> {
        let firmware = self.built()?;
        let mut emulator = tool("emulate.sh");
        Ok(run(emulator.arg(self.name).arg(firmware).arg(scan).arg(out_prefix).args(frames))?)
    }

    /// Compares with the file beside the firmware's source.
    pub fn check_printed(&self, printed: &str) -> Result<(), Failed> {
        let expected_path = root().join("examples").join(self.firmware.example).join("qemu.out");
        check_golden(&expected_path, printed)
    }
}

/// Compares with a file, or writes it where `FLICR_BLESS` is set.
pub fn check_golden(expected_path: &Path, printed: &str) -> Result<(), Failed> {
    if std::env::var_os("FLICR_BLESS").is_some() {
        return Ok(std::fs::write(expected_path, printed)?);
    }
    let expected = std::fs::read_to_string(expected_path).unwrap_or_default();
    if printed == expected {
        return Ok(());
    }
    let path = expected_path.display();
    Err(format!("printed:\n{printed}but {path} says:\n{expected}`make bless` accepts what was printed").into())
}
