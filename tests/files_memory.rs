//! Promise: memory is bounded by a file's length, not by what its header claims. Alone in its process, because the
//! limit is the process's.
#![cfg(feature = "std")]

use std::alloc::System;

use cap::Cap;
use flicr::files::{Fault, pcd};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// More than 88 times any input here, and far less than the headers claim.
const ALLOWED_LEN: usize = 1 << 16;

/// A header that claims `points` of `count` + 12 bytes, and 72 bytes of data that claim to be compressed from that
/// many.
fn hostile(points: u64, count: u64, data: &str) -> Vec<u8> {
    let header = format!(
        "VERSION 0.7\nFIELDS x y z pad\nSIZE 4 4 4 1\nTYPE F F F U\nCOUNT 1 1 1 {count}\nWIDTH {points}\nHEIGHT 1\n\
         POINTS {points}\nDATA {data}\n"
    );
    let plain_len = count.saturating_add(12).saturating_mul(points);
    let plain_len = u32::try_from(plain_len).unwrap_or(u32::MAX);
    [header.as_bytes(), &64_u32.to_le_bytes(), &plain_len.to_le_bytes(), &[b' '; 64]].concat()
}

#[test]
fn gigantic_headers_allocate_nothing() {
    for data in ["ascii", "binary", "binary_compressed"] {
        for points in [1_000_000, 330_382_099, 1_000_000_000_000, u64::MAX] {
            for count in [1, 1_000_000_000, u64::MAX - 1_000] {
                let bytes = hostile(points, count, data);
                // An allocation beyond the limit fails, and ends the process.
                ALLOCATOR.set_limit(ALLOCATOR.allocated() + ALLOWED_LEN).unwrap();
                let error = pcd::parse(&bytes).unwrap_err();
                ALLOCATOR.set_limit(usize::MAX).unwrap();
                let faults = [Fault::Truncated, Fault::Value, Fault::Compressed];
                assert!(faults.contains(&error.fault), "{points} points, {data}: {error}");
            }
        }
    }
}
