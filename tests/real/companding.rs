//! What levels by the square root give an 8-bit image of real scans.

use flicr::coder::ContextSettings;
use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::metrics::{PAPER_MAX_RANGE_M, compare};
use flicr::{Companding, Decoder, Dense, Geometry, ImageViewMut, LatticeConfig, Scale, Stamp, encode};

use crate::common::data::{self, median};

/// 8 bits over 80 m on the sensor's own grid: PSNR and bytes; no point is farther off than its frame says. Cells within 20 m
/// are smaller than even ones, beyond larger: of KITTI's points there is not much more to gain.
pub fn eight_bits_are_better_by_the_square_root() {
    let lattice = Lattice::<66>::new(hdl64e::GRID, 4000).unwrap();
    let scale = Scale::Fixed { max_range_m: 80.0 };
    let even = LatticeConfig { scale, level_bits: 8, measure: true, ..LatticeConfig::new(&lattice) };
    let [even, squares] = [Companding::None, Companding::SquareRoot].map(|companding| {
        let config = LatticeConfig { companding, ..even };
        let found: Vec<[f64; 2]> = data::KITTI.iter().step_by(8).map(|scan| of_scan(&config, scan)).collect();
        [0, 1].map(|at| median(found.iter().map(|found| found[at])))
    });
    println!(
        "8 bits over 80 m: {:.2} dB, {} bytes evenly; {:.2} dB, {} bytes by the square root",
        even[0], even[1], squares[0], squares[1]
    );
    assert!(squares[0] >= even[0] + 0.4);
}

fn of_scan(config: &LatticeConfig<'_, 66>, scan: &data::Scan) -> [f64; 2] {
    let near = |&&[x, y, z, _]: &&[f32; 4]| x * x + y * y + z * z <= 79.8 * 79.8;
    let points: Vec<[f32; 3]> = scan.points.iter().filter(near).map(|&[x, y, z, _]| [x, y, z]).collect();
    let (mut levels, mut out) = (vec![0_u8; 64 * 4000], vec![0; config.worst_case_len::<u8, Dense>()]);
    let mut coder = Dense::<8>::new(ContextSettings::COARSE);
    let image = ImageViewMut::new(&mut levels, 4000).unwrap();
    let encoded = encode(config, points.as_slice(), Stamp::default(), image, &mut coder, &mut out).unwrap();
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&out[..encoded.len]).unwrap();
    let Geometry::Beams(beams) = frame.header().geometry else { panic!("beams") };
    let quality = compare(&points, &frame.points(), PAPER_MAX_RANGE_M).unwrap();
    assert!(quality.max_error_m <= f64::from(beams.point_bound_m), "{}: {} m", scan.name, quality.max_error_m);
    [quality.psnr_db, encoded.len as f64]
}
