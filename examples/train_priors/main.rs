//! Finds the context coders' priors and writes them to `src/coder/context/priors.rs`:
//!
//! ```text
//! cargo run --release --features std --example train_priors -- SCAN.bin... > src/coder/context/priors.rs
//! ```
//!
//! The scans are raw KITTI files of an HDL-64E (x, y, z, intensity as f32). Those in the repository were trained on the
//! three of `kitti/object/`; nothing else may be, for all others are what the coders are measured on.

mod firings;

use std::path::Path;
use std::process::ExitCode;

use flicr::ImageView;
use flicr::coder::context::train::{DenseLearner, SmallLearner, train};

use firings::{Firings, Shifts};

/// In levels of 2 mm: from 31 cm to 2 mm.
const STEPS: [u16; 7] = [157, 101, 51, 25, 10, 5, 1];
const NUMBERS_A_LINE: usize = 24;

fn main() -> ExitCode {
    let paths: Vec<_> = std::env::args().skip(1).collect();
    let Some(first) = paths.first() else {
        eprintln!("usage: train_priors SCAN.bin... > src/coder/context/priors.rs");
        return ExitCode::from(2);
    };
    let scans = Shifts::read(Path::new(first)).and_then(|shifts| {
        paths.iter().map(|path| Firings::read(Path::new(path), &shifts)).collect::<Result<Vec<_>, _>>()
    });
    match scans {
        Ok(scans) => {
            print_priors(&scans);
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn print_priors(scans: &[Firings]) {
    let images: Vec<ImageView<'_, u16>> = scans.iter().filter_map(Firings::image).collect();
    println!(
        "//! What the models know before anything was coded. Written by `examples/train_priors`: trained on three raw"
    );
    println!("//! scans of KITTI's HDL-64E (`kitti/object/`) at steps of 2 mm to 31 cm.");
    let (small, dense) = (train::<SmallLearner>(&images, &STEPS), train::<DenseLearner>(&images, &STEPS));
    print_table("Probabilities of the small tier", "SMALL: [u8; super::small::PROBABILITIES]", &small);
    print_table("Logits of the dense tier", "DENSE: [i8; super::dense::LOGITS]", &dense);
}

fn print_table(what: &str, name_and_type: &str, values: &[i32]) {
    println!("\n/// {what}, in the order of its tables.\n#[rustfmt::skip]\npub(super) const {name_and_type} = [");
    for line in values.chunks(NUMBERS_A_LINE) {
        let numbers: Vec<_> = line.iter().map(i32::to_string).collect();
        println!("    {},", numbers.join(", "));
    }
    println!("];");
}
