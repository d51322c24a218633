//! The tables of `flicr eval`: one a configuration, a line a scan, medians below.

use super::measure::Measured;
use crate::table;

/// A number of the table: its heading, where it comes from, and how many decimals it is worth.
struct Figure {
    heading: &'static str,
    value: fn(&Measured) -> f64,
    decimals: usize,
}

const FIGURES: [Figure; 15] = [
    Figure { heading: "points", value: |m| m.points.into(), decimals: 0 },
    Figure { heading: "kept", value: |m| m.kept.into(), decimals: 0 },
    Figure { heading: "lost %", value: |m| 100.0 * m.se, decimals: 2 },
    Figure { heading: "bytes", value: |m| m.bytes as f64, decimals: 0 },
    Figure { heading: "xyz:1", value: |m| m.ratio_xyz, decimals: 1 },
    Figure { heading: "xyzi:1", value: |m| m.ratio_xyzi, decimals: 1 },
    Figure { heading: "bpp", value: |m| m.bpp, decimals: 2 },
    Figure { heading: "PSNR dB", value: |m| m.psnr_db, decimals: 2 },
    Figure { heading: "reverse", value: |m| m.psnr_reverse_db, decimals: 2 },
    Figure { heading: "ePSNR", value: |m| m.epsnr_db, decimals: 2 },
    Figure { heading: "CD m2", value: |m| m.cd_m2, decimals: 4 },
    Figure { heading: "mean cm", value: |m| 100.0 * m.cd_mean_m, decimals: 2 },
    Figure { heading: "max m", value: |m| m.max_error_m, decimals: 3 },
    Figure { heading: "encode ms", value: |m| m.encode_ns as f64 / 1e6, decimals: 2 },
    Figure { heading: "decode ms", value: |m| m.decode_ns as f64 / 1e6, decimals: 2 },
];

impl Figure {
    fn cell(&self, value: f64) -> String {
        format!("{value:.*}", self.decimals)
    }
}

/// A table for each geometry and number of columns, in the order in which they were measured.
pub fn tables(all: &[Measured]) -> String {
    let mut kinds: Vec<Kind<'_>> = Vec::new();
    for measured in all {
        if !kinds.contains(&kind(measured)) {
            kinds.push(kind(measured));
        }
    }
    let of = |wanted: &Kind<'_>| {
        let some: Vec<&Measured> = all.iter().filter(|measured| kind(measured) == *wanted).collect();
        one_table(&some)
    };
    kinds.iter().map(of).collect::<Vec<_>>().join("\n\n")
}

/// Sensor, geometry and columns as asked for (firings differ from turn to turn), coder and step.
type Kind<'a> = (Option<&'a str>, &'a str, &'a str, String);

fn kind(measured: &Measured) -> Kind<'_> {
    (measured.sensor.as_deref(), measured.geometry, &measured.columns_asked, coding(measured))
}

/// `16 bits, context dense, step 0.02 m`.
fn coding(measured: &Measured) -> String {
    let tier = measured.tier.as_ref().map_or_else(String::new, |tier| format!(" {tier}"));
    let step = measured.step_m.map_or_else(String::new, |step_m| format!(", step {step_m:.3} m"));
    format!("{} bits, {}{tier}{step}", measured.bits, measured.coder)
}

fn one_table(all: &[&Measured]) -> String {
    let Some(first) = all.first() else { return String::new() };
    let Measured { preset, geometry, sensor, columns, rows, .. } = first;
    let geometry = match sensor {
        Some(sensor) => format!("{sensor}, {geometry}"),
        None if preset == "paper" => preset.clone(),
        None => (*geometry).to_owned(),
    };
    let several = all.iter().any(|other| other.columns != *columns);
    let columns = if several { format!("about {columns}") } else { columns.to_string() };
    let headings: Vec<&str> = std::iter::once("file").chain(FIGURES.iter().map(|figure| figure.heading)).collect();
    let mut lines: Vec<Vec<String>> = all.iter().map(|measured| line(measured)).collect();
    if all.len() > 1 {
        lines.push(medians(all));
    }
    let table = table::aligned(&headings, &lines);
    format!("{geometry}, {columns} x {rows}, {}\n{table}", coding(first))
}

fn line(measured: &Measured) -> Vec<String> {
    let cells = FIGURES.iter().map(|figure| figure.cell((figure.value)(measured)));
    std::iter::once(measured.file.clone()).chain(cells).collect()
}

fn medians(all: &[&Measured]) -> Vec<String> {
    let median = |figure: &Figure| table::median(all.iter().map(|measured| (figure.value)(measured)));
    let cells = FIGURES.iter().map(|figure| figure.cell(median(figure)));
    std::iter::once(format!("median of {}", all.len())).chain(cells).collect()
}
