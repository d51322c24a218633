//! Where datagrams come from: sockets, serial lines, files.

use std::fs::File;
use std::io::{self, Read, Write};
use std::net::{TcpStream, UdpSocket};
use std::str::FromStr;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::failure::Failure;

/// What was named on the command line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    Udp(String),
    Tcp(String),
    Unix(String),
    /// A serial device, a file, or `-`.
    Path(String),
}

impl FromStr for Source {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((scheme, rest)) = text.split_once(':') else { return Ok(Self::Path(text.to_owned())) };
        let rest = rest.strip_prefix("//").unwrap_or(rest).to_owned();
        match scheme {
            "udp" => Ok(Self::Udp(rest)),
            "tcp" => Ok(Self::Tcp(rest)),
            "unix" => Ok(Self::Unix(rest)),
            _ => Ok(Self::Path(text.to_owned())),
        }
    }
}

/// What came.
pub enum Message {
    Datagram(Vec<u8>),
    /// A part of a byte stream.
    Bytes(Vec<u8>),
    /// No more will come; why, where that is a failure.
    End(Option<io::Error>),
}

/// Pieces that are waiting to be looked at, at most; a byte stream then waits, of UDP the newest are lost.
const WAITING_MAX: usize = 1024;
/// How long to try to reach a sender that is not there yet.
const PATIENCE: Duration = Duration::from_secs(10);
/// Longer than any datagram.
const PIECE_LEN: usize = 1 << 16;

impl Source {
    /// Opens it; what comes is read by a thread of its own.
    pub fn open(&self) -> Result<Receiver<Message>, Failure> {
        let failed = |name: &str, error: io::Error| Failure::Data(format!("{name}: {error}"));
        let (send, receive) = sync_channel(WAITING_MAX);
        match self {
            Self::Udp(address) => {
                let socket = UdpSocket::bind(address).map_err(|error| failed(address, error))?;
                // Which port it is where 0 was asked for. Where stderr is closed, nobody wants to know.
                if let Ok(bound) = socket.local_addr() {
                    let _ = writeln!(io::stderr(), "note: listening at {bound}");
                }
                thread::spawn(move || read_datagrams(&socket, &send));
            }
            Self::Tcp(address) => {
                let stream = patiently(|| TcpStream::connect(address)).map_err(|error| failed(address, error))?;
                thread::spawn(move || read_bytes(stream, &send));
            }
            Self::Unix(path) => {
                let stream = unix(path).map_err(|error| failed(path, error))?;
                thread::spawn(move || read_bytes(stream, &send));
            }
            Self::Path(path) if path == "-" => {
                thread::spawn(move || read_bytes(io::stdin(), &send));
            }
            Self::Path(path) => {
                let file = File::open(path).map_err(|error| failed(path, error))?;
                thread::spawn(move || read_bytes(file, &send));
            }
        }
        Ok(receive)
    }
}

#[cfg(unix)]
fn unix(path: &str) -> io::Result<std::os::unix::net::UnixStream> {
    patiently(|| std::os::unix::net::UnixStream::connect(path))
}

#[cfg(not(unix))]
fn unix(_: &str) -> io::Result<File> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "no such sockets on this system"))
}

/// Tries until somebody listens.
fn patiently<T>(mut connect: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    let began = Instant::now();
    loop {
        match connect() {
            Err(error)
                if began.elapsed() < PATIENCE
                    && matches!(error.kind(), io::ErrorKind::ConnectionRefused | io::ErrorKind::NotFound) =>
            {
                thread::sleep(Duration::from_millis(50));
            }
            connected => return connected,
        }
    }
}

fn read_datagrams(socket: &UdpSocket, send: &SyncSender<Message>) {
    read(send, Message::Datagram, |piece| socket.recv(piece).map(Some));
}

fn read_bytes(mut stream: impl Read, send: &SyncSender<Message>) {
    read(send, Message::Bytes, |piece| stream.read(piece).map(|len| (len > 0).then_some(len)));
}

/// Until it ends, fails, or nobody listens any more.
fn read(
    send: &SyncSender<Message>,
    message: impl Fn(Vec<u8>) -> Message,
    mut next: impl FnMut(&mut [u8]) -> io::Result<Option<usize>>,
) {
    let mut piece = vec![0; PIECE_LEN];
    loop {
        let came = match next(&mut piece) {
            Ok(Some(len)) => message(piece[..len].to_vec()),
            Ok(None) => Message::End(None),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => Message::End(Some(error)),
        };
        let is_end = matches!(came, Message::End(_));
        if send.send(came).is_err() || is_end {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Source;

    #[test]
    fn sources_have_schemes() {
        let source = |text: &str| text.parse::<Source>().unwrap();
        assert_eq!(source("udp://0.0.0.0:2400"), Source::Udp("0.0.0.0:2400".into()));
        assert_eq!(source("tcp:localhost:2400"), Source::Tcp("localhost:2400".into()));
        assert_eq!(source("unix:/tmp/socket"), Source::Unix("/tmp/socket".into()));
        assert_eq!(source("unix:///tmp/socket"), Source::Unix("/tmp/socket".into()));
        assert_eq!(source("/dev/ttyUSB0"), Source::Path("/dev/ttyUSB0".into()));
        assert_eq!(source("-"), Source::Path("-".into()));
    }
}
