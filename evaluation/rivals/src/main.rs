//! One codec on one scan: `flicr-rivals codec NAME SCAN CLOUD RUNS`. Prints a line of JSON (bytes, times, energy where the
//! machine counts it) and writes the cloud that came back. evaluation/rivals.py calls it; `MODES` lists what else there is.

mod authors;
mod cloud;
mod codec;
mod cost;
mod picture;
mod projection;
#[cfg(feature = "codecs")]
mod promises;
mod stages;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use serde_json::Value;

type Outcome = Result<Value, Box<dyn Error>>;

const MODES: &str = "\
usage: flicr-rivals codec NAME SCAN CLOUD RUNS    a codec: see codec.rs and authors.rs for names
       flicr-rivals image COLUMNS SCAN IMAGE      the authors' 8-bit image, a byte a pixel; JSON has its largest range
       flicr-rivals unimage COLUMNS MAX IMAGE CLOUD
       flicr-rivals project COLUMNS SCAN RUNS     times of points to image: the authors' way and flicr's
       flicr-rivals stages FRAME SCAN RUNS        times of flicr's stages: see stages.rs for frames
       flicr-rivals promises SCAN...              flicr's shares of others' bytes and times: see promises.rs";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&words) {
        Ok(value) => {
            println!("{value}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("flicr-rivals: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(words: &[&str]) -> Outcome {
    match *words {
        ["codec", name, scan, cloud, runs] => {
            codec::run(name, &cloud::read(Path::new(scan))?, Path::new(cloud), runs.parse()?)
        }
        ["image", columns, scan, image] => {
            picture::write(columns.parse()?, &cloud::read(Path::new(scan))?, Path::new(image))
        }
        ["unimage", columns, max_m, image, cloud] => {
            picture::read(columns.parse()?, max_m.parse()?, Path::new(image), Path::new(cloud))
        }
        ["project", columns, scan, runs] => {
            projection::run(columns.parse()?, &cloud::read(Path::new(scan))?, runs.parse()?)
        }
        #[cfg(feature = "codecs")]
        ["promises", ref scans @ ..] if !scans.is_empty() => promises::run(scans),
        ["stages", frame, scan, runs] => stages::run(frame, &cloud::read(Path::new(scan))?, runs.parse()?),
        _ => Err(MODES.into()),
    }
}
