//! The command line: `SCAN OUT_PREFIX FRAME...`. A frame is
//!
//! * `COLUMNS:CODER:MAX_RANGE_M`: 8 bits, evenly spaced rows and columns; where a sensor stands for the coder, the scan is
//!   packets, and one frame is made for every turn;
//! * `native:CODER:STEP`: a column for each firing of KITTI's HDL-64E, its own range counts, a context coder in steps of
//!   STEP counts.

use core::fmt;
use core::str::FromStr;

use flicr::coder::Step;
use semihosting::experimental::env::{Args, args};

use super::Fault;

const COMMAND_LINE_LEN: usize = 2048;

/// What is wrong with the command line.
#[derive(Debug)]
pub enum Usage {
    Missing(&'static str),
    NotText,
    Columns,
    TooManyColumns,
    Coder,
    NativeCoder,
    MaxRange,
    Step,
    PathTooLong,
}

impl fmt::Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(what) => write!(f, "missing argument: {what}"),
            Self::NotText => f.write_str("an argument is not UTF-8"),
            Self::Columns => f.write_str("COLUMNS is neither a number nor native"),
            Self::TooManyColumns => write!(f, "COLUMNS must be 1 to {}", super::COLUMNS_MAX),
            Self::Coder => f.write_str(
                "CODER must be store, rle, deflate, deflate-small, deflate-dense, small, dense, fast, lattice, vlp16, \
                 vlp32c or pandar40p",
            ),
            Self::NativeCoder => f.write_str("native columns are for small, dense and fast"),
            Self::MaxRange => f.write_str("MAX_RANGE_M is no number"),
            Self::Step => f.write_str("STEP must be 1 to 65535"),
            Self::PathTooLong => f.write_str("a path is too long"),
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
pub enum CoderName {
    Store,
    Rle,
    Deflate,
    DeflateSmall,
    DeflateDense,
    Small,
    Dense,
    Fast,
    /// Run lengths on the sensor's own grid.
    Lattice,
    /// Run lengths of packets.
    Vlp16,
    Vlp32c,
    Pandar40p,
}

impl FromStr for CoderName {
    type Err = Usage;

    fn from_str(name: &str) -> Result<Self, Usage> {
        match name {
            "store" => Ok(Self::Store),
            "rle" => Ok(Self::Rle),
            "deflate" => Ok(Self::Deflate),
            "deflate-small" => Ok(Self::DeflateSmall),
            "deflate-dense" => Ok(Self::DeflateDense),
            "small" => Ok(Self::Small),
            "dense" => Ok(Self::Dense),
            "fast" => Ok(Self::Fast),
            "lattice" => Ok(Self::Lattice),
            "vlp16" => Ok(Self::Vlp16),
            "vlp32c" => Ok(Self::Vlp32c),
            "pandar40p" => Ok(Self::Pandar40p),
            _ => Err(Usage::Coder),
        }
    }
}

impl fmt::Display for CoderName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Store => "store",
            Self::Rle => "rle",
            Self::Deflate => "deflate",
            Self::DeflateSmall => "deflate-small",
            Self::DeflateDense => "deflate-dense",
            Self::Small => "small",
            Self::Dense => "dense",
            Self::Fast => "fast",
            Self::Lattice => "lattice",
            Self::Vlp16 => "vlp16",
            Self::Vlp32c => "vlp32c",
            Self::Pandar40p => "pandar40p",
        })
    }
}

/// One frame to be encoded.
pub struct Job<'a> {
    pub scan: &'a str,
    pub out_prefix: &'a str,
    pub coder: CoderName,
    pub shape: Shape,
}

/// What the image is like.
#[derive(Clone, Copy)]
pub enum Shape {
    Even(Even),
    /// A column a firing, levels of a range count.
    Native(Step),
}

/// Columns spread evenly.
#[derive(Clone, Copy)]
pub struct Even {
    pub columns: usize,
    pub max_range_m: f32,
}

impl fmt::Display for Job<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let coder = self.coder;
        match self.shape {
            Shape::Even(Even { columns, max_range_m }) => {
                write!(f, "columns={columns} coder={coder} max_range_m={max_range_m}")
            }
            Shape::Native(step) => write!(f, "columns=native coder={coder} step={}", step.levels()),
        }
    }
}

impl Job<'_> {
    /// Writes what its file's name says of it.
    pub fn write_name(&self, name: &mut impl fmt::Write) -> fmt::Result {
        match self.shape {
            Shape::Even(even) => write!(name, "{}-{}", even.columns, self.coder),
            Shape::Native(step) => write!(name, "native-{}-{}", self.coder, step.levels()),
        }
    }
}

/// The command line, as the host gave it.
pub struct Arguments(Args<COMMAND_LINE_LEN>);

/// Asks the host for the command line.
pub fn arguments() -> Result<Arguments, Fault> {
    Ok(Arguments(args()?))
}

impl Arguments {
    /// The frames that it asks for. To be called once: the arguments are used up.
    pub fn jobs(&self) -> Result<impl Iterator<Item = Result<Job<'_>, Usage>>, Usage> {
        let mut arguments = self.0.into_iter().map(|argument| argument.map_err(|_| Usage::NotText)).skip(1);
        let scan = arguments.next().ok_or(Usage::Missing("SCAN"))??;
        let out_prefix = arguments.next().ok_or(Usage::Missing("OUT_PREFIX"))??;
        Ok(arguments.map(move |frame| parse_frame(scan, out_prefix, frame?)))
    }
}

fn parse_frame<'a>(scan: &'a str, out_prefix: &'a str, frame: &str) -> Result<Job<'a>, Usage> {
    let mut fields = frame.split(':');
    let mut field = |what| fields.next().ok_or(Usage::Missing(what));
    let columns = field("COLUMNS")?;
    let coder = field("CODER")?.parse()?;
    let shape = if columns == "native" {
        parse_native(coder, field("STEP")?)?
    } else {
        let columns = columns.parse().map_err(|_| Usage::Columns)?;
        Shape::Even(Even { columns, max_range_m: field("MAX_RANGE_M")?.parse().map_err(|_| Usage::MaxRange)? })
    };
    Ok(Job { scan, out_prefix, coder, shape })
}

fn parse_native(coder: CoderName, step: &str) -> Result<Shape, Usage> {
    if ![CoderName::Small, CoderName::Dense, CoderName::Fast].contains(&coder) {
        return Err(Usage::NativeCoder);
    }
    step.parse().ok().and_then(Step::new).map(Shape::Native).ok_or(Usage::Step)
}
