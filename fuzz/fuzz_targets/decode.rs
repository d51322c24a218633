//! Any bytes as a frame: an error or an image within the limits, no panic.
//!
//! Length and checksum are made to fit first where the last byte is odd, so that the fuzzer gets past them.
#![no_main]

use flicr::{Decoder, Limits};
use libfuzzer_sys::fuzz_target;

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
const LIMITS: Limits = Limits { frame_len: 1 << 16, pixels: 1 << 18 };

fn seal(frame: &mut [u8]) {
    let frame_len = frame.len() as u32;
    let Some(body_len) = frame.len().checked_sub(4).filter(|&len| len >= 12) else {
        return;
    };
    frame[8..12].copy_from_slice(&frame_len.to_le_bytes());
    let checksum = CRC.checksum(&frame[..body_len]);
    frame[body_len..].copy_from_slice(&checksum.to_le_bytes());
}

fuzz_target!(|data: &[u8]| {
    let mut frame = data.to_vec();
    if data.last().is_some_and(|last| last & 1 == 1) {
        seal(&mut frame);
    }
    if let Ok(header) = flicr::frame::parse_header(&frame) {
        assert!(header.rows > 0 && header.columns > 0);
    }
    if let Ok(decoded) = Decoder::new(LIMITS).decode(&frame) {
        let pixels = decoded.header().pixels();
        let points = decoded.points().len();
        assert!(pixels <= LIMITS.pixels && points <= pixels);
        assert!(decoded.intensities().is_none_or(|intensities| intensities.len() == points));
        assert!(decoded.times_ns().is_none_or(|times_ns| times_ns.len() == points));
        if let Ok(Some(original)) = decoded.original() {
            // Every record is a return's, or stands in the frame as it is.
            assert!(original.len() <= 16 * points + frame.len());
        }
    }
});
