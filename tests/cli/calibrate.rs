//! A sensor's grid comes back from its scans; scans that are on no grid are refused with the reason.

use flicr::geometry::sensors::hdl64e;
use flicr::sensor::Sensor;

use super::picture::Picture;
use super::run::{Place, bin, points};

const TURNS: [&str; 8] = [
    "t-000000.bin",
    "t-000001.bin",
    "t-000002.bin",
    "t-000003.bin",
    "t-000004.bin",
    "t-000005.bin",
    "t-000006.bin",
    "t-000007.bin",
];

fn with_turns() -> Place {
    let place = Place::new();
    place.fine(&["simulate", "--turns", "8", "-o", "t.bin"]);
    assert_eq!(place.names(), TURNS);
    place
}

/// Every number of the built-in table within the limits that real scans are held to; phases repeat with the tick and
/// the count.
fn assert_is_hdl64e(sensor: &Sensor) {
    assert_eq!((sensor.ticks_per_turn, sensor.range_unit_m), (4000, 0.002));
    assert_eq!(sensor.beams.len(), 64);
    let around = |difference: f64, cycle: f64| difference - cycle * (difference / cycle).round();
    for (row, (found, table)) in sensor.beams.iter().zip(&hdl64e::BEAMS).enumerate() {
        let difference = |found: f32, table: f32| f64::from(found) - f64::from(table);
        let phase_deg = difference(found.azimuth_phase_rad, table.azimuth_phase_rad).to_degrees();
        let misses = [
            (difference(found.slope, table.slope), 3e-5),
            (difference(found.z_offset_m, table.z_offset_m), 6e-4),
            (difference(found.h_offset_m, table.h_offset_m), 6e-4),
            (around(phase_deg, 0.09), 0.003),
            (around(difference(found.range_phase_m, table.range_phase_m), 0.002), 1e-4),
        ];
        assert!(misses.iter().all(|(miss, limit)| miss.abs() < *limit), "beam {row}: {misses:?}");
    }
}

fn sensor(place: &Place, name: &str) -> Sensor {
    Sensor::from_toml(&String::from_utf8(place.read(name)).unwrap()).unwrap()
}

#[test]
fn simulated_turns_give_the_table_they_were_made_by() {
    let place = with_turns();
    let text = place.fine(&[&["calibrate"], TURNS.as_slice(), &["-o", "street.toml"]].concat());
    let found = sensor(&place, "street.toml");
    assert_eq!(found.name, "street");
    assert_is_hdl64e(&found);
    assert!(text.contains("64 beams, 4000 ticks a turn, range unit 2.000 mm"), "{text}");
    assert!(text.contains(" 0 lost, 0 off the grid"), "{text}");
    assert_residual_lines(&text);
    assert_residual_picture(&Picture::of(&place.read("street.png")));
}

/// A line a beam: number, elevation, points, then rms and largest in three directions, millimeters.
fn assert_residual_lines(text: &str) {
    let cells = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let beams: Vec<Vec<f64>> = cells
        .filter(|cells| cells.len() == 9 && cells[0].parse::<u32>().is_ok())
        .map(|cells| cells.iter().map(|cell| cell.replace(',', "").parse().unwrap()).collect())
        .collect();
    assert_eq!(beams.len(), 64);
    for (row, beam) in beams.iter().enumerate() {
        assert_eq!(beam[0], row as f64);
        assert!(beam[2] > 100.0, "beam {row} has points");
        for spread in beam[3..].chunks(2) {
            assert!(0.0 < spread[0] && spread[0] < spread[1] && spread[1] <= 2.0, "beam {row}: {spread:?}");
        }
    }
}

/// Three panels; misses of files in millimeters lie within one, so that the panels' upper edges stay black.
fn assert_residual_picture(picture: &Picture) {
    assert!(picture.width >= 1000 && picture.height() >= 900);
    let panel = picture.height() / 3;
    for top in [0, panel, 2 * panel] {
        let middle = top + panel / 2;
        assert!(picture.colored(80..picture.width - 20, middle - 20..middle + 20) > 0.9);
    }
    assert!(picture.colored(80..picture.width - 20, 60..100) < 0.1);
}

