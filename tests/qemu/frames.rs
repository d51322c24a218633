//! The frames that both sides encode, and the host's side of it.

use std::fmt;

use flicr::coder::{ContextSettings, Fast, Step};
use flicr::geometry::{Firings, Lattice, sensors::hdl64e};
use flicr::{
    Coder, Config, DeflateDefault, DeflateDense, DeflateSmall, Dense, FiringsConfig, FrameEncoder, ImageViewMut,
    LatticeConfig, Level, Rle, Scale, Settings, Small, Stamp, Store, frame,
};

const ROWS: usize = 64;
const TICKS: usize = hdl64e::TICKS as usize;

/// What a frame is to be like: an argument of the firmware.
#[derive(Clone, Copy)]
pub enum Frame {
    /// 8 bits, columns spread evenly.
    Even(Even),
    /// A context coder on the sensor's firings, in steps of some range counts.
    Native { coder: &'static str, step: u16 },
}

#[derive(Clone, Copy)]
pub struct Even {
    pub columns: usize,
    pub coder: &'static str,
    pub max_range_m: f32,
}

/// The paper's sizes with both of its coders, each other coder at the largest and the smallest, one on the sensor's own
/// grid; the context coders on its firings at 2, 20, 102 and 314 mm.
pub const FRAMES: [Frame; 38] = [
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
    frame(4500, "small"),
    frame(256, "small"),
    frame(4500, "dense"),
    frame(256, "dense"),
    frame(4500, "fast"),
    frame(256, "fast"),
    native("small", 1),
    native("small", 10),
    native("small", 51),
    native("small", 157),
    native("dense", 1),
    native("dense", 10),
    native("dense", 51),
    native("dense", 157),
    native("fast", 1),
    native("fast", 10),
    native("fast", 51),
    native("fast", 157),
    EVERY_TICK[0],
    // The firmware uses its memory again: nothing of the frames before may be left in it.
    Frame::Even(Even { columns: 1000, coder: "deflate", max_range_m: 50.0 }),
];

/// On the sensor's own grid.
pub const EVERY_TICK: [Frame; 1] = [frame(TICKS, "lattice")];

const fn frame(columns: usize, coder: &'static str) -> Frame {
    Frame::Even(Even { columns, coder, max_range_m: 120.0 })
}

const fn native(coder: &'static str, step: u16) -> Frame {
    Frame::Native { coder, step }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Even(Even { columns, coder, max_range_m }) => write!(f, "{columns}:{coder}:{max_range_m}"),
            Self::Native { coder, step } => write!(f, "native:{coder}:{step}"),
        }
    }
}

impl Frame {
    /// What the firmware appends to the name of the frame's file.
    pub fn file_name(&self) -> String {
        match self {
            Self::Even(Even { columns, coder, .. }) => format!("{columns}-{coder}.flicr"),
            Self::Native { coder, step } => format!("native-{coder}-{step}.flicr"),
        }
    }

    /// The host's bytes.
    pub fn encode(&self, points: &[[f32; 4]]) -> Vec<u8> {
        match self {
            Self::Even(even) => even.encode(points),
            Self::Native { coder, step } => encode_native(coder, *step, points),
        }
    }
}

impl Even {
    fn encode(&self, points: &[[f32; 4]]) -> Vec<u8> {
        let (config, columns, coarse) = (self.uniform(), self.columns, ContextSettings::COARSE);
        match self.coder {
            "store" => encode_with::<u8, _>(Store::new(), &config, columns, points),
            "rle" => encode_with::<u8, _>(Rle::new(), &config, columns, points),
            "deflate" => encode_with::<u8, _>(DeflateDefault::new(), &config, columns, points),
            "deflate-small" => encode_with::<u8, _>(DeflateSmall::new(), &config, columns, points),
            "deflate-dense" => encode_with::<u8, _>(DeflateDense::new(), &config, columns, points),
            "lattice" => {
                let lattice = Lattice::<66>::new(hdl64e::GRID, columns).expect("a valid grid");
                let scale = self.uniform().scale;
                let config = LatticeConfig { scale, level_bits: u8::BITS, ..LatticeConfig::new(&lattice) };
                encode_with::<u8, _>(Rle::new(), &config, columns, points)
            }
            coder => encode_context::<u8>(coder, coarse, &config, columns, points),
        }
    }

    fn uniform(&self) -> Config {
        Config { scale: Scale::Fixed { max_range_m: self.max_range_m }, ..Config::UNIFORM }
    }
}

fn encode_native(coder: &str, step: u16, points: &[[f32; 4]]) -> Vec<u8> {
    let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, TICKS).expect("a valid grid");
    let every_tick = LatticeConfig::new(&lattice);
    let firings = firings(&every_tick, points);
    let config = FiringsConfig { every_tick, firings: &firings };
    let settings = ContextSettings::FINE.with_step(Step::new(step).expect("no step is 0"));
    encode_context::<u16>(coder, settings, &config, firings.len().into(), points)
}

/// The ticks at which any beam has a return.
fn firings(every_tick: &LatticeConfig<'_, 66>, points: &[[f32; 4]]) -> Firings<125> {
    let mut levels = vec![0_u16; ROWS * TICKS];
    let image = ImageViewMut::new(&mut levels, TICKS).expect("whole rows");
    let mut store = Store::new();
    FrameEncoder::start(every_tick, Stamp::default(), image, &mut store).expect("a valid frame").insert(points);
    let is_fired = |tick: &u32| levels.chunks_exact(TICKS).any(|row| row[*tick as usize] > 0);
    Firings::new(hdl64e::TICKS, (0..hdl64e::TICKS).filter(is_fired)).expect("some returns")
}

fn encode_context<L: Level>(
    coder: &str,
    settings: ContextSettings,
    config: &impl Settings,
    columns: usize,
    points: &[[f32; 4]],
) -> Vec<u8> {
    match coder {
        "small" => encode_with::<L, Small>(Small::new(settings), config, columns, points),
        "dense" => encode_with::<L, Dense>(Dense::new(settings), config, columns, points),
        "fast" => encode_with::<L, Fast>(Fast::new(settings), config, columns, points),
        other => unreachable!("no coder {other}"),
    }
}

fn encode_with<L: Level, C: Coder<L>>(
    mut coder: C,
    config: &impl Settings,
    columns: usize,
    points: &[[f32; 4]],
) -> Vec<u8> {
    let mut levels = vec![L::NONE; ROWS * columns];
    let header_len_max = 72 + TICKS.div_ceil(8);
    let mut out = vec![0; frame::worst_case_len::<L, C>(levels.len()) + header_len_max];
    let image = ImageViewMut::new(&mut levels, columns).expect("whole rows");
    let mut filling = FrameEncoder::start(config, Stamp::default(), image, &mut coder).expect("a valid frame");
    filling.insert(points);
    let encoded = filling.finish(&mut out).expect("the worst case fits");
    out.truncate(encoded.len);
    out
}
