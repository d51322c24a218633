//! Captures of a network: pcap and pcapng files, datagram after datagram.
//!
//! The file's blocks are `pcap-parser`'s to read, the headers of Ethernet, IP and UDP `etherparse`'s; datagrams that were
//! cut up on their way are put together again, as an Ouster's long ones are.

use std::boxed::Box;
use std::format;
use std::fs::File;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::vec::Vec;

use etherparse::defrag::IpDefragPool;
use etherparse::{EtherType, IpNumber, NetSlice, SlicedPacket, TransportSlice, UdpSlice};
use pcap_parser::{Linktype, PcapBlockOwned, PcapError, create_reader, traits::PcapReaderIterator};

use super::{Fault, FileError, ParseError};

/// More than a block that holds the longest frame of a network.
const BUFFER_LEN: usize = 1 << 20;
/// Frames after which the rest of a datagram is no longer waited for.
const PATIENCE: u64 = 256;

/// One UDP datagram.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Datagram {
    /// The address that it came from.
    pub source: IpAddr,
    /// The port that it was sent to.
    pub port: u16,
    /// What it holds.
    pub payload: Vec<u8>,
}

/// The datagrams of a capture. Whatever else went over the network is passed over and counted.
///
/// Memory: a megabyte, and what is there of datagrams in pieces: 256 frames' worth at most.
///
/// ```no_run
/// use flicr::files::capture::Capture;
/// for datagram in Capture::open("drive.pcap".as_ref())? {
///     let datagram = datagram?;
///     println!("{} bytes to port {}", datagram.payload.len(), datagram.port);
/// }
/// # Ok::<(), flicr::files::FileError>(())
/// ```
pub struct Capture {
    path: PathBuf,
    reader: Box<dyn PcapReaderIterator + Send>,
    /// Of each interface, in the order in which a pcapng names them.
    links: Vec<Linktype>,
    pieces: IpDefragPool<u64>,
    frames: u64,
    others: u64,
    damaged: u64,
    offset: usize,
    is_over: bool,
}

/// What a block was.
enum Block {
    Datagram(Datagram),
    Other,
    End,
}

impl core::fmt::Debug for Capture {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Capture").field("path", &self.path).field("offset", &self.offset).finish_non_exhaustive()
    }
}

impl Capture {
    /// Opens a capture.
    ///
    /// # Errors
    /// [`FileError::Io`]; [`FileError::Parse`] where the file begins neither as pcap nor as pcapng.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let file = File::open(path).map_err(|error| FileError::io(path, error))?;
        let reader = create_reader(BUFFER_LEN, file).map_err(|_| {
            let error = ParseError::new(Fault::Header, 0, "another beginning", "the one of a pcap or pcapng file");
            FileError::parse(path, error)
        })?;
        let (links, pieces) = (Vec::new(), IpDefragPool::new());
        Ok(Self {
            path: path.into(),
            reader,
            links,
            pieces,
            frames: 0,
            others: 0,
            damaged: 0,
            offset: 0,
            is_over: false,
        })
    }

    /// Frames so far that held no datagram, nor a piece of one.
    #[must_use]
    pub const fn others(&self) -> u64 {
        self.others
    }

    /// Those of them that are cut short (as by a capture's snap length), or whose headers are damaged.
    #[must_use]
    pub const fn damaged(&self) -> u64 {
        self.damaged
    }

    fn next_block(&mut self) -> Result<Block, ParseError> {
        let Self { reader, links, pieces, frames, .. } = self;
        let (used, found) = loop {
            match reader.next() {
                Ok((used, block)) => break (used, datagram_of(&block, links, pieces, frames)),
                Err(PcapError::Eof) => return Ok(Block::End),
                Err(PcapError::Incomplete(_)) => {}
                Err(error) => return Err(fault(self.offset, &error)),
            }
            reader.refill().map_err(|error| fault(self.offset, &error))?;
        };
        reader.consume(used);
        self.offset += used;
        Ok(match found {
            Some(Read::Datagram(datagram)) => Block::Datagram(datagram),
            Some(Read::Piece) | None => Block::Other,
            Some(Read::Other) => {
                self.others += 1;
                Block::Other
            }
            Some(Read::Damaged) => {
                self.others += 1;
                self.damaged += 1;
                Block::Other
            }
        })
    }
}

impl Iterator for Capture {
    type Item = Result<Datagram, FileError>;

    /// The next datagram. Behind an error, nothing follows.
    fn next(&mut self) -> Option<Self::Item> {
        while !self.is_over {
            match self.next_block() {
                Ok(Block::Datagram(datagram)) => return Some(Ok(datagram)),
                Ok(Block::Other) => {}
                Ok(Block::End) => self.is_over = true,
                Err(error) => {
                    self.is_over = true;
                    return Some(Err(FileError::parse(&self.path, error)));
                }
            }
        }
        None
    }
}

