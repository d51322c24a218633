//! Packets: models and policies, lost and bad packets, from packets made here. Captures are in `tests/real`.

#![allow(clippy::cast_possible_wrap)] // small numbers

mod bad;
#[path = "../common/packet_bench.rs"]
mod bench;
mod frames;
mod gaps;
mod models;
#[path = "../common/packet_stream.rs"]
mod stream;
#[path = "../common/packet_writer.rs"]
mod writer;
