//! The command line: `SENSOR:STEP[:BYTES_A_SECOND] uart`, or `... IN OUT` for files of the host in the place of UARTs.
//!
//! A board of your own has no command line: it makes its [`Job`] a constant.

use core::fmt;
use core::str::FromStr;

use flicr::coder::Step;
use semihosting::experimental::env::{Args, args};

use super::Fault;

const COMMAND_LINE_LEN: usize = 1024;

/// Whose packets come in, and how their columns are made.
#[derive(Clone, Copy)]
pub enum SensorName {
    Vlp16,
    Hdl64e,
    Hdl64eAligned,
}

impl FromStr for SensorName {
    type Err = Fault;

    fn from_str(name: &str) -> Result<Self, Fault> {
        match name {
            "vlp16" => Ok(Self::Vlp16),
            "hdl64e" => Ok(Self::Hdl64e),
            "hdl64e-aligned" => Ok(Self::Hdl64eAligned),
            _ => Err(Fault::Usage("SENSOR must be vlp16, hdl64e or hdl64e-aligned")),
        }
    }
}

impl fmt::Display for SensorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Vlp16 => "vlp16",
            Self::Hdl64e => "hdl64e",
            Self::Hdl64eAligned => "hdl64e-aligned",
        })
    }
}

/// What is to be streamed.
pub struct Job {
    pub sensor: SensorName,
    pub step: Step,
    /// What the link carries; without it, every column in steps of `step`.
    pub bytes_a_second: Option<u32>,
}

/// Where bytes come from and go to.
pub enum Place<'a> {
    Uart,
    Files { packets: &'a str, datagrams: &'a str },
}

/// The command line, as the host gave it.
pub struct Arguments(Args<COMMAND_LINE_LEN>);

/// Asks the host for the command line.
pub fn arguments() -> Result<Arguments, Fault> {
    Ok(Arguments(args()?))
}

impl Arguments {
    /// What it asks for. To be called once: the arguments are used up.
    pub fn parse(&self) -> Result<(Job, Place<'_>), Fault> {
        let mut arguments = self.0.into_iter().skip(1);
        let mut next = |what| match arguments.next() {
            Some(Ok(argument)) => Ok(argument),
            _ => Err(Fault::Usage(what)),
        };
        let job = parse_job(next("SENSOR:STEP[:BYTES_A_SECOND]")?)?;
        let place = match next("uart or IN")? {
            "uart" => Place::Uart,
            packets => Place::Files { packets, datagrams: next("OUT")? },
        };
        Ok((job, place))
    }
}

fn parse_job(text: &str) -> Result<Job, Fault> {
    let mut fields = text.split(':');
    let sensor = fields.next().unwrap_or_default().parse()?;
    let step = fields.next().and_then(|step| step.parse().ok()).and_then(Step::new);
    let step = step.ok_or(Fault::Usage("STEP must be 1 to 65535"))?;
    let bytes_a_second = fields.next().map(str::parse).transpose();
    Ok(Job { sensor, step, bytes_a_second: bytes_a_second.map_err(|_| Fault::Usage("BYTES_A_SECOND is no number"))? })
}
