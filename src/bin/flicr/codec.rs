//! The library's encoder and decoder, with level type and coder chosen at run time.

use flicr::coder::{Coder, ContextSettings, WorstCase};
use flicr::{
    Config, DeflateDefault, Dense, EncodeError, Encoded, ImageViewMut, Level, Levels, Limits, Quantizer, Rle, Scale,
    Small, Stamp, Store, UniformGrid, encode,
};

use crate::args::{CoderName, FrameArgs, Tier};
use crate::failure::Failure;

/// Encodes scans as the command line asks, with memory for one frame.
pub struct Codec {
    config: Config,
    columns: usize,
    levels: Levels,
    coder: AnyCoder,
    out: Vec<u8>,
    len: usize,
}

enum AnyCoder {
    Rle(Rle),
    Deflate(Box<DeflateDefault>),
    Small(Box<Small<GROUPS>>),
    Dense(Box<Dense<GROUPS>>),
    Store(Store),
}

/// Room for 1024 rows, as many as context coders can have.
const GROUPS: usize = 128;

impl Codec {
    /// Memory for frames of `columns` columns.
    pub fn new(args: &FrameArgs, columns: u16) -> Result<Self, Failure> {
        let config = args.config();
        check(&config, args.rows, columns).map_err(|error| Failure::Usage(error.to_string()))?;
        let pixels = usize::from(args.rows) * usize::from(columns);
        check_pixels(pixels)?;
        let coder = AnyCoder::new(args.coder, args.tier, args.context()?);
        let (levels, worst_case) = if config.level_bits <= u8::BITS {
            (Levels::U8(vec![0; pixels]), coder.worst_case::<u8>())
        } else {
            (Levels::U16(vec![0; pixels]), coder.worst_case::<u16>())
        };
        let out = vec![0; flicr::frame::OVERHEAD_LEN + worst_case.len(pixels)];
        Ok(Self { config, columns: columns.into(), levels, coder, out, len: 0 })
    }

    /// Encodes a scan; [`frame`](Self::frame) has the bytes.
    pub fn encode(&mut self, points: &[[f32; 3]], stamp: Stamp) -> Result<Encoded, EncodeError> {
        self.len = 0;
        let (config, columns, out) = (&self.config, self.columns, self.out.as_mut_slice());
        let encoded = match &mut self.levels {
            Levels::U8(levels) => self.coder.encode(config, points, stamp, (levels, columns), out),
            Levels::U16(levels) => self.coder.encode(config, points, stamp, (levels, columns), out),
        }?;
        self.len = encoded.len;
        Ok(encoded)
    }

    /// Columns of its frames.
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// The bytes of the last frame.
    pub fn frame(&self) -> &[u8] {
        &self.out[..self.len]
    }
}

/// What would make every frame fail, found before any scan is read.
fn check(config: &Config, rows: u16, columns: u16) -> Result<(), EncodeError> {
    UniformGrid::new(rows.into(), columns.into(), config.view)?;
    if let Scale::Fixed { max_range_m } = config.scale {
        Quantizer::new(config.level_bits, max_range_m)?;
    }
    Ok(())
}

/// A decoder with default limits must be able to read what is written here.
fn check_pixels(pixels: usize) -> Result<(), Failure> {
    let most = Limits::default().pixels;
    if pixels > most {
        return Err(Failure::Usage(format!("rows times columns are {pixels} pixels: expected at most {most}")));
    }
    Ok(())
}

impl AnyCoder {
    fn new(name: CoderName, tier: Tier, settings: ContextSettings) -> Self {
        match name {
            CoderName::Context => match tier {
                Tier::Small => Self::Small(Box::new(Small::<GROUPS>::new(settings))),
                Tier::Dense => Self::Dense(Box::new(Dense::<GROUPS>::new(settings))),
            },
            CoderName::Rle => Self::Rle(Rle::new()),
            CoderName::Deflate => Self::Deflate(Box::new(DeflateDefault::new())),
            CoderName::Store => Self::Store(Store::new()),
        }
    }

    fn worst_case<L: Level>(&self) -> WorstCase
    where
        DeflateDefault: Coder<L>,
    {
        match self {
            Self::Rle(_) => <Rle as Coder<L>>::WORST_CASE,
            Self::Deflate(_) => <DeflateDefault as Coder<L>>::WORST_CASE,
            Self::Small(_) => <Small<GROUPS> as Coder<L>>::WORST_CASE,
            Self::Dense(_) => <Dense<GROUPS> as Coder<L>>::WORST_CASE,
            Self::Store(_) => <Store as Coder<L>>::WORST_CASE,
        }
    }

    fn encode<L: Level>(
        &mut self,
        config: &Config,
        points: &[[f32; 3]],
        stamp: Stamp,
        (levels, columns): (&mut [L], usize),
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError>
    where
        DeflateDefault: Coder<L>,
    {
        let size = flicr::ConfigError::Size { rows: 0, columns };
        let image = ImageViewMut::new(levels, columns).ok_or(size)?;
        match self {
            Self::Rle(coder) => encode(config, points, stamp, image, coder, out),
            Self::Deflate(coder) => encode(config, points, stamp, image, coder.as_mut(), out),
            Self::Small(coder) => encode(config, points, stamp, image, coder.as_mut(), out),
            Self::Dense(coder) => encode(config, points, stamp, image, coder.as_mut(), out),
            Self::Store(coder) => encode(config, points, stamp, image, coder, out),
        }
    }
}
