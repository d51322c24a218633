//! What a control makes of a link that changes: a table and a picture.
//!
//! ```text
//! cargo run --release --features std --example control -- control.csv control.svg
//! ```

#[path = "../tests/common/link.rs"]
mod link;

use std::fmt::Write;
use std::process::ExitCode;

use flicr::coder::Step;
use flicr::control::Bounds;
use link::{Link, Outcome, run};

const TURNS: usize = 40;

fn main() -> ExitCode {
    let [Some(table), Some(picture)] = [1, 2].map(|nth| std::env::args().nth(nth)) else {
        eprintln!("usage: control TABLE.csv PICTURE.svg");
        return ExitCode::from(2);
    };
    let link = Link { loss: 0.01, delay_us: 30_000, feedback_us: 40_000, seed: 5 };
    // 2 mm to 31 cm, every fourth column at least.
    let [finest, coarsest] = [1, 157].map(|levels| Step::new(levels).unwrap_or(Step::LOSSLESS));
    let outcomes = run(link, TURNS, Bounds { finest, coarsest, stride_max: 4 });
    let written = std::fs::write(&table, csv(&outcomes)).and_then(|()| std::fs::write(&picture, svg(&outcomes)));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{table}, {picture}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn csv(outcomes: &[Outcome]) -> String {
    let mut csv = String::from(
        "turn,link_bytes_a_turn,budget_bytes,bytes,finest_mm,coarsest_mm,stride,columns_cut,latency_ms,strips_sent,\
         strips_received,columns_received\n",
    );
    for Outcome { report, bandwidth, latency_us, strips_sent, strips_received, columns_received, .. } in outcomes {
        let (finest_mm, coarsest_mm) = (2 * report.finest, 2 * report.coarsest);
        let _ = writeln!(
            csv,
            "{},{},{},{},{finest_mm},{coarsest_mm},{},{},{:.1},{strips_sent},{strips_received},{columns_received:.3}",
            report.turn,
            bandwidth / 10,
            report.budget,
            report.bytes,
            report.stride,
            report.cut,
            *latency_us as f64 / 1e3
        );
    }
    csv
}

const WIDTH: f64 = 760.0;
const PANEL: f64 = 130.0;

/// Panels one below the other, the turn to the right.
fn svg(outcomes: &[Outcome]) -> String {
    type Value = fn(&Outcome) -> f64;
    let panels: [(&str, &[(&str, Value)]); 4] = [
        (
            "KB a turn",
            &[
                ("silver", |turn| f64::from(turn.bandwidth) / 1e4),
                ("steelblue", |turn| f64::from(turn.report.bytes) / 1e3),
            ],
        ),
        (
            "step, mm",
            &[
                ("orange", |turn| f64::from(2 * turn.report.coarsest)),
                ("firebrick", |turn| f64::from(2 * turn.report.finest)),
            ],
        ),
        ("latency, ms", &[("seagreen", |turn| turn.latency_us as f64 / 1e3)]),
        ("columns received, %", &[("purple", |turn| 100.0 * turn.columns_received)]),
    ];
    let height = PANEL * panels.len() as f64;
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{WIDTH}' height='{height}' font-family='sans-serif' font-size='12'>\n\
         <rect width='100%' height='100%' fill='white'/>\n"
    );
    for (number, (title, curves)) in panels.into_iter().enumerate() {
        let top = PANEL * number as f64;
        let most = curves.iter().flat_map(|(_, value)| outcomes.iter().map(value)).fold(1e-9, f64::max);
        let _ = writeln!(svg, "<text x='8' y='{:.0}'>{title}, up to {most:.0}</text>", top + 16.0);
        for (color, value) in curves {
            let at = |(turn, outcome): (usize, &Outcome)| {
                let x = 8.0 + (WIDTH - 16.0) * turn as f64 / (outcomes.len() - 1).max(1) as f64;
                format!("{x:.1},{:.1}", top + PANEL - 4.0 - (PANEL - 28.0) * value(outcome) / most)
            };
            let points: Vec<_> = outcomes.iter().enumerate().map(at).collect();
            let _ = writeln!(
                svg,
                "<polyline fill='none' stroke='{color}' stroke-width='2' points='{}'/>",
                points.join(" ")
            );
        }
    }
    svg.push_str("</svg>\n");
    svg
}
