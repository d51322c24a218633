//! Firmware that streams: what it sends, over emulated UARTs too, is what the host sends, byte for byte.
//!
//! Packets of the simulated sensors, and of a real one where they are at hand, go through `examples/live_cortex_m` and
//! `examples/live_aarch64` on every emulated board. What the host sends must be what `live.out` says, on every machine;
//! `make bless` writes that anew. Without an emulator the boards' tests are skipped and counted as ignored; with
//! `FLICR_REQUIRE_QEMU` they fail.

#[path = "live/board.rs"]
mod board;
#[path = "firmware/board.rs"]
mod boards;
#[path = "common/captures.rs"]
mod captures;
mod common;
mod firmware;
#[allow(dead_code, reason = "the firmware asks more")]
#[path = "../examples/live_firmware/packets.rs"]
mod reader;
#[path = "live/reference.rs"]
mod reference;
#[path = "common/simulated_packets.rs"]
mod simulated_packets;

use std::fmt::Write;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use libtest_mimic::{Arguments, Failed, Trial};

use board::{BOARDS, Board};
use firmware::tool;
use flicr::coder::Step;
use flicr::simulate::Sensor;
use flicr::stream::{Deframer, StreamDecoder, write_framed};
use reference::Kind;

/// A stream: whose packets, how many, and the step in range counts.
struct Stream {
    kind: Kind,
    step: u16,
    source: Source,
}

/// Where the packets come from.
#[derive(Clone, Copy)]
enum Source {
    /// So many.
    Simulated(usize),
    /// Of a capture that is not part of this repository.
    Capture(&'static str),
}

/// Two turns each: lossless with 16 beams, in steps of 2 cm with 64.
static STREAMS: [Stream; 4] = [
    Stream { kind: Kind::Vlp16, step: 1, source: Source::Simulated(152) },
    Stream { kind: Kind::Hdl64e, step: 10, source: Source::Simulated(718) },
    Stream { kind: Kind::Hdl64eAligned, step: 10, source: Source::Simulated(718) },
    Stream { kind: Kind::Vlp16, step: 1, source: Source::Capture("velodyne/vlp16_dual.pcap") },
];

/// The same with fewer packets: an emulated UART takes its time.
static OVER_UARTS: [Stream; 2] = [
    Stream { kind: Kind::Vlp16, step: 1, source: Source::Simulated(40) },
    Stream { kind: Kind::Hdl64e, step: 10, source: Source::Simulated(40) },
];

impl Stream {
    fn name(&self) -> String {
        let source = match self.source {
            Source::Simulated(packets) => packets.to_string(),
            Source::Capture(_) => "capture".to_owned(),
        };
        format!("{}-{}-{source}", self.kind.name(), self.step)
    }

    fn is_missing(&self) -> bool {
        matches!(self.source, Source::Capture(_)) && common::data::FOLDER.is_none()
    }

    /// What the firmware is asked for.
    fn job(&self) -> String {
        format!("{}:{}", self.kind.name(), self.step)
    }

    fn packets(&self) -> Vec<Vec<u8>> {
        match (self.source, self.kind) {
            (Source::Simulated(count), Kind::Vlp16) => simulated_packets::vlp16(1).take(count).collect(),
            (Source::Simulated(count), _) => simulated_packets::hdl64e(1).take(count).collect(),
            (Source::Capture(path), _) => captures::payloads(path, 2368),
        }
    }

    fn datagrams(&self) -> Vec<Vec<u8>> {
        reference::datagrams(self.kind, self.step, &self.packets())
    }

