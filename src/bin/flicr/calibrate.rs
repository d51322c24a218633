//! `flicr calibrate`: a sensor's own grid, found from its scans.

mod plot;
mod report;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use flicr::calibrate::{self, Calibration, Progress, Stage};
use flicr::files::PointCloud;
use flicr::sensor::Sensor;
use indicatif::ProgressBar;

use crate::capture::CaptureArgs;
use crate::failure::Failure;
use crate::output::Outputs;
use crate::{console, input};

/// Find a sensor's beams, encoder ticks and range unit from its scans
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Calibrate {
    /// Scans: .bin (KITTI), .xyzir.bin, .pcd or .pcap; eight or more of different places are best
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// The sensor file
    #[arg(short, long)]
    output: PathBuf,
    /// What the sensor is called [default: the sensor file's name]
    #[arg(long)]
    name: Option<String>,
    /// Picture of the residuals [default: beside the sensor file, as .png]
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Scans must be raw: in the sensor's own frame, not motion-compensated, not merged. Others are refused, with the
reason. Where all scans have rings, these say which points share a beam; neither their order nor that of the
points matters.

Residuals, in millimeters: how far points lie from the middle of the cell of the grid that they fall into,
  across the beam in its vertical plane (elevation, vertical offset),
  around, in the direction of the turn (encoder tick, horizontal offset, azimuth phase),
  along the beam (range count, range phase).
Lost are points that share beam and tick with another of their scan.

Examples:
  flicr calibrate drive/*.bin -o sensor.toml
  flicr calibrate turn.xyzir.bin -o roof.toml --name 'roof, left' --png roof-residuals.png";

impl Calibrate {
    pub fn run(self) -> Result<(), Failure> {
        input::check_scan_extensions(&self.inputs)?;
        let mut outputs = Outputs::new(&self.inputs);
        let png = self.png.clone().unwrap_or_else(|| self.output.with_extension("png"));
        outputs.check(&self.output)?;
        outputs.check(&png)?;
        let found = find(&self.name(), &self.clouds()?).map_err(|error| self.refused(error))?;
        stage_sensor(&mut outputs, &self.output, &found.sensor)?;
        stage_plot(&mut outputs, &png, &found)?;
        outputs.commit()?;
        console::line_if_read(&ProgressBar::hidden(), report::text(&found))
    }

    fn name(&self) -> String {
        let stem = || self.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.name.clone().unwrap_or_else(stem)
    }

    fn clouds(&self) -> Result<Vec<PointCloud>, Failure> {
        let bar = console::progress(self.inputs.len(), "reading");
        let mut clouds = Vec::new();
        for input in &self.inputs {
            for scan in input::scans(input, &CaptureArgs::default(), None)? {
                clouds.push(scan?.cloud);
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(clouds)
    }

    /// No one scan is to blame: all of them are named.
    fn refused(&self, error: calibrate::CalibrateError) -> Failure {
        let first = self.inputs.first().map(|input| input.display().to_string()).unwrap_or_default();
        match self.inputs.len() {
            0 | 1 => Failure::Data(format!("{first}: {error}")),
            len => Failure::Data(format!("{first} and {} more: {error}", len - 1)),
        }
    }
}

fn find(name: &str, clouds: &[PointCloud]) -> Result<Calibration, calibrate::CalibrateError> {
    let scans: Vec<calibrate::Scan> = clouds.iter().map(scan).collect();
    let bar = console::progress(STAGES.len() * 100, "calibrating");
    let found = calibrate::calibrate(name, &scans, &mut |progress| show(&bar, progress));
    bar.finish_and_clear();
    found
}

fn scan(PointCloud { points, rings, .. }: &PointCloud) -> calibrate::Scan<'_> {
    calibrate::Scan { points, beams: rings.as_deref() }
}

/// In the order in which they come, with what the bar says of them.
const STAGES: [(Stage, &str); 5] = [
    (Stage::Beams, "finding beams"),
    (Stage::Ticks, "finding ticks"),
    (Stage::Offsets, "finding offsets"),
    (Stage::Unit, "finding the range unit"),
    (Stage::Residuals, "measuring residuals"),
];

fn show(bar: &ProgressBar, Progress { stage, fraction }: Progress) {
    if let Some((done, (_, doing))) = STAGES.iter().enumerate().find(|(_, (other, _))| *other == stage) {
        bar.set_message(*doing);
        bar.set_position((100.0 * (done as f32 + fraction)) as u64);
    }
}

fn stage_sensor(outputs: &mut Outputs, destination: &Path, sensor: &Sensor) -> Result<(), Failure> {
    outputs.stage(destination, |temporary| {
        fs::write(temporary, sensor.to_toml()).map_err(|error| Failure::data(destination, error))
    })
}

fn stage_plot(outputs: &mut Outputs, destination: &Path, found: &Calibration) -> Result<(), Failure> {
    outputs.stage(destination, |temporary| {
        plot::draw(found).write_png(temporary).map_err(|error| Failure::data(destination, error))
    })
}
