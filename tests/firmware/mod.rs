//! Firmware examples, built for their target.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A firmware example and the target to build it for.
pub struct Firmware {
    /// Name of the example.
    pub example: &'static str,
    /// Rust's name of the target.
    pub target: &'static str,
}

impl Firmware {
    /// Builds it and gives its path.
    pub fn build(&self) -> Result<PathBuf, String> {
        let arguments =
            ["build", "--quiet", "--profile", "firmware", "--example", self.example, "--target", self.target];
        run(tool("cross.sh").args(arguments))?;
        let folder = run(tool("cross.sh").args(["--target-dir", self.target]))?;
        Ok(PathBuf::from(folder.trim()).join(self.target).join("firmware/examples").join(self.example))
    }

    /// What is needed and not on this machine: the target, or the command `program`.
    pub fn missing(&self, program: &str) -> Option<String> {
        let target = run(tool("cross.sh").args(["--way", self.target]));
        if std::env::var_os("FLICR_EMULATED").is_some() {
            Some("emulator inside an emulator".into())
        } else if target.is_err() {
            Some(format!("core library for {}", self.target))
        } else {
            run(Command::new(program).arg("--version")).is_err().then(|| program.to_owned())
        }
    }
}

/// Whether tests whose tools are `missing` are to be skipped. They are not where `FLICR_REQUIRE_QEMU` is set: there
/// they run, and fail. Prints a line for what is skipped.
pub fn is_skipped(missing: Option<String>) -> bool {
    let Some(missing) = missing.filter(|_| std::env::var_os("FLICR_REQUIRE_QEMU").is_none()) else {
        return false;
    };
    println!("skipped: no {missing} (tools/setup.sh installs what can be installed)");
    true
}

/// The crate's folder.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// One of the project's scripts.
pub fn tool(script: &str) -> Command {
    Command::new(root().join("tools").join(script))
}

/// What a command prints; what it complains of where it fails.
pub fn run(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    text_of(&output).ok_or_else(|| format!("{command:?}: {}\n{}", output.status, all_text_of(&output)))
}

fn text_of(output: &Output) -> Option<String> {
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

fn all_text_of(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text)).concat()
}
