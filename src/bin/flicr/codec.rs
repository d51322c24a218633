//! The library's encoder and decoder, with geometry, level type and coder chosen at run time.

use flicr::coder::{Coder, ContextSettings, Fast, WorstCase};
use flicr::geometry::{Lattice, SensorGrid};
use flicr::{
    Config, DeflateDefault, Dense, EncodeError, Encoded, FiringsConfig, FrameEncoder, ImageViewMut, LatticeConfig,
    Level, Levels, Limits, Quantizer, Rle, Scale, Small, Stamp, Store, UniformGrid, encode,
};

use crate::args::{CoderName, Columns, FrameArgs, Step, Tier};
use crate::failure::Failure;
use crate::input::Scan;
use crate::plan::{COLUMNS, Plan, Shape, plan};
use crate::sensors::Asked;

/// Lines for sensors of up to 256 beams.
const LINES: usize = 258;

/// Encodes scans as the command line asks, with memory for one frame.
pub struct Codec {
    args: FrameArgs,
    /// Of the uniform geometry.
    config: Config,
    columns: Option<Columns>,
    asked: Option<Asked>,
    plan: Plan,
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
    Fast(Box<Fast<BANDS>>),
    Store(Store),
}

/// Room for 1024 rows, as many as context coders can have.
const GROUPS: usize = 128;
/// As many rows, for the fast tier.
const BANDS: usize = 16;

impl Codec {
    /// Checks what is asked for, as far as that can be done before there is a scan.
    pub fn new(args: &FrameArgs, columns: Option<Columns>) -> Result<Self, Failure> {
        let config = args.config();
        let asked = args.asked()?;
        let uniform_columns = match columns {
            Some(Columns::Count(columns)) => columns,
            Some(Columns::Native) if args.preset.is_some() => {
                let wrong = "native columns are a sensor's: expected a number with --preset";
                return Err(Failure::Usage(wrong.to_owned()));
            }
            _ => COLUMNS,
        };
        check(&config, args.rows, uniform_columns).map_err(|error| Failure::Usage(error.to_string()))?;
        let pixels = usize::from(args.rows) * usize::from(uniform_columns);
        check_pixels(pixels).map_err(Failure::Usage)?;
        let levels = if config.level_bits <= u8::BITS { Levels::U8(Vec::new()) } else { Levels::U16(Vec::new()) };
        let plan = Plan { shape: Shape::Uniform { columns: uniform_columns }, why: String::new() };
        let coder = AnyCoder::new(args.coder, args.tier, args.context(None).map_err(Failure::Usage)?);
        Ok(Self { args: args.clone(), config, columns, asked, plan, levels, coder, out: Vec::new(), len: 0 })
    }

    /// Chooses the geometry of a scan and takes the memory that its frame needs.
    pub fn prepare(&mut self, scan: &Scan) -> Result<&Plan, String> {
        if self.args.preset.is_none() {
            self.plan = plan(scan, self.asked.as_ref(), self.columns).map_err(|error| error.to_string())?;
        }
        if self.args.step == Some(Step::Native) && self.plan.shape.sensor().is_none() {
            let why = if self.plan.why.is_empty() { "--preset" } else { &self.plan.why };
            return Err(format!("no sensor's grid, so no native step: expected meters ({why})"));
        }
        let rows = self.plan.shape.sensor().map_or(self.args.rows.into(), |sensor| sensor.grid().beams.len());
        let pixels = rows * self.plan.shape.columns();
        check_pixels(pixels)?;
        let level_m = self.plan.shape.sensor().map(|sensor| sensor.grid().range_unit_m);
        self.coder = AnyCoder::new(self.args.coder, self.args.tier, self.args.context(level_m)?);
        let worst_case = match &mut self.levels {
            Levels::U8(levels) => {
                levels.resize(pixels, 0);
                self.coder.worst_case::<u8>()
            }
            Levels::U16(levels) => {
                levels.resize(pixels, 0);
                self.coder.worst_case::<u16>()
            }
        };
        self.out.resize(flicr::frame::OVERHEAD_LEN + self.more_header_len(rows) + worst_case.len(pixels), 0);
        Ok(&self.plan)
    }

