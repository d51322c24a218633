//! Emulated boards, and the firmware of each.

use std::path::PathBuf;
use std::sync::OnceLock;

use crate::firmware::Firmware;

/// A board, and what runs on it.
pub struct Board {
    /// What `tools/emulate.sh` calls it.
    pub name: &'static str,
    emulator: &'static str,
    pub firmware: Firmware,
    built: OnceLock<Result<PathBuf, String>>,
}

/// All boards, with one example for those of Thumb-2 and one for AArch64.
pub const fn boards(thumb: &'static str, aarch64: &'static str) -> [Board; 4] {
    [
        board("m4f", "qemu-system-arm", thumb, "thumbv7em-none-eabihf"),
        board("m7", "qemu-system-arm", thumb, "thumbv7em-none-eabihf"),
        board("m33", "qemu-system-arm", thumb, "thumbv8m.main-none-eabihf"),
        board("a53", "qemu-system-aarch64", aarch64, "aarch64-unknown-none"),
    ]
}

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

    /// The firmware's file, built when first asked for.
    pub fn built(&'static self) -> Result<&'static PathBuf, String> {
        self.built.get_or_init(|| self.firmware.build()).as_ref().map_err(Clone::clone)
    }
}
