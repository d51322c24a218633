//! Coder, tier, predictor and step: one of each for `encode` and `view`, several for `eval`.

use clap::{Args, ValueEnum};

use crate::args::{CoderName, Step, Tier, meters, step};

/// The default: odometry and detection cannot tell a scan kept in steps of 2 cm from the original.
const DEFAULT_STEP: Step = Step::Meters(0.02);

/// What codes a frame, and how finely.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Choice {
    /// `None` where it was not said.
    pub coder: Option<CoderName>,
    pub tier: Tier,
    pub fineness: Option<Fineness>,
}

/// How finely ranges are kept, where bits and the largest range do not say it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fineness {
    Step(Step),
    /// The coarsest step that keeps every point as near to where it was, meters.
    Bound(f32),
    /// The finest step whose frame is no longer.
    TargetBytes(usize),
}

/// Of `encode` and `view`.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Frame")]
pub struct ChoiceArgs {
    /// How finely ranges are kept; native is the sensor's range count, and without loss on its own grid. The context
    /// coders keep a range within 0.6 of it, the others within 0.5 [default: 0.02; with --preset, --bits or --max-range
    /// the bits decide]
    #[arg(long, value_name = "METERS|native", value_parser = step, conflicts_with = "max_range")]
    step: Option<Step>,
    /// The coarsest step that leaves every point of a scan on its sensor's grid within so many meters; where the grid
    /// cannot promise that, the scan is refused
    #[arg(long, value_name = "METERS", value_parser = meters, conflicts_with_all = ["step", "target_bytes", "max_range", "preset"])]
    bound: Option<f32>,
    /// The finest step whose frame takes no more bytes, found anew for each frame
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with_all = ["step", "max_range"])]
    target_bytes: Option<u32>,
    /// What codes the range image [default: context; with --preset deflate]
    #[arg(long, value_enum)]
    coder: Option<CoderName>,
    /// Which of the context coders
    #[arg(long, value_enum, default_value_t)]
    tier: Tier,
}

/// Of `eval`: every coder and tier with every step.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Frame")]
pub struct ChoicesArgs {
    /// How finely ranges are kept, as of `encode`; several with commas: native,0.02,0.1 [default: 0.02; with --preset,
    /// --bits or --max-range the bits decide]
    #[arg(long, value_name = "METERS|native,...", value_delimiter = ',', value_parser = step, conflicts_with = "max_range")]
    step: Vec<Step>,
    /// What codes the range image; several with commas [default: context; with --preset deflate]
    #[arg(long, value_enum, value_delimiter = ',')]
    coder: Vec<CoderName>,
    /// Which of the context coders; several with commas [default: dense]
    #[arg(long, value_enum, value_delimiter = ',')]
    tier: Vec<Tier>,
}

/// What a pixel is predicted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PredictorName {
    /// Whichever of the two makes the smaller frame
    #[default]
    Auto,
    /// The last pixel of its beam
    West,
    /// That, the one above and the one between
    MedianEdge,
}

impl ChoiceArgs {
    pub fn choice(&self) -> Choice {
        let fineness = match (self.step, self.bound, self.target_bytes) {
            (Some(step), ..) => Some(Fineness::Step(step)),
            (_, Some(bound_m), _) => Some(Fineness::Bound(bound_m)),
            (.., Some(bytes)) => Some(Fineness::TargetBytes(bytes as usize)),
            _ => None,
        };
        Choice { coder: self.coder, tier: self.tier, fineness }
    }
}

impl ChoicesArgs {
    /// Each once.
    pub fn choices(&self) -> Vec<Choice> {
        let coders = or_none(self.coder.iter().copied().map(Some).collect());
        let finenesses = or_none(self.step.iter().map(|&step| Some(Fineness::Step(step))).collect());
        let tiers = if self.tier.is_empty() { vec![Tier::Dense] } else { self.tier.clone() };
        let mut choices = Vec::new();
        for coder in coders {
            for tier in &tiers {
                // Other coders have no tiers.
                let tier = if coder.is_none_or(|coder| coder == CoderName::Context) { *tier } else { Tier::Dense };
                for &fineness in &finenesses {
                    let choice = Choice { coder, tier, fineness };
                    if !choices.contains(&choice) {
                        choices.push(choice);
                    }
                }
            }
        }
        choices
    }
}

fn or_none<T>(values: Vec<Option<T>>) -> Vec<Option<T>> {
    if values.is_empty() { vec![None] } else { values }
}

impl Choice {
    /// With what is taken where nothing is said; `by_bits` where bits or the largest range say how finely.
    pub fn or_default(self, preset: bool, by_bits: bool) -> Self {
        let coder = if preset { CoderName::Deflate } else { CoderName::Context };
        let by_step = if by_bits { None } else { Some(Fineness::Step(DEFAULT_STEP)) };
        Self { coder: self.coder.or(Some(coder)), fineness: self.fineness.or(by_step), ..self }
    }
}
