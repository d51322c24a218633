//! The command line: `SCAN OUT_PREFIX COLUMNS:CODER:MAX_RANGE_M...`, one frame for each of the last; where a sensor stands
//! for the coder, the scan is packets, and one frame is made for every turn.

use core::fmt;
use core::str::FromStr;

use semihosting::experimental::env::{Args, args};

use super::Fault;

const COMMAND_LINE_LEN: usize = 1024;

/// What is wrong with the command line.
#[derive(Debug)]
pub enum Usage {
    Missing(&'static str),
    NotText,
    Columns,
    TooManyColumns,
    Coder,
    MaxRange,
    PathTooLong,
}

impl fmt::Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(what) => write!(f, "missing argument: {what}"),
            Self::NotText => f.write_str("an argument is not UTF-8"),
            Self::Columns => f.write_str("COLUMNS is no number"),
            Self::TooManyColumns => write!(f, "COLUMNS must be 1 to {}", super::COLUMNS_MAX),
            Self::Coder => f.write_str(
                "CODER must be store, rle, deflate, deflate-small, deflate-dense, lattice, vlp16, vlp32c or pandar40p",
            ),
            Self::MaxRange => f.write_str("MAX_RANGE_M is no number"),
            Self::PathTooLong => f.write_str("a path is too long"),
        }
    }
}

#[derive(Clone, Copy)]
pub enum CoderName {
    Store,
    Rle,
    Deflate,
    DeflateSmall,
    DeflateDense,
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
    pub columns: usize,
    pub coder: CoderName,
    pub max_range_m: f32,
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
    Ok(Job {
        scan,
        out_prefix,
        columns: field("COLUMNS")?.parse().map_err(|_| Usage::Columns)?,
        coder: field("CODER")?.parse()?,
        max_range_m: field("MAX_RANGE_M")?.parse().map_err(|_| Usage::MaxRange)?,
    })
}
