//! `flicr encode`: scans to frames.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use clap::Args;
use flicr::geometry::sensors::ouster::OusterSensor;
use flicr::{Encoded, Stamp, Tally};
use indicatif::ProgressBar;

use crate::args::{ColumnsArg, FrameArgs};
use crate::capture::CaptureArgs;
use crate::codec::Codec;
use crate::failure::Failure;
use crate::input::{self, Scan};
use crate::output::Outputs;
use crate::plan::Noted;
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
    frame: FrameArgs,
    #[command(flatten)]
    capture: CaptureArgs,
}

const EXAMPLES: &str = "\
Points at the origin are the sensor's way of saying 'no return': counted, but not lost.
Where no --preset says that rows and columns are to be evenly spread, rows are the beams of the sensor that the points
fit, if they fit one; on its own grid no point is lost. What was chosen, and why, is noted on stderr.
Intensities are not encoded. A file that is there is replaced, once the new one is complete.

Examples:
  flicr encode scan.bin -o scan.flicr
  flicr encode scan.bin -o scan.flicr --step native
  flicr encode drive/*.bin -o drive.flicr --columns 2048 --max-range 80
  flicr encode os1.pcap --metadata os1.json -o os1.flicr
  flicr encode drive/*.bin -o encoded/ --preset paper --coder rle";

impl Encode {
    pub fn run(self) -> Result<(), Failure> {
        input::check_scan_extensions(&self.inputs)?;
        let mut outputs = Outputs::new(&self.inputs);
        let bar = console::progress(self.inputs.len(), "encoding");
        let (codec, ouster) = (Codec::new(&self.frame, self.columns.columns)?, self.frame.ouster()?);
        let Self { capture, .. } = &self;
        let mut run = Run { codec, capture, ouster, sequence: 0, noted: Noted::default(), bar };
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
    ouster: Option<Rc<OusterSensor>>,
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
                let mut scans = input::scans(input, self.capture, self.ouster.as_deref())?;
                for scan in scans.by_ref() {
                    self.encode(&scan?, input)?;
                    out.write_all(self.codec.frame()).map_err(wrong)?;
                }
                if let Some(complaint) = scans.complaint() {
                    console::note(&self.bar, format_args!("{}: {complaint}", input.display()));
                }
                self.bar.inc(1);
            }
            out.flush().map_err(wrong)
        })
    }

    fn encode(&mut self, scan: &Scan, input: &Path) -> Result<(), Failure> {
        let stamp = Stamp { sequence: self.sequence, timestamp_ns: scan.timestamp_ns };
        let plan = self.codec.prepare(scan).map_err(|error| Failure::data(input, error))?;
        self.noted.note(&self.bar, &scan.name(input), plan);
        let encoded = self.codec.encode(scan, stamp).map_err(|error| Failure::data(input, error))?;
        console::line_if_read(&self.bar, summary(&scan.name(input), self.sequence, &encoded))?;
        self.sequence += 1;
        Ok(())
    }
}

/// One line: the frame's length, its error bound, and where every point went.
fn summary(input: &str, sequence: u32, encoded: &Encoded) -> String {
    let Encoded { len, tally, range_bound_m, .. } = encoded;
    format!(
        "{input}: frame {sequence}, {} bytes, ranges within {range_bound_m:.3} m; {}",
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
    if tally.clamped > 0 {
        account.extend([" (", &grouped(tally.clamped), " clamped into an edge row)"]);
    }
    account
}

fn grouped(count: u32) -> String {
    table::grouped(count.into())
}
