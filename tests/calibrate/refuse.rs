//! Clouds that are on no grid are refused, for the reason that is theirs.

use std::f64::consts::TAU;

use flicr::calibrate::{CalibrateError, Scan, calibrate};

use crate::made_up::{MadeUp, Random, SIXTY_FOUR, positions};

/// Four scans of the 64-beam sensor, each point changed by `spoil`.
fn spoiled(mut spoil: impl FnMut([f64; 3]) -> [f64; 3]) -> Vec<Vec<[f32; 3]>> {
    let sensor = MadeUp::new(SIXTY_FOUR);
    let scans = (0..4).map(|scan| positions(&sensor.scan(scan)));
    scans
        .map(|points| points.into_iter().map(|point| spoil(point.map(f64::from)).map(|value| value as f32)).collect())
        .collect()
}

fn refusal(clouds: &[Vec<[f32; 3]>]) -> CalibrateError {
    let scans: Vec<Scan> = clouds.iter().map(|points| Scan { points, beams: None }).collect();
    let error = calibrate("none", &scans, &mut |_| ()).expect_err("no sensor to be found");
    println!("{error}");
    error
}

fn assert_not_on_beams(error: CalibrateError) {
    let CalibrateError::NotOnBeams { share, limit, .. } = error else { panic!("{error}") };
    assert!(share < limit, "{error}");
}

/// What a car at `speed` m/s does to a turn of a tenth of a second that is then put together.
fn shifted_by_motion(speed: f64) -> impl FnMut([f64; 3]) -> [f64; 3] {
    move |[x, y, z]| {
        let time_s = 0.1 * y.atan2(x).rem_euclid(TAU) / TAU;
        let turned = 0.3 * time_s * speed / 10.0;
        [x * turned.cos() - y * turned.sin() + speed * time_s, x * turned.sin() + y * turned.cos(), z]
    }
}

#[test]
fn unspoiled_is_not_refused() {
    let clouds = spoiled(|point| point);
    let scans: Vec<Scan> = clouds.iter().map(|points| Scan { points, beams: None }).collect();
    assert!(calibrate("fine", &scans, &mut |_| ()).is_ok());
}

#[test]
fn motion_compensated() {
    assert_not_on_beams(refusal(&spoiled(shifted_by_motion(10.0))));
}

#[test]
fn motion_compensated_at_walking_pace() {
    // A few centimetres a turn: not much across flat beams, but no count survives it.
    let error = refusal(&spoiled(shifted_by_motion(0.5)));
    assert!(!matches!(error, CalibrateError::TooFewPoints { .. } | CalibrateError::BeamHints { .. }), "{error}");
}

#[test]
fn jittered_in_space() {
    let mut random = Random(1);
    assert_not_on_beams(refusal(&spoiled(|point| point.map(|value| value + random.between(-0.01, 0.01)))));
}

#[test]
fn jittered_in_range() {
    let mut random = Random(2);
    let unit_vector_scale = |point: [f64; 3], by: f64| {
        let range = point.iter().map(|value| value * value).sum::<f64>().sqrt();
        point.map(|value| value * (1.0 + by / range))
    };
    let error = refusal(&spoiled(|point| unit_vector_scale(point, random.between(-0.003, 0.003))));
    let CalibrateError::NotOnCounts { coherence, limit, .. } = error else { panic!("{error}") };
    assert!(coherence < limit);
}

#[test]
fn jittered_in_azimuth() {
    let mut random = Random(3);
    let error = refusal(&spoiled(|[x, y, z]| {
        let by = random.between(-0.5, 0.5) * TAU / f64::from(SIXTY_FOUR.ticks);
        [x * by.cos() - y * by.sin(), x * by.sin() + y * by.cos(), z]
    }));
    let CalibrateError::NotOnTicks { coherence, limit, .. } = error else { panic!("{error}") };
    assert!(coherence < limit);
}

#[test]
fn tilted_frame() {
    // A vehicle's frame instead of the sensor's: three degrees of pitch.
    let (sin, cos) = 0.05_f64.sin_cos();
    assert_not_on_beams(refusal(&spoiled(|[x, y, z]| [x * cos + z * sin, y, z * cos - x * sin])));
}

#[test]
fn merged_sensors() {
    let other = MadeUp::new(crate::made_up::Recipe { seed: 65, ..SIXTY_FOUR });
    let mut clouds = spoiled(|point| point);
    for (points, seed) in clouds.iter_mut().zip(50..) {
        let moved = other.scan(seed).into_iter().map(|made| made.position).map(|[x, y, z]| [x + 1.0, y, z + 0.3]);
        points.extend(moved);
    }
    assert_not_on_beams(refusal(&clouds));
}

#[test]
fn solid_state() {
    let mut random = Random(4);
    let cloud = |random: &mut Random| {
        let point = |random: &mut Random| {
            let (azimuth, elevation) = (random.between(-0.6, 0.6), random.between(-0.25, 0.25));
            let range = random.between(2.0, 80.0);
            [azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()]
                .map(|value| (range * value) as f32)
        };
        (0..60_000).map(|_| point(random)).collect::<Vec<_>>()
    };
    assert_not_on_beams(refusal(&[cloud(&mut random), cloud(&mut random)]));
}

#[test]
fn nothing_and_almost_nothing() {
    assert_eq!(refusal(&[]), CalibrateError::TooFewPoints { found: 0, needed: 500 });
    let mut few = vec![[0.0; 3]; 1000];
    few.extend([[5.0, 5.0, 1.0]; 99]);
    few.push([f32::NAN, 1.0, 1.0]);
    assert_eq!(refusal(&[few]), CalibrateError::TooFewPoints { found: 99, needed: 500 });
}

#[test]
fn one_place_over_and_over() {
    let error = refusal(&[vec![[5.0, 5.0, 1.0]; 5000]]);
    assert!(matches!(error, CalibrateError::NotOnBeams { .. } | CalibrateError::NotOnTicks { .. }), "{error}");
}

#[test]
fn beam_numbers_that_do_not_match() {
    let points = [[1.0, 2.0, 3.0]; 4];
    let scans = [Scan { points: &points, beams: None }, Scan { points: &points, beams: Some(&[1, 2, 3]) }];
    let error = calibrate("none", &scans, &mut |_| ()).unwrap_err();
    assert_eq!(error, CalibrateError::BeamHints { scan: 1, points: 4, hints: 3 });
    assert_eq!(error.to_string(), "scan 1 has 4 points but 3 beam numbers");
}
