//! The command line's words, and what `encode`, `eval` and `view` share of them.

use clap::{Args, Parser, Subcommand, ValueEnum};

use flicr::coder::{self, ContextSettings};
use flicr::{Companding, Config, Scale};

use crate::choice::{Choice, Fineness, PredictorName};
use crate::failure::Failure;
use crate::sensors::Asked;
use crate::{calibrate, compare, decode, encode, eval, info, receive, simulate, view};

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
  flicr encode street.bin -o street.flicr      120,000 points to some 50 KB, each range within 13 mm
  flicr decode street.flicr -o back.pcd        and back
  flicr eval street.bin --columns native,256   what it costs and what it saves
  flicr compare street.bin back.bin            how near a cloud is, whatever codec it came out of
  flicr view street.bin -o street.png          how it looks
  flicr calibrate drive/*.bin -o sensor.toml   the sensor's own grid, from its scans
  flicr encode turns.pcap -o turns.flicr       a frame for every turn of a capture
  flicr receive udp://0.0.0.0:2400 -o live/    a sensor's stream of datagrams, as it turns

Exit codes: 0 fine, 1 bad data, 2 bad usage.";

#[derive(Debug, Subcommand)]
pub enum Command {
    Encode(encode::Encode),
    Decode(decode::Decode),
    Info(info::Info),
    Eval(eval::Eval),
    Compare(compare::Compare),
    Simulate(simulate::Simulate),
    Calibrate(calibrate::Calibrate),
    View(view::View),
    Receive(receive::Receive),
}

impl Command {
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::Encode(encode) => encode.run(),
            Self::Decode(decode) => decode.run(),
            Self::Info(info) => info.run(),
            Self::Eval(eval) => eval.run(),
            Self::Compare(compare) => compare.run(),
            Self::Simulate(simulate) => simulate.run(),
            Self::Calibrate(calibrate) => calibrate.run(),
            Self::View(view) => view.run(),
            Self::Receive(receive) => receive.run(),
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
    /// Bits of a range, 1 to 16: the quantizer has 2^N - 1 steps [default: 16; with --preset and no
    /// --step, or with --max-range, 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    pub bits: Option<u32>,
    /// Range of the largest level; farther points are dropped and counted [default: each scan's farthest point]
    #[arg(long, value_name = "METERS", value_parser = meters)]
    pub max_range: Option<f32>,
    /// How levels are spread over ranges; by the square root, which takes --bits of 8 or fewer (or --max-range), near ranges
    /// are finer and far ones coarser: 3.7 dB more with 8 bits
    #[arg(long, value_enum, default_value_t)]
    pub companding: CompandingName,
    /// What the context coders predict a pixel from
    #[arg(long, value_enum, default_value_t)]
    pub predictor: PredictorName,
    /// Runs of columns that each frame is cut into: they decode alone, on several cores; 16 cost 1 to 4 % of a context
    /// coder's bytes, the fast tier's 2 to 6
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub strips: u16,
    /// Coder and step, which `eval` takes several of.
    #[arg(skip)]
    pub choice: Choice,
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

/// Meters, or `native`.
pub fn step(text: &str) -> Result<Step, String> {
    if text == "native" { Ok(Step::Native) } else { meters(text).map(Step::Meters) }
}

impl FrameArgs {
    /// With coder and step, those that were not said included.
    pub fn with(&self, choice: Choice) -> Self {
        let by_bits = self.preset.is_some() || self.bits.is_some() || self.max_range.is_some();
        Self { choice: choice.or_default(self.preset.is_some(), by_bits), ..self.clone() }
    }

    /// The library's configuration, but for its scale where that depends on the scan.
    pub fn config(&self) -> Config {
        let preset = match self.preset {
            Some(Preset::Paper) => Config::PAPER,
            Some(Preset::Uniform) | None => Config::UNIFORM,
        };
        let scale = match (self.choice.fineness, self.max_range) {
            (Some(_), _) if self.is_context() => Scale::Step { step_m: FINE_LEVEL_M },
            (Some(Fineness::Step(Step::Meters(step_m))), _) => Scale::Step { step_m },
            (_, Some(max_range_m)) => Scale::Fixed { max_range_m },
            _ => preset.scale,
        };
        Config { level_bits: self.bits(), scale, companding: self.companding(), strips: self.strips, ..preset }
    }

    /// Bits of a range.
    pub fn bits(&self) -> u32 {
        self.bits.unwrap_or(if self.choice.fineness.is_some() { 16 } else { 8 })
    }

    pub const fn companding(&self) -> Companding {
        match self.companding {
            CompandingName::None => Companding::None,
            CompandingName::Sqrt => Companding::SquareRoot,
        }
    }

    pub fn coder(&self) -> CoderName {
        self.choice.coder.unwrap_or(CoderName::Context)
    }

    pub fn is_context(&self) -> bool {
        self.coder() == CoderName::Context
    }

    /// The step, where it was said.
    pub fn step(&self) -> Option<Step> {
        match self.choice.fineness {
            Some(Fineness::Step(step)) => Some(step),
            _ => None,
        }
    }

    /// The sensor that was asked for; `None` where it is to be found out.
    pub fn asked(&self) -> Result<Option<Asked>, Failure> {
        if self.sensor == "auto" { Ok(None) } else { Asked::named(&self.sensor).map(Some) }
    }

    /// What the context coders are to do with levels `level_m` apart, where they choose among them.
    pub fn context(&self, level_m: f32) -> Result<ContextSettings, String> {
        let settings = ContextSettings::of_levels(level_m);
        let step_m = match self.choice.fineness {
            None => return Ok(ContextSettings::COARSE),
            Some(Fineness::Step(Step::Meters(step_m))) => step_m,
            Some(_) => return Ok(settings),
        };
        // Not coarser than asked for, but for the rounding of the division.
        let levels = (step_m / level_m + 0.001).floor().max(1.0);
        let step = (levels <= f32::from(u16::MAX)).then_some(levels as u16).and_then(coder::Step::new);
        let step = step.ok_or_else(|| format!("--step {step_m}: expected at most {} m", 65535.0 * level_m))?;
        Ok(settings.with_step(step))
    }
}

/// Distance of the levels of frames without a sensor between which the context coders step: [`FINE_LEVEL_M`], or such
/// that 16 bits reach the farthest point and a step is a whole number of them.
pub fn uniform_level_m(step: Option<Step>, farthest_m: f32) -> f32 {
    let least_m = FINE_LEVEL_M.max(farthest_m / 65_000.0);
    match step {
        Some(Step::Meters(step_m)) if step_m > least_m => step_m / (step_m / least_m).floor(),
        _ => least_m,
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// As the paper's authors do: the last point in a pixel wins, points come back at its corner
    Paper,
    /// The best of evenly spaced rows and columns: the nearest point wins and comes back in the middle
    Uniform,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum CompandingName {
    /// Evenly
    #[default]
    None,
    /// By the square root
    Sqrt,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CoderName {
    /// Run-length coding: the fastest that compresses
    Rle,
    /// LZ77 and Huffman codes, as in zip
    Deflate,
    /// Made for range images: by far the smallest, and the choice between size and error
    Context,
    /// No coding
    Store,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Tier {
    /// The fewest bytes
    #[default]
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

/// A length.
pub fn meters(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(meters) if meters.is_finite() && meters > 0.0 => Ok(meters),
        _ => Err("expected a positive number of meters".to_owned()),
    }
}
