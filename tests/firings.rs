//! Promise: with a column for each of a turn's firings, what holds with a column for each tick holds too, and the list of
//! firings costs some tens of bytes.
#![allow(missing_docs)]

use flicr::geometry::{FiringLattice, Firings, Lattice, Projection, SensorGrid, find_firings, sensors::hdl64e};
use flicr::simulate::Simulator;
use flicr::{
    ConfigError, DecodeError, Decoder, EncodeError, Encoded, FiringsConfig, FrameEncoder, HeaderField, ImageViewMut,
    LatticeConfig, Rle, Stamp, encode, frame,
};
use proptest::prelude::*;

/// A street, seen by a sensor whose lasers look beside each other as those of KITTI's unit do.
fn street(seed: u64) -> Vec<[f32; 3]> {
    Simulator::hdl64e(seed).turn(0).points.iter().map(|&[x, y, z, _]| [x, y, z]).collect()
}

fn encoded<const LINES: usize, const WORDS: usize>(
    config: &FiringsConfig<'_, LINES, WORDS>,
    points: &[[f32; 3]],
) -> (Encoded, Vec<u8>) {
    let columns = usize::from(config.firings.len());
    let mut levels = vec![0_u16; usize::from(config.every_tick.lattice.rows()) * columns];
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
    let encoded = encode(config, points, Stamp::default(), image, &mut Rle::new(), &mut out).unwrap();
    out.truncate(encoded.len);
    (encoded, out)
}

fn hdl64e() -> Lattice<'static, 66> {
    Lattice::new(hdl64e::FIRING_GRID, 4000).unwrap()
}

/// Bytes of the list in a frame's header.
fn list_len(bytes: &[u8]) -> usize {
    frame::parse(bytes).unwrap().firings().len()
}

/// Points in an order that does not depend on columns, to the micrometer.
fn sorted(mut points: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    points.sort_by(|a, b| a.partial_cmp(b).unwrap());
    points
}

fn assert_all_there(points: &[[f32; 3]], bytes: &[u8], within_m: f64) {
    let mut decoder = Decoder::default();
    let decoded = decoder.decode(bytes).unwrap().points();
    assert_eq!(decoded.len(), points.len());
    let mut tree: kd::Tree = kd::Tree::default();
    for point in &decoded {
        tree.add(*point);
    }
    for point in points {
        let off = tree.nearest_m(*point);
        assert!(off <= within_m, "{point:?} is {off} m from any");
    }
}

/// Nearest points by cells of a centimeter's size: enough where all are near.
mod kd {
    use std::collections::HashMap;

    #[derive(Default)]
    pub struct Tree(HashMap<[i32; 3], Vec<[f32; 3]>>);

    fn cell(point: [f32; 3]) -> [i32; 3] {
        point.map(|v| (v * 50.0).floor() as i32)
    }

    impl Tree {
        pub fn add(&mut self, point: [f32; 3]) {
            self.0.entry(cell(point)).or_default().push(point);
        }

