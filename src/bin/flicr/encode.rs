//! `flicr encode`: scans to frames.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use flicr::files::Format;
use flicr::{Encoded, Stamp, Tally, original};
use indicatif::ProgressBar;

use crate::args::{ColumnsArg, FrameArgs, Step};
use crate::capture::CaptureArgs;
use crate::choice::{ChoiceArgs, Fineness};
use crate::codec::{Codec, Keep, keep};
use crate::failure::Failure;
use crate::input::{self, Scan};
use crate::output::Outputs;
use crate::plan::Noted;
use crate::sensors::Asked;
use crate::{console, table};

/// Encode scans: one frame each, with a line of what became of every point
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Encode {
    /// Scans: .bin (KITTI), .xyzir.bin or .pcd; captures, a frame a turn: .pcap or .pcapng
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// A file for all frames, back to back, numbered from 0; or a folder that is there, for a .flicr file an input
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    columns: ColumnsArg,
    #[command(flatten)]
    choice: ChoiceArgs,
    #[command(flatten)]
    frame: FrameArgs,
    /// Keeps the intensities, too: lossless, where they are numbers of 8 bits (hundredths in KITTI's files, whole numbers in
    /// packets), or in steps of so many of these: 16 keeps about 4 bits
    #[arg(long, value_name = "lossless|STEP", value_parser = keep)]
    intensity: Option<Keep>,
    /// Keeps the time of every column of a capture, to the nanosecond
    #[arg(long)]
    timestamps: bool,
    /// Codes frames by the frame before where that makes them shorter, for sensors that stand still; every Nth needs none
    /// before it. Decoding the others takes all since the last of these, in order
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    previous: Option<u32>,
    /// Keeps all of a KITTI file (.bin) on its sensor's grid, so that `decode` into a .bin file gives back every byte of it:
    /// digits, intensities and the order of the points. A file that is not such is refused
    #[arg(long, conflicts_with_all = ["previous", "intensity", "step", "bound", "target_bytes", "bits", "preset", "columns", "max_range"])]
    exact: bool,
    #[command(flatten)]
    capture: CaptureArgs,
}

const EXAMPLES: &str = "\
Points at the origin are the sensor's way of saying 'no return': counted, but not lost.
Where no --preset says that rows and columns are to be evenly spread, rows are the beams of the sensor that the points
fit, if they fit one; on its own grid no point is lost. What was chosen, and why, is noted on stderr.
Without options, the context coder's dense tier keeps ranges in steps of 2 cm, within 13 mm on a sensor's grid.
Intensities are kept where --intensity says so. A file that is there is replaced, once the new one is complete.

