//! What a calibration found, for people: a line a beam, and the sums below.

use flicr::calibrate::{BeamResiduals, Calibration, OFF_GRID_M, Spread};
use flicr::sensor::Beam;

use crate::sensors::{self, OwnedGrid};
use crate::table::{self, grouped};

const HEADINGS: [&str; 9] =
    ["beam", "elevation", "points", "across rms", "max", "around rms", "max", "along rms mm", "max"];

/// The table of residuals and what the scans say of the whole sensor.
pub fn text(found: &Calibration) -> String {
    let beams = found.sensor.beams.iter().zip(&found.residuals.beams).enumerate();
    let lines: Vec<Vec<String>> = beams.map(|(row, (beam, residuals))| line(row, beam, residuals)).collect();
    format!("{}\n{}", table::aligned(&HEADINGS, &lines), summary(found))
}

fn line(row: usize, beam: &Beam, residuals: &BeamResiduals) -> Vec<String> {
    let BeamResiduals { points, across, around, along, .. } = residuals;
    let elevation_deg = beam.slope.atan().to_degrees();
    let mut cells = vec![row.to_string(), format!("{elevation_deg:+.3}"), grouped(*points as u64)];
    cells.extend([across, around, along].into_iter().flat_map(cells_of));
    cells
}

fn cells_of(Spread { rms_m, max_m, .. }: &Spread) -> [String; 2] {
    [rms_m, max_m].map(|miss_m| format!("{:.3}", 1e3 * miss_m))
}

fn summary(found: &Calibration) -> String {
    let Calibration { sensor, residuals, beam_share, tick_coherence, count_coherence } = found;
    let lines = [
        format!(
            "{}: {} beams, {} ticks a turn, range unit {:.3} mm",
            sensor.name,
            sensor.beams.len(),
            sensor.ticks_per_turn,
            1e3 * sensor.range_unit_m
        ),
        format!(
            "{} points: {} lost, {} off the grid by more than {:.0} mm",
            grouped(residuals.points as u64),
            grouped(residuals.lost as u64),
            grouped(residuals.off_grid as u64),
            1e3 * OFF_GRID_M
        ),
        format!(
            "{:.2} % of the points on beams; coherence {tick_coherence:.3} of ticks, {count_coherence:.3} of counts",
            1e2 * beam_share
        ),
    ];
    lines.into_iter().chain(unseen(found)).collect::<Vec<_>>().join("\n")
}

/// Which beams of a sensor that is built in nothing came back from.
fn unseen(found: &Calibration) -> Option<String> {
    let (name, count, beams) = sensors::unseen(&OwnedGrid::new(&found.sensor.grid()))?;
    let elevation = |beam: &Beam| format!("{:+.3}", beam.slope.atan().to_degrees());
    let elevations: Vec<String> = beams.iter().map(elevation).collect();
    Some(format!(
        "{} of {name}'s {count} beams: nothing came back from {} degrees. With its captures the file is used all the \
         same, and these are as designed; scans in which they hit something would tell",
        found.sensor.beams.len(),
        elevations.join(", ")
    ))
}
