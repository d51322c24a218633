//! Makes `src/coder/context/fast/priors.bin`, the probabilities of the fast tier, from the three scans of KITTI's
//! object benchmark: `cargo run --release --features std --example train_fast`. The same scans give the same file.

#[path = "../tests/common/data.rs"]
mod data;
#[path = "../tests/common/firings.rs"]
mod firings;

use flicr::coder::fast_lab::{CELLS, CONTEXTS, Census, KINDS, NIBBLES, SYMBOLS, TABLES, kind};
use flicr::coder::{ContextSettings, Step};

/// Steps that are trained, in levels of 2 mm.
const STEPS: [u16; 11] = [1, 2, 3, 5, 10, 25, 40, 51, 80, 101, 157];
/// The sum of a table's frequencies.
const TOTAL: u16 = 4096;
/// How many more of its parent's symbols each cell is taken to have had.
const PARENT_WEIGHT: f64 = 16.0;
const ROUNDS: usize = 30;

type Shares = [f64; SYMBOLS];

fn main() {
    let scans: Vec<_> = (0..3).map(|n| data::read_points(&data::path(&format!("kitti/object/{n:06}.bin")))).collect();
    let turns = firings::turns(scans.iter().map(Vec::as_slice));
    let mut cells = vec![[0.0; SYMBOLS]; KINDS * CELLS];
    let mut nibbles = vec![[0.0; NIBBLES]; CONTEXTS];
    for step in STEPS.map(|levels| Step::new(levels).unwrap()) {
        let mut census = Census::default();
        for turn in &turns {
            census.add(turn.view(), ContextSettings::FINE.with_step(step));
        }
        add(&mut cells[kind(step) * CELLS..], &census.symbols);
        add(&mut nibbles, &census.nibbles);
    }
    let shares = smoothed(&cells);
    let (tables, assigned) = cluster(&cells, &shares);
    let mut file: Vec<u8> = assigned.iter().map(|&table| table as u8).collect();
    for frequencies in frequencies_of_tables(&cells, &tables, &assigned) {
        file.extend(frequencies.iter().flat_map(|f| f.to_le_bytes()));
    }
    for frequencies in frequencies_of_nibbles(&nibbles) {
        file.extend(frequencies.iter().flat_map(|f| f.to_le_bytes()));
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/coder/context/fast/priors.bin");
    std::fs::write(path, &file).unwrap();
    println!("{} bytes", file.len());
}

fn add<const N: usize>(to: &mut [[f64; N]], counts: &[[u32; N]]) {
    let pairs = to.iter_mut().flatten().zip(counts.iter().flatten());
    pairs.for_each(|(to, &count)| *to += f64::from(count));
}

fn sum<'a, const N: usize>(rows: impl IntoIterator<Item = &'a [f64; N]>) -> [f64; N] {
    let mut sum = [0.0; N];
    for row in rows {
        sum.iter_mut().zip(row).for_each(|(sum, count)| *sum += count);
    }
    sum
}

/// Counts and `weight` times `like`, as shares.
fn mixed<const N: usize>(counts: &[f64; N], like: &[f64; N], weight: f64) -> [f64; N] {
    let total = counts.iter().sum::<f64>() + weight;
    std::array::from_fn(|i| (counts[i] + weight * like[i]) / total)
}

/// Each cell's shares, leaning on those of all cells of its energy.
fn smoothed(cells: &[[f64; SYMBOLS]]) -> Vec<Shares> {
    const ENERGIES: usize = 20;
    let all = mixed(&sum(cells), &[1.0 / SYMBOLS as f64; SYMBOLS], 1.0);
    let parents = cells.chunks(CELLS / ENERGIES);
    parents
        .flat_map(|cells| {
            cells.iter().map({
                let parent = mixed(&sum(cells), &all, 4.0);
                move |cell| mixed(cell, &parent, PARENT_WEIGHT)
            })
        })
        .collect()
}

fn log2(shares: &Shares) -> Shares {
    shares.map(|share| libm::log2(share.max(1e-9)))
}

