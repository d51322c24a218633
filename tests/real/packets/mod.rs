//! Captures of real sensors against what other decoders made of them.

#![allow(clippy::cast_possible_wrap)] // small numbers

pub mod bad;
#[path = "../../common/packet_bench.rs"]
pub mod bench;
#[path = "../../common/captures.rs"]
pub mod captures;
pub mod frames;
pub mod hesai;
// The sensor's own metadata are JSON, which the command line reads.
#[cfg(feature = "cli")]
pub mod ouster;
#[path = "../../common/packet_stream.rs"]
pub mod stream;
pub mod velodyne;
