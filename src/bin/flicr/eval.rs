//! `flicr eval`: what frames cost and what they lose.

mod measure;
mod report;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::ProgressBar;

use crate::args::FrameArgs;
use crate::codec::Codec;
use crate::failure::Failure;
use crate::info::json;
use crate::input::Scan;
use crate::{console, input};
use measure::{Measured, measure};

/// Encode, decode and compare: bytes, quality by the paper's measures, time
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Eval {
    /// Scans: .bin (KITTI), .xyzir.bin or .pcd
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// One JSON object a scan and column count, each on a line
    #[arg(long)]
    json: bool,
    /// Columns of the range image, all around; several with commas: 4500,2048,256
    #[arg(long, value_name = "N,...", default_value = "4500", value_delimiter = ',',
          value_parser = clap::value_parser!(u16).range(1..), help_heading = "Frame")]
    columns: Vec<u16>,
    #[command(flatten)]
    frame: FrameArgs,
}

const EXAMPLES: &str = "\
Measures (JSON names; a table shows the same, and medians):
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
  flicr eval drive/*.bin --json --coder rle > rle.jsonl";

impl Eval {
    pub fn run(self) -> Result<(), Failure> {
        input::check_scan_extensions(&self.inputs)?;
        let mut codecs = self.codecs()?;
        let bar = console::progress(self.inputs.len() * codecs.len(), "measuring");
        let mut all: Vec<Measured> = Vec::new();
        for input in &self.inputs {
            for scan in input::scans(input)? {
                self.measure(&scan?, input, &mut codecs, &bar, &mut all)?;
            }
        }
        bar.finish_and_clear();
        if self.json { Ok(()) } else { console::line(&bar, report::tables(&all, self.frame.config().level_bits)) }
    }

    /// One for each number of columns, those that are asked for twice once.
    fn codecs(&self) -> Result<Vec<Codec>, Failure> {
        let mut seen = BTreeSet::new();
        let columns = self.columns.iter().filter(|&columns| seen.insert(columns));
        columns.map(|&columns| Codec::new(&self.frame, columns)).collect()
    }

    fn measure(
        &self,
        scan: &Scan,
        input: &Path,
        codecs: &mut [Codec],
        bar: &ProgressBar,
        all: &mut Vec<Measured>,
    ) -> Result<(), Failure> {
        for codec in codecs {
            let measured = measure(codec, scan, input, &self.frame)?;
            if self.json {
                console::line(bar, json(&measured))?;
            }
            all.push(measured);
            bar.inc(1);
        }
        Ok(())
    }
}
