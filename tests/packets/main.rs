//! Packets: every return of the shared captures, models without captures, bad packets.

#![allow(clippy::cast_possible_wrap)] // small numbers

mod bad;
mod captures;
mod gaps;
mod hesai;
mod models;
mod ouster;
mod velodyne;
mod writer;
