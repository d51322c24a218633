//! A turn as it turns: columns in, datagrams out, each of which decodes alone.
//!
//! A microcontroller cannot hold a turn, nor wait for its end; links lose packets. So columns are coded as the sensor fires
//! them, and as soon as a datagram is full it goes out: a *strip*, with all that is needed to decode it but the sensor's
//! beams, which are known on both sides. A lost datagram loses its columns and nothing else.
//!
//! ```text
//! packets -> columns -> StreamEncoder -> datagrams ~~~> StreamDecoder -> strips, turns
//!            as fired   a strip's code   <= 1400 B      any order       points
//!            or aligned                  write_framed ~~~> Deframer (UARTs)
//! ```

mod config;
mod datagram;
#[cfg(feature = "std")]
mod decoder;
mod encoder;
mod framing;
mod line;
#[cfg(feature = "std")]
mod received;
mod tally;

pub use config::StreamConfig;
#[cfg(feature = "std")]
pub use datagram::DatagramError;
pub use datagram::{DATAGRAM_LEN, OVERHEAD_LEN};
#[cfg(feature = "std")]
pub use decoder::{StreamDecoder, StreamLimits, StreamLosses};
pub use encoder::StreamEncoder;
pub use framing::{Deframer, frame_into, framed_len, write_framed, write_framed_async};
pub use line::{Aligned, AlignedHdl64e, AsFired, Line};
#[cfg(feature = "std")]
pub use received::{ReceivedStrip, ReceivedTurn};
pub use tally::{Sent, StreamTally};