#[test]
fn names_and_pictures_go_where_they_are_told() {
    let place = with_turns();
    let names = ["-o", "s.toml", "--name", "roof \"left\"", "--png", "fit.png"];
    place.fine(&[&["calibrate"], &TURNS[..3], &names].concat());
    assert_eq!(sensor(&place, "s.toml").name, "roof \"left\"");
    assert!(place.path("fit.png").exists() && !place.path("s.png").exists());
    place.fails_with(2, &["calibrate", TURNS[0], "-o", TURNS[0]], TURNS[0], &["input"]);
    place.fails_with(2, &["calibrate", TURNS[0], "-o", "x.png"], "x.png", &["two outputs"]);
}

#[test]
fn rings_say_which_points_share_a_beam() {
    let place = Place::new();
    place.fine(&["simulate", "--turns", "8", "-o", "t.xyzir.bin"]);
    let names = place.names();
    let inputs: Vec<&str> = names.iter().map(String::as_str).collect();
    place.fine(&[&["calibrate"], inputs.as_slice(), &["-o", "s.toml"]].concat());
    assert_is_hdl64e(&sensor(&place, "s.toml"));
}

/// Changes every point of the first turns.
fn change(place: &Place, change: impl Fn(usize, [f32; 4]) -> [f32; 4]) {
    for name in &TURNS[..3] {
        let turn = points(&place.read(name));
        let changed: Vec<[f32; 4]> = turn.iter().enumerate().map(|(nth, point)| change(nth, *point)).collect();
        place.write(name, &bin(&changed));
    }
}

fn assert_refused(place: &Place, reason: &str) {
    let calibrate = [&["calibrate"], &TURNS[..3], &["-o", "s.toml"]].concat();
    place.fails_with(1, &calibrate, "t-000000.bin and 2 more", &[reason, "it takes"]);
}

#[test]
fn motion_compensated_scans_are_refused() {
    let place = with_turns();
    // 10 m/s ahead: a meter a turn, shared out by azimuth.
    change(&place, |_, [x, y, z, intensity]| [x + y.atan2(x) / std::f32::consts::TAU, y, z, intensity]);
    assert_refused(&place, "motion-compensated");
}

#[test]
fn noisy_scans_are_refused() {
    let place = with_turns();
    let noise_m = |nth: usize| 0.02 * (((nth as u32).wrapping_mul(2_654_435_761) >> 16) as f32 / 65_536.0 - 0.5);
    change(&place, |nth, [x, y, z, intensity]| [x, y, z + noise_m(nth), intensity]);
    assert_refused(&place, "not on beams");
}

#[test]
fn ranges_that_are_not_counted_are_refused() {
    let place = with_turns();
    let scale = |nth: usize| 1.0 + 1e-3 * (((nth as u32).wrapping_mul(2_654_435_761) >> 16) as f32 / 65_536.0);
    // About the point where all beams meet the axis, so that beams and ticks stay.
    change(&place, |nth, [x, y, z, intensity]| {
        [x * scale(nth), y * scale(nth), 0.2 + (z - 0.2) * scale(nth), intensity]
    });
    assert_refused(&place, "not on ");
}

#[test]
fn few_points_are_refused() {
    let place = Place::new();
    place.write("few.bin", &bin(&[[1.0, 2.0, 3.0, 0.5]; 10]));
    place.fails_with(1, &["calibrate", "few.bin", "-o", "s.toml"], "few.bin", &["10 returns", "500"]);
    place.fails_with(2, &["calibrate", "few.las", "-o", "s.toml"], "few.las", &["expected", ".pcd"]);
    place.fails(2, &["calibrate", "-o", "s.toml"]);
}
