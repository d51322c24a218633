//! `flicr simulate`: scans of a made-up street.

use std::path::PathBuf;

use clap::Args;
use flicr::files::PointCloud;
use flicr::simulate::{Simulator, Turn};

use crate::console;
use crate::failure::Failure;
use crate::output::{self, Outputs};

/// Write scans of a simulated HDL-64E driving down a made-up street
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Simulate {
    /// A .bin, .xyzir.bin, .pcd or .ply file, or a folder that is there
    #[arg(short, long)]
    output: PathBuf,
    /// Which street; the same seed gives the same bytes on every machine
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Turns of the sensor, a tenth of a second and a scan each
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    turns: u32,
}

const EXAMPLES: &str = "\
Several turns become as many files, numbered from 0: '-o drive.bin' gives drive-000000.bin, ...;
'-o drive/' gives drive/000000.bin, ...

Examples:
  flicr simulate -o street.bin
  flicr simulate -o drive/ --seed 7 --turns 10";

impl Simulate {
    pub fn run(self) -> Result<(), Failure> {
        output::check_cloud_extension(&self.output)?;
        let names = output::numbered(&self.output, self.turns as usize);
        let mut outputs = Outputs::default();
        let bar = console::progress(names.len(), "simulating");
        for (name, turn) in names.iter().zip(Simulator::hdl64e(self.seed)) {
            outputs.stage_cloud(name, &cloud(&turn))?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        outputs.commit()
    }
}

fn cloud(turn: &Turn) -> PointCloud {
    PointCloud {
        points: turn.points.iter().map(|&[x, y, z, _]| [x, y, z]).collect(),
        intensities: Some(turn.points.iter().map(|&[.., intensity]| intensity).collect()),
        rings: Some(turn.returns.iter().map(|found| found.beam.into()).collect()),
    }
}