        pub fn nearest_m(&self, point: [f32; 3]) -> f64 {
            let [x, y, z] = cell(point);
            let around =
                (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
            let near = around.filter_map(|cell| self.0.get(&cell)).flatten();
            let off = |other: &[f32; 3]| (0..3).map(|i| f64::from(other[i] - point[i]).powi(2)).sum::<f64>().sqrt();
            near.map(off).fold(f64::INFINITY, f64::min)
        }
    }
}

/// From an image of every tick, by which firings need not be known before.
fn cut_down(config: &LatticeConfig<'_, 66>, points: &[[f32; 3]]) -> Result<(Encoded, Vec<u8>), EncodeError> {
    let mut levels = vec![0_u16; 64 * 4000];
    let image = ImageViewMut::new(&mut levels, 4000).unwrap();
    let (mut coder, mut out) = (Rle::new(), vec![0; config.worst_case_len::<u16, Rle>()]);
    let mut frame = FrameEncoder::start(config, Stamp::default(), image, &mut coder).unwrap();
    frame.insert(points);
    let encoded = frame.finish_by_firings::<125>(&mut out)?;
    out.truncate(encoded.len);
    Ok((encoded, out))
}

#[test]
fn an_image_of_every_tick_gives_the_frame_of_its_firings() {
    let lattice = hdl64e();
    for (seed, measure, strips) in [(1, false, 1), (2, true, 1), (3, true, 16)] {
        let points = street(seed);
        let every_tick = LatticeConfig { measure, strips, ..LatticeConfig::new(&lattice) };
        let found = find_firings(points.as_slice(), &hdl64e::FIRING_GRID).unwrap().unwrap();
        let firings: Firings<125> = Firings::new(4000, found.ticks).unwrap();
        let known = encoded(&FiringsConfig { every_tick, firings: &firings }, &points);
        assert!(cut_down(&every_tick, &points).unwrap() == known, "seed {seed}");
    }
}

#[test]
fn an_image_with_few_empty_ticks_stays_as_it_is() {
    let lattice = hdl64e();
    let config = LatticeConfig { strips: 4, ..LatticeConfig::new(&lattice) };
    let around = |ticks: usize| -> Vec<[f32; 3]> {
        let at = |tick: usize| (tick as f32 / 4000.0 * std::f32::consts::TAU).sin_cos();
        (0..ticks).map(at).map(|(y, x)| [10.0 * x, 10.0 * y, -1.0]).collect()
    };
    for (ticks, columns) in [(0, 4000), (4, 4), (2500, 2500), (3200, 4000)] {
        let (_, bytes) = cut_down(&config, &around(ticks)).unwrap();
        assert_eq!(frame::parse_header(&bytes).unwrap().columns, columns, "of {ticks} ticks");
        assert_eq!(Decoder::default().decode(&bytes).unwrap().points().len(), ticks);
    }
    let refused = cut_down(&config, &around(3)).map(|_| ());
    assert_eq!(refused, Err(ConfigError::Strips { found: 4, max: 3 }.into()));
    let few = Lattice::<66>::new(hdl64e::FIRING_GRID, 1000).unwrap();
    let mut levels = vec![0_u16; 64 * 1000];
    let image = ImageViewMut::new(&mut levels, 1000).unwrap();
    let mut coder = Rle::new();
    let mut frame = FrameEncoder::start(&LatticeConfig::new(&few), Stamp::default(), image, &mut coder).unwrap();
    frame.insert(around(1).as_slice());
    let refused = frame.finish_by_firings::<125>(&mut [0; 1000]).map(|_| ());
    assert_eq!(refused, Err(ConfigError::Ticks { found: 1000, max: 4000 }.into()));
}

#[test]
fn no_point_of_a_turn_is_lost_and_each_comes_back() {
    for seed in 1..=3 {
        let points = street(seed);
        let found = find_firings(points.as_slice(), &hdl64e::FIRING_GRID).unwrap().expect("shared");
        assert_eq!(found.beams, hdl64e::FIRING_BEAMS);
        let firings = Firings::<125>::new(4000, found.ticks.iter().copied()).unwrap();
        let lattice = hdl64e();
        let every_tick = LatticeConfig { measure: true, ..LatticeConfig::new(&lattice) };
        let (encoded, bytes) = encoded(&FiringsConfig { every_tick, firings: &firings }, &points);
        assert_eq!((encoded.tally.lost(), encoded.tally.kept() as usize), (0, points.len()));
        assert!(encoded.fit.point_bound_m() <= 0.002, "{}", encoded.fit.point_bound_m());
        assert_all_there(&points, &bytes, encoded.fit.point_bound_m().into());
        println!("{} firings in {} bytes", firings.len(), list_len(&bytes));
        assert!((2000..2300).contains(&firings.len()) && list_len(&bytes) <= 64);
    }
}

/// Of two frames that differ in the ticks of a turn only, too: where columns lie follows from them.
#[test]
fn a_frame_says_the_same_whatever_came_before_it() {
    let frame_of = |ticks: u32| {
        let grid = SensorGrid { ticks, ..hdl64e::FIRING_GRID };
        let lattice = Lattice::<66>::new(grid, ticks as usize).unwrap();
        let firings = Firings::<250>::new(ticks, (0..2000).step_by(2)).unwrap();
        let every_tick = LatticeConfig { table: true, ..LatticeConfig::new(&lattice) };
        encoded(&FiringsConfig { every_tick, firings: &firings }, &[[0.5, 10.0, -1.0], [9.0, 4.0, -2.0]]).1
    };
    let frames = [frame_of(4000), frame_of(8000)];
    let mut decoder = Decoder::default();
    for bytes in [&frames[0], &frames[1], &frames[0]] {
        let alone = Decoder::default().decode(bytes).unwrap().points();
        assert_eq!(decoder.decode(bytes).unwrap().points(), alone);
    }
}

/// Whatever whole ticks were in the beams' phases.
#[test]
fn beams_are_found_to_fire_together() {
    let points = street(4);
    let known = find_firings(points.as_slice(), &hdl64e::FIRING_GRID).unwrap().unwrap();
    let found = find_firings(points.as_slice(), &hdl64e::GRID).unwrap().expect("shared");
    assert_eq!(found.ticks.len(), known.ticks.len());
    // But for a turn of all of them.
    let tick_rad = std::f64::consts::TAU / 4000.0;
    let ahead = |row: usize| {
        f64::from(found.beams[row].azimuth_phase_rad - hdl64e::FIRING_BEAMS[row].azimuth_phase_rad) / tick_rad
    };
    for row in 0..64 {
        assert!((ahead(row) - ahead(0)).abs() < 1e-3, "beam {row}: {} ticks, {} of the first", ahead(row), ahead(0));
    }
}

#[test]
fn scattered_points_have_no_firings() {
    let scattered: Vec<[f32; 3]> = (0..100_000_u32)
        .map(|i| {
            let part = |factor: f64| (f64::from(i) * factor).fract();
            let (rho, azimuth) = (5.0 + 50.0 * part(0.618_034), std::f64::consts::TAU * part(0.754_877_666));
            [rho * azimuth.cos(), rho * azimuth.sin(), -rho * 0.4 * part(0.569_840_29)].map(|v| v as f32)
        })
        .collect();
    assert_eq!(find_firings(scattered.as_slice(), &hdl64e::GRID), Ok(None));
    assert_eq!(find_firings(&[] as &[[f32; 3]], &hdl64e::GRID), Ok(None));
}

/// A point at a tick that is not listed is kept, and the bound covers it.
#[test]
fn a_point_beside_the_firings_goes_to_the_nearest() {
    let lattice = hdl64e();
    let firings = Firings::<125>::new(4000, (0..4000).step_by(8)).unwrap();
    let at = |row, tick: u32| lattice.grid().position(row, tick, 10_000_u32).unwrap().map(|v| v as f32);
    let points = [at(0, 80), at(10, 83), at(20, 3999), at(40, 2005)];
    let every_tick = LatticeConfig { measure: true, ..LatticeConfig::new(&lattice) };
    let (encoded, bytes) = encoded(&FiringsConfig { every_tick, firings: &firings }, &points);
    assert_eq!(encoded.tally.kept(), 4);
    let bound_m = f64::from(encoded.fit.point_bound_m());
    // Three ticks at 20 m are 94 mm.
    assert!((0.094..0.1).contains(&bound_m), "{bound_m}");
    let decoded = sorted(Decoder::default().decode(&bytes).unwrap().points());
    let mut farthest = 0.0_f64;
    for (decoded, point) in decoded.iter().zip(sorted(points.to_vec())) {
        let off = (0..3).map(|i| f64::from(decoded[i] - point[i]).powi(2)).sum::<f64>().sqrt();
        assert!(off <= bound_m, "{off}");
        farthest = farthest.max(off);
    }
    assert!(farthest > 0.09, "{farthest}");
}

/// Columns look one way: a wall around the sensor makes rows whose columns agree in azimuth.
#[test]
fn columns_look_one_way() {
    let lattice = hdl64e();
    let firings = Firings::<125>::new(4000, (0..4000).step_by(2)).unwrap();
    let grid = FiringLattice::new(&lattice, &firings).unwrap();
    assert_eq!((grid.rows(), grid.columns()), (64, 2000));
    let mut decoder = Decoder::default();
    for row in 0..64 {
        let point = lattice.grid().position(row, 1000_u32, 10_000_u32).unwrap().map(|v| v as f32);
        let every_tick = LatticeConfig::new(&lattice);
        let (_, bytes) = encoded(&FiringsConfig { every_tick, firings: &firings }, &[point]);
        let frame = decoder.decode(&bytes).unwrap();
        let flicr::Levels::U16(levels) = frame.levels() else { panic!("u16") };
        let column = levels.iter().position(|level| *level > 0).unwrap() % 2000;
        let azimuth = f64::from(point[1].atan2(point[0])).rem_euclid(std::f64::consts::TAU);
        let looks = column as f64 / 2000.0 * std::f64::consts::TAU;
        // Half a column, the way from the laser's offset, and half a tick of its phase.
        assert!((azimuth - looks).abs() < 0.0016 + 0.0014 + 0.0008, "row {row}: {azimuth} {looks}");
    }
}

#[test]
fn what_is_no_list_of_firings_is_refused() {
    let new = |ticks, fired: &[u32]| Firings::<125>::new(ticks, fired.iter().copied()).map(|_| ()).unwrap_err();
    assert_eq!(new(0, &[]), ConfigError::Ticks { found: 0, max: 4000 });
    assert_eq!(new(4001, &[0]), ConfigError::Ticks { found: 4001, max: 4000 });
    assert_eq!(new(4000, &[0, 4000]), ConfigError::Firings { tick: 4000, ticks: 4000 });
    assert_eq!(new(3990, &[0, 3990]), ConfigError::Firings { tick: 3990, ticks: 3990 });
    assert_eq!(new(4000, &[]), ConfigError::Firings { tick: 4000, ticks: 4000 });
    let (coarse, firings) = (Lattice::<66>::new(hdl64e::GRID, 2000).unwrap(), Firings::<125>::new(4000, [1]).unwrap());
    assert_eq!(FiringLattice::new(&coarse, &firings).unwrap_err(), ConfigError::Ticks { found: 2000, max: 4000 });
    let other = Firings::<125>::new(3999, [1]).unwrap();
    assert_eq!(FiringLattice::new(&hdl64e(), &other).unwrap_err(), ConfigError::Ticks { found: 3999, max: 4000 });
}

/// The ticks that a frame says its columns are, seen from outside: by the azimuths of beam 10.
fn ticks_there_and_back<const WORDS: usize>(ticks: u32, fired: &[u32]) -> (usize, Vec<u32>) {
    let mut grid = hdl64e::FIRING_GRID;
    grid.ticks = ticks;
    let lattice = Lattice::<66>::new(grid, ticks as usize).unwrap();
    let firings = Firings::<WORDS>::new(ticks, fired.iter().copied()).unwrap();
    assert_eq!(firings.iter().collect::<Vec<_>>(), fired);
    for (number, &tick) in fired.iter().enumerate() {
        assert_eq!(firings.nearest(tick), (number as u16, 0));
    }
    let points: Vec<[f32; 3]> =
        fired.iter().map(|&tick| grid.position(10, tick, 5000_u32).unwrap().map(|v| v as f32)).collect();
    let every_tick = LatticeConfig { table: true, measure: true, ..LatticeConfig::new(&lattice) };
    let (encoded, bytes) = encoded(&FiringsConfig { every_tick, firings: &firings }, &points);
    assert!(encoded.fit.point_bound_m() <= 0.002);
    assert_all_there(&points, &bytes, encoded.fit.point_bound_m().into());
    (list_len(&bytes), firings.iter().collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn any_list_comes_back(ticks in 1_u32..4001, seed in any::<u64>(), share in 1_u64..1001) {
        let mut state = seed;
        let mut chance = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 33
        };
        let mut fired: Vec<u32> = (0..ticks).filter(|_| chance() % 1000 < share).collect();
        if fired.is_empty() {
            fired.push(ticks - 1);
        }
        let (len, _) = ticks_there_and_back::<125>(ticks, &fired);
        prop_assert!(len <= ticks.div_ceil(8) as usize);
    }

    #[test]
    fn nearest_is_nearest(fired in proptest::collection::btree_set(0_u32..500, 1..40), tick in 0_u32..500) {
        let firings = Firings::<16>::new(500, fired.iter().copied()).unwrap();
        let off = |&other: &u32| { let apart = other.abs_diff(tick); apart.min(500 - apart) };
        let nearest = fired.iter().map(off).min().unwrap();
        let (number, found) = firings.nearest(tick);
        prop_assert_eq!(found, nearest);
        prop_assert_eq!(off(fired.iter().nth(number.into()).unwrap()), nearest);
    }

    /// Steps of another sensor's size, evenly or with gaps.
    #[test]
    fn other_sensors_lists_come_back(step in 15.0_f64..40.0, gap in 0_usize..900, wobble in 0_u32..3) {
        let count = (36_000.0 / step) as usize;
        let at = |number: usize| ((number as f64 * step) as u32 + number as u32 * 7919 % (wobble + 1)).min(35_999);
        let mut fired: Vec<u32> = (0..count).filter(|number| !(100..100 + gap).contains(number)).map(at).collect();
        fired.dedup();
        let (len, _) = ticks_there_and_back::<1125>(36_000, &fired);
        prop_assert!(len < fired.len() / 2, "{} bytes for {} firings", len, fired.len());
    }
}

/// No damage to a list passes: it is refused, or (where the checksum was made to fit) it is another list of as many.
#[test]
fn damaged_lists_are_refused_or_are_lists() {
    let points = street(5);
    let found = find_firings(points.as_slice(), &hdl64e::FIRING_GRID).unwrap().unwrap();
    let firings = Firings::<125>::new(4000, found.ticks.iter().copied()).unwrap();
    let lattice = hdl64e();
    let config = FiringsConfig { every_tick: LatticeConfig::new(&lattice), firings: &firings };
    let (_, bytes) = encoded(&config, &points[..50]);
    let len = list_len(&bytes);
    let mut refused = 0;
    let refusal = DecodeError::Header { field: HeaderField::Firings, found: len as u32 };
    for at in 72..72 + len {
        for flip in [1, 0x80, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            match Decoder::default().decode(&sealed(damaged)) {
                Ok(frame) => assert_eq!(frame.points().len(), 50),
                Err(error) => {
                    assert_eq!(error, refusal, "byte {at}");
                    refused += 1;
                }
            }
        }
    }
    assert!(refused > len, "{refused} of {}", 3 * len);
    for (at, value, field) in [
        (46, 3, HeaderField::ColumnMode),
        (46, 0, HeaderField::Firings),
        (46, 1, HeaderField::Firings),
        (68, len as u8 - 1, HeaderField::HeaderLen),
        (68, 0, HeaderField::Firings),
        (69, 2, HeaderField::Firings),
        (70, 1, HeaderField::Reserved),
        (26, 1, HeaderField::Columns),
    ] {
        let mut damaged = bytes.clone();
        damaged[at] = value;
        let error = Decoder::default().decode(&sealed(damaged)).unwrap_err();
        let expected =
            |error: &DecodeError| matches!(error, DecodeError::Header { field: found, .. } if *found == field);
        // Another number of columns makes another list, and strips that do not cover them.
        assert!(expected(&error) || at == 26, "{error:?} for {field:?}");
    }
}

fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let crc = bytes[..body].iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    });
    bytes[body..].copy_from_slice(&(!crc).to_le_bytes());
    bytes
}
