//! The frames that both sides encode, and the host's side of it.

use std::fmt;

use flicr::geometry::{Lattice, sensors::hdl64e};
use flicr::{
    Coder, Config, DeflateDefault, DeflateDense, DeflateSmall, FrameEncoder, ImageViewMut, LatticeConfig, Rle, Scale,
    Settings, Stamp, Store, frame,
};

const ROWS: usize = 64;

/// What a frame is to be like: an argument of the firmware.
pub struct Frame {
    pub columns: usize,
    pub coder: &'static str,
    pub max_range_m: f32,
}

/// The paper's sizes with both of its coders, each other coder at the largest and the smallest, one on the sensor's own grid.
pub const FRAMES: [Frame; 20] = [
    frame(4500, "rle"),
    frame(4096, "rle"),
    frame(2048, "rle"),
    frame(1024, "rle"),
    frame(512, "rle"),
    frame(256, "rle"),
    frame(4500, "deflate"),
    frame(4096, "deflate"),
    frame(2048, "deflate"),
    frame(1024, "deflate"),
    frame(512, "deflate"),
    frame(256, "deflate"),
    frame(4500, "deflate-small"),
    frame(256, "deflate-small"),
    frame(4500, "deflate-dense"),
    frame(256, "deflate-dense"),
    frame(4500, "store"),
    frame(256, "store"),
    // On the sensor's own grid.
    frame(4000, "lattice"),
    // The firmware uses its memory again: nothing of the frames before may be left in it.
    Frame { columns: 1000, coder: "deflate", max_range_m: 50.0 },
];

const fn frame(columns: usize, coder: &'static str) -> Frame {
    Frame { columns, coder, max_range_m: 120.0 }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.columns, self.coder, self.max_range_m)
    }
}

impl Frame {
    /// The host's bytes.
    pub fn encode(&self, points: &[[f32; 4]]) -> Vec<u8> {
        match self.coder {
            "store" => self.encode_with(Store::new(), &self.uniform(), points),
            "rle" => self.encode_with(Rle::new(), &self.uniform(), points),
            "deflate" => self.encode_with(DeflateDefault::new(), &self.uniform(), points),
            "deflate-small" => self.encode_with(DeflateSmall::new(), &self.uniform(), points),
            "deflate-dense" => self.encode_with(DeflateDense::new(), &self.uniform(), points),
            "lattice" => {
                let lattice = Lattice::<66>::new(hdl64e::GRID, self.columns).expect("a valid grid");
                let scale = self.uniform().scale;
                let config = LatticeConfig { scale, level_bits: u8::BITS, ..LatticeConfig::new(&lattice) };
                self.encode_with(Rle::new(), &config, points)
            }
            other => unreachable!("no coder {other}"),
        }
    }

    fn uniform(&self) -> Config {
        Config { scale: Scale::Fixed { max_range_m: self.max_range_m }, ..Config::UNIFORM }
    }

    fn encode_with<C: Coder<u8>>(&self, mut coder: C, config: &impl Settings, points: &[[f32; 4]]) -> Vec<u8> {
        let mut levels = vec![0; ROWS * self.columns];
        let mut out = vec![0; frame::worst_case_len::<u8, C>(levels.len())];
        let image = ImageViewMut::new(&mut levels, self.columns).expect("whole rows");
        let mut filling = FrameEncoder::start(config, Stamp::default(), image, &mut coder).expect("a valid frame");
        filling.insert(points);
        let encoded = filling.finish(&mut out).expect("the worst case fits");
        out.truncate(encoded.len);
        out
    }
}
