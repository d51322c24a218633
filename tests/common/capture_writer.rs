//! Writes captures: Ethernet, IPv4 and UDP by their byte tables, in pcap and pcapng.
#![allow(dead_code, reason = "each test uses a part")]

/// Most bytes of an IP packet's payload on an Ethernet, a multiple of 8.
const PIECE_LEN: usize = 1480;

/// An Ethernet frame with a datagram to `port`; several where it is too long for one.
pub fn frames(port: u16, payload: &[u8], id: u16) -> Vec<Vec<u8>> {
    frames_from(201, port, payload, id)
}

/// The same from 192.168.1.`host`.
pub fn frames_from(host: u8, port: u16, payload: &[u8], id: u16) -> Vec<Vec<u8>> {
    let mut udp = Vec::new();
    udp.extend(40_000_u16.to_be_bytes());
    udp.extend(port.to_be_bytes());
    udp.extend((8 + payload.len() as u16).to_be_bytes());
    udp.extend([0, 0]);
    udp.extend(payload);
    let pieces: Vec<&[u8]> = udp.chunks(PIECE_LEN).collect();
    let last = pieces.len() - 1;
    let frame = |(nth, piece): (usize, &&[u8])| frame(host, id, nth * PIECE_LEN / 8, nth < last, piece);
    pieces.iter().enumerate().map(frame).collect()
}

fn frame(host: u8, id: u16, offset: usize, more: bool, payload: &[u8]) -> Vec<u8> {
    let mut frame = vec![0xff; 6];
    frame.extend([2, 0, 0, 0, 0, 1, 0x08, 0x00]);
    frame.extend([0x45, 0]);
    frame.extend((20 + payload.len() as u16).to_be_bytes());
    frame.extend(id.to_be_bytes());
    frame.extend((offset as u16 | if more { 0x2000 } else { 0 }).to_be_bytes());
    frame.extend([64, 17, 0, 0]);
    frame.extend([192, 168, 1, host, 255, 255, 255, 255]);
    frame.extend(payload);
    frame
}

/// All of `datagrams`, with their ports, as Ethernet frames.
pub fn all_frames<'a>(datagrams: impl IntoIterator<Item = (u16, &'a [u8])>) -> Vec<Vec<u8>> {
    (0..).zip(datagrams).flat_map(|(id, (port, payload))| frames(port, payload, id)).collect()
}

/// A pcap file, microseconds, little-endian.
pub fn pcap(frames: &[Vec<u8>]) -> Vec<u8> {
    let mut file = Vec::new();
    file.extend(0xa1b2_c3d4_u32.to_le_bytes());
    file.extend([2, 0, 4, 0]);
    file.extend([0; 8]);
    file.extend(262_144_u32.to_le_bytes());
    file.extend(1_u32.to_le_bytes());
    for (nth, frame) in (0_u32..).zip(frames) {
        for word in [nth / 1000, nth % 1000 * 1000, frame.len() as u32, frame.len() as u32] {
            file.extend(word.to_le_bytes());
        }
        file.extend(frame);
    }
    file
}

/// A pcapng file of one section and one interface.
pub fn pcapng(frames: &[Vec<u8>]) -> Vec<u8> {
    let mut file = block(0x0a0d_0d0a, &[&0x1a2b_3c4d_u32.to_le_bytes()[..], &[1, 0, 0, 0], &[0xff; 8]].concat());
    file.extend(block(1, &[&[1, 0, 0, 0][..], &262_144_u32.to_le_bytes()].concat()));
    for (nth, frame) in (0_u32..).zip(frames) {
        let len = (frame.len() as u32).to_le_bytes();
        let mut body = [[0; 4], [0; 4], nth.to_le_bytes(), len, len].concat();
        body.extend(frame);
        body.resize(body.len().next_multiple_of(4), 0);
        file.extend(block(6, &body));
    }
    file
}

fn block(kind: u32, body: &[u8]) -> Vec<u8> {
    let len = (12 + body.len() as u32).to_le_bytes();
    [&kind.to_le_bytes()[..], &len, body, &len].concat()
}
