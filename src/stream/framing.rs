//! Datagrams over a byte stream, as a UART is one: each between zeros, and without zeros in it.
//!
//! Source: consistent overhead byte stuffing (Cheshire and Baker, 1999). A receiver that hears the stream from anywhere on, or
//! bytes that were lost or changed, is right again at the next zero.

use embedded_io::Write;

/// Bytes of a run at most, without its length.
const RUN_LEN_MAX: usize = 254;

/// Bytes that a datagram of `len` bytes takes in a byte stream, at most: one for each 254 of them, and three.
#[must_use]
pub const fn framed_len(len: usize) -> usize {
    len + len / RUN_LEN_MAX + 3
}

/// The datagram's runs: each its length plus one, and bytes that are not zero. Behind each run but the last stands for the
/// decoder a zero, unless it is of 254 bytes.
fn runs(datagram: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut left = Some(datagram);
    core::iter::from_fn(move || {
        let bytes = left?;
        let most = bytes.get(..RUN_LEN_MAX).unwrap_or(bytes);
        let len = most.iter().position(|&byte| byte == 0).unwrap_or(most.len());
        let (run, behind) = bytes.split_at_checked(len)?;
        left = match behind {
            [] => None,
            behind if len == RUN_LEN_MAX => Some(behind),
            [_, behind @ ..] => Some(behind),
        };
        Some((len as u8 + 1, run))
    })
}

/// Writes a datagram to a byte stream, its zeros before and behind included. Waits where the stream does; holds no copy.
///
/// # Errors
/// The stream's; the receiver then loses this datagram, no other.
///
/// ```
/// let mut uart = [0; 8];
/// flicr::stream::write_framed(&mut uart.as_mut_slice(), &[5, 0, 7])?;
/// assert_eq!(uart, [0, 2, 5, 2, 7, 0, 0, 0]);
/// # Ok::<(), embedded_io::SliceWriteError>(())
/// ```
pub fn write_framed<W: Write>(stream: &mut W, datagram: &[u8]) -> Result<(), W::Error> {
    stream.write_all(&[0])?;
    for (code, run) in runs(datagram) {
        stream.write_all(&[code])?;
        stream.write_all(run)?;
    }
    stream.write_all(&[0])
}

/// The same as [`write_framed`] into memory: gives its length, `None` where it does not fit. [`framed_len`] bytes are enough.
///
/// ```
/// let mut line = [0xee; 8];
/// assert_eq!(flicr::stream::frame_into(&[5, 0, 7], &mut line), Some(6));
/// assert_eq!(line[..6], [0, 2, 5, 2, 7, 0]);
/// ```
#[must_use]
pub fn frame_into(datagram: &[u8], out: &mut [u8]) -> Option<usize> {
    let mut len = 0;
    let mut put = |bytes: &[u8]| {
        let place = out.get_mut(len..)?.get_mut(..bytes.len())?;
        place.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        len += bytes.len();
        Some(())
    };
    put(&[0])?;
    for (code, run) in runs(datagram) {
        put(&[code])?;
        put(run)?;
    }
    put(&[0])?;
    Some(len)
}

/// As [`write_framed`], where waiting is not done by standing still.
///
/// # Errors
/// As [`write_framed`].
pub async fn write_framed_async<W: embedded_io_async::Write>(stream: &mut W, datagram: &[u8]) -> Result<(), W::Error> {
    stream.write_all(&[0]).await?;
    for (code, run) in runs(datagram) {
        stream.write_all(&[code]).await?;
        stream.write_all(run).await?;
    }
    stream.write_all(&[0]).await
}

/// A byte stream back to datagrams of up to `LEN` bytes, from anywhere on.
///
/// What comes out is what stood between two zeros: a datagram, or what was left of one. [`StreamDecoder`] tells.
///
/// RAM: `LEN` bytes and a few.
///
/// [`StreamDecoder`]: super::StreamDecoder
///
/// ```
/// use flicr::stream::{Deframer, write_framed};
/// let mut line = vec![9, 9, 9];
/// write_framed(&mut line, &[5, 0, 7])?;
/// let mut deframer: Deframer = Deframer::new();
/// let mut found = Vec::new();
/// deframer.push(&line, |datagram| found.push(datagram.to_vec()));
/// assert_eq!((found, deframer.refused()), (vec![vec![5, 0, 7]], 1));
/// # Ok::<(), core::convert::Infallible>(())
/// ```
#[derive(Debug, Clone)]
pub struct Deframer<const LEN: usize = { super::DATAGRAM_LEN }> {
    datagram: [u8; LEN],
    len: usize,
    state: State,
    refused: u32,
}

#[derive(Debug, Clone, Copy)]
enum State {
    /// Behind a zero.
    Between,
    /// Bytes that are left of a run; whether a zero comes behind it.
    Run(u8, bool),
    /// Until the next zero: what came was no datagram.
    Lost,
}

impl<const LEN: usize> Default for Deframer<LEN> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const LEN: usize> Deframer<LEN> {
    /// One that has heard nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { datagram: [0; LEN], len: 0, state: State::Between, refused: 0 }
    }

    /// Takes bytes as they come, any number at a time; calls `each` with every datagram that ends in them.
    pub fn push(&mut self, bytes: &[u8], mut each: impl FnMut(&[u8])) {
        for &byte in bytes {
            if let Some(len) = self.take(byte) {
                each(self.datagram.get(..len).unwrap_or_default());
            }
        }
    }

    /// Runs of bytes between zeros that were no datagram.
    #[must_use]
    pub const fn refused(&self) -> u32 {
        self.refused
    }

    /// The length of the datagram that ends with this byte.
    fn take(&mut self, byte: u8) -> Option<usize> {
        match (self.state, byte) {
            (State::Between, 0) => None,
            (State::Between, code) => {
                self.len = 0;
                self.state = State::Run(code - 1, usize::from(code) <= RUN_LEN_MAX);
                None
            }
            (State::Run(0, _), 0) => {
                self.state = State::Between;
                Some(self.len)
            }
            (State::Run(0, has_zero), code) => {
                self.state = State::Run(code - 1, usize::from(code) <= RUN_LEN_MAX);
                if has_zero {
                    self.put(0);
                }
                None
            }
            (State::Run(..) | State::Lost, 0) => {
                self.refused = self.refused.saturating_add(1);
                self.state = State::Between;
                None
            }
            (State::Run(left, has_zero), byte) => {
                self.state = State::Run(left - 1, has_zero);
                self.put(byte);
                None
            }
            (State::Lost, _) => None,
        }
    }

    fn put(&mut self, byte: u8) {
        match self.datagram.get_mut(self.len) {
            Some(place) => {
                *place = byte;
                self.len += 1;
            }
            None => self.state = State::Lost,
        }
    }
}
