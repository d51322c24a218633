//! The simulated sensor keeps its promises: exact on its grid, the same everywhere, like KITTI.
#![cfg(feature = "std")]

mod common;

use std::f64::consts::TAU;

use common::statistics::Statistics;
use flicr::geometry::{Beam, sensors::hdl64e};
use flicr::simulate::{EgoMotion, Return, Sensor, Simulator, Turn};

/// `codec.md`'s way from a point to (tick, count), written on its own: nothing is shared with the
/// simulator but the beam table.
#[expect(clippy::many_single_char_names, reason = "the letters of the formulas")]
fn tick_and_count(sensor: &Sensor, beam: &Beam, [x, y, z, _]: [f32; 4]) -> (u16, u32) {
    let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
    let rho = libm::hypot(x, y);
    let (c, h) = (f64::from(beam.z_offset_m), f64::from(beam.h_offset_m));
    let turned = libm::atan2(y, x) + libm::asin(h / rho) - f64::from(beam.azimuth_phase_rad);
    let tick = libm::round(turned / (TAU / f64::from(sensor.ticks))) as i64;
    let v = libm::atan(f64::from(beam.slope));
    let vo = c * libm::cos(v);
    let beside = if sensor.range_from_axis { 0.0 } else { h };
    let flat = libm::sqrt(rho * rho - beside * beside) + vo * libm::sin(v);
    let d = flat * libm::cos(v) + (z - vo * libm::cos(v)) * libm::sin(v);
    let count = libm::round((d - f64::from(beam.range_phase_m)) / sensor.range_unit_m) as u32;
    (tick.rem_euclid(i64::from(sensor.ticks)) as u16, count)
}

fn nearest_beam(beams: &[Beam], [x, y, z, _]: [f32; 4]) -> (u8, f64) {
    let (rho, z) = (libm::hypot(f64::from(x), f64::from(y)), f64::from(z));
    let miss = |beam: &Beam| {
        let [slope, z_offset_m, h] = [beam.slope, beam.z_offset_m, beam.h_offset_m].map(f64::from);
        (z - (slope * libm::sqrt(rho * rho - h * h) + z_offset_m)).abs()
    };
    let misses = beams.iter().map(miss).enumerate();
    let (beam, miss) = misses.min_by(|one, other| one.1.total_cmp(&other.1)).unwrap();
    (beam as u8, miss)
}

fn assert_inverts(sensor: &Sensor, turn: &Turn) {
    for (point, found) in turn.points.iter().zip(&turn.returns) {
        let (row, _) = nearest_beam(&sensor.beams, *point);
        let beam = &sensor.beams[usize::from(row)];
        let (tick, count) = tick_and_count(sensor, beam, *point);
        assert_eq!((row, count), (found.beam, found.count), "{point:?}");
        let off = (i64::from(tick) - i64::from(found.tick)).rem_euclid(i64::from(sensor.ticks));
        let off = off.min(i64::from(sensor.ticks) - off);
        assert!(off <= ticks_rounded_away(sensor, *point), "{point:?} is {off} ticks off");
        assert_eq!(point[3], f32::from(found.intensity) / 100.0);
    }
}

/// Ticks that a point can move by when it is rounded to a millimetre: none on the HDL-64E, but
/// fine ticks are closer than that nearby.
fn ticks_rounded_away(sensor: &Sensor, [x, y, ..]: [f32; 4]) -> i64 {
    let rounded_rad = 0.000_708 / libm::hypot(f64::from(x), f64::from(y));
    let tick_rad = TAU / f64::from(sensor.ticks);
    libm::floor(rounded_rad / tick_rad + 0.5) as i64
}

#[test]
fn every_point_inverts_to_its_return() {
    for seed in 1..=3 {
        let drive = Simulator::hdl64e(seed);
        let turn = drive.turn(7 * seed);
        assert_inverts(drive.sensor(), &turn);
        let nowhere = |point| ticks_rounded_away(drive.sensor(), point) == 0;
        assert!(turn.points.iter().all(|point| nowhere(*point)));
    }
}

#[test]
fn other_sensors_are_exact_on_their_own_grids() {
    let mut coarse = Sensor::vlp16();
    coarse.range_unit_m = 0.004;
    coarse.first_tick = 35_999;
    for sensor in [Sensor::vlp16(), coarse] {
        let turn = Simulator::with_sensor(sensor.clone(), 5).next().unwrap();
        assert!(turn.points.len() > 15_000, "{}", turn.points.len());
        assert_inverts(&sensor, &turn);
    }
}

