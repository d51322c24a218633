//! The same scan gives the same bytes on a microcontroller as on this machine.
//!
//! Firmware (`examples/cortex_m`, `examples/aarch64`) is built for each emulated board and encodes the simulated scan,
//! and real ones where they are at hand, at all of the paper's sizes with every coder, and sensors' packets; each byte
//! must equal the host's. What it prints of the simulated scan must be what stands in `qemu.out` beside its source, of a real
//! one in `tests/qemu/`; `make bless` writes these anew.
//!
//! Without an emulator the tests are skipped and counted as ignored; with `FLICR_REQUIRE_QEMU` they fail. So are those of
//! real scans where there are none.

#[path = "qemu/board.rs"]
mod board;
#[path = "firmware/board.rs"]
mod boards;
#[path = "common/captures.rs"]
mod captures;
mod common;
mod firmware;
#[path = "qemu/frames.rs"]
mod frames;
#[path = "qemu/packets.rs"]
mod packets;
#[path = "qemu/scan.rs"]
mod scan;
#[path = "common/packet_writer.rs"]
mod writer;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use libtest_mimic::{Arguments, Failed, Trial};

use board::{BOARDS, Board};
use frames::Frame;
use scan::{Kind, Scan};

/// Most Thumb-2 instructions from x, y, z to the image on the sensor's own grid.
const POINT_MAX: f64 = 130.0;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let skip = firmware::is_skipped(BOARDS.iter().find_map(Board::missing));
    let scans = scan::all();
    let pairs = BOARDS.iter().flat_map(|board| scans.iter().map(move |scan| (board, Arc::clone(scan))));
    let trials = pairs.map(|(board, scan)| {
        let name = format!("{}::{}", board.name, scan.name);
        let ignored = skip || scan.is_missing();
        Trial::test(name, move || bytes_equal_the_hosts(board, &scan)).with_ignored_flag(ignored)
    });
    libtest_mimic::run(&arguments, trials.collect()).exit_code()
}

fn bytes_equal_the_hosts(board: &'static Board, scan: &Scan) -> Result<(), Failed> {
    let out_prefix = out_prefix(board, scan);
    let printed = board.run(scan.path()?, &out_prefix, scan.jobs().map(Frame::to_string))?;
    for (frame, on_host) in scan.jobs().zip(scan.frames()?) {
        check_frame(frame, &out_prefix, on_host)?;
    }
    match scan.kind {
        Kind::Simulated => board.check_printed(&lines_of("frame ", &printed)),
        Kind::Real(_) => scan.check_printed(&lines_of("frame ", &printed)),
        Kind::Near(_) => check_projection(board, &printed),
        Kind::Packets(_) => packets::check_cost(board, &lines_of("cost ", &printed)),
        // How many cells hold a return is the scene's doing.
        Kind::Capture { .. } => {
            println!("{}", lines_of("cost ", &printed));
            Ok(())
        }
    }
}

/// Instructions that Thumb-2 takes from x, y, z to the image are as few as promised.
fn check_projection(board: &Board, printed: &str) -> Result<(), Failed> {
    let number = |name: &str| -> Result<f64, Failed> {
        let field = printed.split_whitespace().find_map(|field| field.strip_prefix(name));
        Ok(field.ok_or(format!("no {name}"))?.parse()?)
    };
    let a_point = number("project=")? / number("points=")?;
    println!("{}: {a_point:.1} instructions a point", board.name);
    if board.is_thumb() && a_point > POINT_MAX {
        return Err(format!("{a_point:.1} instructions a point, promised are at most {POINT_MAX}").into());
    }
    Ok(())
}

/// The lines that start with `what`.
fn lines_of(what: &str, printed: &str) -> String {
    printed.lines().filter(|line| line.starts_with(what)).flat_map(|line| [line, "\n"]).collect()
}

fn check_frame(frame: &Frame, out_prefix: &Path, on_host: &[u8]) -> Result<(), Failed> {
    let on_board = std::fs::read(format!("{}-{}", out_prefix.display(), frame.file_name()))?;
    if on_board == on_host {
        return Ok(());
    }
    let equal = on_board.iter().zip(on_host).take_while(|(a, b)| a == b).count();
    let (board_len, host_len) = (on_board.len(), on_host.len());
    Err(format!("{frame}: {board_len} bytes on the board, {host_len} on the host, the first {equal} equal").into())
}

fn out_prefix(board: &Board, scan: &Scan) -> PathBuf {
    let file = format!("qemu-{}-{}", board.name, scan.name.replace('/', "-"));
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(file)
}
