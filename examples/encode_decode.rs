//! A scan to a frame and back: `cargo run --features std --example encode_decode`.

use flicr::{Config, Decoder, Encoder, Limits, Rle, Stamp, simulate::Simulator};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scan = Simulator::hdl64e(1).turn(0).points; // or your sensor's: [f32; 3] or [f32; 4], meters
    let mut encoder = Box::new(Encoder::<64, 1024, u8, Rle>::new(Rle::new())); // a `static` on a microcontroller
    let mut frame = vec![0; Encoder::<64, 1024, u8, Rle>::WORST_CASE_LEN];
    let sent = encoder.encode(&Config::UNIFORM, scan.as_slice(), Stamp::default(), &mut frame)?;

    let mut decoder = Decoder::new(Limits::default());
    let points = decoder.decode(&frame[..sent.len])?.points();
    println!("{} points, {} bytes, {} points", scan.len(), sent.len, points.len());
    Ok(())
}
