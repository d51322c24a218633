//! `flicr compare`: how near one point cloud is to another.

use std::path::{Path, PathBuf};

use clap::Args;
use flicr::files::{self, Format};
use flicr::metrics::{self, Cloud, EpsnrParameters, MetricError, PAPER_MAX_RANGE_M, Quality};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::args::meters;
use crate::failure::Failure;
use crate::info::json;
use crate::input::Scan;
use crate::{console, table};

/// Compare a point cloud with the scan that it was made of, whatever codec made it
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Compare {
    /// The scan: .bin (KITTI), .xyzir.bin or .pcd
    original: PathBuf,
    /// What came back, in any of these formats
    decoded: PathBuf,
    /// One JSON object on a line
    #[arg(long)]
    json: bool,
    /// Peak of the PSNR: the paper's is 80
    #[arg(long, value_name = "METERS", default_value_t = PAPER_MAX_RANGE_M as f32, value_parser = meters)]
    peak: f32,
}

const EXAMPLES: &str = "\
Measures (JSON names), as of 'flicr eval':
  points, decoded   returns of the scan (points at the origin are none), and points that came back
  se, epsnr_db      share that is missing, and psnr_db made to reflect it; null where more came back than there were
  psnr_db           from decoded points to the nearest original; psnr_reverse_db: the other way; null: infinite
  cd_m2, cd_mean_m  both ways' mean squared distances added, and the mean of both ways' mean distances
  max_error_m       the largest distance from a decoded point to the nearest original; max_error_reverse_m: the other way

Examples:
  flicr compare scan.bin back.bin
  flicr compare scan.bin draco.pcd --json";

#[derive(Debug, Serialize)]
struct Compared {
    original: String,
    decoded_file: String,
    points: usize,
    decoded: usize,
    se: Option<f64>,
    psnr_db: f64,
    psnr_reverse_db: f64,
    cd_m2: f64,
    cd_mean_m: f64,
    epsnr_db: Option<f64>,
    max_error_m: f64,
    max_error_reverse_m: f64,
}

impl Compare {
    pub fn run(self) -> Result<(), Failure> {
        let (original, decoded) = (returns(&self.original)?, returns(&self.decoded)?);
        let wrong = |error| Failure::data(self.file_of(&error), error);
        let quality = metrics::compare(&original, &decoded, self.peak.into()).map_err(wrong)?;
        let compared = self.compared((original.len(), decoded.len()), &quality).map_err(wrong)?;
        let text = if self.json { json(&compared) } else { compared.text() };
        console::line(&ProgressBar::hidden(), text)
    }

    /// Whose fault an error is.
    fn file_of(&self, error: &MetricError) -> &Path {
        match error {
            MetricError::Empty { cloud: Cloud::Original } | MetricError::NotFinite { cloud: Cloud::Original, .. } => {
                &self.original
            }
            _ => &self.decoded,
        }
    }

    fn compared(&self, (points, decoded): (usize, usize), quality: &Quality) -> Result<Compared, MetricError> {
        // A codec may also invent points: then none of these two means anything.
        let se = (decoded <= points).then(|| metrics::sampling_error(points, decoded)).transpose()?;
        let epsnr_db = se.map(|se| metrics::epsnr_db(quality.psnr_db, se, EpsnrParameters::PAPER)).transpose()?;
        Ok(Compared {
            original: self.original.display().to_string(),
            decoded_file: self.decoded.display().to_string(),
            points,
            decoded,
            se,
            psnr_db: quality.psnr_db,
            psnr_reverse_db: quality.psnr_reverse_db,
            cd_m2: quality.cd_m2,
            cd_mean_m: quality.cd_mean_m,
            epsnr_db,
            max_error_m: quality.max_error_m,
            max_error_reverse_m: quality.max_error_reverse_m,
        })
    }
}

/// Points that something was measured at.
fn returns(file: &Path) -> Result<Vec<[f32; 3]>, Failure> {
    match Format::of(file) {
        Some(Format::Kitti | Format::KittiRing | Format::Pcd) => {
            Ok(Scan { cloud: files::read(file)?, ..Scan::default() }.returns())
        }
        _ => Err(Failure::usage(file, "unknown kind of file: expected .bin, .xyzir.bin or .pcd")),
    }
}

impl Compared {
    fn text(&self) -> String {
        let number =
            |value: Option<f64>, decimals| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"));
        let lines = [
            ("points", self.points.to_string(), "decoded", self.decoded.to_string()),
            ("lost %", number(self.se.map(|se| 100.0 * se), 2), "ePSNR dB", number(self.epsnr_db, 2)),
            ("PSNR dB", number(Some(self.psnr_db), 2), "reverse", number(Some(self.psnr_reverse_db), 2)),
            ("CD m2", number(Some(self.cd_m2), 6), "mean cm", number(Some(100.0 * self.cd_mean_m), 3)),
            ("max m", number(Some(self.max_error_m), 4), "reverse", number(Some(self.max_error_reverse_m), 4)),
        ];
        let rows: Vec<Vec<String>> =
            lines.iter().map(|(a, b, c, d)| vec![(*a).to_owned(), b.clone(), (*c).to_owned(), d.clone()]).collect();
        table::aligned(&["measure", "value", "measure", "value"], &rows)
    }
}