fn dot(a: &Shares, b: &Shares) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Shares the tables out among the cells so that the code is short: k-means with bits as the distance.
fn cluster(cells: &[[f64; SYMBOLS]], shares: &[Shares]) -> (Vec<Shares>, Vec<usize>) {
    let weights: Vec<f64> = cells.iter().map(|cell| cell.iter().sum()).collect();
    let mut seen: Vec<usize> = (0..cells.len()).filter(|&cell| weights[cell] > 0.0).collect();
    let entropy: Vec<f64> = shares.iter().map(|shares| -dot(shares, &log2(shares))).collect();
    seen.sort_by(|&a, &b| entropy[a].total_cmp(&entropy[b]));
    let total: f64 = weights.iter().sum();
    let mut before = 0.0;
    let mut assigned = vec![0; cells.len()];
    for &cell in &seen {
        assigned[cell] = ((before / total * TABLES as f64) as usize).min(TABLES - 1);
        before += weights[cell];
    }
    let mut tables = vec![[1.0 / SYMBOLS as f64; SYMBOLS]; TABLES];
    for _ in 0..ROUNDS {
        let mut sums = vec![[0.0; SYMBOLS]; TABLES];
        for &cell in &seen {
            let sums = &mut sums[assigned[cell]];
            sums.iter_mut().zip(&shares[cell]).for_each(|(sum, share)| *sum += share * weights[cell]);
        }
        for (table, sums) in tables.iter_mut().zip(&sums) {
            if sums.iter().sum::<f64>() > 0.0 {
                *table = mixed(sums, table, 1e-3);
            }
        }
        let logs: Vec<Shares> = tables.iter().map(log2).collect();
        for (assigned, shares) in assigned.iter_mut().zip(shares) {
            *assigned = (0..TABLES).max_by(|&a, &b| dot(shares, &logs[a]).total_cmp(&dot(shares, &logs[b]))).unwrap();
        }
    }
    (tables, assigned)
}

fn frequencies_of_tables(cells: &[[f64; SYMBOLS]], tables: &[Shares], assigned: &[usize]) -> Vec<[u16; SYMBOLS]> {
    let of = |table: usize| cells.iter().zip(assigned).filter(move |(_, a)| **a == table).map(|(cell, _)| cell);
    let table = |table: usize| frequencies(&escaped(mixed(&sum(of(table)), &tables[table], 2.0)));
    (0..TABLES).map(table).collect()
}

/// Leaves symbols that are too rare for a frequency to the escape.
fn escaped(mut shares: Shares) -> Shares {
    let mut rare = 0.0;
    for symbol in (1..SYMBOLS - 1).rev() {
        if rare + shares[symbol] > 0.7 / f64::from(TOTAL) {
            break;
        }
        rare += std::mem::take(&mut shares[symbol]);
    }
    let kept = shares.iter().rposition(|&share| share > 0.0).unwrap_or(0);
    shares[..=kept].iter_mut().for_each(|share| *share = share.max(1e-9));
    shares[SYMBOLS - 1] = rare.max(1e-9);
    shares
}

/// Frequencies of at least one where there is a share, that sum up.
fn frequencies<const N: usize>(shares: &[f64; N]) -> [u16; N] {
    let all: f64 = shares.iter().sum();
    let wanted = shares.map(|share| share / all * f64::from(TOTAL));
    let mut found = wanted.map(|wanted| if wanted > 0.0 { (wanted.round() as u16).max(1) } else { 0 });
    loop {
        let off = i32::from(found.iter().sum::<u16>()) - i32::from(TOTAL);
        // One more or less where it changes the length of the code least.
        let gain = |i: usize| wanted[i] * (libm::log2(f64::from(found[i]) + 1.0) - libm::log2(f64::from(found[i])));
        let loss = |i: usize| wanted[i] * (libm::log2(f64::from(found[i])) - libm::log2(f64::from(found[i]) - 1.0));
        match off {
            0 => return found,
            1.. => {
                let i = (0..N).filter(|&i| found[i] > 1).min_by(|&a, &b| loss(a).total_cmp(&loss(b))).unwrap();
                found[i] -= 1;
            }
            _ => {
                let i = (0..N).filter(|&i| found[i] > 0).max_by(|&a, &b| gain(a).total_cmp(&gain(b))).unwrap();
                found[i] += 1;
            }
        }
    }
}

/// The first 32 contexts are of changed groups, by the changes before and by halves; then come three kinds of changed
/// rows by what was before. Each leans on all of its kind.
fn frequencies_of_nibbles(nibbles: &[[f64; NIBBLES]]) -> Vec<[u16; NIBBLES]> {
    let kind = |context: usize| if context < 32 { context % 2 } else { 2 + (context - 32) % 3 };
    let even = [1.0 / NIBBLES as f64; NIBBLES];
    let like = |k: usize| mixed(&sum((0..CONTEXTS).filter(|&c| kind(c) == k).map(|c| &nibbles[c])), &even, 1.0);
    let likes: Vec<_> = (0..5).map(like).collect();
    let shares = nibbles.iter().enumerate().map(|(c, counts)| mixed(counts, &likes[kind(c)], 8.0));
    let shares = shares.enumerate().map(|(c, mut shares)| {
        if kind(c) == 4 {
            // The second nibble of a changed group whose first did not change is not 0.
            shares[0] = 0.0;
        }
        shares
    });
    shares.map(|shares| frequencies(&shares)).collect()
}
