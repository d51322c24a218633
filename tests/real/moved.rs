//! Raw scans moved by what an ego-motion compensation does to them: off every grid.

use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::{
    Advice, Decoder, Encoded, FrameEncoder, GeometryChoice, ImageViewMut, LatticeConfig, Levels, Rle, Stamp,
    UniformView, choose_geometry, recognize_sensor,
};

use crate::common::{data, xyz};
use crate::lattice::support::{distance, exact_cell};

const COLUMNS: usize = 4500;

/// What the vehicle did during the turn.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    ahead_m: f64,
    left_m: f64,
    yaw_rad: f64,
}

const fn straight(ahead_m: f64) -> Motion {
    Motion { ahead_m, left_m: 0.0, yaw_rad: 0.0 }
}

pub const MOTIONS: [Motion; 5] = [
    straight(0.5),
    straight(1.0),
    straight(1.5),
    Motion { ahead_m: 1.5, left_m: 0.0, yaw_rad: 0.03 },
    Motion { ahead_m: 2.5, left_m: 0.3, yaw_rad: 0.03 },
];

/// Every point as from where the vehicle was at the middle of the turn, which begins ahead.
pub fn moved(points: &[[f32; 3]], motion: Motion) -> Vec<[f32; 3]> {
    let one = |[x, y, z]: [f32; 3]| {
        let turns = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU;
        let time = (if turns < 0.0 { turns + 1.0 } else { turns }) - 0.5;
        let (sin, cos) = (motion.yaw_rad * time).sin_cos();
        let (x, y) = (f64::from(x), f64::from(y));
        let x_moved = x * cos - y * sin + motion.ahead_m * time;
        let y_moved = x * sin + y * cos + motion.left_m * time;
        [x_moved as f32, y_moved as f32, z]
    };
    points.iter().map(|&point| if point == [0.0; 3] { point } else { one(point) }).collect()
}

fn encoded(points: &[[f32; 3]], advice: &Advice) -> (Encoded, Vec<u8>) {
    let lattice = Lattice::<66>::new(hdl64e::GRID, COLUMNS).unwrap();
    let config = LatticeConfig { measure: true, ..LatticeConfig::new(&lattice) };
    let (mut levels, mut coder) = (vec![0_u16; 64 * COLUMNS], Rle::new());
    let image = ImageViewMut::new(&mut levels, COLUMNS).unwrap();
    let mut frame = FrameEncoder::start(&config, Stamp::default(), image, &mut coder).unwrap();
    frame.insert_on_rows(points, &advice.rows);
    let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
    let encoded = frame.finish(&mut out).unwrap();
    out.truncate(encoded.len);
    (encoded, out)
}

/// Finds every point again in its row, at its level and at most seven columns off, all in double precision; gives how many
/// are not there and the farthest of those that are.
fn found_again(points: &[[f32; 3]], rows: &[u16], bytes: &[u8]) -> (u32, f64) {
    let mut decoder = Decoder::default();
    let frame = decoder.decode(bytes).unwrap();
    let Levels::U16(levels) = frame.levels() else { panic!("16 bits") };
    let mut decoded = frame.points().into_iter();
    let places: Vec<_> = levels.iter().map(|&level| (level > 0).then(|| decoded.next().unwrap())).collect();
    let (mut missing, mut farthest_m) = (0, 0.0_f64);
    for (&point, &row) in points.iter().zip(rows).filter(|(point, _)| **point != [0.0; 3]) {
        let row = usize::from(row);
        let beam = flicr::geometry::SensorGrid { beams: &hdl64e::BEAMS[row..=row], ticks: 4500, ..hdl64e::GRID };
        let (_, column, count) = exact_cell(&beam, point.map(f64::from));
        let at = |off: usize| row * COLUMNS + (column as usize + COLUMNS + off - 7) % COLUMNS;
        // A level either way: between two of them the encoder's floats and these may differ.
        let is_its = |pixel: &usize| (f64::from(levels[*pixel]) - count).abs() < 0.6;
        let candidates = (0..15).map(at).filter(is_its);
        let off_m = candidates.filter_map(|pixel| places[pixel]).map(|place| distance(place, point));
        match off_m.min_by(f64::total_cmp) {
            Some(off_m) => farthest_m = farthest_m.max(off_m),
            None => missing += 1,
        }
    }
    (missing, farthest_m)
}

pub fn at_most_one_percent_is_lost_and_the_bound_holds_for_every_point() {
    for data::Scan { name, points } in data::KITTI.iter().step_by(2) {
        let raw = xyz(points);
        for motion in MOTIONS {
            let points = moved(&raw, motion);
            let found = recognize_sensor(&points, &[hdl64e::GRID]);
            let advice = choose_geometry(&points, &hdl64e::GRID, COLUMNS, UniformView::HDL64E).unwrap();
            let (encoded, bytes) = encoded(&points, &advice);
            let tally = encoded.tally;
            let lost = f64::from(tally.lost()) / f64::from(tally.returns());
            let bound_m = f64::from(encoded.fit.point_bound_m());
            let (missing, farthest_m) = found_again(&points, &advice.rows, &bytes);
            println!(
                "{name} {motion:?}: off {:.2} {:?} {:.3} % lost, {:.2} % displaced, {missing} missing, {farthest_m:.3} m off, bound {bound_m:.3}",
                found.off[0],
                advice.choice,
                100.0 * lost,
                100.0 * f64::from(tally.displaced) / f64::from(tally.returns()),
            );
            assert_eq!(advice.choice, GeometryChoice::BeamsInOrder, "{name} {motion:?}: {}", advice.why);
            assert!(lost <= 0.01, "{name} {motion:?}: {lost}");
            assert!(missing <= tally.lost(), "{name} {motion:?}: {missing} are missing, {} lost", tally.lost());
            assert!(farthest_m <= bound_m, "{name} {motion:?}: {farthest_m} > {bound_m}");
        }
    }
}
