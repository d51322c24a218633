//! Promise: C clients compile without a warning, get the bytes that Rust gets, and stay within their memory.
//!
//! The example client (`examples/c/encode.c`) is built and run twice: for AArch64, under qemu-aarch64, and for this
//! machine under AddressSanitizer and UndefinedBehaviorSanitizer.
//!
//! Without the cross tools a test is skipped and counted as ignored; with `FLICR_REQUIRE_QEMU` it fails.

#[path = "common/data.rs"]
mod data;
#[allow(dead_code, reason = "a part is for firmware")]
mod firmware;
#[path = "c/grid.rs"]
mod grid;
#[path = "c/stream.rs"]
mod stream;
#[path = "common/packet_writer.rs"]
mod writer;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use flicr::capi::{
    FLICR_ENCODER_ALIGN, flicr_encoder_size, flicr_grid_encoder_size, flicr_grid_worst_case_len,
    flicr_grid_worst_case_len_in_strips, flicr_stream_size, flicr_version, flicr_worst_case_len,
    flicr_worst_case_len_in_strips,
};
use flicr::coder::ContextSettings;
use flicr::{Coder, Config, DeflateDefault, DeflateDense, DeflateSmall, Dense, ImageViewMut, Rle, Scale, Small, Stamp};
use libtest_mimic::{Arguments, Failed, Trial};

use firmware::{is_skipped, root, run, tool};

const ROWS: usize = 64;
const STACK_FRAME_MAX: usize = 1536;
const STRICT: [&str; 7] = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-O1", "-g"];

/// A C compiler, the target whose library its programs are linked to, and what runs them.
#[derive(Clone, Copy)]
struct Client {
    name: &'static str,
    compiler: &'static str,
    target: &'static str,
    flags: &'static [&'static str],
    runner: &'static [&'static str],
}

const AARCH64: Client = Client {
    name: "aarch64",
    compiler: "aarch64-linux-gnu-gcc",
    target: "aarch64-unknown-linux-gnu",
    flags: &[],
    runner: &["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"],
};

const SANITIZED: Client = Client {
    name: "sanitized",
    compiler: "cc",
    target: HOST,
    flags: &["-fsanitize=address,undefined", "-fno-sanitize-recover=all"],
    runner: &[],
};

const HOST: &str = if cfg!(target_arch = "aarch64") { "aarch64-unknown-linux-gnu" } else { "x86_64-unknown-linux-gnu" };

/// Bare metal: nothing can be run there without firmware, but the header and the library can be looked at.
const BARE: [(&str, &str); 2] =
    [("thumbv7em-none-eabihf", "arm-none-eabi-"), ("aarch64-unknown-none", "aarch64-linux-gnu-")];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = Vec::new();
    for client in [SANITIZED, AARCH64] {
        let skip = is_skipped(missing(client.target, &[client.compiler, client.runner.first().unwrap_or(&"cc")]));
        let name = |what: &str| format!("{}::{what}", client.name);
        trials.push(Trial::test(name("made_up_scan"), move || bytes_are_rusts(client, None)).with_ignored_flag(skip));
        trials.push(Trial::test(name("packets"), move || grid::bytes_are_rusts(client)).with_ignored_flag(skip));
        trials.push(Trial::test(name("stream"), move || stream::datagrams_are_rusts(client)).with_ignored_flag(skip));
        let scan = data::FOLDER.as_ref().map(|folder| folder.join("kitti/drive/000000.bin"));
        let skip = skip || scan.is_none();
        trials.push(Trial::test(name("real_scan"), move || bytes_are_rusts(client, scan)).with_ignored_flag(skip));
    }
    // Only what is built with the command line has it.
    if let Some(flicr) = option_env!("CARGO_BIN_EXE_flicr") {
        let skip = is_skipped(missing(HOST, &["cc"]));
        let receives = move || stream::flicr_receives_it(SANITIZED, flicr);
        trials.push(Trial::test("sanitized::stream_to_flicr_receive", receives).with_ignored_flag(skip));
    }
    for by in ["cmake", "pkg-config"] {
        let skip = is_skipped(missing(HOST, &["cc", by]));
        trials.push(Trial::test(format!("found_by_{by}"), move || stream::is_found(by)).with_ignored_flag(skip));
    }
    for (compiler, standard) in [("cc", "-std=c99"), ("c++", "-std=c++11")] {
        let skip = is_skipped(missing(HOST, &[compiler]));
        let trial = Trial::test(format!("sizes{standard}"), move || macros_are_right(compiler, standard));
        trials.push(trial.with_ignored_flag(skip));
    }
    for (target, tools) in BARE {
        let skip = is_skipped(missing(target, &[&format!("{tools}nm"), &format!("{tools}gcc")]));
        let trial = Trial::test(format!("{target}::no_panic"), move || nothing_panics(target, tools));
        trials.push(trial.with_ignored_flag(skip));
        let trial = Trial::test(format!("{target}::header"), move || header_compiles(&format!("{tools}gcc")));
        trials.push(trial.with_ignored_flag(skip));
    }
    let (target, tools) = BARE[0];
    let skip = is_skipped(missing(target, &[&format!("{tools}objdump")]));
    let trial = Trial::test(format!("{target}::stack_frames"), move || stack_frames_are_small(target, tools));
    trials.push(trial.with_ignored_flag(skip));
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// What is needed and not on this machine.
fn missing(target: &str, programs: &[&str]) -> Option<String> {
    if std::env::var_os("FLICR_EMULATED").is_some() {
        return Some("emulator inside an emulator".into());
    }
    if run(tool("cross.sh").args(["--way", target])).is_err() {
        return Some(format!("core library for {target}"));
    }
    let is_missing = |program: &&&str| run(Command::new(program).arg("--version")).is_err();
    programs.iter().find(is_missing).map(|program| (*program).to_owned())
}

