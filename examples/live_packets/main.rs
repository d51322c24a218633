//! A sensor's packets as a byte stream, for the streaming firmware: of the simulated sensor, or of a capture.
//!
//! ```sh
//! cargo run --release --features std --example live_packets -- vlp16|hdl64e|CAPTURE.pcap [TURNS|COUNT] > PACKETS
//! ```
//!
//! Of the simulated sensors so many turns (10; 0 for no end), of a capture so many packets (all).

#[cfg(not(target_os = "none"))]
#[path = "../../tests/common/simulated_packets.rs"]
mod simulated_packets;

#[cfg(not(target_os = "none"))]
mod capture {
    use std::fs::File;

    use etherparse::{SlicedPacket, TransportSlice};
    use pcap_parser::traits::PcapReaderIterator;
    use pcap_parser::{LegacyPcapReader, PcapBlockOwned, PcapError};

    /// Payloads of a capture's UDP packets of this length; those of others are not the sensor's returns.
    pub fn payloads(path: &str, len: usize) -> Result<Vec<Vec<u8>>, String> {
        let file = File::open(path).map_err(|error| format!("{path}: {error}"))?;
        let mut reader = LegacyPcapReader::new(1 << 16, file).map_err(|error| format!("{path}: {error}"))?;
        let mut payloads = Vec::new();
        loop {
            match reader.next() {
                Ok((used, block)) => {
                    if let PcapBlockOwned::Legacy(frame) = block {
                        payloads.extend(udp(frame.data).filter(|payload| payload.len() == len));
                    }
                    reader.consume(used);
                }
                Err(PcapError::Incomplete(_)) => reader.refill().map_err(|error| format!("{path}: {error}"))?,
                Err(PcapError::Eof) => return Ok(payloads),
                Err(error) => return Err(format!("{path}: {error}")),
            }
        }
    }

    fn udp(frame: &[u8]) -> Option<Vec<u8>> {
        match SlicedPacket::from_ethernet(frame).ok()?.transport? {
            TransportSlice::Udp(udp) => Some(udp.payload().to_vec()),
            _ => None,
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() -> Result<(), String> {
    use std::io::Write;

    let mut arguments = std::env::args().skip(1);
    let source = arguments.next().ok_or("arguments: vlp16|hdl64e|CAPTURE.pcap [TURNS|COUNT]")?;
    let count = arguments.next().map(|count| count.parse::<usize>()).transpose().map_err(|error| error.to_string())?;
    // Packets that hold a turn, and a few more so that its end is in them.
    let of_turns = |a_turn: usize| match count.unwrap_or(10) {
        0 => usize::MAX,
        turns => turns * a_turn,
    };
    let packets: Box<dyn Iterator<Item = Vec<u8>>> = match source.as_str() {
        "vlp16" => Box::new(simulated_packets::vlp16(1).take(of_turns(76))),
        "hdl64e" => Box::new(simulated_packets::hdl64e(1).take(of_turns(359))),
        path => Box::new(capture::payloads(path, 1206)?.into_iter().take(count.unwrap_or(usize::MAX))),
    };
    let mut out = std::io::stdout().lock();
    for packet in packets.chain([Vec::new()]) {
        let mut framed = Vec::new();
        flicr::stream::write_framed(&mut framed, &packet).map_err(|never| never.to_string())?;
        match out.write_all(&framed) {
            Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => return Ok(()),
            written => written.map_err(|error| error.to_string())?,
        }
    }
    out.flush().map_err(|error| error.to_string())
}

#[cfg(target_os = "none")]
fn main() {}
