//! Logging by `defmt`: a line takes a few bytes of the link, and no text of the flash. Compiled in by the feature of that name,
//! on Cortex-M, where a third UART carries it; `tools/defmt.sh` makes text of it.

use flicr::stream::StreamTally;

use super::job::Job;

#[cfg(all(feature = "defmt", target_arch = "arm"))]
mod on {
    use super::{Job, StreamTally};

    pub fn start(job: &Job, encoder_bytes: usize) {
        defmt::info!("streams in steps of {=u16} counts, encoder of {=usize} bytes", job.step.levels(), encoder_bytes);
    }

    pub fn turn(tally: &StreamTally) {
        defmt::info!("turn over: {}", tally);
    }

    pub fn refused(packets: u32) {
        defmt::warn!("packet {=u32} is none of the sensor's", packets);
    }
}

#[cfg(all(feature = "defmt", target_arch = "arm"))]
pub use on::{refused, start, turn};

#[cfg(not(all(feature = "defmt", target_arch = "arm")))]
pub fn start(_: &Job, _: usize) {}

#[cfg(not(all(feature = "defmt", target_arch = "arm")))]
pub fn turn(_: &StreamTally) {}

#[cfg(not(all(feature = "defmt", target_arch = "arm")))]
pub fn refused(_: u32) {}