    /// Bytes by which a header can be longer than that of a uniform geometry.
    fn more_header_len(&self, rows: usize) -> usize {
        use flicr::frame::{BeamsHeader, HEADER_LEN};
        let beams_len = BeamsHeader::HEADER_LEN - HEADER_LEN + BeamsHeader::BEAM_LEN * rows;
        match &self.plan.shape {
            Shape::Uniform { .. } => 0,
            Shape::Beams { .. } => beams_len,
            Shape::Firings { firings, .. } => beams_len + firings.ticks().div_ceil(8) as usize,
        }
    }

    /// Encodes the scan that was [prepared](Self::prepare) for; [`frame`](Self::frame) has the bytes.
    pub fn encode(&mut self, scan: &Scan, stamp: Stamp) -> Result<Encoded, EncodeError> {
        self.len = 0;
        let scale = self.scale(scan);
        let job = Job { config: &self.config, shape: &self.plan.shape, scale, scan, stamp };
        let (columns, out) = (self.plan.shape.columns(), self.out.as_mut_slice());
        let encoded = match &mut self.levels {
            Levels::U8(levels) => self.coder.encode(&job, (levels, columns), out),
            Levels::U16(levels) => self.coder.encode(&job, (levels, columns), out),
        }?;
        self.len = encoded.len;
        Ok(encoded)
    }

    /// Of a sensor's grid, where it is known before the first point comes.
    fn scale(&self, scan: &Scan) -> Scale {
        let Some(sensor) = self.plan.shape.sensor() else { return self.config.scale };
        let grid = sensor.grid();
        match (self.args.step, self.args.max_range) {
            (Some(Step::Native), _) => Scale::Step { step_m: grid.range_unit_m },
            // The coder steps between the sensor's own levels.
            (Some(Step::Meters(_)), _) if self.args.coder == CoderName::Context => {
                Scale::Step { step_m: grid.range_unit_m }
            }
            (Some(Step::Meters(step_m)), _) => Scale::Step { step_m },
            (None, Some(max_range_m)) => Scale::Fixed { max_range_m },
            (None, None) => Scale::Fixed { max_range_m: farthest_m(scan, &grid) },
        }
    }

    /// What the last prepared scan's geometry is.
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Columns of its frames, in words of the command line.
    pub fn columns_asked(&self) -> String {
        match self.columns {
            Some(Columns::Count(columns)) => columns.to_string(),
            Some(Columns::Native) | None => "native".to_owned(),
        }
    }

    /// The bytes of the last frame.
    pub fn frame(&self) -> &[u8] {
        &self.out[..self.len]
    }
}

/// The largest range along any beam; 1 m where there is none, as of uniform frames.
fn farthest_m(scan: &Scan, grid: &SensorGrid<'_>) -> f32 {
    if let Some(turn) = &scan.turn {
        let farthest = turn.returns.iter().map(|found| found.count).max().unwrap_or(0);
        return (farthest as f32 * grid.range_unit_m).max(grid.range_unit_m);
    }
    let range_m = |[x, y, z]: &[f32; 3]| (x * x + y * y + z * z).sqrt();
    let ranges = scan.cloud.points.iter().map(range_m).filter(|range_m| range_m.is_finite());
    let farthest_m = ranges.fold(0.0, f32::max);
    // A level's range is along the beam and begins at its phase.
    let before_m = grid.beams.iter().map(|beam| -beam.range_phase_m).fold(0.0, f32::max);
    if farthest_m > 0.0 { farthest_m + before_m } else { 1.0 }
}

/// What would make every frame fail, found before any scan is read.
fn check(config: &Config, rows: u16, columns: u16) -> Result<(), EncodeError> {
    UniformGrid::new(rows.into(), columns.into(), config.view)?;
    match config.scale {
        Scale::Fixed { max_range_m } => Quantizer::new(config.level_bits, max_range_m).map(|_| ())?,
        Scale::Step { step_m } => Quantizer::with_step(config.level_bits, step_m).map(|_| ())?,
        Scale::PerFrame => {}
    }
    Ok(())
}