fn library(target: &str) -> Result<PathBuf, String> {
    run(tool("staticlib.sh").arg(target)).map(|path| PathBuf::from(path.trim()))
}

fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("c_client-{name}"))
}

fn compile(compiler: &str, flags: &[&str], source: &str, out: &Path) -> Command {
    let mut command = Command::new(compiler);
    command.args(STRICT).args(flags).arg("-I").arg(root().join("include")).arg(root().join(source));
    command.arg("-o").arg(out);
    command
}

impl Client {
    /// Runs the example on a scan, or the one that it makes up, and gives where its files are.
    fn run(&self, scan: Option<&Path>) -> Result<PathBuf, String> {
        let out_prefix = scratch(&format!("{}-{}", self.name, if scan.is_some() { "real" } else { "made-up" }));
        self.run_example("encode", &out_prefix, scan)?;
        Ok(out_prefix)
    }

    /// Runs an example.
    fn run_example(&self, name: &str, out_prefix: &Path, input: Option<&Path>) -> Result<(), String> {
        let program = out_prefix.with_extension("elf");
        let flags = [self.flags, &["-std=c99"]].concat();
        run(compile(self.compiler, &flags, &format!("examples/c/{name}.c"), &program).arg(library(self.target)?))?;
        let words = self.runner.iter().map(AsRef::as_ref).chain([program.as_os_str(), out_prefix.as_os_str()]);
        let words: Vec<_> = words.chain(input.map(Path::as_os_str)).collect();
        run(Command::new(words[0]).args(&words[1..]))?;
        Ok(())
    }
}

fn bytes_are_rusts(client: Client, scan: Option<PathBuf>) -> Result<(), Failed> {
    let out_prefix = client.run(scan.as_deref())?;
    let file = |name: &str| PathBuf::from(format!("{}-{name}", out_prefix.display()));
    let points = data::read_points(&scan.unwrap_or_else(|| file("scan.bin")));
    for columns in [4500, 256] {
        for (name, expected) in frames(columns, &points) {
            let from_c = std::fs::read(file(&format!("{columns}-{name}.flicr")))?;
            if from_c != expected {
                return Err(format!("{columns} {name}: {} bytes, Rust's {}", from_c.len(), expected.len()).into());
            }
        }
    }
    Ok(())
}

