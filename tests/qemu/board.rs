//! Emulated boards: what runs on them, and what it prints.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use libtest_mimic::Failed;

use crate::firmware::{Firmware, root, run, tool};

/// A board, and what runs on it.
pub struct Board {
    /// What `tools/emulate.sh` calls it.
    pub name: &'static str,
    emulator: &'static str,
    firmware: Firmware,
    built: OnceLock<Result<PathBuf, String>>,
}

pub static BOARDS: [Board; 4] = [
    board("m4f", "qemu-system-arm", "cortex_m", "thumbv7em-none-eabihf"),
    board("m7", "qemu-system-arm", "cortex_m", "thumbv7em-none-eabihf"),
    board("m33", "qemu-system-arm", "cortex_m", "thumbv8m.main-none-eabihf"),
    board("a53", "qemu-system-aarch64", "aarch64", "aarch64-unknown-none"),
];

const fn board(name: &'static str, emulator: &'static str, example: &'static str, target: &'static str) -> Board {
    Board { name, emulator, firmware: Firmware { example, target }, built: OnceLock::new() }
}

impl Board {
    /// What is needed to run it and not on this machine.
    pub fn missing(&self) -> Option<String> {
        self.firmware.missing(self.emulator)
    }

    /// Whether its instructions are Thumb-2.
    pub fn is_thumb(&self) -> bool {
        self.firmware.target.starts_with("thumb")
    }

    /// Runs the firmware and gives what it printed.
    pub fn run(
        &'static self,
        scan: &Path,
        out_prefix: &Path,
        frames: impl Iterator<Item = String>,
    ) -> Result<String, Failed> {
        let firmware = self.built.get_or_init(|| self.firmware.build()).as_ref()?;
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
