//! On AArch64 the projection is made of vector instructions, four points at a time: read off the disassembled firmware
//! (`examples/aarch64`), so that no compiler and no harmless-looking change can take that away unseen.
//!
//! Without the cross toolchain the test is skipped and counted as ignored; with `FLICR_REQUIRE_QEMU` it fails.

mod firmware;

use std::process::{Command, ExitCode};

use libtest_mimic::{Arguments, Failed, Trial};

use firmware::Firmware;

/// The function that does the projection's arithmetic.
const KERNEL: &str = "flicr::kernel::uniform::project_uniform";

/// What that arithmetic cannot do without; `fcvtz` is both `fcvtzs` and `fcvtzu`.
const NEEDED: [&str; 5] = ["fadd", "fmul", "fdiv", "fsqrt", "fcvtz"];

/// Instructions that would cost four times as much one by one.
const NOT_ONE_BY_ONE: [&str; 2] = ["fdiv", "fsqrt"];

const OBJDUMP: &str = "aarch64-linux-gnu-objdump";
const FIRMWARE: Firmware = Firmware { example: "aarch64", target: "aarch64-unknown-none" };

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let skip = firmware::is_skipped(FIRMWARE.missing(OBJDUMP));
    let trial = Trial::test("projection_is_vectorized", projection_is_vectorized).with_ignored_flag(skip);
    libtest_mimic::run(&arguments, vec![trial]).exit_code()
}

fn projection_is_vectorized() -> Result<(), Failed> {
    let path = FIRMWARE.build()?;
    let listing = firmware::run(Command::new(OBJDUMP).args(["-d", "--demangle=rust", "--no-show-raw-insn"]).arg(path))?;
    let instructions = instructions_of(KERNEL, &listing);
    if instructions.is_empty() {
        return Err(format!("no function {KERNEL} in the firmware").into());
    }
    let vector = |name: &&str| instructions.iter().any(|it| it.name.starts_with(*name) && it.is_on_four_floats());
    let scalar = |name: &&str| instructions.iter().any(|it| it.name.starts_with(*name) && it.is_on_one_float());
    if let Some(name) = NEEDED.iter().find(|name| !vector(name)) {
        return Err(format!("no vector {name} in {KERNEL}").into());
    }
    if let Some(name) = NOT_ONE_BY_ONE.iter().find(|name| scalar(name)) {
        return Err(format!("a scalar {name} in {KERNEL}").into());
    }
    Ok(())
}

/// A line of a disassembly: `40082040:  fmul  v0.4s, v1.4s, v2.4s`.
struct Instruction<'a> {
    name: &'a str,
    operands: &'a str,
}

impl<'a> Instruction<'a> {
    fn parse(line: &'a str) -> Option<Self> {
        let (_, text) = line.split_once(":\t")?;
        let (name, operands) = text.trim().split_once(char::is_whitespace)?;
        Some(Self { name, operands: operands.trim() })
    }

    fn is_on_four_floats(&self) -> bool {
        self.operands.contains(".4s")
    }

    fn is_on_one_float(&self) -> bool {
        self.operands.starts_with('s')
    }
}

/// The instructions of all functions of that name: a generic one may be there several times.
fn instructions_of<'a>(function: &str, listing: &'a str) -> Vec<Instruction<'a>> {
    let is_function = |block: &&str| block.lines().next().is_some_and(|heading| is_heading_of(function, heading));
    listing.split("\n\n").filter(is_function).flat_map(str::lines).filter_map(Instruction::parse).collect()
}

/// `0000000040082040 <flicr::kernel::uniform::project_uniform>:`, with type arguments or not.
fn is_heading_of(function: &str, heading: &str) -> bool {
    let named = heading.split_once('<').and_then(|(_, named)| named.strip_prefix(function));
    named.is_some_and(|rest| rest.starts_with('>') || rest.starts_with("::<"))
}
