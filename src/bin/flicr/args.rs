//! The command line's words, and what `encode`, `eval` and `view` share of them.

use std::rc::Rc;

use clap::{Args, Parser, Subcommand, ValueEnum};
use flicr::geometry::sensors::ouster::OusterSensor;

use flicr::coder::{self, ContextSettings};
use flicr::{Config, Scale};

use crate::failure::Failure;
use crate::sensors::Asked;
use crate::{calibrate, decode, encode, eval, info, simulate, view};

/// LiDAR scans to a few kilobytes and back, with a known error.
#[derive(Debug, Parser)]
#[command(name = "flicr", version, after_help = EXAMPLES)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  flicr simulate -o street.bin                 a scan to try things with
  flicr encode street.bin -o street.flicr      120,000 points to 50 KB
  flicr decode street.flicr -o back.pcd        and back
  flicr eval street.bin --columns native,256   what it costs and what it saves
  flicr view street.bin -o street.png          how it looks
  flicr calibrate drive/*.bin -o sensor.toml   the sensor's own grid, from its scans
  flicr encode turns.pcap -o turns.flicr       a frame for every turn of a capture

Exit codes: 0 fine, 1 bad data, 2 bad usage.";

#[derive(Debug, Subcommand)]
pub enum Command {
    Encode(encode::Encode),
    Decode(decode::Decode),
    Info(info::Info),
    Eval(eval::Eval),
    Simulate(simulate::Simulate),
    Calibrate(calibrate::Calibrate),
    View(view::View),
}

impl Command {
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::Encode(encode) => encode.run(),
            Self::Decode(decode) => decode.run(),
            Self::Info(info) => info.run(),
            Self::Eval(eval) => eval.run(),
            Self::Simulate(simulate) => simulate.run(),
            Self::Calibrate(calibrate) => calibrate.run(),
            Self::View(view) => view.run(),
        }
    }
}

/// What frames are to be like; the columns apart, for `eval` takes several.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Frame")]
pub struct FrameArgs {
    /// Whose beams the rows are: auto (by the points), a built-in sensor's name (hdl64e, hdl32e, vlp16, ...), a file of
    /// `flicr calibrate` (.toml) or an Ouster's metadata (.json)
    #[arg(long, value_name = "SENSOR", default_value = "auto", conflicts_with = "preset")]
    pub sensor: String,
    /// Rows and columns evenly spread instead of a sensor's, and how points are put into pixels and taken out again
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
    /// Rows of evenly spread rows, from the highest elevation to the lowest; a sensor has its own
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(1..))]
    pub rows: u16,
    /// Bits of a range, 1 to 16: the quantizer has 2^N - 1 steps [default: 8; with --step 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    pub bits: Option<u32>,
    /// How finely ranges are kept; native is the sensor's range count, and without loss on its own grid. The context
    /// coders keep a range within 0.6 of it, the others within 0.5
    #[arg(long, value_name = "METERS|native", value_parser = step, conflicts_with = "max_range")]
    pub step: Option<Step>,
    /// Range of the largest level; farther points are dropped and counted [default: each scan's farthest point]
    #[arg(long, value_name = "METERS", value_parser = meters)]
    pub max_range: Option<f32>,
    /// What codes the range image, without loss
    #[arg(long, value_enum, default_value_t = CoderName::Deflate)]
    pub coder: CoderName,
    /// Which of the context coders
    #[arg(long, value_enum, default_value_t = Tier::Dense)]
    pub tier: Tier,
}

/// Levels between which the context coders step, of frames without a sensor: as finely as KITTI's counts, meters.
const FINE_LEVEL_M: f32 = 0.002;

/// Columns of `encode` and `view`.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Frame")]
pub struct ColumnsArg {
    /// Columns of the range image, all around: a number of evenly spread ones (the paper's are 4500, 4096, 2048, 1024,
    /// 512 and 256), or native: the firings of the sensor on whose grid the scan is [default: native, else 4500]
    #[arg(long, value_name = "N|native", value_parser = columns)]
    pub columns: Option<Columns>,
}

/// Columns of a range image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Columns {
    /// The sensor's firings where the scan is on its grid.
    Native,
    /// So many, evenly spread.
    Count(u16),
}

/// Columns by their number, or `native`.
pub fn columns(text: &str) -> Result<Columns, String> {
    if text == "native" {
        return Ok(Columns::Native);
    }
    let count = text.parse().ok().filter(|&count| count > 0);
    count.map(Columns::Count).ok_or_else(|| "expected native or a number from 1 to 65535".to_owned())
}

/// Distance of two levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// The sensor's range count.
    Native,
    Meters(f32),
}

fn step(text: &str) -> Result<Step, String> {
    if text == "native" { Ok(Step::Native) } else { meters(text).map(Step::Meters) }
}

impl FrameArgs {
    /// The library's configuration.
    pub fn config(&self) -> Config {
        let preset = match self.preset {
            Some(Preset::Paper) => Config::PAPER,
            Some(Preset::Uniform) | None => Config::UNIFORM,
        };
        let scale = match (self.step, self.max_range) {
            (Some(Step::Meters(_)), _) if self.coder == CoderName::Context => Scale::Step { step_m: FINE_LEVEL_M },
            (Some(Step::Meters(step_m)), _) => Scale::Step { step_m },
            (_, Some(max_range_m)) => Scale::Fixed { max_range_m },
            _ => preset.scale,
        };
        Config { level_bits: self.bits(), scale, ..preset }
    }

    /// Bits of a range.
    pub fn bits(&self) -> u32 {
        self.bits.unwrap_or(if self.step.is_some() { 16 } else { 8 })
    }

    /// An Ouster that was asked for, to read its packets with.
    pub fn ouster(&self) -> Result<Option<Rc<OusterSensor>>, Failure> {
        Ok(match self.asked()? {
            Some(Asked::Ouster(sensor)) => Some(sensor),
            _ => None,
        })
    }

    /// The sensor that was asked for; `None` where it is to be found out.
    pub fn asked(&self) -> Result<Option<Asked>, Failure> {
        if self.sensor == "auto" { Ok(None) } else { Asked::named(&self.sensor).map(Some) }
    }

    /// What the context coders are to do with levels `level_m` apart, where they choose among them: those of the sensor,
    /// where there is one.
    pub fn context(&self, sensor_level_m: Option<f32>) -> Result<ContextSettings, String> {
        let level_m = sensor_level_m.unwrap_or(FINE_LEVEL_M);
        let settings = ContextSettings::of_levels(level_m);
        let step_m = match self.step {
            None => return Ok(ContextSettings::COARSE),
            Some(Step::Native) => return Ok(settings),
            Some(Step::Meters(step_m)) => step_m,
        };
        let levels = (step_m / level_m).round().max(1.0);
        let step = (levels <= f32::from(u16::MAX)).then_some(levels as u16).and_then(coder::Step::new);
        let step = step.ok_or_else(|| format!("--step {step_m}: expected at most {} m", 65535.0 * level_m))?;
        Ok(settings.with_step(step))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// As the paper's authors do: the last point in a pixel wins, points come back at its corner
    Paper,
    /// The best of evenly spaced rows and columns: the nearest point wins and comes back in the middle
    Uniform,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CoderName {
    /// Run-length coding: the fastest that compresses
    Rle,
    /// LZ77 and Huffman codes, as in zip: the smallest
    Deflate,
    /// Made for range images: by far the smallest, and with '--step' the choice between size and error
    Context,
    /// No coding
    Store,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Tier {
    /// The fewest bytes
    Dense,
    /// For microcontrollers: a third of the memory and time, 5 to 20 % more bytes
    Small,
    /// For SoCs and servers: many times as fast, some percent more bytes than small
    Fast,
}

/// The word by which the command line and JSON know a value.
pub fn word(value: &impl ValueEnum) -> String {
    value.to_possible_value().map(|possible| possible.get_name().to_owned()).unwrap_or_default()
}

fn meters(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(meters) if meters.is_finite() && meters > 0.0 => Ok(meters),
        _ => Err("expected a positive number of meters".to_owned()),
    }
}
