//! `flicr decode`: frames to point clouds.

use std::path::PathBuf;

use clap::Args;
use flicr::files::PointCloud;
use flicr::{Decoder, Limits};

use crate::console;
use crate::failure::Failure;
use crate::frames::FrameFile;
use crate::output::{self, Outputs};

/// Decode frames into point clouds
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Decode {
    /// A .flicr file
    input: PathBuf,
    /// A .bin, .xyzir.bin, .pcd or .ply file, or a folder that is there
    #[arg(short, long)]
    output: PathBuf,
}

const EXAMPLES: &str = "\
A file of several frames becomes as many files, numbered from 0: '-o drive.pcd' gives
drive-000000.pcd, drive-000001.pcd, ...; '-o drive/' gives drive/000000.bin, ...
Either all files are written or, where a frame is damaged, none.
A .bin file gets intensities of 0, an .xyzir.bin file rings of 0 too: frames do not hold them.

Examples:
  flicr decode scan.flicr -o scan.ply
  flicr decode drive.flicr -o drive/";

impl Decode {
    pub fn run(self) -> Result<(), Failure> {
        output::check_cloud_extension(&self.output)?;
        let file = FrameFile::read_whole(&self.input)?;
        let mut outputs = Outputs::new(&[self.input]);
        let mut decoder = Decoder::new(Limits::default());
        let bar = console::progress(file.len(), "decoding");
        for (destination, (number, _, bytes)) in output::numbered(&self.output, file.len()).iter().zip(file.frames()) {
            let frame = decoder.decode(bytes).map_err(|error| file.damaged(number, error))?;
            let cloud = PointCloud { points: frame.points(), ..PointCloud::default() };
            outputs.stage_cloud(destination, &cloud)?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        outputs.commit()
    }
}
