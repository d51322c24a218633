//! Promises that only real scans and packets can test. Where `FLICR_DATA` (default `../shared/data`) is not there, one
//! line says so and every one of these is counted as ignored, not as passed.
#![allow(missing_docs)]

mod calibrate;
#[path = "../common/mod.rs"]
mod common;
mod context;
mod deflate;
mod files;
#[path = "../../examples/train_priors/firings.rs"]
mod firings;
mod geometry;
mod lattice;
mod metrics;
mod paper;
mod simulate;

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial, run};

const TESTS: &[(&str, fn())] = &[
    ("calibrate::any_eight_kitti_scans_give_the_table", calibrate::any_eight_kitti_scans_give_the_table),
    ("calibrate::eight_kitti_scans_in_a_row_give_the_table", calibrate::eight_kitti_scans_in_a_row_give_the_table),
    ("calibrate::helios_16p", calibrate::helios_16p),
    ("calibrate::vlp_16", calibrate::vlp_16),
    ("calibrate::vlp_32c", calibrate::vlp_32c),
    ("calibrate::ouster_os0_32", calibrate::ouster_os0_32),
    ("calibrate::ouster_os1_128", calibrate::ouster_os1_128),
    ("calibrate::nuscenes_is_motion_compensated", calibrate::nuscenes_is_motion_compensated),
    ("context::ratios_on_the_sensors_own_grid", context::ratios_on_the_sensors_own_grid),
    ("context::smaller_than_zlib_on_the_papers_images", context::smaller_than_zlib_on_the_papers_images),
    ("deflate::profiles_are_as_small_as_promised", deflate::profiles_are_as_small_as_promised),
    ("files::point_files_are_read", files::point_files_are_read),
    ("files::pcd_files_are_what_pcd_rs_reads", files::pcd_files_are_what_pcd_rs_reads),
    ("geometry::columns_are_those_of_double_precision", geometry::columns_are_those_of_double_precision),
    (
        "lattice::every_point_is_on_its_beam_tick_and_count",
        lattice::every_point_of_the_raw_scans_is_on_its_beam_tick_and_count,
    ),
    ("lattice::raw_scans_come_back_to_the_millimeter", lattice::raw_scans_come_back_to_the_millimeter),
    ("lattice::few_points_are_lost_on_other_columns", lattice::few_points_are_lost_on_other_columns),
    ("lattice::raw_scans_are_told_to_be_on_the_grid", lattice::raw_scans_are_told_to_be_on_the_grid),
    ("metrics::agree_with_scipy", metrics::agree_with_scipy),
    ("paper::presets_lose_and_err_as_the_paper_does", paper::presets_lose_and_err_as_the_paper_does),
    ("simulate::the_beam_table_is_the_fit", simulate::the_beam_table_is_the_fit),
    ("simulate::statistics_are_those_of_real_scans", simulate::statistics_are_those_of_real_scans),
];

fn main() -> ExitCode {
    let skip = common::data::FOLDER.is_none();
    if skip {
        eprintln!("skipped: no shared data beside the crate or at FLICR_DATA; {} tests ignored", TESTS.len());
    }
    let trial = |&(name, test): &(&'static str, fn())| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
        .with_ignored_flag(skip)
    };
    run(&Arguments::from_args(), TESTS.iter().map(trial).collect()).exit_code()
}
