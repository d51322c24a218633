//! The library's encoder and decoder, with geometry, level type and coder chosen at run time.

mod choose;
mod lit;

use flicr::coder::{Coder, ContextSettings, Fast};
use flicr::frame::worst_case_len_in_strips;
use flicr::geometry::{Lattice, SensorGrid};
use flicr::plane::TimesPlane;
use flicr::{
    Companding, Config, DeflateDefault, Dense, EncodeError, Encoded, FiringsConfig, FrameEncoder, ImageViewMut,
    LatticeConfig, Level, Levels, Limits, Previous, Quantizer, Rle, Scale, Small, Stamp, Store, UniformGrid,
};

use crate::args::{CoderName, Columns, FrameArgs, Step, Tier, uniform_level_m};
use crate::choice::{Choice, Fineness, PredictorName};
pub use crate::codec::lit::{Keep, keep};
use crate::codec::lit::{Lit, LitScan};
use crate::failure::Failure;
use crate::input::Scan;
use crate::plan::{COLUMNS, Plan, Shape, plan};
use crate::sensors::Asked;

/// Lines for sensors of up to 256 beams.
const LINES: usize = 258;

/// How finely times are kept.
const TIME_UNIT_NS: u32 = 1;

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
    settings: ContextSettings,
    /// Distance of the levels that the context coders step between, meters.
    level_m: f32,
    out: Vec<u8>,
    len: usize,
    lit: Option<Lit>,
    keeps_times: bool,
    /// Every so many frames is a key frame, where frames go on from the one before.
    key_every: Option<u32>,
    previous: Option<Previous<Vec<u16>>>,
    previous_size: (usize, usize),
    /// Of the columns.
    times_ns: Vec<u64>,
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
    pub fn new(args: &FrameArgs, choice: Choice, columns: Option<Columns>) -> Result<Self, Failure> {
        let args = args.with(choice);
        check_choice(&args).map_err(Failure::Usage)?;
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
        let level_m = uniform_level_m(args.step(), 0.0);
        let settings = args.context(level_m).map_err(Failure::Usage)?;
        let coder = AnyCoder::new(args.coder(), args.choice.tier, settings);
        Ok(Self {
            args,
            config,
            columns,
            asked,
            plan,
            levels,
            coder,
            settings,
            level_m,
            out: Vec::new(),
            len: 0,
            lit: None,
            keeps_times: false,
            key_every: None,
            previous: None,
            previous_size: (0, 0),
            times_ns: Vec::new(),
        })
    }

    /// Has frames of captures carry the columns' times.
    pub fn keep_times(&mut self) {
        self.keeps_times = true;
    }

    /// Has frames go on from the one before, but for every so many.
    pub fn go_on(&mut self, key_every: u32) -> Result<(), Failure> {
        if !self.args.is_context() || self.args.choice.tier == Tier::Fast {
            let why = "--previous: expected --coder context, of the dense or the small tier";
            return Err(Failure::Usage(why.to_owned()));
        }
        self.key_every = Some(key_every);
        Ok(())
    }

    /// Has frames carry intensities.
    pub fn keep_intensities(&mut self, keep: Keep) {
        self.lit = Some(Lit::new(keep));
    }

    /// Chooses the geometry of a scan and takes the memory that its frame needs.
    pub fn prepare(&mut self, scan: &Scan) -> Result<&Plan, String> {
        if self.args.preset.is_none() {
            self.plan = plan(scan, self.asked.as_ref(), self.columns).map_err(|error| error.to_string())?;
        }
        if self.args.step() == Some(Step::Native) && self.plan.shape.sensor().is_none() {
            let why = if self.plan.why.is_empty() { "--preset" } else { &self.plan.why };
            return Err(format!("no sensor's grid, so no native step: expected meters ({why})"));
        }
        self.check_reach(scan)?;
        let rows = self.plan.shape.sensor().map_or(self.args.rows.into(), |sensor| sensor.grid().beams.len());
        let pixels = rows * self.plan.shape.columns();
        check_pixels(pixels)?;
        self.level_m = match self.plan.shape.sensor() {
            Some(sensor) => sensor.grid().range_unit_m,
            None => uniform_level_m(self.args.step(), farthest_point_m(scan)),
        };
        if self.args.is_context() && self.args.choice.fineness.is_some() {
            self.config.scale = Scale::Step { step_m: self.level_m };
        }
        self.settings = self.args.context(self.level_m)?;
        self.coder.set(self.settings);
        let (columns, strips) = (self.plan.shape.columns(), self.args.strips);
        let worst_case_len = match &mut self.levels {
            Levels::U8(levels) => {
                levels.resize(pixels, 0);
                self.coder.worst_case_len::<u8>(rows, columns, strips)
            }
            Levels::U16(levels) => {
                levels.resize(pixels, 0);
                self.coder.worst_case_len::<u16>(rows, columns, strips)
            }
        };
        let planes_len = match &mut self.lit {
            Some(lit) => lit.prepare(&scan.cloud, pixels, strips.into())?,
            None => 0,
        };
        let planes_len = planes_len + self.prepare_times(scan, strips.into())? + self.prepare_previous(rows, columns);
        self.out.resize(worst_case_len + self.more_header_len(rows) + planes_len, 0);
        self.choose(scan)?;
        Ok(&self.plan)
    }

    /// Refuses levels that are so fine, or so few, that most of the scan lies beyond the last: what is dropped then is
    /// hardly meant. Less is dropped and counted.
    fn check_reach(&self, scan: &Scan) -> Result<(), String> {
        let (Some(sensor), Scale::Step { step_m }) = (self.plan.shape.sensor(), self.scale(scan)) else {
            return Ok(());
        };
        let (bits, unit_m) = (self.config.level_bits, sensor.grid().range_unit_m);
        if self.config.companding == Companding::SquareRoot {
            return Ok(());
        }
        let reach_m =
            Quantizer::with_step(bits, step_m).map_err(|error| error.to_string())?.max_range_m() + 0.5 * step_m;
        let is_beyond = |range_m: f32| range_m > reach_m && range_m.is_finite();
        let (beyond, all) = if let Some(turn) = &scan.turn {
            let ranges = turn.returns.iter().map(|found| found.count as f32 * unit_m);
            (ranges.filter(|&range_m| is_beyond(range_m)).count(), turn.returns.len())
        } else {
            let ranges = scan.cloud.points.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt());
            (ranges.filter(|&range_m| is_beyond(range_m)).count(), scan.cloud.points.len())
        };
        if 2 * beyond <= all {
            return Ok(());
        }
        // The context coders' levels are the sensor's counts, however long their steps.
        let or = if self.args.is_context() { "--coder deflate with a longer --step" } else { "a longer --step" };
        Err(format!(
            "{bits} bits in levels of {step_m} m reach {reach_m:.2} m, and {beyond} of {all} points are beyond: expected \
             --bits 16 or {or}"
        ))
    }

    /// Memory of the frame before, where frames go on from it; gives the bytes by which a frame can get longer.
    fn prepare_previous(&mut self, rows: usize, columns: usize) -> usize {
        let Some(every) = self.key_every else { return 0 };
        if self.previous_size.0 != rows || self.previous_size.1 < columns {
            // More firings may come.
            let columns_max = columns + columns / 8;
            let memory = vec![0; Previous::<Vec<u16>>::memory_len(rows, columns_max, true)];
            self.previous = Some(Previous::new(memory, columns_max, every));
            self.previous_size = (rows, columns_max);
        }
        Previous::<Vec<u16>>::WORST_CASE_LEN
    }

    /// The times of the columns, where they are kept; gives the bytes by which a frame can get longer.
    fn prepare_times(&mut self, scan: &Scan, strips: usize) -> Result<usize, String> {
        if !self.keeps_times {
            return Ok(0);
        }
        let turn = scan.turn.as_ref().ok_or("found no times, asked to keep them: expected a capture")?;
        let (columns, ticks) = (self.plan.shape.columns(), turn.sensor.grid().ticks as usize);
        self.times_ns.clear();
        self.times_ns.resize(columns, 0);
        for (&tick, &time_ns) in turn.ticks.iter().zip(&turn.times_ns) {
            let column = match &self.plan.shape {
                Shape::Firings { firings, .. } => firings.nearest(tick).0.into(),
                _ => (2 * tick as usize * columns + ticks) / (2 * ticks) % columns,
            };
            let time = &mut self.times_ns[column];
            // The first of a column's firings.
            *time = if *time == 0 { time_ns } else { *time };
        }
        Ok(TimesPlane::worst_case_len(columns, strips))
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
        let mut previous = self.previous.take();
        let encoded = self.encode_after(scan, stamp, previous.as_mut());
        self.previous = previous;
        encoded
    }

    /// The same as a frame of its own, whatever was before.
    fn encode_alone(&mut self, scan: &Scan, stamp: Stamp) -> Result<Encoded, EncodeError> {
        self.encode_after(scan, stamp, None)
    }

    fn encode_after(
        &mut self,
        scan: &Scan,
        stamp: Stamp,
        previous: Option<&mut Previous<Vec<u16>>>,
    ) -> Result<Encoded, EncodeError> {
        self.len = 0;
        let scale = self.scale(scan);
        let times = TimesPlane::new(&self.times_ns, TIME_UNIT_NS).filter(|_| self.keeps_times);
        let mut job = Job { config: &self.config, shape: &self.plan.shape, scale, scan, stamp, times, previous };
        let (columns, out) = (self.plan.shape.columns(), self.out.as_mut_slice());
        let lit = self.lit.as_mut().map(Lit::scan);
        let encoded = match &mut self.levels {
            Levels::U8(levels) => self.coder.encode(&mut job, (levels, columns), lit, out),
            Levels::U16(levels) => self.coder.encode(&mut job, (levels, columns), lit, out),
        }?;
        self.len = encoded.len;
        Ok(encoded)
    }

    /// Of a sensor's grid, where it is known before the first point comes.
    fn scale(&self, scan: &Scan) -> Scale {
        let Some(sensor) = self.plan.shape.sensor() else { return self.config.scale };
        let grid = sensor.grid();
        match (self.args.choice.fineness, self.args.max_range) {
            // The coder steps between the sensor's own levels.
            (Some(_), _) if self.args.is_context() => Scale::Step { step_m: grid.range_unit_m },
            (Some(Fineness::Step(Step::Meters(step_m))), _) => Scale::Step { step_m },
            (Some(_), _) => Scale::Step { step_m: grid.range_unit_m },
            (None, Some(max_range_m)) => Scale::Fixed { max_range_m },
            (None, None) => Scale::Fixed { max_range_m: farthest_m(scan, &grid) },
        }
    }

    /// Step of the last prepared scan's frames, where it is not what bits and the largest range make it.
    pub fn step_m(&self) -> Option<f32> {
        match self.args.choice.fineness? {
            Fineness::Step(Step::Meters(step_m)) if !self.args.is_context() => Some(step_m),
            _ if self.args.is_context() => Some(f32::from(self.settings.step.levels()) * self.level_m),
            _ => Some(self.level_m),
        }
    }

    /// What was asked for, and what is taken where nothing was said.
    pub const fn args(&self) -> &FrameArgs {
        &self.args
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
    let farthest_m = farthest_point_m(scan);
    // A level's range is along the beam and begins at its phase.
    let before_m = grid.beams.iter().map(|beam| -beam.range_phase_m).fold(0.0, f32::max);
    if farthest_m > 0.0 { farthest_m + before_m } else { 1.0 }
}

