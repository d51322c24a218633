//! The frames that both sides encode, and the host's side of it.

use std::fmt;

use flicr::{
    Coder, Config, DeflateDefault, DeflateDense, DeflateSmall, FrameEncoder, ImageViewMut, Rle, Scale, Stamp, Store,
    frame,
};

const ROWS: usize = 64;

/// What a frame is to be like: an argument of the firmware.
pub struct Frame {
    pub columns: usize,
    pub coder: &'static str,
    pub max_range_m: f32,
}

/// The paper's sizes with both of its coders, and each other coder at the largest and the smallest.
pub const FRAMES: [Frame; 19] = [
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
            "store" => self.encode_with(Store::new(), points),
            "rle" => self.encode_with(Rle::new(), points),
            "deflate" => self.encode_with(DeflateDefault::new(), points),
            "deflate-small" => self.encode_with(DeflateSmall::new(), points),
            "deflate-dense" => self.encode_with(DeflateDense::new(), points),
            other => unreachable!("no coder {other}"),
        }
    }

    fn encode_with<C: Coder<u8>>(&self, mut coder: C, points: &[[f32; 4]]) -> Vec<u8> {
        let mut levels = vec![0; ROWS * self.columns];
        let mut out = vec![0; frame::worst_case_len::<u8, C>(levels.len())];
        let image = ImageViewMut::new(&mut levels, self.columns).expect("whole rows");
        let config = Config { scale: Scale::Fixed { max_range_m: self.max_range_m }, ..Config::UNIFORM };
        let mut filling = FrameEncoder::start(&config, Stamp::default(), image, &mut coder).expect("a valid frame");
        filling.insert(points);
        let encoded = filling.finish(&mut out).expect("the worst case fits");
        out.truncate(encoded.len);
        out
    }
}