    fn file(&self, what: &str) -> PathBuf {
        PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("live-{}-{what}", self.name()))
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let skip = firmware::is_skipped(BOARDS.iter().find_map(Board::missing));
    write_packets().expect("the packets' files are written");
    let no_print =
        || firmware::run(Command::new("defmt-print").arg("--version")).is_err().then(|| "defmt-print".into());
    let skip_log = firmware::is_skipped(BOARDS[0].missing().or_else(no_print));
    let mut trials = vec![
        Trial::test("m7::the_log_is_decoded", the_log_is_decoded).with_ignored_flag(skip_log),
        Trial::test("host::bytes_are_known", bytes_are_known),
        Trial::test("host::every_return_comes_back", every_return_comes_back),
    ];
    for board in &BOARDS {
        for stream in &STREAMS {
            let name = format!("{}::files::{}", board.name, stream.name());
            let ignored = skip || stream.is_missing();
            trials.push(Trial::test(name, || bytes_equal_the_hosts(board, stream)).with_ignored_flag(ignored));
        }
        for stream in &OVER_UARTS {
            let name = format!("{}::uarts::{}", board.name, stream.name());
            trials.push(Trial::test(name, || uarts_lose_nothing(board, stream)).with_ignored_flag(skip));
        }
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// Four turns of each simulated sensor and a few packets more, for `tools/size_stream.sh`.
fn write_packets() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let vlp16: Vec<_> = simulated_packets::vlp16(1).take(4 * 76).collect();
    std::fs::write(folder.join("live-vlp16.packets"), simulated_packets::framed(&vlp16))?;
    let hdl64e: Vec<_> = simulated_packets::hdl64e(1).take(4 * 359).collect();
    std::fs::write(folder.join("live-hdl64e.packets"), simulated_packets::framed(&hdl64e))
}

/// What the host sends is what it has always sent.
fn bytes_are_known() -> Result<(), Failed> {
    let mut told = String::new();
    for stream in STREAMS.iter().filter(|stream| matches!(stream.source, Source::Simulated(_))) {
        let sent = stream.datagrams();
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&sent.concat());
        let bytes: usize = sent.iter().map(Vec::len).sum();
        writeln!(told, "{} datagrams={} bytes={bytes} crc={crc:08x}", stream.name(), sent.len())?;
    }
    let path = firmware::root().join("tests/live.out");
    if std::env::var_os("FLICR_BLESS").is_some() {
        return Ok(std::fs::write(path, told)?);
    }
    let known = std::fs::read_to_string(path)?;
    if told == known { Ok(()) } else { Err(format!("{told}but live.out says\n{known}").into()) }
}

/// The packets' returns are those that the simulated sensor measured, within the step.
fn every_return_comes_back() -> Result<(), Failed> {
    for stream in &STREAMS[..2] {
        let sensor = if stream.kind == Kind::Vlp16 { Sensor::vlp16() } else { Sensor::hdl64e() };
        let error_max = Step::new(stream.step).ok_or("a step")?.error_max();
        let mut measured = simulated_packets::firings(sensor, 1);
        let mut decoder = StreamDecoder::default();
        decoder.know(&reference::vlp16_grid())?;
        let mut columns = 0;
        for datagram in stream.datagrams() {
            for (tick, levels) in decoder.push(&datagram)?.columns() {
                let firing = measured.next().ok_or("more columns than firings")?;
                // A VLP-16's packets tell every other firing's azimuth; those between are put in the middle, and at a
                // packet's end where the one before was.
                let off = firing.tick.abs_diff(tick);
                let off_max = if stream.kind == Kind::Vlp16 && columns % 2 == 1 { 5 } else { 0 };
                assert!(off.min(36_000 - off) <= off_max, "column {columns} at {tick}, fired at {}", firing.tick);
                for (count, &level) in firing.counts.into_iter().zip(levels) {
                    assert!((count == 0) == (level == 0) && count.abs_diff(level) <= error_max, "{count} {level}");
                }
                columns += 1;
            }
        }
        assert!(columns > 3500, "{columns}");
    }
    Ok(())
}

fn bytes_equal_the_hosts(board: &'static Board, stream: &Stream) -> Result<(), Failed> {
    let packets = stream.packets();
    let (given, sent) = (stream.file(&format!("{}-in", board.name)), stream.file(&format!("{}-out", board.name)));
    std::fs::write(&given, simulated_packets::framed(&packets))?;
    let printed = board.stream_files(&stream.job(), &given, &sent)?;
    println!("{}::{}: {printed}", board.name, stream.name());
    check_bytes(stream, &sent)?;
    check_told(&printed, &packets)
}

fn uarts_lose_nothing(board: &'static Board, stream: &Stream) -> Result<(), Failed> {
    let packets = stream.packets();
    let sent = stream.file(&format!("{}-out", board.name));
    let printed = board.stream_uarts(&stream.job(), simulated_packets::framed(&packets), &sent)?;
    println!("{}::{}: {printed}", board.name, stream.name());
    check_bytes(stream, &sent)?;
    check_told(&printed, &packets)?;
    // The interrupt's included; a 64-bit core's words are twice as long.
    let (stack_bytes, stack_max) = (number(&printed, "stack_bytes")?, if board.is_thumb() { 2048 } else { 3072 });
    if stack_bytes > stack_max {
        return Err(format!("{stack_bytes} bytes of stack, promised are {stack_max}").into());
    }
    Ok(())
}

/// What came out of the UART, or is in the file, is what the host sends.
fn check_bytes(stream: &Stream, sent: &PathBuf) -> Result<(), Failed> {
    let on_board = std::fs::read(sent)?;
    let mut on_host = Vec::new();
    stream.datagrams().iter().try_for_each(|datagram| write_framed(&mut on_host, datagram))?;
    if on_board == on_host {
        return Ok(());
    }
    let mut deframer: Deframer = Deframer::new();
    let mut datagrams = 0;
    deframer.push(&on_board, |_| datagrams += 1);
    let equal = on_board.iter().zip(&on_host).take_while(|(a, b)| a == b).count();
    let (board_len, host_len) = (on_board.len(), on_host.len());
    Err(format!("{board_len} bytes, {datagrams} datagrams; the host {host_len}, the first {equal} equal").into())
}

/// Every packet came, and none was refused.
fn check_told(printed: &str, packets: &[Vec<u8>]) -> Result<(), Failed> {
    let told = ["packets", "refused", "noise", "overruns"].map(|name| number(printed, name));
    let told: Vec<u64> = told.into_iter().collect::<Result<_, _>>()?;
    if told == [packets.len() as u64, 0, 0, 0] { Ok(()) } else { Err(format!("packets lost: {printed}").into()) }
}

/// What the firmware logs by `defmt` says what the host has sent.
fn the_log_is_decoded() -> Result<(), Failed> {
    let stream = &STREAMS[0];
    let (given, sent, log) = (stream.file("log-in"), stream.file("log-out"), stream.file("log"));
    std::fs::write(&given, simulated_packets::framed(&stream.packets()))?;
    let firmware = firmware::run(tool("defmt.sh").arg("build"))?;
    let firmware = firmware.trim();
    let mut emulator = tool("emulate.sh");
    emulator.env("FLICR_SERIAL", format!("null null file:{}", log.display()));
    firmware::run(emulator.args(["m7", firmware, &stream.job()]).arg(&given).arg(&sent))?;
    let printed = firmware::run(tool("defmt.sh").args(["print", firmware]).stdin(File::open(&log)?))?;
    println!("{printed}");
    let datagrams = stream.datagrams();
    let bytes: usize = datagrams.iter().map(Vec::len).sum();
    let last = printed.lines().last().unwrap_or_default();
    let told = format!("datagrams: {}, bytes: {bytes} }}", datagrams.len());
    if last.starts_with("INFO  turn over: StreamTally {") && last.ends_with(&told) {
        return Ok(());
    }
    Err(format!("{printed}expected at the end: {told}").into())
}

/// A number out of what the firmware printed.
fn number(printed: &str, name: &str) -> Result<u64, Failed> {
    let mut fields = printed.split_whitespace().filter_map(|field| field.split_once('='));
    let found = fields.find(|(found, _)| *found == name).ok_or_else(|| format!("no {name} in: {printed}"))?;
    Ok(found.1.parse()?)
}
