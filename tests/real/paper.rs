//! The presets lose and err as an independent implementation of the paper's projection found on these scans.

use flicr::metrics::{PAPER_MAX_RANGE_M, distances};
use flicr::{Config, Decoder, ImageViewMut, Rle, Stamp, encode};

use crate::common::data::{self, Scan, median};
use crate::common::xyz;

struct Expected {
    columns: usize,
    /// Of the returns, preset `paper`.
    lost: f64,
    paper_psnr_db: f64,
    uniform_psnr_db: f64,
}

const fn expected(columns: usize, lost_percent: f64, paper_psnr_db: f64, uniform_psnr_db: f64) -> Expected {
    Expected { columns, lost: lost_percent / 100.0, paper_psnr_db, uniform_psnr_db }
}

const EXPECTED: [Expected; 6] = [
    expected(4500, 7.07, 58.40, 59.57),
    expected(4096, 7.79, 58.39, 59.59),
    expected(2048, 19.75, 58.23, 59.67),
    expected(1024, 58.3, 57.37, 59.43),
    expected(512, 78.8, 54.86, 58.42),
    expected(256, 89.25, 50.68, 55.88),
];

pub fn presets_lose_and_err_as_the_paper_does() {
    for expected in EXPECTED {
        let columns = expected.columns;
        let (lost, psnr_db) = medians(&Config::PAPER, columns);
        println!("{columns:4} paper:   {:5.2} % lost, {psnr_db:.2} dB", 100.0 * lost);
        assert!((lost - expected.lost).abs() <= 0.002, "{columns}: {lost} lost");
        assert!((psnr_db - expected.paper_psnr_db).abs() <= 0.2, "{columns}: {psnr_db} dB");
        let (lost, psnr_db) = medians(&Config::UNIFORM, columns);
        println!("{columns:4} uniform: {:5.2} % lost, {psnr_db:.2} dB", 100.0 * lost);
        // The figures are rounded to a hundredth.
        assert!(psnr_db >= expected.uniform_psnr_db - 0.005, "{columns}: {psnr_db} dB");
    }
}

fn medians(config: &Config, columns: usize) -> (f64, f64) {
    let (lost, psnr_db): (Vec<f64>, Vec<f64>) =
        data::KITTI.iter().map(|scan| lost_and_psnr_db(config, columns, scan)).unzip();
    (median(lost), median(psnr_db))
}

fn lost_and_psnr_db(config: &Config, columns: usize, scan: &Scan) -> (f64, f64) {
    let mut levels = vec![0_u8; 64 * columns];
    let mut out = vec![0; 400_000];
    let image = ImageViewMut::new(&mut levels, columns).unwrap();
    let points = scan.points.as_slice();
    let encoded = encode(config, points, Stamp::default(), image, &mut Rle::new(), &mut out).unwrap();
    let decoded = Decoder::default().decode(&out[..encoded.len]).unwrap().points();
    assert_eq!(decoded.len(), encoded.tally.kept() as usize);
    let returns: Vec<[f32; 3]> = xyz(points).into_iter().filter(|point| *point != [0.0; 3]).collect();
    let mse_m2 = distances(&decoded, &returns).unwrap().mse_m2;
    let lost = 1.0 - decoded.len() as f64 / returns.len() as f64;
    (lost, 10.0 * (PAPER_MAX_RANGE_M * PAPER_MAX_RANGE_M / mse_m2).log10())
}
