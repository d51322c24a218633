//! Where bytes come from and go to.

use heapless::CString;
use semihosting::fs::File;
use semihosting::io::{Read, Write};

use flicr::stream::write_framed;

use super::Fault;

/// Packets in, datagrams out; both in frames of `flicr::stream`'s, as a UART needs them.
pub trait Link {
    /// Waits for bytes; 0 where no more will come.
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Fault>;

    /// Waits until the datagram has gone out.
    fn send(&mut self, datagram: &[u8]) -> Result<(), Fault>;

    /// Bytes that came faster than they were taken.
    fn overruns(&self) -> u32;
}

const PATH_LEN: usize = 256;

/// Files of the host: where there are no interrupts, what the codec takes can be counted alone.
pub struct Files {
    packets: File,
    datagrams: Framed,
}

impl Files {
    pub fn open(packets: &str, datagrams: &str) -> Result<Self, Fault> {
        let path = |path: &str| {
            CString::<PATH_LEN>::from_bytes_truncating_at_nul(path.as_bytes())
                .map_err(|_| Fault::Usage("a path is too long"))
        };
        Ok(Self { packets: File::open(path(packets)?)?, datagrams: Framed(File::create(path(datagrams)?)?) })
    }
}

impl Link for Files {
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Fault> {
        Ok(self.packets.read(bytes)?)
    }

    fn send(&mut self, datagram: &[u8]) -> Result<(), Fault> {
        Ok(write_framed(&mut self.datagrams, datagram)?)
    }

    fn overruns(&self) -> u32 {
        0
    }
}

/// The host's file, as `embedded_io` knows streams.
struct Framed(File);

/// An error of the host's.
#[derive(Debug)]
pub struct HostError(semihosting::io::Error);

impl core::fmt::Display for HostError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

impl core::error::Error for HostError {}

impl embedded_io::Error for HostError {
    fn kind(&self) -> embedded_io::ErrorKind {
        embedded_io::ErrorKind::Other
    }
}

impl embedded_io::ErrorType for Framed {
    type Error = HostError;
}

impl embedded_io::Write for Framed {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, HostError> {
        self.0.write(bytes).map_err(HostError)
    }

    fn flush(&mut self) -> Result<(), HostError> {
        Ok(())
    }
}

impl From<HostError> for Fault {
    fn from(HostError(error): HostError) -> Self {
        Self::Host(error)
    }
}
