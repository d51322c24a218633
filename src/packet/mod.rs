//! Sensor packets to columns of returns, in integers.
//!
//! A spinning LiDAR sends what it measured as (beam, azimuth tick, range count), all integers; the
//! x, y, z of a driver are made from them. This module reads the packets and stops at the integers:
//! no float, no trigonometry, no allocation, no copy of the returns, no panic.
//!
//! ```text
//! datagram -> checked view -> firings -> columns of a turn -> returns
//!             velodyne        (spin)     (spin_turns,         (column)
//!             pandar40p, pandar64,        ouster_turns)
//!             pandar_xt, ouster
//! ```
//!
//! - One file for each wire format, with its bytes drawn. A packet is checked whole (length,
//!   markers, model, return mode, header, tail, azimuths, checksum where there is one) before any of
//!   it is used.
//! - [`TurnAssembler`] numbers the firings of a turn, cuts turns at the azimuth's wrap and marks
//!   what is missing ([`Event::Gap`]), so that column and azimuth keep together whatever is lost.
//! - [`Column`] borrows the datagram; its loops over the returns are made for each format.
//! - [`Model::facts`] has each sensor's constants, among them the time at which each beam fires, from
//!   which the geometry finds a beam's own azimuth: see [`ModelFacts::fire_ns`].

// Block, channel and tick numbers, all far below 2^31, change sign where azimuths are subtracted.
#![allow(clippy::cast_possible_wrap)]

mod assembler;
mod bytes;
mod column;
mod error;
mod event;
mod hesai_time;
mod model;
mod ouster;
mod ouster_turns;
mod pandar40p;
mod pandar64;
mod pandar_xt;
mod spin;
mod spin_turns;
mod velodyne;

pub use assembler::{Sensor, TurnAssembler};
pub(crate) use column::TakeRun;
pub use column::{Cell, Column, Return, ReturnPolicy};
pub use error::{PacketError, PacketStats};
pub use event::{Event, GapCause, MAX_COLUMNS, Turn, TurnCut};
pub use model::{Model, ModelFacts, TICKS_PER_TURN};
pub use ouster::{MAX_ROWS, OusterFormat, OusterProfile};