#[test]
fn raw_motion_stays_on_the_grid_and_compensated_motion_leaves_it() {
    let raw = Simulator::hdl64e(2).ego_motion(EgoMotion::Raw);
    let turn = raw.turn(4);
    assert_inverts(raw.sensor(), &turn);
    let compensated = Simulator::hdl64e(2).ego_motion(EgoMotion::Compensated).turn(4);
    assert_eq!(compensated.returns, turn.returns);
    let off = compensated.points.iter().filter(|point| nearest_beam(&hdl64e::BEAMS, **point).1 > 0.002).count();
    assert!(off * 2 > turn.points.len(), "{off} of {} points off the grid", turn.points.len());
}

#[test]
fn a_turn_is_the_same_on_every_machine() {
    let crc = |bytes: &[u8]| crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(bytes);
    let golden = [
        (Simulator::hdl64e(1), 0x58de_4857_u32),
        (Simulator::hdl64e(2).ego_motion(EgoMotion::Compensated), 0x1936_8319),
        (Simulator::with_sensor(Sensor::vlp16(), 3), 0x6218_b3da),
    ];
    let found = golden.clone().map(|(drive, _)| crc(&drive.turn(10).kitti_bytes()));
    assert_eq!(found, golden.map(|(_, hash)| hash), "{found:#010x?}");
}

#[test]
fn turns_come_in_order_and_seeds_differ() {
    let mut drive = Simulator::new(9);
    let (first, second) = (drive.next().unwrap(), drive.next().unwrap());
    assert_eq!((first.index, second.index), (0, 1));
    assert_eq!(second.time_ns, 100_000_000);
    assert_eq!(second, Simulator::hdl64e(9).turn(1));
    assert_ne!(first.points, second.points);
    assert_ne!(first.points, Simulator::new(10).turn(0).points);
}

#[test]
fn points_are_in_the_order_of_kitti_files() {
    let turn = Simulator::hdl64e(1).turn(3);
    assert!(turn.returns.is_sorted_by_key(|found| found.beam));
    for beam in 0..64 {
        let azimuths: Vec<f64> = (turn.returns.iter().zip(&turn.points))
            .filter(|(found, _)| found.beam == beam)
            .map(|(_, point)| libm::atan2(f64::from(point[1]), f64::from(point[0])))
            .map(|azimuth| azimuth.rem_euclid(TAU))
            .collect();
        // Rounding to a millimetre moves a point by less than this, maybe across the start.
        let in_order = |one: &f64, next: &f64| one - next < 5e-4 || one - next > TAU - 0.01;
        assert!(azimuths.is_sorted_by(in_order), "beam {beam}");
    }
}

#[test]
fn firings_step_by_one_or_two_ticks_and_are_shared_by_all_beams() {
    let drive = Simulator::hdl64e(6);
    for index in 0..3 {
        let turn = drive.turn(index);
        let ticks = &turn.firing_ticks;
        assert!((2140..=2160).contains(&ticks.len()));
        let next = ticks.iter().cycle().skip(1);
        let steps = ticks.iter().zip(next).map(|(one, next)| (4000 + next - one) % 4000);
        assert!(steps.clone().all(|step| step == 1 || step == 2));
        assert_eq!(steps.map(u32::from).sum::<u32>(), 4000);
        for Return { firing, beam, tick, .. } in &turn.returns {
            let shift = drive.sensor().tick_shifts[usize::from(*beam)];
            let own = i32::from(ticks[usize::from(*firing)]);
            assert_eq!(i32::from(*tick), (own + shift).rem_euclid(4000));
        }
    }
}

#[test]
fn returns_as_fired_are_in_the_order_of_time() {
    let turn = Simulator::hdl64e(1).turn(2);
    let fired = turn.returns_as_fired();
    assert_eq!(fired.len(), turn.returns.len());
    assert!(fired.is_sorted_by_key(|found| (found.time_ns, found.beam)));
    assert!(fired.iter().all(|found| (200_000_000..300_000_000).contains(&found.time_ns)));
}

#[test]
fn a_standing_sensor_sees_the_same_street_again() {
    let drive = Simulator::hdl64e(4).speed(0.0);
    let (one, other) = (drive.turn(0), drive.turn(30));
    let near = |turn: &Turn| turn.points.iter().filter(|point| point[0].abs() < 20.0).count();
    let share = near(&one) as f64 / near(&other) as f64;
    assert!((0.9..1.1).contains(&share), "{share}");
}

/// What KITTI's 29 full raw scans have, roughly: holds without the data, too.
#[test]
fn statistics_are_those_of_a_street() {
    let found = Statistics::simulated();
    println!("simulated: {found}");
    assert!((110_000.0..125_000.0).contains(&found.points));
    assert!((0.09..0.20).contains(&found.empty));
    assert!((0.07..0.09).contains(&found.lost));
    assert!((0.012..0.020).contains(&found.step_m));
    assert!((36_000.0..60_500.0).contains(&found.zlib_len));
}
