//! On the 8-bit images of real scans the DEFLATE profiles keep up with zlib -6.

use flicr::{Deflate, DeflateDefault, DeflateDense, DeflateSmall};

use crate::common::data::{self, median};
use crate::common::range_images::{WIDTHS, image, zlib};

/// Median bytes at each width, as a share of zlib -6's: the most that a profile may take.
const DEFAULT_MOST: f64 = 1.03;
const SMALL_MOST: f64 = 1.10;
const DENSE_MOST: f64 = 1.00;

pub fn profiles_are_as_small_as_promised() {
    println!("{:>8} {:>8} {:>8} {:>8} {:>8}", "columns", "zlib -6", "default", "small", "dense");
    for columns in WIDTHS {
        let images: Vec<_> = data::KITTI.iter().map(|scan| image(&scan.points, columns)).collect();
        let mut out = vec![0; 600_000];
        let theirs = median(images.iter().map(|image| zlib(image, 6, &mut out) as f64));
        let default = median_len(&mut Box::new(DeflateDefault::new()), &images, columns) / theirs;
        let small = median_len(&mut Box::new(DeflateSmall::new()), &images, columns) / theirs;
        let dense = median_len(&mut Box::new(DeflateDense::new()), &images, columns) / theirs;
        println!("{columns:8} {theirs:8} {default:8.4} {small:8.4} {dense:8.4}");
        assert!(default <= DEFAULT_MOST && small <= SMALL_MOST && dense <= DENSE_MOST);
    }
}

fn median_len<const SHORT: usize, const LONG: usize, const WAYS: usize, const SEQUENCES: usize>(
    coder: &mut Deflate<SHORT, LONG, WAYS, SEQUENCES>,
    images: &[Vec<u8>],
    columns: usize,
) -> f64 {
    let mut out = vec![0; Deflate::<SHORT, LONG, WAYS, SEQUENCES>::worst_case_len(64 * columns)];
    let mut encode = |image: &Vec<u8>| {
        let len = coder.encode_bytes(image, columns, &mut out).unwrap();
        assert!(miniz_oxide::inflate::decompress_to_vec(&out[..len]).unwrap() == *image);
        len as f64
    };
    median(images.iter().map(&mut encode))
}