fn fault<I: core::fmt::Debug>(offset: usize, error: &PcapError<I>) -> ParseError {
    match error {
        PcapError::UnexpectedEof => ParseError::new(Fault::Truncated, offset, "the end of the file", "a whole block"),
        PcapError::BufferTooSmall => {
            let expected = format!("at most {BUFFER_LEN} bytes");
            ParseError::new(Fault::Length, offset, "a longer block", expected)
        }
        PcapError::ReadError => ParseError::new(Fault::Truncated, offset, "a file that cannot be read", "a block"),
        _ => ParseError::new(Fault::Value, offset, "bytes that are no block", "a block of a capture"),
    }
}

/// What a block holds; `None` where that is no frame.
fn datagram_of(
    block: &PcapBlockOwned<'_>,
    links: &mut Vec<Linktype>,
    pieces: &mut IpDefragPool<u64>,
    frames: &mut u64,
) -> Option<Read> {
    use pcap_parser::Block as Ng;
    let (link, frame) = match block {
        PcapBlockOwned::LegacyHeader(header) => {
            *links = [header.network].into();
            return None;
        }
        PcapBlockOwned::NG(Ng::SectionHeader(_)) => {
            links.clear();
            return None;
        }
        PcapBlockOwned::NG(Ng::InterfaceDescription(interface)) => {
            links.push(interface.linktype);
            return None;
        }
        PcapBlockOwned::Legacy(frame) => (links.first(), frame.data),
        PcapBlockOwned::NG(Ng::EnhancedPacket(frame)) => {
            let len = frame.data.len().min(frame.caplen as usize);
            (links.get(frame.if_id as usize), &frame.data[..len])
        }
        PcapBlockOwned::NG(Ng::SimplePacket(frame)) => (links.first(), frame.data),
        PcapBlockOwned::NG(_) => return None,
    };
    *frames += 1;
    let now = *frames;
    let found = match sliced(link.copied(), frame) {
        Some(Ok(sliced)) => read(&sliced, now, pieces),
        Some(Err(Damaged)) => Read::Damaged,
        None => Read::Other,
    };
    pieces.retain(|&then| now - then < PATIENCE);
    Some(found)
}

/// A frame whose headers say more than there is, or nothing that makes sense.
struct Damaged;

/// The headers of a frame, by what the network was; `None` of a network that is not known.
fn sliced(link: Option<Linktype>, frame: &[u8]) -> Option<Result<SlicedPacket<'_>, Damaged>> {
    let sliced = match link? {
        Linktype::ETHERNET => SlicedPacket::from_ethernet(frame).ok(),
        Linktype::LINUX_SLL => SlicedPacket::from_linux_sll(frame).ok(),
        Linktype::RAW | Linktype::IPV4 | Linktype::IPV6 => SlicedPacket::from_ip(frame).ok(),
        // Loopback: the family before the packet.
        Linktype::NULL | Linktype::LOOP => frame.get(4..).and_then(|packet| SlicedPacket::from_ip(packet).ok()),
        Linktype(276) => cooked(frame),
        _ => return None,
    };
    Some(sliced.ok_or(Damaged))
}

/// Version 2 of Linux' "cooked": the protocol is the first of 20 bytes.
fn cooked(frame: &[u8]) -> Option<SlicedPacket<'_>> {
    let (head, packet) = frame.split_first_chunk::<20>()?;
    SlicedPacket::from_ether_type(EtherType(u16::from_be_bytes([head[0], head[1]])), packet).ok()
}

/// What a frame holds.
enum Read {
    Datagram(Datagram),
    /// Of a datagram that is not complete.
    Piece,
    Other,
    Damaged,
}

fn read(sliced: &SlicedPacket<'_>, now: u64, pieces: &mut IpDefragPool<u64>) -> Read {
    let Some(source) = source(sliced) else { return Read::Other };
    if sliced.is_ip_payload_fragmented() {
        return match pieces.process_sliced_packet(sliced, now, ()) {
            Ok(Some(whole)) => {
                let datagram = (whole.ip_number == IpNumber::UDP).then(|| UdpSlice::from_slice(&whole.payload).ok());
                let found = datagram.flatten().map_or(Read::Other, |udp| Read::Datagram(to_owned(source, &udp)));
                pieces.return_buf(whole);
                found
            }
            Ok(None) => Read::Piece,
            Err(_) => Read::Other,
        };
    }
    match &sliced.transport {
        Some(TransportSlice::Udp(udp)) => Read::Datagram(to_owned(source, udp)),
        _ => Read::Other,
    }
}

fn source(sliced: &SlicedPacket<'_>) -> Option<IpAddr> {
    match sliced.net.as_ref()? {
        NetSlice::Ipv4(packet) => Some(packet.header().source_addr().into()),
        NetSlice::Ipv6(packet) => Some(packet.header().source_addr().into()),
        NetSlice::Arp(_) => None,
    }
}

fn to_owned(source: IpAddr, udp: &UdpSlice<'_>) -> Datagram {
    Datagram { source, port: udp.destination_port(), payload: udp.payload().to_vec() }
}
