//! The C ABI. `include/flicr.h` is made from these files by cbindgen, and `tests/capi.rs` compares the two, so that the
//! types have their C names here too.
//!
//! The conventions, which the header's first comment tells C: a status is returned; results go to the last argument,
//! and only on success; the caller owns all memory and can size it at compile time.
//!
//! `status`, `config`, `context` and `sensor` hold what C sees of values, `encoder` (points), `grid` (returns and packets) and
//! `stream` the functions; `memory` is all that the functions do with pointers.
#![allow(non_camel_case_types, reason = "as in C")]
#![allow(
    clippy::missing_safety_doc,
    reason = "one contract for all, in the header's first comment and `cbindgen.toml`"
)]

mod config;
mod context;
mod encoder;
mod grid;
mod memory;
mod planes;
mod sensor;
mod status;
mod stream;

pub use config::*;
pub use context::{
    FLICR_CONTEXT_BLOCK_COST, FLICR_CONTEXT_BLOCK_LEN, FLICR_CONTEXT_ROWS_MAX, FLICR_DENSE_STATE_LEN,
    FLICR_SMALL_STATE_LEN, PredictorCode, flicr_context, flicr_context_init, flicr_predictor,
};
pub use encoder::*;
pub use grid::*;
pub use planes::*;
pub use sensor::*;
pub use status::*;
pub use stream::*;

/// Major version: changes where programs that use this header must be changed.
pub const FLICR_VERSION_MAJOR: u32 = 0;
/// Minor version: changes where something is added (and, while the major version is 0, where something breaks).
pub const FLICR_VERSION_MINOR: u32 = 1;
/// Patch version.
pub const FLICR_VERSION_PATCH: u32 = 0;

/// The version of the library, to compare with FLICR_VERSION, the header's.
#[unsafe(no_mangle)]
#[allow(unsafe_code, reason = "the name is for C")]
pub extern "C" fn flicr_version() -> u32 {
    (FLICR_VERSION_MAJOR << 16) | (FLICR_VERSION_MINOR << 8) | FLICR_VERSION_PATCH
}

/// For a static library without Rust's standard library, which `tools/staticlib.sh` builds with `--cfg
/// flicr_staticlib`; everybody else has a handler already. Nothing in the library is known to get here: it stops where
/// a debugger can see it, as there is nobody to tell.
#[cfg(flicr_staticlib)]
#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
