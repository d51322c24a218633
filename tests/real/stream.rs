//! What streams of real scans cost.

use flicr::coder::{ContextSettings, SmallModel, Step};
use flicr::geometry::{Firings, Lattice, find_firings, sensors::hdl64e};
use flicr::stream::{AlignedHdl64e, AsFired, Line, StreamConfig, StreamEncoder};
use flicr::{FiringsConfig, ImageViewMut, LatticeConfig, Small, Stamp, encode};

use crate::common::{data, xyz};

struct Scan {
    ticks: Vec<u32>,
    /// Range counts, row-major, a column a firing.
    fired: Vec<u16>,
}

fn settings(step: u16) -> ContextSettings {
    ContextSettings::FINE.with_step(Step::new(step).unwrap())
}

fn read(points: &[[f32; 4]], lattice: &Lattice<'_, 66>) -> (Scan, Vec<usize>) {
    let points = xyz(points);
    let found = find_firings(points.as_slice(), &hdl64e::FIRING_GRID).unwrap().expect("shared");
    let firings = Firings::<125>::new(4000, found.ticks.iter().copied()).unwrap();
    let columns = found.ticks.len();
    let config = FiringsConfig { every_tick: LatticeConfig::new(lattice), firings: &firings };
    let mut aligned = vec![0_u16; 64 * columns];
    let mut lens = Vec::new();
    for step in [1, 10, 51, 157] {
        let image = ImageViewMut::new(&mut aligned, columns).unwrap();
        let mut out = vec![0; config.worst_case_len::<u16, Small<8>>()];
        let encoded =
            encode(&config, points.as_slice(), Stamp::default(), image, &mut Small::<8>::new(settings(step)), &mut out);
        lens.push(encoded.unwrap().len);
    }
    let mut fired = vec![0; aligned.len()];
    for (row, beam) in hdl64e::FIRING_BEAMS.iter().enumerate() {
        let turns = f64::from(beam.azimuth_phase_rad) / std::f64::consts::TAU;
        let shift = (turns * columns as f64).round_ties_even().rem_euclid(columns as f64) as usize;
        for firing in 0..columns {
            let column = (firing + shift) % columns;
            fired[row * columns + firing] = aligned[row * columns + column];
        }
    }
    (Scan { ticks: found.ticks, fired }, lens)
}

/// A turn's bytes and datagrams in the midst of a stream: the same turn goes by before and after.
fn streamed<L: Line>(scan: &Scan, step: u16) -> (usize, usize) {
    let config =
        StreamConfig { columns_a_turn: 2150, ..StreamConfig::new(&hdl64e::FIRING_GRID, 1, settings(step)).unwrap() };
    let mut stream: Box<StreamEncoder<SmallModel, 8, 1400, L>> = Box::new(StreamEncoder::BLANK);
    stream.start(config).unwrap();
    let columns = scan.ticks.len();
    let (mut bytes, mut datagrams) = (0, 0);
    for _ in 0..3 {
        let mut send = |datagram: &[u8]| {
            // All that turn 1 has.
            if u16::from_le_bytes([datagram[4], datagram[5]]) == 1 {
                (bytes, datagrams) = (bytes + datagram.len(), datagrams + 1);
            }
        };
        for (column, &tick) in scan.ticks.iter().enumerate() {
            let counts: [u32; 64] = std::array::from_fn(|row| scan.fired[row * columns + column].into());
            stream.push_counts(column as u16, tick as u16, 0, &counts, &mut send);
        }
        stream.end_turn(&mut send);
    }
    (bytes, datagrams)
}

/// Beside whole frames by the same coder: promised are at most 5 % more bytes where columns are aligned, 12 % as fired.
/// The first is missed by 0.3 % at 2 and 20 mm (docs/PERFORMANCE.md says why), which is kept from growing.
pub fn streams_cost_little_on_raw_scans() {
    let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, 4000).unwrap();
    let steps = [1, 10, 51, 157];
    let mut shares = vec![[Vec::new(), Vec::new()]; steps.len()];
    let held_out = data::KITTI.iter().filter(|scan| !scan.name.contains("object"));
    for scan in held_out.step_by(5) {
        let (scan, lens) = read(&scan.points, &lattice);
        for ((&step, whole), shares) in steps.iter().zip(lens).zip(&mut shares) {
            let (aligned, datagrams) = streamed::<AlignedHdl64e>(&scan, step);
            let (fired, _) = streamed::<AsFired>(&scan, step);
            println!("{step}: {whole} {aligned} {fired} {datagrams}");
            shares[0].push(aligned as f64 / whole as f64);
            shares[1].push(fired as f64 / whole as f64);
        }
    }
    for (step, shares) in steps.into_iter().zip(shares) {
        let [aligned, fired] = shares.map(data::median);
        println!("{} mm: aligned {aligned:.4}, as fired {fired:.4}", 2 * step);
        assert!(aligned <= if step <= 10 { 1.0535 } else { 1.05 } && fired <= 1.12);
    }
}
