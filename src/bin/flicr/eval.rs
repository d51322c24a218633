//! `flicr eval`: what frames cost and what they lose.

mod measure;
mod report;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::ProgressBar;

use crate::args::{self, Columns, FrameArgs};
use crate::capture::CaptureArgs;
use crate::choice::ChoicesArgs;
use crate::codec::Codec;
use crate::failure::Failure;
use crate::info::json;
use crate::input::Scan;
use crate::plan::Noted;
use crate::{console, input};
use measure::{Measured, measure};

/// Encode, decode and compare: bytes, quality by the paper's measures, time
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Eval {
    /// Scans: .bin (KITTI), .xyzir.bin or .pcd; captures, every turn of them: .pcap or .pcapng
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// One JSON object a scan and configuration, each on a line
    #[arg(long)]
    json: bool,
    /// Columns of the range image, all around; several with commas: native,2048,256 [default: native, else 4500]
    #[arg(long, value_name = "N|native,...", value_delimiter = ',', value_parser = args::columns, help_heading = "Frame")]
    columns: Vec<Columns>,
    /// Decode as 'flicr decode --smooth' does
    #[arg(long)]
    smooth: bool,
    #[command(flatten)]
    choices: ChoicesArgs,
    #[command(flatten)]
    frame: FrameArgs,
    #[command(flatten)]
    capture: CaptureArgs,
}

const EXAMPLES: &str = "\
Measures (JSON names; a table shows the same, and medians):
  geometry, sensor  where pixels lie, and whose beams rows are (null: nobody's); why: the reason for the choice
  coder, tier       what coded the image; tier and step_m are null where there is none
  bits, step_m      of a level; how finely ranges are kept, where a step says it
  range_bound_m     most that a kept point's range is off, as the frame says
  points, kept      returns of the scan (points at the origin are none), and those of them in the frame
  bytes             the whole frame, header and checksum included
  ratio_xyz, _xyzi  12 and 16 bytes for every point of the file, divided by bytes; bpp: bits for every point
  se                share of the returns that was lost
  psnr_db           from decoded points to the nearest original, peak 80 m; psnr_reverse_db: the other way
  cd_m2, cd_mean_m  both ways' mean squared distances added, and the mean of both ways' mean distances
  epsnr_db          psnr_db made to reflect se, alpha -0.15, beta 0.5
  max_error_m       the largest distance from a decoded point to the nearest original
  encode_ns, decode_ns  fastest of 7 runs on one core; points to frame, frame to points

Examples:
  flicr eval scan.bin
  flicr eval drive/*.bin --preset paper --columns 4500,4096,2048,1024,512,256
  flicr eval drive/*.bin --tier dense,small,fast --step native,0.02,0.1
  flicr eval drive/*.bin --json --coder rle > rle.jsonl";

impl Eval {
    pub fn run(self) -> Result<(), Failure> {
        input::check_scan_extensions(&self.inputs)?;
        let mut codecs = self.codecs()?;
        let bar = console::progress(self.inputs.len() * codecs.len(), "measuring");
        let (mut all, mut noted) = (Vec::new(), Noted::default());
        let asked = self.frame.asked()?;
        for input in &self.inputs {
            let mut scans = input::scans(input, &self.capture, asked.as_ref())?;
            for scan in scans.by_ref() {
                self.measure(&scan?, input, &mut codecs, (&bar, &mut noted), &mut all)?;
            }
            if let Some(complaint) = scans.complaint() {
                console::note(&bar, format_args!("{}: {complaint}", input.display()));
            }
        }
        bar.finish_and_clear();
        if self.json { Ok(()) } else { console::line(&bar, report::tables(&all)) }
    }

    /// One for each number of columns, coder, tier and step; those that are asked for twice once.
    fn codecs(&self) -> Result<Vec<Codec>, Failure> {
        let mut seen = BTreeSet::new();
        let mut columns: Vec<_> =
            self.columns.iter().filter(|&columns| seen.insert(columns)).map(|&c| Some(c)).collect();
        if columns.is_empty() {
            columns.push(None);
        }
        let choices = self.choices.choices();
        let all = columns.iter().flat_map(|&columns| choices.iter().map(move |&choice| (choice, columns)));
        all.map(|(choice, columns)| Codec::new(&self.frame, choice, columns)).collect()
    }

    fn measure(
        &self,
        scan: &Scan,
        input: &Path,
        codecs: &mut [Codec],
        (bar, noted): (&ProgressBar, &mut Noted),
        all: &mut Vec<Measured>,
    ) -> Result<(), Failure> {
        for codec in codecs {
            let plan = codec.prepare(scan).map_err(|error| Failure::data(input, error))?;
            noted.note(bar, &scan.name(input), plan);
            let measured = measure(codec, scan, input, self.smooth)?;
            if self.json {
                console::line(bar, json(&measured))?;
            }
            all.push(measured);
            bar.inc(1);
        }
        Ok(())
    }
}