fn farthest_point_m(scan: &Scan) -> f32 {
    let range_m = |[x, y, z]: &[f32; 3]| (x * x + y * y + z * z).sqrt();
    let ranges = scan.cloud.points.iter().map(range_m).filter(|range_m| range_m.is_finite());
    ranges.fold(0.0, f32::max)
}

/// What some coders cannot do.
fn check_choice(args: &FrameArgs) -> Result<(), String> {
    if args.companding() == Companding::SquareRoot && args.bits() > u8::BITS {
        return Err("--companding sqrt: expected --bits of 8 or fewer, and no --step".to_owned());
    }
    let only_context = match args.choice.fineness {
        Some(Fineness::Bound(_)) => Some("--bound"),
        Some(Fineness::TargetBytes(_)) => Some("--target-bytes"),
        _ => None,
    };
    match only_context {
        Some(option) if !args.is_context() => Err(format!("{option}: expected --coder context")),
        _ if args.is_context() && args.choice.tier == Tier::Fast && args.predictor == PredictorName::MedianEdge => {
            Err("--predictor median-edge: the fast tier predicts a pixel from its own beam".to_owned())
        }
        _ => Ok(()),
    }
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
    times: Option<TimesPlane<'a>>,
    previous: Option<&'a mut Previous<Vec<u16>>>,
}

