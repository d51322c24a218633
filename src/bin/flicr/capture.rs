//! The turns of a capture: packets to returns, by the sensor's own integers.

use std::collections::VecDeque;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use clap::{Args, ValueEnum};
use flicr::GridReturn;
use flicr::files::PointCloud;
use flicr::files::capture::{Capture, Datagram};
use flicr::geometry::sensors::ouster::OusterSensor;
use flicr::geometry::sensors::{SensorGeometry, hesai, velodyne};
use flicr::packet::{Column, Event, GapCause, Model, PacketStats, ReturnPolicy, Sensor, Turn, TurnAssembler, TurnCut};

use crate::failure::Failure;
use crate::input::Scan;
use crate::sensors::{OwnedGrid, metadata, turning};
use crate::table::grouped;

/// How captures are read.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Captures (.pcap)")]
pub struct CaptureArgs {
    /// An Ouster's metadata (.json): its packets do not say how to read them
    #[arg(long, value_name = "FILE")]
    pub metadata: Option<PathBuf>,
    /// Which return of two
    #[arg(long, value_enum, default_value_t = Returns::Strongest)]
    pub returns: Returns,
    /// Only this turn, from 0: the first that is whole
    #[arg(long, value_name = "N")]
    pub turn: Option<usize>,
    /// Also turns that the capture begins or ends in
    #[arg(long)]
    pub partial: bool,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum Returns {
    /// The stronger of two
    #[default]
    Strongest,
    /// The farther of two
    Last,
}

impl From<Returns> for ReturnPolicy {
    fn from(returns: Returns) -> Self {
        match returns {
            Returns::Strongest => Self::Strongest,
            Returns::Last => Self::Last,
        }
    }
}

/// A turn as the packets have it.
#[derive(Debug, Clone)]
pub struct CapturedTurn {
    pub sensor: Rc<OwnedGrid>,
    pub returns: Vec<GridReturn>,
    /// Of the firings, those without a return too.
    pub ticks: Vec<u32>,
    /// Number in the capture, from 0.
    pub number: usize,
    /// Columns that did not come, for whatever cause.
    pub missing: u16,
    pub is_whole: bool,
}

/// The turns of a capture, one after the other.
pub struct Turns {
    path: PathBuf,
    datagrams: Capture,
    assembler: TurnAssembler,
    ouster: Option<Rc<OwnedGrid>>,
    /// The grid of a sensor whose beams fire one after another, and the rate that it is for.
    turning: Option<(u32, Rc<OwnedGrid>)>,
    open: Open,
    ready: VecDeque<Scan>,
    ended: usize,
    /// Where the first packet that was understood went: what goes elsewhere is another sensor's, or no returns.
    port: Option<u16>,
    elsewhere: u64,
    /// Why the first of the refused packets was.
    refusal: Option<String>,
    is_over: bool,
}

/// The turn that is being read.
#[derive(Debug, Default)]
struct Open {
    returns: Vec<GridReturn>,
    intensities: Vec<f32>,
    ticks: Vec<u32>,
    /// Sum of the columns' steps.
    steps_q8: u64,
    time_ns: Option<u64>,
    begins_late: bool,
}

impl Open {
    fn add(&mut self, column: &Column<'_>) {
        self.time_ns.get_or_insert(column.time_ns);
        self.ticks.push(column.tick.into());
        self.steps_q8 += u64::from(column.step_q8);
        column.for_each_return(|found| {
            self.returns.push(found.into());
            self.intensities.push(found.intensity.into());
        });
    }

    fn step_q8(&self) -> u64 {
        self.steps_q8 / self.ticks.len().max(1) as u64
    }
}

impl Turns {
    pub fn open(path: &Path, args: &CaptureArgs, ouster: Option<&OusterSensor>) -> Result<Self, Failure> {
        let read = args.metadata.as_deref().map(metadata).transpose()?;
        let ouster = read.as_ref().or(ouster);
        let sensor = ouster.map_or(Sensor::Auto, |sensor| Sensor::Ouster(sensor.format));
        Ok(Self {
            path: path.into(),
            datagrams: Capture::open(path)?,
            assembler: TurnAssembler::new(sensor, args.returns.into()),
            ouster: ouster.map(|sensor| Rc::new(OwnedGrid::new(&sensor.grid()))),
            turning: None,
            open: Open::default(),
            ready: VecDeque::new(),
            ended: 0,
            port: None,
            elsewhere: 0,
            refusal: None,
            is_over: false,
        })
    }

    /// Datagrams to other ports than the sensor's.
    pub const fn elsewhere(&self) -> u64 {
        self.elsewhere
    }

    pub fn stats(&self) -> PacketStats {
        self.assembler.stats()
    }

    /// Packets that were refused and why, and what was missing; nothing where nothing was.
    pub fn complaint(&self) -> Option<String> {
        let stats = self.stats();
        let counts = [
            (stats.wrong_length, "of another length"),
            (stats.wrong_model, "of another sensor"),
            (stats.damaged, "damaged"),
            (stats.wrong_azimuth, "with an impossible azimuth"),
            (stats.discontinuous, "out of step"),
            (stats.duplicate, "received twice"),
            (stats.late, "late"),
        ];
        let mut text = String::new();
        if stats.refused() > 0 {
            let some = counts.iter().filter(|(count, _)| *count > 0);
            let some: Vec<String> = some.map(|(count, what)| format!("{} {what}", grouped((*count).into()))).collect();
            let (used, refused) = (grouped(stats.used.into()), grouped(stats.refused().into()));
            // Writing to a string cannot fail.
            let _ = write!(text, "{used} packets used, {refused} refused: {}", some.join(", "));
            if let Some(refusal) = &self.refusal {
                let _ = write!(text, " (the first: {refusal})");
            }
        }
        if stats.lost_columns > 0 {
            let gap = if text.is_empty() { "" } else { "; " };
            let _ = write!(text, "{gap}{} columns lost", grouped(stats.lost_columns.into()));
        }
        (!text.is_empty()).then_some(text)
    }

