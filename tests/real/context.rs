//! How small the context coders make real scans that their priors were not trained on, each within its bound.

use flicr::coder::{Coder, ContextSettings, Predictor, Step};
use flicr::{Dense, ImageView, Small};

use crate::common::data::{self, median};
use crate::common::range_images::{WIDTHS, image, zlib};
use crate::firing_images::{Firings, Shifts};

/// Steps in levels of 2 mm, and the least ratios to 16 bytes a point: small and dense.
const LEAST: [(u16, f64, f64); 7] = [
    (1, 19.2, 20.0),
    (5, 30.8, 32.9),
    (10, 39.4, 43.0),
    (25, 57.0, 64.0),
    (51, 74.8, 85.5),
    (101, 96.5, 112.0),
    (157, 114.0, 134.0),
];

/// Header, strip and checksum of a frame on the sensor's grid, and the list of firings.
const OTHER_BYTES: usize = 84 + 48;

pub fn ratios_on_the_sensors_own_grid() {
    let held_out: Vec<_> = data::KITTI.iter().filter(|scan| !scan.name.contains("object")).collect();
    let shifts = Shifts::read(&data::path("kitti/object/000000.bin")).unwrap();
    let read = |scan: &&data::Scan| Firings::read(&data::path(&scan.name), &shifts).unwrap();
    let images: Vec<Firings> = held_out.iter().map(read).collect();
    println!("{:>8} {:>8} {:>8}", "step mm", "small", "dense");
    for (step, least_small, least_dense) in LEAST {
        let settings = ContextSettings::FINE.with_step(Step::new(step).unwrap());
        let ratio = |coder: &mut dyn FnMut(ImageView<'_, u16>) -> usize| {
            let scans = images.iter().zip(&held_out);
            median(scans.map(|(firings, scan)| {
                16.0 * scan.points.len() as f64 / (coder(firings.image().unwrap()) + OTHER_BYTES) as f64
            }))
        };
        let mut out = vec![0; 1 << 20];
        let small = ratio(&mut |image| Small::<8>::new(settings).encode(image, &mut out).unwrap());
        let dense = ratio(&mut |image| Dense::<8>::new(settings).encode(image, &mut out).unwrap());
        println!("{:8} {small:8.2} {dense:8.2}", 2 * step);
        assert!(small >= least_small && dense >= least_dense);
    }
}

/// zlib -6's bytes, divided by those of the dense tier.
const LEAST_TO_ZLIB: [f64; 6] = [1.15, 1.15, 1.3, 1.3, 1.3, 1.3];

pub fn smaller_than_zlib_on_the_papers_images() {
    println!("{:>8} {:>8} {:>8} {:>8}", "columns", "small", "dense", "median");
    for (columns, least) in WIDTHS.into_iter().zip(LEAST_TO_ZLIB) {
        let images: Vec<_> = data::KITTI.iter().map(|scan| image(&scan.points, columns)).collect();
        let mut out = vec![0; 600_000];
        let theirs = median(images.iter().map(|image| zlib(image, 6, &mut out) as f64));
        let west = ContextSettings::COARSE;
        let median_edge = ContextSettings { predictor: Predictor::MedianEdge, ..west };
        let mut len = |coder: &mut dyn FnMut(ImageView<'_, u8>, &mut [u8]) -> usize| {
            median(images.iter().map(|image| coder(ImageView::new(image, columns).unwrap(), &mut out) as f64))
        };
        let small = theirs / len(&mut |image, out| Small::<8>::new(west).encode(image, out).unwrap());
        let dense = theirs / len(&mut |image, out| Dense::<8>::new(west).encode(image, out).unwrap());
        let other = theirs / len(&mut |image, out| Dense::<8>::new(median_edge).encode(image, out).unwrap());
        println!("{columns:8} {small:8.3} {dense:8.3} {other:8.3}");
        assert!(dense.max(other) >= least);
    }
}
