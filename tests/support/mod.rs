//! What several tests share.

pub mod kitti;
pub mod statistics;
