//! The metrics of real scans against SciPy's (`tests/reference/metrics_scipy.py` makes the numbers).

#![expect(clippy::unreadable_literal, reason = "as SciPy printed them")]

use flicr::metrics::{PAPER_MAX_RANGE_M, Quality, compare};

use crate::common::data;
use crate::common::xyz;

const NEXT_TURN: Quality = Quality {
    mse_m2: 0.07909349606882987,
    mse_reverse_m2: 0.07465899265574956,
    psnr_db: 49.08039201453977,
    psnr_reverse_db: 49.330978481176935,
    cd_m2: 0.15375248872457942,
    cd_mean_m: 0.17266243151616487,
    max_error_m: 6.872784941971224,
    max_error_reverse_m: 6.053790032746123,
};

const LATTICE: Quality = Quality {
    mse_m2: 0.008829774109573797,
    mse_reverse_m2: 0.008647732146226932,
    psnr_db: 58.60230380737064,
    psnr_reverse_db: 58.692777446132325,
    cd_m2: 0.017477506255800728,
    cd_mean_m: 0.0866111980602339,
    max_error_m: 0.21020023385714054,
    max_error_reverse_m: 0.21020023385714054,
};

const EVERY_FIFTH: Quality = Quality {
    mse_m2: 0.0,
    mse_reverse_m2: 0.033932567060118865,
    psnr_db: f64::INFINITY,
    psnr_reverse_db: 52.75563257932266,
    cd_m2: 0.033932567060118865,
    cd_mean_m: 0.03927322711765031,
    max_error_m: 0.0,
    max_error_reverse_m: 11.00455715930888,
};

pub fn agree_with_scipy() {
    let drive = |number: usize| xyz(&data::KITTI[5 + number].points);
    let (scan, next) = (drive(0), drive(1));
    let lattice: Vec<[f32; 3]> = scan.iter().map(|point| point.map(|c| (c * 8.0).floor() / 8.0)).collect();
    let every_fifth: Vec<[f32; 3]> = scan.iter().step_by(5).copied().collect();
    assert_close(&compare(&scan, &next, PAPER_MAX_RANGE_M).unwrap(), &NEXT_TURN);
    assert_close(&compare(&scan, &lattice, PAPER_MAX_RANGE_M).unwrap(), &LATTICE);
    assert_close(&compare(&scan, &every_fifth, PAPER_MAX_RANGE_M).unwrap(), &EVERY_FIFTH);
}

fn assert_close(found: &Quality, expected: &Quality) {
    let fields = |q: &Quality| {
        let mse = [q.mse_m2, q.mse_reverse_m2, q.psnr_db, q.psnr_reverse_db];
        (mse, [q.cd_m2, q.cd_mean_m, q.max_error_m, q.max_error_reverse_m])
    };
    let (found, expected) = (fields(found), fields(expected));
    for (found, expected) in found.0.iter().chain(&found.1).zip(expected.0.iter().chain(&expected.1)) {
        let close = found == expected || (found - expected).abs() <= 1e-12 * expected.abs();
        assert!(close, "found {found}, expected {expected}");
    }
}
