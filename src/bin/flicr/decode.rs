//! `flicr decode`: frames to point clouds.

use std::path::PathBuf;

use clap::Args;
use flicr::files::{Format, PointCloud, kitti};
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
    /// Evens out the stairs that a coarse step makes of a surface: for a sensor's own grid and steps of 5 cm and
    /// more, where ranges are nearer on average; with finer ones it does harm. A range may be off by twice what the frame
    /// promises
    #[arg(long)]
    smooth: bool,
}

const EXAMPLES: &str = "\
A file of several frames becomes as many files, numbered from 0: '-o drive.pcd' gives
drive-000000.pcd, drive-000001.pcd, ...; '-o drive/' gives drive/000000.bin, ...
A frame of 'flicr encode --exact' becomes the .bin file that it was made from, byte for byte.
Either all files are written or, where a frame is damaged, none.
A .bin file gets intensities of 0 where the frames do not hold them, an .xyzir.bin file rings of 0, which no frame does.

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
            let original = frame.original().map_err(|error| file.damaged(number, error))?;
            match original.filter(|_| !self.smooth) {
                Some(bytes) if Format::of(destination) == Some(Format::Kitti) => {
                    let wrong = |error| Failure::data(destination, error);
                    outputs.stage(destination, |temporary| std::fs::write(temporary, &bytes).map_err(wrong))?;
                }
                Some(bytes) => {
                    let cloud = kitti::parse(&bytes).map_err(|error| Failure::data(destination, error))?;
                    outputs.stage_cloud(destination, &cloud)?;
                }
                None => {
                    let points = if self.smooth { frame.smooth_points() } else { frame.points() };
                    let cloud = PointCloud { points, intensities: frame.intensities(), rings: None };
                    outputs.stage_cloud(destination, &cloud)?;
                }
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        outputs.commit()
    }
}