Examples:
  flicr encode scan.bin -o scan.flicr
  flicr encode scan.bin -o scan.flicr --step native
  flicr encode scan.bin -o scan.flicr --bound 0.05
  flicr encode drive/*.bin -o drive.flicr --target-bytes 20000
  flicr encode scan.bin -o scan.flicr --step native --intensity lossless
  flicr encode scan.bin -o scan.flicr --exact
  flicr encode drive/*.bin -o drive.flicr --columns 2048 --max-range 80
  flicr encode roadside.pcap -o roadside.flicr --previous 50
  flicr encode os1.pcap --metadata os1.json -o os1.flicr
  flicr encode drive/*.bin -o encoded/ --preset paper --coder rle";

impl Encode {
    pub fn run(self) -> Result<(), Failure> {
        input::check_scan_extensions(&self.inputs)?;
        let mut outputs = Outputs::new(&self.inputs);
        let bar = console::progress(self.inputs.len(), "encoding");
        let mut choice = self.choice.choice();
        if self.exact {
            choice.fineness = Some(Fineness::Step(Step::Native));
        }
        let mut codec = Codec::new(&self.frame, choice, self.columns.columns)?;
        if let Some(keep) = self.intensity.or(self.exact.then_some(Keep::Lossless)) {
            codec.keep_intensities(keep);
        }
        if self.timestamps {
            codec.keep_times();
        }
        if let Some(key_every) = self.previous {
            codec.go_on(key_every)?;
        }
        let asked = self.frame.asked()?;
        let Self { capture, exact, .. } = &self;
        let mut run = Run { codec, capture, exact: *exact, asked, sequence: 0, noted: Noted::default(), bar };
        if self.output.is_dir() {
            for input in &self.inputs {
                let name = Path::new(input.file_stem().unwrap_or_default()).with_extension("flicr");
                let inputs = std::slice::from_ref(input);
                run.stage(&mut outputs, &self.output.join(name), inputs)?;
            }
        } else {
            run.stage(&mut outputs, &self.output, &self.inputs)?;
        }
        run.bar.finish_and_clear();
        outputs.commit()
    }
}

struct Run<'a> {
    codec: Codec,
    capture: &'a CaptureArgs,
    exact: bool,
    asked: Option<Asked>,
    sequence: u32,
    noted: Noted,
    bar: ProgressBar,
}

impl Run<'_> {
    fn stage(&mut self, outputs: &mut Outputs, destination: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
        let wrong = |error| Failure::data(destination, error);
        outputs.stage(destination, |temporary| {
            let mut out = BufWriter::new(File::create(temporary).map_err(wrong)?);
            for input in inputs {
                let mut scans = input::scans(input, self.capture, self.asked.as_ref())?;
                for scan in scans.by_ref() {
                    let frame = self.encode(&scan?, input)?;
                    out.write_all(&frame).map_err(wrong)?;
                }
                if let Some(complaint) = scans.complaint() {
                    console::note(&self.bar, format_args!("{}: {complaint}", input.display()));
                }
                self.bar.inc(1);
            }
            out.flush().map_err(wrong)
        })
    }

    fn encode(&mut self, scan: &Scan, input: &Path) -> Result<Vec<u8>, Failure> {
        let stamp = Stamp { sequence: self.sequence, timestamp_ns: scan.timestamp_ns };
        let exact = if self.exact { "--exact: " } else { "" };
        let wrong = |error: &dyn std::fmt::Display| Failure::data(input, format_args!("{exact}{error}"));
        let plan = self.codec.prepare(scan).map_err(|error| wrong(&error))?;
        self.noted.note(&self.bar, &scan.name(input), plan);
        let mut encoded = self.codec.encode(scan, stamp).map_err(|error| wrong(&error))?;
        let mut frame = self.codec.frame().to_vec();
        if self.exact {
            if Format::of(input) != Some(Format::Kitti) || scan.cloud.rings.is_some() {
                return Err(wrong(&"expected a KITTI file, .bin, of four floats a point"));
            }
            let file = std::fs::read(input).map_err(|error| Failure::data(input, error))?;
            original::append(&mut frame, &file).map_err(|error| wrong(&error))?;
            encoded.len = frame.len();
        }
        console::line_if_read(&self.bar, summary(&scan.name(input), self.sequence, &encoded, self.codec.chosen()))?;
        self.sequence += 1;
        Ok(frame)
    }
}

/// One line: the frame's length, its error bound, and where every point went.
fn summary(input: &str, sequence: u32, encoded: &Encoded, chosen: Option<String>) -> String {
    let chosen = chosen.map_or_else(String::new, |chosen| format!("{chosen}, "));
    let Encoded { len, tally, range_bound_m, .. } = encoded;
    format!(
        "{input}: frame {sequence}, {} bytes, {chosen}ranges within {range_bound_m:.3} m; {}",
        table::grouped(*len as u64),
        account(tally)
    )
}

/// `120,574 points: 112,040 kept, 8,533 collided, 1 no return`; what did not happen is left out.
fn account(tally: &Tally) -> String {
    let mut account = format!("{} points: {} kept", grouped(tally.points), grouped(tally.kept()));
    let others = [
        (tally.collided, "collided"),
        (tally.out_of_view, "out of view"),
        (tally.beyond_range, "beyond range"),
        (tally.too_near, "too near"),
        (tally.no_return, "no return"),
        (tally.not_finite, "not finite"),
    ];
    for (count, what) in others.into_iter().filter(|&(count, _)| count > 0) {
        account.extend([", ", &grouped(count), " ", what]);
    }
    if tally.displaced > 0 {
        account.extend([" (", &grouped(tally.displaced), " in a free column beside their own)"]);
    }
    if tally.clamped > 0 {
        account.extend([" (", &grouped(tally.clamped), " clamped into an edge row)"]);
    }
    account
}

fn grouped(count: u32) -> String {
    table::grouped(count.into())
}
