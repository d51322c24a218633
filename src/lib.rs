//! A LiDAR codec for the device that the sensor hangs on: returns of a spinning LiDAR to a range image to a few
//! kilobytes, without an allocator, and back to points with a known error.
//!
//! # The way of the data
//!
//! Each stage knows only those before it; a file holds one stage, forward and inverse side by side.
//!
//! ```text
//! points ──> point ──> geometry, kernel ──> insert ──> image ──> coder ────────> frame ──> bytes
//!            blocks    pixel and level      collisions levels    store, rle,     header,
//!            of lanes  of each point        and tally  0 = none  deflate         strips, crc
//!
//! packets ─> packet ──> returns ───────────────────────^
//!            columns    pixel and level of each beam, tick and count
//! ```
//!
//! `encoder` wires them; `decoder` (feature `std`) walks back; `metrics` compares what went in with
//! what came out and sees only points. `capi` and the command line sit on top. [`packet`] reads the sensor's own
//! packets, where range, beam and azimuth stand as integers; `packet_encoder` makes a frame of every turn of them,
//! [`stream`] datagrams while the sensor turns.
//!
//! # Words
//!
//! | word | meaning |
//! |---|---|
//! | range | slant distance from the sensor, meters |
//! | azimuth, elevation | radians; counterclockwise from x, above the horizon |
//! | row, column | beam or elevation bin, 0 = the highest; azimuth bin |
//! | return | a measured point; 'no return' where nothing came back |
//! | level | a range in steps of the quantizer; 0 = no return |
//! | strip | a run of columns that decodes alone |
//! | frame | one turn of the sensor, complete in itself |
//!
//! # Features
//!
//! None by default: the encoder, without `std` and without an allocator. `std`: decoder, metrics, point files,
//! simulated sensor, calibration. `rayon`: the decoder on all cores. `cli`: the command line. `capi`: the C ABI. `defmt`: `defmt::Format` on errors and
//! statistics. They only add; none changes a byte of a frame.
#![no_std]
#![deny(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "std")]
extern crate std;

/// The README's example compiles and runs.
#[cfg(all(doctest, feature = "std"))]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(feature = "std")]
mod beam_order;
mod beside;
#[cfg(feature = "capi")]
pub mod capi;
pub mod coder;
mod config;
pub mod control;
mod encoder;
mod error;
mod firings_config;
mod fit;
pub mod frame;
pub mod geometry;
mod image;
mod insert;
mod kernel;
pub mod packet;
mod packet_encoder;
pub mod plane;
mod point;
mod previous;
mod quantize;
mod returns;
pub mod stream;
mod tally;

#[cfg(feature = "std")]
pub mod calibrate;
#[cfg(feature = "std")]
mod choose;
#[cfg(feature = "std")]
mod decoder;
#[cfg(feature = "std")]
pub mod files;
#[cfg(feature = "std")]
pub mod metrics;
#[cfg(feature = "std")]
pub mod original;
#[cfg(feature = "std")]
mod parallel;
#[cfg(feature = "std")]
mod recognize;
#[cfg(feature = "std")]
pub mod sensor;
#[cfg(feature = "std")]
pub mod simulate;
#[cfg(feature = "std")]
mod smooth;

pub use coder::{
    Coder, CoderId, Deflate, DeflateDefault, DeflateDense, DeflateSmall, Dense, OutputFull, Rle, Small, Store,
    WorstCase,
};
pub use config::{Config, FrameSettings, GridConfig, GridSettings, LatticeConfig, Scale, Settings};
pub use encoder::{
    Encoded, Encoder, Encoder256x64, Encoder512x64, Encoder1024x64, Encoder2048x64, Encoder4096x64, Encoder4500x64,
    FrameEncoder, Stamp, encode,
};
pub use error::{ConfigError, DecodeError, EncodeError, HeaderField, LimitKind, PayloadFault};
pub use firings_config::FiringsConfig;
pub use fit::{GridFit, NoFit, Residual};
pub use frame::{Geometry, Header};
pub use geometry::{Placement, UniformGrid, UniformView};
pub use image::{ImageView, ImageViewMut, Level, RangeImage};
pub use insert::{Collision, OutOfView, Policy};
pub use packet_encoder::{EncodedTurn, PacketEncoder, PushError};
pub use point::{BLOCK_LEN, Block, Points, StridedPoints};
pub use previous::{Link, Previous};
pub use quantize::{Companding, OutOfScale, Quantizer};
pub use returns::GridReturn;
pub use tally::Tally;

#[cfg(feature = "std")]
pub use choose::{Advice, GeometryChoice, Trial, choose_geometry};
#[cfg(feature = "std")]
pub use decoder::{Decoder, Frame, Levels, Limits};
#[cfg(feature = "std")]
pub use recognize::{Recognition, recognize_sensor};
