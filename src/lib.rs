//! flicr: a LiDAR codec for the device that the sensor hangs on.
#![no_std]
#![deny(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "capi")]
pub mod capi;
pub mod coder;
mod config;
mod encoder;
mod error;
mod fit;
pub mod frame;
pub mod geometry;
mod image;
mod insert;
mod kernel;
pub mod packet;
mod point;
mod quantize;
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
pub mod sensor;
#[cfg(feature = "std")]
pub mod simulate;

pub use coder::{
    Coder, CoderId, Deflate, DeflateDefault, DeflateDense, DeflateSmall, OutputFull, Rle, Store, WorstCase,
};
pub use config::{Config, LatticeConfig, Scale, Settings};
pub use encoder::{Encoded, Encoder, FrameEncoder, Stamp, encode};
pub use error::{ConfigError, DecodeError, EncodeError, HeaderField, LimitKind, PayloadFault};
pub use fit::{GridFit, NoFit, Residual};
pub use frame::{Geometry, Header};
pub use geometry::{Placement, UniformGrid, UniformView};
pub use image::{ImageView, ImageViewMut, Level, RangeImage};
pub use insert::{Collision, OutOfView, Policy};
pub use point::{BLOCK_LEN, Block, Points, StridedPoints};
pub use quantize::{OutOfScale, Quantizer};
pub use tally::Tally;

#[cfg(feature = "std")]
pub use choose::{Advice, GeometryChoice, Trial, choose_geometry};
#[cfg(feature = "std")]
pub use decoder::{Decoder, Frame, Levels, Limits};