    fn push(&mut self, Datagram { port, payload }: &Datagram) {
        if self.port.is_some_and(|known| known != *port) {
            self.elsewhere += 1;
            return;
        }
        let (open, mut ended) = (&mut self.open, Vec::new());
        let pushed = self.assembler.push(payload, |event| take(event, open, &mut ended));
        match pushed {
            Ok(()) => self.port = Some(*port),
            Err(error) => {
                self.refusal.get_or_insert_with(|| error.to_string());
            }
        }
        self.end(ended);
    }

    fn finish(&mut self) {
        let (open, mut ended) = (&mut self.open, Vec::new());
        self.assembler.finish(|event| take(event, open, &mut ended));
        self.end(ended);
    }

    fn end(&mut self, ended: Vec<(Open, Turn)>) {
        for (open, turn) in ended {
            if let Some(sensor) = self.sensor(&open) {
                self.ready.push_back(scan(open, turn, sensor, self.ended));
                self.ended += 1;
            }
        }
    }

    /// The grid on which a turn's returns lie. A motor that keeps its rate within a hundredth keeps its grid.
    fn sensor(&mut self, open: &Open) -> Option<Rc<OwnedGrid>> {
        if let Some(ouster) = &self.ouster {
            return Some(ouster.clone());
        }
        let model = self.assembler.model()?;
        let rate = turns_per_minute(model, open.step_q8());
        match &self.turning {
            Some((known, grid)) if 100 * rate.abs_diff(*known) <= *known => Some(grid.clone()),
            _ => {
                let grid = Rc::new(turning(geometry(model)?, rate));
                self.turning = Some((rate, grid.clone()));
                Some(grid)
            }
        }
    }

    /// Where not one packet was understood.
    fn nothing(&self) -> Failure {
        let found = match (&self.refusal, self.stats().refused()) {
            (Some(refusal), count) => format!("found {} other packets (the first: {refusal})", grouped(count.into())),
            (None, _) => format!("found no UDP packet among {} frames", self.datagrams.others()),
        };
        let expected = "expected packets of a Velodyne or Hesai, or an Ouster's and its --metadata FILE";
        Failure::data(&self.path, format_args!("{found}, {expected}"))
    }
}

impl Iterator for Turns {
    type Item = Result<Scan, Failure>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(scan) = self.ready.pop_front() {
                return Some(Ok(scan));
            }
            if self.is_over {
                return None;
            }
            match self.datagrams.next() {
                Some(Ok(datagram)) => self.push(&datagram),
                Some(Err(error)) => {
                    self.is_over = true;
                    return Some(Err(error.into()));
                }
                None => {
                    self.is_over = true;
                    self.finish();
                    if self.stats().used == 0 {
                        return Some(Err(self.nothing()));
                    }
                }
            }
        }
    }
}

fn take(event: Event<'_>, open: &mut Open, ended: &mut Vec<(Open, Turn)>) {
    match event {
        Event::Column(column) => open.add(&column),
        Event::Gap { cause: GapCause::Start, .. } => open.begins_late = true,
        Event::TurnEnd(turn) => ended.push((std::mem::take(open), turn)),
        _ => {}
    }
}

fn scan(open: Open, turn: Turn, sensor: Rc<OwnedGrid>, number: usize) -> Scan {
    let grid = sensor.grid();
    let reaches_end = open
        .ticks
        .last()
        .is_some_and(|&last| u64::from(last) + open.step_q8().max(256) * 2 / 256 > u64::from(grid.ticks));
    let is_whole = !open.begins_late && (turn.end == TurnCut::Wrap || reaches_end);
    let point = |found: &GridReturn| grid.position(found.row.into(), found.tick, found.count).unwrap_or_default();
    let cloud = PointCloud {
        points: open.returns.iter().map(point).map(|point| point.map(|v| v as f32)).collect(),
        intensities: Some(open.intensities),
        rings: Some(open.returns.iter().map(|found| found.row).collect()),
    };
    let (returns, ticks, missing) = (open.returns, open.ticks, turn.missing);
    let turn = CapturedTurn { sensor, returns, ticks, number, missing, is_whole };
    Scan { cloud, timestamp_ns: open.time_ns.unwrap_or(0), turn: Some(turn) }
}

fn turns_per_minute(model: Model, step_q8: u64) -> u32 {
    let facts = model.facts();
    let turns_a_column = step_q8 as f64 / 256.0 / f64::from(facts.ticks_per_turn);
    (turns_a_column * 60e9 / f64::from(facts.period_ns)).round() as u32
}

fn geometry(model: Model) -> Option<&'static SensorGeometry> {
    Some(match model {
        Model::Vlp16 => &velodyne::VLP16,
        Model::PuckHiRes => &velodyne::PUCK_HI_RES,
        Model::Vlp32c => &velodyne::VLP32C,
        Model::Hdl32e => &velodyne::HDL32E,
        Model::Vls128 => &velodyne::VLS128,
        Model::Pandar40p => &hesai::PANDAR40P,
        Model::Pandar64 => &hesai::PANDAR64,
        Model::PandarXt32 => &hesai::PANDAR_XT32,
        _ => return None,
    })
}
