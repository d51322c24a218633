//! What is found out by trial: the predictor, and the step for a bound or a length.

use flicr::coder::{Predictor, Step};
use flicr::{Geometry, Stamp, frame};

use super::Codec;
use crate::args::Tier;
use crate::choice::{Fineness, PredictorName};
use crate::input::Scan;

/// The coarsest step there is, levels.
const COARSEST: u16 = u16::MAX;

impl Codec {
    /// Settles the context coders' settings for a scan that the memory is there for.
    pub(super) fn choose(&mut self, scan: &Scan) -> Result<(), String> {
        if !self.args.is_context() {
            return Ok(());
        }
        self.choose_predictor(scan)?;
        match self.args.choice.fineness {
            Some(Fineness::Bound(bound_m)) => self.choose_bound(scan, bound_m),
            Some(Fineness::TargetBytes(len)) => self.choose_len(scan, len),
            _ => Ok(()),
        }
    }

    fn choose_predictor(&mut self, scan: &Scan) -> Result<(), String> {
        let asked = self.args.predictor;
        let predictor = match asked {
            PredictorName::Auto if self.args.choice.tier != Tier::Fast => self.shorter_predictor(scan)?,
            PredictorName::Auto | PredictorName::West => Predictor::West,
            PredictorName::MedianEdge => Predictor::MedianEdge,
        };
        self.settings.predictor = predictor;
        self.coder.set(self.settings);
        Ok(())
    }

    fn shorter_predictor(&mut self, scan: &Scan) -> Result<Predictor, String> {
        let mut len = |predictor| {
            self.settings.predictor = predictor;
            self.trial(scan)
        };
        let median_edge_is_shorter = len(Predictor::MedianEdge)? < len(Predictor::West)?;
        Ok(if median_edge_is_shorter { Predictor::MedianEdge } else { Predictor::West })
    }

    /// Bytes of the frame with the settings as they are.
    fn trial(&mut self, scan: &Scan) -> Result<usize, String> {
        self.coder.set(self.settings);
        let encoded = self.encode_alone(scan, Stamp::default()).map_err(|error| error.to_string())?;
        Ok(encoded.len)
    }

    fn trial_of_step(&mut self, scan: &Scan, levels: u16) -> Result<usize, String> {
        self.settings.step = Step::new(levels).unwrap_or(Step::LOSSLESS);
        self.trial(scan)
    }

    fn choose_bound(&mut self, scan: &Scan, bound_m: f32) -> Result<(), String> {
        if self.plan.shape.sensor().is_none() {
            let why = &self.plan.why;
            return Err(format!(
                "no sensor's grid, so no bound: a point comes back in the middle of its pixel ({why})"
            ));
        }
        let keeps = |codec: &mut Self, levels| {
            codec.trial_of_step(scan, levels)?;
            codec.bound_m().map(|found_m| found_m <= bound_m)
        };
        if !keeps(self, 1)? {
            let least_m = self.bound_m()?;
            let why = &self.plan.why;
            return Err(format!(
                "--bound {bound_m}: without any step, points come back up to {least_m} m away ({why})"
            ));
        }
        let (mut fits, mut too_coarse) = (1, COARSEST);
        while too_coarse - fits > 1 {
            let middle = fits + (too_coarse - fits) / 2;
            if keeps(self, middle)? { fits = middle } else { too_coarse = middle }
        }
        self.trial_of_step(scan, fits).map(|_| ())
    }

    /// How far a point of the last frame can be from where it was, meters; of packets, its range.
    fn bound_m(&self) -> Result<f32, String> {
        let header = frame::parse_header(self.frame()).map_err(|error| error.to_string())?;
        let of_points = match header.geometry {
            Geometry::Beams(beams) => Some(beams.point_bound_m).filter(|bound_m| bound_m.is_finite()),
            _ => None,
        };
        Ok(of_points.unwrap_or(header.range_bound_m()))
    }

    fn choose_len(&mut self, scan: &Scan, most: usize) -> Result<(), String> {
        let least = self.trial_of_step(scan, COARSEST)?;
        if least > most {
            return Err(format!("--target-bytes {most}: even with the coarsest step a frame takes {least}"));
        }
        if self.trial_of_step(scan, 1)? <= most {
            return Ok(());
        }
        // What is too long only gets longer with a finer step, or nearly so: what is chosen was seen to fit.
        let (mut too_long, mut fits) = (1, COARSEST);
        while fits - too_long > 1 {
            let middle = too_long + (fits - too_long) / 2;
            if self.trial_of_step(scan, middle)? <= most { fits = middle } else { too_long = middle }
        }
        self.trial_of_step(scan, fits).map(|_| ())
    }

    /// What was found out and is worth a word: the step for a bound or a length.
    pub fn chosen(&self) -> Option<String> {
        match self.args.choice.fineness {
            Some(Fineness::Bound(_) | Fineness::TargetBytes(_)) => {
                Some(format!("step {:.4} m", self.step_m().unwrap_or_default()))
            }
            _ => None,
        }
    }
}
