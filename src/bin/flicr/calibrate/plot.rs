//! Residuals as a picture: for each direction the misses of every beam, and how many there are of each size.

use colorous::TURBO;
use flicr::calibrate::{BeamResiduals, Calibration, HISTOGRAM_BINS, HISTOGRAM_REACH_M, Residuals, Spread};

use crate::canvas::{Area, Canvas};
use crate::table::grouped;

const WIDTH: u32 = 1600;
const MARGIN: u32 = 12;
/// Room for the labels at the left of a panel.
const LABELS: u32 = 60;
/// Height of the text above a panel.
const TITLE: u32 = 22;
/// Pixels for a bin of the histogram.
const BIN: u32 = 5;
const PANEL: u32 = BIN * HISTOGRAM_BINS as u32;
const BEAM_LABELS: u32 = 20;
/// Panels' shares of the height.
const PITCH: u32 = TITLE + PANEL + BEAM_LABELS + MARGIN;

const NO_POINT: [u8; 3] = [0, 0, 0];
const RMS: [u8; 3] = [255, 255, 255];

/// A direction in which points miss the grid.
struct Direction {
    name: &'static str,
    of: fn(&BeamResiduals) -> &Spread,
}

const DIRECTIONS: [Direction; 3] = [
    Direction { name: "across the beam", of: |beam| &beam.across },
    Direction { name: "around, along the turn", of: |beam| &beam.around },
    Direction { name: "along the beam", of: |beam| &beam.along },
];

/// The picture: its panels one below the other, beams from left (highest) to right.
pub fn draw(found: &Calibration) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, MARGIN + TITLE + PITCH * DIRECTIONS.len() as u32);
    canvas.text(MARGIN, MARGIN, &title(found));
    let x = MARGIN + LABELS;
    for (direction, panel) in DIRECTIONS.iter().zip(0..) {
        let y = MARGIN + TITLE + PITCH * panel + TITLE;
        let area = Area { x, y, width: WIDTH - MARGIN - x, height: PANEL };
        canvas.text(area.x, area.y - TITLE + 4, &heading(direction, &found.residuals));
        draw_panel(&mut canvas, area, direction, &found.residuals.beams);
    }
    canvas
}

fn title(Calibration { sensor, residuals, .. }: &Calibration) -> String {
    format!(
        "{}: residuals of {} points on {} beams; {} lost, {} off the grid. Color: share of a beam's points, \
         logarithmic; white: -rms and +rms",
        sensor.name,
        grouped(residuals.points as u64),
        sensor.beams.len(),
        grouped(residuals.lost as u64),
        grouped(residuals.off_grid as u64)
    )
}

fn heading(direction: &Direction, residuals: &Residuals) -> String {
    let (mut squares, mut points, mut max_m) = (0.0, 0, 0.0_f64);
    for beam in &residuals.beams {
        let spread = (direction.of)(beam);
        squares += spread.rms_m.powi(2) * beam.points as f64;
        points += beam.points;
        max_m = max_m.max(spread.max_m);
    }
    let rms_m = (squares / points.max(1) as f64).sqrt();
    format!("{}: rms {:.3} mm, max {:.3} mm", direction.name, 1e3 * rms_m, 1e3 * max_m)
}

fn draw_panel(canvas: &mut Canvas, area: Area, direction: &Direction, beams: &[BeamResiduals]) {
    canvas.fill(area, NO_POINT);
    for (beam, row) in beams.iter().zip(0..) {
        let column = column_of(area, row, beams.len());
        draw_histogram(canvas, column, (direction.of)(beam), beam.points);
        draw_rms(canvas, column, (direction.of)(beam).rms_m);
    }
    draw_miss_labels(canvas, area);
    draw_beam_labels(canvas, area, beams.len());
}

/// Where a beam is drawn: neighbors meet without a gap.
fn column_of(area: Area, row: usize, beams: usize) -> Area {
    let edge = |row: usize| area.x + (u64::from(area.width) * row as u64 / beams as u64) as u32;
    let x = edge(row);
    Area { x, width: edge(row + 1) - x, ..area }
}

fn draw_histogram(canvas: &mut Canvas, column: Area, spread: &Spread, points: usize) {
    for (&count, bin) in spread.histogram.iter().zip(0..) {
        if count > 0 {
            // Bin 0 holds the most negative misses: it is at the bottom.
            let y = column.y + column.height - BIN * (bin + 1);
            canvas.fill(Area { y, height: BIN, ..column }, color(count, points));
        }
    }
}

/// From one point in 10,000 (dark blue) to one in 10 (red).
fn color(count: u32, points: usize) -> [u8; 3] {
    let share = (f64::from(count) / points as f64).log10() / 3.0 + 4.0 / 3.0;
    TURBO.eval_continuous(0.1 + 0.84 * share.clamp(0.0, 1.0)).as_array()
}

fn draw_rms(canvas: &mut Canvas, column: Area, rms_m: f64) {
    if rms_m <= HISTOGRAM_REACH_M {
        for miss_m in [-rms_m, rms_m] {
            canvas.fill(Area { y: y_of(column, miss_m), height: 2, ..column }, RMS);
        }
    }
}

fn y_of(area: Area, miss_m: f64) -> u32 {
    let share = (1.0 - miss_m / HISTOGRAM_REACH_M) / 2.0;
    area.y + (share * f64::from(area.height - 2)) as u32
}

fn draw_miss_labels(canvas: &mut Canvas, area: Area) {
    for miss_mm in [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5] {
        let y = y_of(area, miss_mm * 1e-3);
        let label = if miss_mm == 0.0 { "0 mm".to_owned() } else { format!("{miss_mm:+.1}") };
        canvas.fill(Area { x: area.x - 6, y, width: 6, height: 1 }, [160, 160, 160]);
        canvas.text(area.x - 8 - 8 * label.len() as u32, y - 6, &label);
    }
}

fn draw_beam_labels(canvas: &mut Canvas, area: Area, beams: usize) {
    let every = [1, 2, 4, 8, 16, 32, 64].into_iter().find(|every| beams / every <= 32).unwrap_or(128);
    for row in (0..beams).step_by(every) {
        let column = column_of(area, row, beams);
        canvas.centered_text(column.x + column.width / 2, area.y + area.height + 3, &row.to_string());
    }
    canvas.text(MARGIN, area.y + area.height + 3, "beam");
}
