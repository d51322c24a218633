//! The command line's words, and what `encode`, `eval` and `view` share of them.

use clap::{Args, Parser, Subcommand, ValueEnum};

use flicr::coder::{ContextSettings, Step};
use flicr::{Config, Scale};

use crate::failure::Failure;
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
  flicr eval street.bin --columns 4500,256     what it costs and what it saves
  flicr view street.bin -o street.png          how it looks
  flicr calibrate drive/*.bin -o sensor.toml   the sensor's own grid, from its scans

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
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Frame")]
pub struct FrameArgs {
    /// How points are put into pixels and taken out again
    #[arg(long, value_enum, default_value_t = Preset::Uniform)]
    pub preset: Preset,
    /// Rows of the range image, from the highest elevation to the lowest
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(1..))]
    pub rows: u16,
    /// Bits of a range, 1 to 16: the quantizer has 2^N - 1 steps
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub bits: u32,
    /// Range of the largest level; farther points are dropped and counted [default: each scan's farthest point]
    #[arg(long, value_name = "METERS", value_parser = meters)]
    pub max_range: Option<f32>,
    /// What codes the range image, without loss
    #[arg(long, value_enum, default_value_t = CoderName::Deflate)]
    pub coder: CoderName,
    /// Which of the context coders
    #[arg(long, value_enum, default_value_t = Tier::Dense)]
    pub tier: Tier,
    /// With '--coder context': keep ranges in steps of so much, each at most 0.6 steps off. Levels are 2 mm apart then
    #[arg(long, value_name = "METERS", value_parser = meters, conflicts_with_all = ["bits", "max_range"])]
    pub step: Option<f32>,
}

/// Levels of `--step`, meters: as finely as KITTI's sensor counts.
const FINE_LEVEL_M: f32 = 0.002;

/// Columns of `encode` and `view`.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Frame")]
pub struct ColumnsArg {
    /// Columns of the range image, all around; the paper's are 4500, 4096, 2048, 1024, 512 and 256
    #[arg(long, value_name = "N", default_value_t = 4500, value_parser = clap::value_parser!(u16).range(1..))]
    pub columns: u16,
}

impl FrameArgs {
    /// The library's configuration.
    pub fn config(&self) -> Config {
        let preset = match self.preset {
            Preset::Paper => Config::PAPER,
            Preset::Uniform => Config::UNIFORM,
        };
        if self.step.is_some() {
            return Config { level_bits: 16, scale: Scale::Step { step_m: FINE_LEVEL_M }, ..preset };
        }
        let scale = self.max_range.map_or(preset.scale, |max_range_m| Scale::Fixed { max_range_m });
        Config { level_bits: self.bits, scale, ..preset }
    }

    /// What the context coders are to do.
    pub fn context(&self) -> Result<ContextSettings, Failure> {
        let Some(step_m) = self.step else { return Ok(ContextSettings::COARSE) };
        if self.coder != CoderName::Context {
            return Err(Failure::Usage(
                "--step needs '--coder context': the other coders keep levels as they are".into(),
            ));
        }
        let levels = (step_m / FINE_LEVEL_M).round().max(1.0);
        let step = (levels <= f32::from(u16::MAX)).then_some(levels as u16).and_then(Step::new);
        let step = step.ok_or_else(|| Failure::Usage(format!("--step {step_m}: expected at most 131 m")))?;
        Ok(ContextSettings::FINE.with_step(step))
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
