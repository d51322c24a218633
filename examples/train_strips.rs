//! Finds what the small tier knows at the beginning of strips and writes it to `src/coder/context/strip_priors.rs`:
//!
//! ```text
//! cargo run --release --features std --example train_strips -- SCAN.bin... > src/coder/context/strip_priors.rs
//! ```
//!
//! The scans are raw KITTI files of an HDL-64E (x, y, z, intensity as f32). What is in the repository was trained on the three
//! of `kitti/object/`; nothing else may be, for all others are what streams are measured on.

use std::f64::consts::TAU;
use std::process::ExitCode;

use flicr::coder::context::train_strips::train_strips;
use flicr::geometry::{Firings, Lattice, find_firings, sensors::hdl64e};
use flicr::{FiringsConfig, ImageView, ImageViewMut, LatticeConfig, Stamp, Store, encode};

/// In levels of 2 mm, by coarseness.
const STEPS: [&[u16]; 4] = [&[1], &[20, 10, 5], &[75, 51, 25], &[157, 101]];
const NUMBERS_A_LINE: usize = 24;
const ROWS: usize = 64;

/// A turn's range counts, row-major.
struct Turn {
    columns: usize,
    aligned: Vec<u16>,
    fired: Vec<u16>,
}

fn main() -> ExitCode {
    let paths: Vec<_> = std::env::args().skip(1).collect();
    let turns: Result<Vec<_>, _> = paths.iter().map(|path| read(path)).collect();
    match turns {
        Ok(turns) if !turns.is_empty() => {
            print_priors(&turns);
            ExitCode::SUCCESS
        }
        Ok(_) => {
            eprintln!("usage: train_strips SCAN.bin... > src/coder/context/strip_priors.rs");
            ExitCode::from(2)
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn read(path: &str) -> Result<Turn, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("{path}: {error}");
    let bytes = std::fs::read(path).map_err(|error| wrong(&error))?;
    let point = |point: &[u8; 16]| std::array::from_fn(|i| f32::from_le_bytes(point.as_chunks().0[i]));
    let points: Vec<[f32; 3]> = bytes.as_chunks().0.iter().map(point).collect();
    let found = find_firings(points.as_slice(), &hdl64e::FIRING_GRID).map_err(|error| wrong(&error))?;
    let ticks = found.ok_or_else(|| wrong(&"no firings that the beams share"))?.ticks;
    let firings = Firings::<125>::new(hdl64e::TICKS, ticks).map_err(|error| wrong(&error))?;
    let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, 4000).map_err(|error| wrong(&error))?;
    let config = FiringsConfig { every_tick: LatticeConfig::new(&lattice), firings: &firings };
    let columns = usize::from(firings.len());
    let mut aligned = vec![0_u16; ROWS * columns];
    let mut out = vec![0; config.worst_case_len::<u16, Store>()];
    let image = ImageViewMut::new(&mut aligned, columns).ok_or_else(|| wrong(&"no image"))?;
    encode(&config, points.as_slice(), Stamp::default(), image, &mut Store::new(), &mut out)
        .map_err(|error| wrong(&error))?;
    let mut fired = aligned.clone();
    for (row, beam) in fired.chunks_exact_mut(columns).zip(&hdl64e::FIRING_BEAMS) {
        let shift = f64::from(beam.azimuth_phase_rad) / TAU * columns as f64;
        row.rotate_left(shift.round_ties_even().rem_euclid(columns as f64) as usize);
    }
    Ok(Turn { columns, aligned, fired })
}

fn print_priors(turns: &[Turn]) {
    println!(
        "//! What the small tier knows at the beginning of strips. Written by `examples/train_strips`: trained on three raw scans"
    );
    println!("//! of KITTI's HDL-64E (`kitti/object/`) at steps of 2 mm to 31 cm.\n");
    println!("use super::small::PROBABILITIES;\nuse super::strip::COARSENESSES;\n");
    println!(
        "/// By order (as fired, aligned) and coarseness of steps: probabilities of the first column, and of the others, in the order"
    );
    println!("/// of the tier's tables.\n#[rustfmt::skip]");
    println!("pub(super) static SMALL: [[[[u8; PROBABILITIES]; 2]; COARSENESSES]; 2] = [");
    let orders: [fn(&Turn) -> &[u16]; 2] = [|turn| &turn.fired, |turn| &turn.aligned];
    for levels in orders {
        println!("    [");
        let images: Vec<_> = turns.iter().filter_map(|turn| ImageView::new(levels(turn), turn.columns)).collect();
        for steps in STEPS {
            println!("        [");
            for table in train_strips(&images, steps) {
                print_table(&table);
            }
            println!("        ],");
        }
        println!("    ],");
    }
    println!("];");
}

fn print_table(values: &[i32]) {
    println!("            [");
    for line in values.chunks(NUMBERS_A_LINE) {
        let numbers: Vec<_> = line.iter().map(i32::to_string).collect();
        println!("                {},", numbers.join(", "));
    }
    println!("            ],");
}
