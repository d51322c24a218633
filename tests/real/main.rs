//! Promises that only real scans and packets can test. Where `FLICR_DATA` (default `../shared/data`) is not there, one
//! line says so and every one of these is counted as ignored, not as passed.
#![allow(missing_docs)]

mod calibrate;
#[cfg(feature = "cli")]
mod command_line;
#[path = "../common/mod.rs"]
mod common;
mod companding;
mod context;
mod deflate;
#[cfg(feature = "cli")]
mod eval;
#[cfg(feature = "cli")]
mod exact;
mod fast;
mod files;
#[path = "../../examples/train_priors/firings.rs"]
mod firing_images;
#[path = "../common/firings.rs"]
mod firing_turns;
mod firings;
mod geometry;
mod lattice;
mod metrics;
mod moved;
mod packets;
mod paper;
#[cfg(feature = "cli")]
mod sensors;
mod simulate;
mod stream;
mod strips;

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
    ("companding::eight_bits_are_better_by_the_square_root", companding::eight_bits_are_better_by_the_square_root),
    ("context::ratios_on_the_sensors_own_grid", context::ratios_on_the_sensors_own_grid),
    ("context::smaller_than_zlib_on_the_papers_images", context::smaller_than_zlib_on_the_papers_images),
    ("deflate::profiles_are_as_small_as_promised", deflate::profiles_are_as_small_as_promised),
    ("firings::all_raw_scans_by_firings", firings::all_raw_scans_by_firings),
    ("firings::shared_firings_are_found_from_the_points", firings::shared_firings_are_found_from_the_points),
    #[cfg(feature = "cli")]
    ("eval::the_papers_frame_of_a_kitti_scan", eval::the_papers_frame_of_a_kitti_scan),
    ("fast::the_bytes_are_those_of_the_format", fast::the_bytes_are_those_of_the_format),
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
    ("moved::one_percent_and_the_bound", moved::at_most_one_percent_is_lost_and_the_bound_holds_for_every_point),
    ("metrics::agree_with_scipy", metrics::agree_with_scipy),
    ("packets::every_flipped_bit", packets::bad::captured_packets_survive_every_flipped_bit),
    ("packets::pandar40p", packets::hesai::pandar40p_has_every_reference_point),
    ("packets::pandar_xt32", packets::hesai::pandar_xt32_has_every_reference_point),
    #[cfg(feature = "cli")]
    ("packets::os0_32_dual", packets::ouster::os0_32_dual_equals_the_sdk),
    #[cfg(feature = "cli")]
    ("packets::os1_128_low_rate", packets::ouster::os1_128_low_rate_equals_the_sdk),
    ("packets::vlp16_dual", packets::velodyne::vlp16_dual_equals_the_independent_decode),
    ("packets::vlp32c", packets::velodyne::vlp32c_equals_the_independent_decode),
    ("packets::vlp16_turns_are_whole", packets::velodyne::vlp16_turns_are_whole),
    ("packets::vlp32c_blind_sector", packets::velodyne::vlp32c_blind_sector_is_told_from_loss),
    ("packets::vlp16_through_frames", packets::frames::vlp16_comes_back_from_frames),
    ("packets::vlp32c_through_frames", packets::frames::vlp32c_comes_back_from_frames),
    ("packets::pandar40p_through_frames", packets::frames::pandar40p_comes_back_from_frames),
    #[cfg(feature = "cli")]
    ("packets::ouster_through_frames", packets::frames::ouster_comes_back_from_frames),
    ("paper::presets_lose_and_err_as_the_paper_does", paper::presets_lose_and_err_as_the_paper_does),
    ("simulate::the_beams_are_those_of_the_table", simulate::the_beams_are_those_of_the_table),
    ("stream::streams_cost_little_on_raw_scans", stream::streams_cost_little_on_raw_scans),
    ("strips::sixteen_strips_cost_little", strips::sixteen_strips_cost_little),
    ("simulate::statistics_are_those_of_real_scans", simulate::statistics_are_those_of_real_scans),
];

/// Of the program, where it is built.
#[cfg(feature = "cli")]
const COMMAND_LINE: &[(&str, fn())] = &[
    ("exact::raw_scans_come_back_byte_for_byte", exact::raw_scans_come_back_byte_for_byte),
    ("command_line::captures_are_encoded_without_loss", command_line::captures_are_encoded_without_loss),
    (
        "command_line::what_is_not_measured_is_told_from_what_is_missing",
        command_line::what_is_not_measured_is_told_from_what_is_missing,
    ),
    (
        "command_line::a_beam_without_returns_is_taken_from_the_design",
        command_line::a_beam_without_returns_is_taken_from_the_design,
    ),
    ("command_line::ouster_frames_equal_the_sdk", command_line::ouster_frames_equal_the_sdk),
    ("command_line::moved_scans_are_encoded_on_their_beams", command_line::moved_scans_are_encoded_on_their_beams),
    ("command_line::clouds_of_other_sensors", command_line::clouds_of_other_sensors),
    ("sensors::no_sensor_takes_more_than_zstd", sensors::no_sensor_takes_more_than_zstd),
];
#[cfg(not(feature = "cli"))]
const COMMAND_LINE: &[(&str, fn())] = &[];

fn main() -> ExitCode {
    let skip = common::data::FOLDER.is_none();
    if skip {
        eprintln!(
            "skipped: no shared data beside the crate or at FLICR_DATA; {} tests ignored",
            TESTS.len() + COMMAND_LINE.len()
        );
    }
    let trial = |&(name, test): &(&'static str, fn())| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
        .with_ignored_flag(skip)
    };
    run(&Arguments::from_args(), TESTS.iter().chain(COMMAND_LINE).map(trial).collect()).exit_code()
}