/// The frames that the example makes.
fn frames(columns: usize, points: &[[f32; 4]]) -> [(&'static str, Vec<u8>); 6] {
    [
        ("rle", encode(columns, points, Rle::new())),
        ("deflate", encode(columns, points, DeflateDefault::new())),
        ("deflate-small", encode(columns, points, DeflateSmall::new())),
        ("deflate-dense", encode(columns, points, DeflateDense::new())),
        ("small", encode(columns, points, Small::<8>::new(ContextSettings::COARSE))),
        ("dense", encode(columns, points, Dense::<8>::new(ContextSettings::COARSE))),
    ]
}

fn encode<C: Coder<u8>>(columns: usize, points: &[[f32; 4]], mut coder: C) -> Vec<u8> {
    let config = Config { scale: Scale::Fixed { max_range_m: 80.0 }, ..Config::UNIFORM };
    let mut levels = vec![0_u8; ROWS * columns];
    let image = ImageViewMut::new(&mut levels, columns).expect("whole rows");
    let mut out = vec![0; flicr::frame::worst_case_len::<u8, C>(ROWS * columns)];
    let stamp = Stamp { sequence: 7, timestamp_ns: 1_000_000_000 };
    let encoded = flicr::encode(&config, points, stamp, image, &mut coder, &mut out).expect("room for the worst case");
    out.truncate(encoded.len);
    out
}

fn macros_are_right(compiler: &str, standard: &str) -> Result<(), Failed> {
    let program = scratch(&format!("sizes{standard}"));
    run(&mut compile(compiler, &[standard, "-x", language(standard)], "tests/c/sizes.c", &program))?;
    let printed = run(&mut Command::new(program))?;
    let (sizes, last) = printed.trim_end().rsplit_once('\n').ok_or("one line")?;
    for line in sizes.lines() {
        let numbers: Vec<usize> = line.split(' ').map(str::parse).collect::<Result<_, _>>()?;
        let (of, found) = numbers.split_at(numbers.len() - 3);
        let of: Vec<u32> = of.iter().map(|&number| number as u32).collect();
        let expected = match of[..] {
            [beams, coder, aligned, _, _, _] => {
                let size = flicr_stream_size(beams, coder, aligned);
                [size, 0, size.div_ceil(8)]
            }
            [level_bits, columns, beams, coder, strips] => [
                flicr_worst_case_len_in_strips(columns, beams, coder, strips),
                flicr_grid_worst_case_len_in_strips(columns, beams, level_bits, coder, strips),
                strips as usize,
            ],
            [level_bits, columns, beams, coder] => {
                let size = flicr_grid_encoder_size(columns, beams, level_bits, coder);
                [size, flicr_grid_worst_case_len(columns, beams, level_bits, coder), size.div_ceil(8)]
            }
            _ => {
                let size = flicr_encoder_size(of[0], of[1], of[2]);
                [size, flicr_worst_case_len(of[0], of[1], of[2]), size.div_ceil(8)]
            }
        };
        if found != expected {
            return Err(format!("{line}: expected {expected:?}").into());
        }
    }
    let (memory, frame) = (flicr_encoder_size(4500, 64, 1).next_multiple_of(8), flicr_worst_case_len(4500, 64, 1));
    let expected = format!("version {} align {FLICR_ENCODER_ALIGN} memory {memory} frame {frame}", flicr_version());
    if last == expected { Ok(()) } else { Err(format!("{last}: expected {expected}").into()) }
}

fn language(standard: &str) -> &'static str {
    if standard.contains("++") { "c++" } else { "c" }
}

/// Nothing that could panic is left in a library for bare metal: not the checks that never fail, nor the text that
/// would be printed.
fn nothing_panics(target: &str, tools: &str) -> Result<(), Failed> {
    let listing = run(Command::new(format!("{tools}nm")).arg("-A").arg(library(target)?))?;
    let ours: Vec<&str> = listing.lines().filter(|line| line.contains("flicr-")).collect();
    if !ours.iter().any(|line| line.ends_with(" T flicr_stream_push_packet")) {
        return Err("no flicr_stream_push_packet in the library".into());
    }
    let panics: Vec<&str> = ours.into_iter().filter(|line| line.contains("panic")).collect();
    if panics.is_empty() { Ok(()) } else { Err(panics.join("\n").into()) }
}

/// Nothing is built on the stack that belongs into the caller's memory: coders are larger than a device's stack.
fn stack_frames_are_small(target: &str, tools: &str) -> Result<(), Failed> {
    let listing =
        run(Command::new(format!("{tools}objdump")).args(["-d", "--no-show-raw-insn"]).arg(library(target)?))?;
    let frames: Vec<usize> = listing.lines().filter_map(stack_taken_by).collect();
    match frames.iter().max() {
        None => Err("no function takes any stack: the listing has not been understood".into()),
        Some(&largest) if largest > STACK_FRAME_MAX => Err(format!("a stack frame of {largest} bytes").into()),
        Some(_) => Ok(()),
    }
}

/// Bytes in `sub sp, #336` or `sub.w sp, sp, #948 @ 0x3b4`.
fn stack_taken_by(line: &str) -> Option<usize> {
    let (_, instruction) = line.split_once(":\t")?;
    let operands = instruction.strip_prefix("sub")?.split_once("sp, ")?.1;
    let number = operands.trim_start_matches("sp, ").strip_prefix('#')?;
    number.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
}

fn header_compiles(compiler: &str) -> Result<(), Failed> {
    let source = scratch("header.c");
    std::fs::write(&source, "#include \"flicr.h\"\nuint64_t memory[FLICR_ENCODER_WORDS(256, 64, FLICR_CODER_RLE)];\n")?;
    let mut command = Command::new(compiler);
    command.args(STRICT).args(["-std=c99", "-ffreestanding", "-fsyntax-only"]).arg("-I").arg(root().join("include"));
    run(command.arg(source))?;
    Ok(())
}