/// A decoder with default limits must be able to read what is written here.
fn check_pixels(pixels: usize) -> Result<(), String> {
    let most = Limits::default().pixels;
    if pixels > most {
        return Err(format!("rows times columns are {pixels} pixels: expected at most {most}"));
    }
    Ok(())
}

/// One scan to encode.
struct Job<'a> {
    config: &'a Config,
    shape: &'a Shape,
    /// Of a sensor's grid.
    scale: Scale,
    scan: &'a Scan,
    stamp: Stamp,
}

impl Job<'_> {
    fn encode<L: Level, C: Coder<L>>(
        &self,
        image: ImageViewMut<'_, L>,
        coder: &mut C,
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError> {
        let points = self.scan.cloud.points.as_slice();
        match self.shape {
            Shape::Uniform { .. } => encode(self.config, points, self.stamp, image, coder, out),
            Shape::Beams { sensor, columns, rows } => {
                let lattice = Lattice::<LINES>::new(sensor.grid(), usize::from(*columns))?;
                let config = self.lattice_config(&lattice, !sensor.is_known());
                let mut frame = FrameEncoder::start(&config, self.stamp, image, coder)?;
                match &self.scan.turn {
                    Some(turn) => frame.insert_returns(turn.returns.iter().copied()),
                    None if rows.is_empty() => frame.insert(points),
                    None => frame.insert_on_rows(points, rows),
                }
                frame.finish(out)
            }
            Shape::Firings { sensor, firings } => {
                let grid = sensor.grid();
                let lattice = Lattice::<LINES>::new(grid, grid.ticks as usize)?;
                let every_tick = self.lattice_config(&lattice, !sensor.is_known());
                let config = FiringsConfig { every_tick, firings };
                let mut frame = FrameEncoder::start(&config, self.stamp, image, coder)?;
                match &self.scan.turn {
                    Some(turn) => frame.insert_fired(turn.returns.iter().copied()),
                    None => frame.insert(points),
                }
                frame.finish(out)
            }
        }
    }

    fn lattice_config<'l>(&self, lattice: &'l Lattice<'l, LINES>, table: bool) -> LatticeConfig<'l, LINES> {
        // Packets have no points that could be off.
        let measure = self.scan.turn.is_none();
        let (level_bits, scale) = (self.config.level_bits, self.scale);
        LatticeConfig { level_bits, scale, table, measure, ..LatticeConfig::new(lattice) }
    }
}

impl AnyCoder {
    fn new(name: CoderName, tier: Tier, settings: ContextSettings) -> Self {
        match name {
            CoderName::Context => match tier {
                Tier::Small => Self::Small(Box::new(Small::<GROUPS>::new(settings))),
                Tier::Dense => Self::Dense(Box::new(Dense::<GROUPS>::new(settings))),
                Tier::Fast => Self::Fast(Box::new(Fast::new(settings))),
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
            Self::Fast(_) => <Fast<BANDS> as Coder<L>>::WORST_CASE,
            Self::Store(_) => <Store as Coder<L>>::WORST_CASE,
        }
    }

    fn encode<L: Level>(
        &mut self,
        job: &Job<'_>,
        (levels, columns): (&mut [L], usize),
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError>
    where
        DeflateDefault: Coder<L>,
    {
        let size = flicr::ConfigError::Size { rows: 0, columns };
        let image = ImageViewMut::new(levels, columns).ok_or(size)?;
        match self {
            Self::Rle(coder) => job.encode(image, coder, out),
            Self::Deflate(coder) => job.encode(image, coder.as_mut(), out),
            Self::Small(coder) => job.encode(image, coder.as_mut(), out),
            Self::Dense(coder) => job.encode(image, coder.as_mut(), out),
            Self::Fast(coder) => job.encode(image, coder.as_mut(), out),
            Self::Store(coder) => job.encode(image, coder, out),
        }
    }
}
