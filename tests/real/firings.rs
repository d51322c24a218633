//! Raw scans with a column for each firing.

use flicr::geometry::{FiringLattice, Firings, Lattice, SensorGrid, find_firings, sensors::hdl64e};
use flicr::{Encoded, FiringsConfig, ImageViewMut, LatticeConfig, Rle, Stamp, encode, frame};

use crate::common::{data, xyz};
use crate::lattice::support::distances;

fn encoded(config: &FiringsConfig<'_, 66, 125>, points: &[[f32; 3]]) -> (Encoded, Vec<u8>) {
    let columns = usize::from(config.firings.len());
    let mut levels = vec![0_u16; 64 * columns];
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
    let encoded = encode(config, points, Stamp::default(), image, &mut Rle::new(), &mut out).unwrap();
    out.truncate(encoded.len);
    (encoded, out)
}

/// What holds with a column a tick holds with a column a firing; gives the firings and the bytes of their list.
fn check(name: &str, grid: SensorGrid<'_>, ticks: &[u32], points: &[[f32; 3]]) -> (usize, usize) {
    let lattice = Lattice::<66>::new(grid, 4000).unwrap();
    let firings = Firings::<125>::new(4000, ticks.iter().copied()).unwrap();
    let every_tick = LatticeConfig { measure: true, ..LatticeConfig::new(&lattice) };
    let every_tick = LatticeConfig { table: grid != hdl64e::FIRING_GRID, ..every_tick };
    let (encoded, bytes) = encoded(&FiringsConfig { every_tick, firings: &firings }, points);
    let returns: Vec<_> = points.iter().copied().filter(|point| *point != [0.0; 3]).collect();
    assert_eq!((encoded.tally.lost(), encoded.tally.kept() as usize), (0, returns.len()), "{name}");
    let found = distances(&FiringLattice::new(&lattice, &firings).unwrap(), &returns, &bytes);
    assert_eq!(found.len(), returns.len());
    let farthest = found.iter().map(|f| f.2).fold(0.0, f64::max);
    let rms = (found.iter().map(|f| f.2 * f.2).sum::<f64>() / found.len() as f64).sqrt();
    let bound = f64::from(encoded.fit.point_bound_m());
    assert!(farthest <= 0.0018 && rms <= 0.0006, "{name}: {farthest} {rms}");
    assert!(farthest <= bound && bound <= 1.2 * farthest + 2e-4, "{name}: {farthest} {bound}");
    (ticks.len(), frame::parse(&bytes).unwrap().firings().len())
}

pub fn all_raw_scans_by_firings() {
    let mut lens = Vec::new();
    for data::Scan { name, points } in data::all_kitti() {
        let points = xyz(points);
        let found = find_firings(points.as_slice(), &hdl64e::FIRING_GRID).unwrap().expect("shared");
        assert_eq!(found.beams, hdl64e::FIRING_BEAMS, "{name}");
        let (firings, list_len) = check(name, hdl64e::FIRING_GRID, &found.ticks, &points);
        println!("{name}: {firings} firings in {list_len} bytes");
        assert!((2140..2160).contains(&firings), "{name}: {firings}");
        lens.push(list_len as f64);
    }
    let (median, most) = (data::median(lens.iter().copied()), lens.iter().copied().fold(0.0, f64::max));
    println!("list of firings: median {median}, at most {most} bytes");
    assert!(median <= 44.0 && most <= 56.0, "{median} {most}");
}

/// Without knowing what each laser's own angle is.
pub fn shared_firings_are_found_from_the_points() {
    for data::Scan { name, points } in data::KITTI.iter().step_by(5) {
        let points = xyz(points);
        let known = find_firings(points.as_slice(), &hdl64e::FIRING_GRID).unwrap().expect("shared");
        let found = find_firings(points.as_slice(), &hdl64e::GRID).unwrap().expect("shared");
        assert_eq!(found.ticks.len(), known.ticks.len(), "{name}");
        check(name, SensorGrid { beams: &found.beams, ..hdl64e::GRID }, &found.ticks, &points);
    }
}