impl Job<'_> {
    fn encode<L: Level, C: Coder<L>>(
        &mut self,
        image: ImageViewMut<'_, L>,
        coder: &mut C,
        mut lit: Option<LitScan<'_>>,
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError> {
        let points = self.scan.cloud.points.as_slice();
        match self.shape {
            Shape::Uniform { .. } => {
                let mut frame = FrameEncoder::start_for(self.config, points, self.stamp, image, coder)?;
                match &mut lit {
                    None => frame.insert(points),
                    Some(lit) => frame.insert_lit(points, |at| lit.numbers[at], lit.plane),
                }
                LitScan::finish(lit, self.times, self.previous.as_deref_mut(), frame, out)
            }
            Shape::Beams { sensor, columns, rows } => {
                let lattice = Lattice::<LINES>::new(sensor.grid(), usize::from(*columns))?;
                let config = self.lattice_config(&lattice, !sensor.is_known());
                let mut frame = FrameEncoder::start(&config, self.stamp, image, coder)?;
                match (&self.scan.turn, &mut lit) {
                    (Some(turn), None) => frame.insert_returns(turn.returns.iter().copied()),
                    (Some(turn), Some(lit)) => {
                        frame.insert_lit_returns(LitScan::returns(lit.numbers, &turn.returns), lit.plane);
                    }
                    (None, None) if rows.is_empty() => frame.insert(points),
                    (None, Some(lit)) if rows.is_empty() => frame.insert_lit(points, |at| lit.numbers[at], lit.plane),
                    (None, None) => frame.insert_on_rows(points, rows),
                    (None, Some(lit)) => frame.insert_lit_on_rows(points, rows, |at| lit.numbers[at], lit.plane),
                }
                LitScan::finish(lit, self.times, self.previous.as_deref_mut(), frame, out)
            }
            Shape::Firings { sensor, firings } => {
                let grid = sensor.grid();
                let lattice = Lattice::<LINES>::new(grid, grid.ticks as usize)?;
                let every_tick = self.lattice_config(&lattice, !sensor.is_known());
                let config = FiringsConfig { every_tick, firings };
                let mut frame = FrameEncoder::start(&config, self.stamp, image, coder)?;
                match (&self.scan.turn, &mut lit) {
                    (Some(turn), None) => frame.insert_fired(turn.returns.iter().copied()),
                    (Some(turn), Some(lit)) => {
                        frame.insert_lit_fired(LitScan::returns(lit.numbers, &turn.returns), lit.plane);
                    }
                    (None, None) => frame.insert(points),
                    (None, Some(lit)) => frame.insert_lit(points, |at| lit.numbers[at], lit.plane),
                }
                LitScan::finish(lit, self.times, self.previous.as_deref_mut(), frame, out)
            }
        }
    }

    fn lattice_config<'l>(&self, lattice: &'l Lattice<'l, LINES>, table: bool) -> LatticeConfig<'l, LINES> {
        let (scale, Config { level_bits, companding, strips, .. }) = (self.scale, *self.config);
        LatticeConfig { level_bits, scale, companding, strips, table, measure: true, ..LatticeConfig::new(lattice) }
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

    /// Changes how the context coders go about images.
    fn set(&mut self, settings: ContextSettings) {
        match self {
            Self::Small(coder) => coder.set(settings),
            Self::Dense(coder) => coder.set(settings),
            Self::Fast(coder) => coder.set(settings),
            Self::Rle(_) | Self::Deflate(_) | Self::Store(_) => {}
        }
    }

    fn worst_case_len<L: Level>(&self, rows: usize, columns: usize, strips: u16) -> usize
    where
        DeflateDefault: Coder<L>,
    {
        match self {
            Self::Rle(_) => worst_case_len_in_strips::<L, Rle>(rows, columns, strips),
            Self::Deflate(_) => worst_case_len_in_strips::<L, DeflateDefault>(rows, columns, strips),
            Self::Small(_) => worst_case_len_in_strips::<L, Small<GROUPS>>(rows, columns, strips),
            Self::Dense(_) => worst_case_len_in_strips::<L, Dense<GROUPS>>(rows, columns, strips),
            Self::Fast(_) => worst_case_len_in_strips::<L, Fast<BANDS>>(rows, columns, strips),
            Self::Store(_) => worst_case_len_in_strips::<L, Store>(rows, columns, strips),
        }
    }

    fn encode<L: Level>(
        &mut self,
        job: &mut Job<'_>,
        (levels, columns): (&mut [L], usize),
        lit: Option<LitScan<'_>>,
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError>
    where
        DeflateDefault: Coder<L>,
    {
        let size = flicr::ConfigError::Size { rows: 0, columns };
        let image = ImageViewMut::new(levels, columns).ok_or(size)?;
        match self {
            Self::Rle(coder) => job.encode(image, coder, lit, out),
            Self::Deflate(coder) => job.encode(image, coder.as_mut(), lit, out),
            Self::Small(coder) => job.encode(image, coder.as_mut(), lit, out),
            Self::Dense(coder) => job.encode(image, coder.as_mut(), lit, out),
            Self::Fast(coder) => job.encode(image, coder.as_mut(), lit, out),
            Self::Store(coder) => job.encode(image, coder, lit, out),
        }
    }
}
