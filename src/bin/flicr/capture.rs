//! The turns of a capture: packets to returns, by the sensor's own integers.

use std::collections::VecDeque;
use std::fmt::Write;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use clap::{Args, ValueEnum};
use flicr::GridReturn;
use flicr::files::capture::{Capture, Datagram};
use flicr::files::{FileError, PointCloud};
use flicr::geometry::sensors::{SensorGeometry, hesai, velodyne};
use flicr::geometry::{Beam, SensorGrid};
use flicr::packet::{
    Column, Event, GapCause, Model, OusterFormat, PacketStats, ReturnPolicy, Sensor, Turn, TurnAssembler, TurnCut,
};

use crate::failure::Failure;
use crate::input::Scan;
use crate::sensors::{Asked, OwnedGrid, metadata, turning};
use crate::table::grouped;

/// How captures are read.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Captures (.pcap)")]
pub struct CaptureArgs {
    /// An Ouster's metadata (.json): its packets do not say how to read them
    #[arg(long, value_name = "FILE")]
    pub metadata: Option<PathBuf>,
    /// Which return of two; both are two frames a turn: the stronger ones, then those that they leave
    #[arg(long, value_enum, default_value_t = Returns::Strongest)]
    pub returns: Returns,
    /// The sensor's address, where several sent to one port [default: the first whose packets are understood]
    #[arg(long, value_name = "ADDRESS")]
    pub source: Option<IpAddr>,
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
    /// Both, in two frames a turn
    Both,
}

impl From<Returns> for ReturnPolicy {
    fn from(returns: Returns) -> Self {
        match returns {
            Returns::Strongest => Self::Strongest,
            Returns::Last => Self::Last,
            Returns::Both => Self::Both,
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
    /// When, of each of these.
    pub times_ns: Vec<u64>,
    /// Number in the capture, from 0.
    pub number: usize,
    /// Columns that did not come, for whatever cause.
    pub missing: u16,
    /// Those of them in which the sensor is told not to measure.
    pub blind: u16,
    pub is_whole: bool,
    /// 1 for what the first of two frames a turn leaves.
    pub layer: u8,
}

/// The turns of a capture, one after the other.
pub struct Turns {
    path: PathBuf,
    datagrams: Capture,
    assembler: TurnAssembler,
    ouster: Option<Rc<OwnedGrid>>,
    /// What stands in the metadata to compare an Ouster's packets with.
    identity: Option<OusterIdentity>,
    /// A sensor file's grid, to be the packets' instead of the built-in one.
    file: Option<Rc<OwnedGrid>>,
    /// The grid of a sensor whose beams fire one after another, and the rate that it is for.
    turning: Option<(u32, Rc<OwnedGrid>)>,
    open: [Open; 2],
    ready: VecDeque<Scan>,
    ended: usize,
    /// Where the first packet that was understood went: what goes elsewhere is another sensor's, or no returns.
    port: Option<u16>,
    elsewhere: u64,
    /// The address of the sensor, once it is known or asked for, and of the first other that sent to its port.
    source: Option<IpAddr>,
    other_source: Option<(IpAddr, u64)>,
    /// Why the file was not read to its end.
    broken: Option<FileError>,
    /// How packets contradict the metadata.
    contradiction: Option<String>,
    failure: Option<Failure>,
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
    times_ns: Vec<u64>,
    /// Sum of the columns' steps.
    steps_q8: u64,
    time_ns: Option<u64>,
    begins_late: bool,
    blind: u16,
}

impl Open {
    fn add(&mut self, column: &Column<'_>) {
        self.time_ns.get_or_insert(column.time_ns);
        self.ticks.push(column.tick.into());
        self.times_ns.push(column.time_ns);
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
    pub fn open(path: &Path, args: &CaptureArgs, asked: Option<&Asked>) -> Result<Self, Failure> {
        let read = args.metadata.as_deref().map(metadata).transpose()?;
        let ouster = read.as_ref().or(match asked {
            Some(Asked::Ouster(sensor)) => Some(sensor),
            _ => None,
        });
        let file = match asked {
            Some(Asked::File(grid)) => Some(grid.clone()),
            _ => None,
        };
        let sensor = ouster.map_or(Sensor::Auto, |sensor| Sensor::Ouster(sensor.format));
        Ok(Self {
            path: path.into(),
            datagrams: Capture::open(path)?,
            assembler: TurnAssembler::new(sensor, args.returns.into()),
            ouster: ouster.map(|sensor| Rc::new(OwnedGrid::new(&sensor.grid()))),
            identity: ouster.map(|sensor| OusterIdentity { format: sensor.format, serial: sensor.serial_number }),
            file,
            turning: None,
            open: Default::default(),
            ready: VecDeque::new(),
            ended: 0,
            port: None,
            elsewhere: 0,
            source: args.source,
            other_source: None,
            broken: None,
            contradiction: None,
            failure: None,
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
        let others = self.other_source.map(|(source, count)| {
            let count = grouped(count);
            format!(
                "{count} datagrams to the same port from {source} and others: not used (--source {source} takes it)"
            )
        });
        let broken = self.broken.as_ref().map(|error| match error {
            FileError::Parse { error, .. } => format!("not read to its end: {error}"),
            error => format!("not read to its end: {error}"),
        });
        let damaged = self.damaged_frames();
        for more in [others, damaged, broken, self.contradiction.clone()].into_iter().flatten() {
            let gap = if text.is_empty() { "" } else { "; " };
            let _ = write!(text, "{gap}{more}");
        }
        (!text.is_empty()).then_some(text)
    }

    /// Frames that hold less than their headers say: what their datagrams were is not known.
    fn damaged_frames(&self) -> Option<String> {
        let count = self.datagrams.damaged();
        (count > 0).then(|| format!("{} frames cut short or damaged: not used", grouped(count)))
    }

    fn push(&mut self, Datagram { source, port, payload }: &Datagram) {
        if self.port.is_some_and(|known| known != *port) {
            self.elsewhere += 1;
            return;
        }
        // Turns of two sensors must never be mixed.
        if self.source.is_some_and(|known| known != *source) {
            self.other_source.get_or_insert((*source, 0)).1 += 1;
            return;
        }
        let (open, mut ended) = (&mut self.open, Vec::new());
        let pushed = self.assembler.push(payload, |event| take(event, open, &mut ended));
        match pushed {
            Ok(()) => {
                (self.port, self.source) = (Some(*port), Some(*source));
                if let (Some(identity), None) = (&self.identity, &self.contradiction) {
                    self.contradiction = identity.contradiction(payload);
                }
            }
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

    fn end(&mut self, ended: Vec<([Open; 2], Turn)>) {
        for ([first, second], turn) in ended {
            let sensor = match self.sensor(&first) {
                Ok(Some(sensor)) => sensor,
                Ok(None) => continue,
                Err(failure) => {
                    (self.failure, self.is_over) = (Some(failure), true);
                    return;
                }
            };
            let second = (!second.ticks.is_empty()).then_some(Open {
                begins_late: first.begins_late,
                blind: first.blind,
                ..second
            });
            self.ready.push_back(scan(first, turn, sensor.clone(), self.ended, 0));
            self.ready.extend(second.map(|second| scan(second, turn, sensor, self.ended, 1)));
            self.ended += 1;
        }
    }

    /// The grid on which a turn's returns lie. A motor that keeps its rate within a hundredth keeps its grid.
    fn sensor(&mut self, open: &Open) -> Result<Option<Rc<OwnedGrid>>, Failure> {
        if let Some(sensor) = self.ouster.clone() {
            return self.checked_file(&sensor).map(|file| Some(file.unwrap_or(sensor)));
        }
        let Some(model) = self.assembler.model() else { return Ok(None) };
        let rate = turns_per_minute(model, open.step_q8());
        let grid = match &self.turning {
            Some((known, grid)) if 100 * rate.abs_diff(*known) <= *known => grid.clone(),
            _ => {
                let Some(geometry) = geometry(model) else { return Ok(None) };
                let grid = Rc::new(turning(geometry, rate));
                self.turning = Some((rate, grid.clone()));
                grid
            }
        };
        self.checked_file(&grid).map(|file| Some(file.unwrap_or(grid)))
    }

    /// The sensor file's grid, where one was asked for: it must be of a sensor like the packets', of which it may lack
    /// beams.
    fn checked_file(&self, packets: &OwnedGrid) -> Result<Option<Rc<OwnedGrid>>, Failure> {
        let Some(file) = &self.file else { return Ok(None) };
        if file.counts_as(packets)
            && let Some(file) = file.completed(packets)
        {
            return Ok(Some(Rc::new(on_ticks_of(packets, &file))));
        }
        let (found, expected) = (file.grid(), packets.grid());
        let say = |grid: &SensorGrid<'_>| {
            let (beams, ticks, unit_m) = (grid.beams.len(), grid.ticks, grid.range_unit_m);
            format!("{} ({beams} beams, {ticks} ticks, range unit {unit_m} m)", grid.name)
        };
        let (found, expected) = (say(&found), say(&expected));
        Err(Failure::usage(
            &self.path,
            format_args!("found --sensor {found}, expected one like the packets' {expected}"),
        ))
    }

    /// Where not one packet was understood.
    fn nothing(&self) -> Failure {
        let found = match (&self.refusal, self.stats().refused()) {
            (None, _) if let (Some(source), Some(_)) = (self.source, self.other_source) => {
                format!("found no packet from {source}")
            }
            (Some(refusal), count) => format!("found {} other packets (the first: {refusal})", grouped(count.into())),
            (None, _) => {
                let damaged = self.damaged_frames().map_or_else(String::new, |damaged| format!(" ({damaged})"));
                format!("found no UDP packet among {} frames{damaged}", grouped(self.datagrams.others()))
            }
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
            if let Some(failure) = self.failure.take() {
                return Some(Err(failure));
            }
            if self.is_over {
                return None;
            }
            match self.datagrams.next() {
                Some(Ok(datagram)) => self.push(&datagram),
                // What was read before is as good as ever.
                Some(Err(error)) => {
                    self.is_over = true;
                    if self.stats().used == 0 {
                        return Some(Err(error.into()));
                    }
                    self.broken = Some(error);
                    self.finish();
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

/// A sensor file's beams by the packets' ticks.
///
/// A file knows a beam's azimuth from points, and so but for whole ticks; how many these are, the packets' sensor tells.
fn on_ticks_of(packets: &OwnedGrid, file: &OwnedGrid) -> OwnedGrid {
    let tick_rad = std::f32::consts::TAU / packets.grid().ticks as f32;
    let nearest = |(known, found): (&Beam, &Beam)| {
        let off_rad = found.azimuth_phase_rad - known.azimuth_phase_rad;
        let azimuth_phase_rad = found.azimuth_phase_rad - (off_rad / tick_rad).round() * tick_rad;
        Beam { azimuth_phase_rad, ..*found }
    };
    let beams: Vec<Beam> = packets.grid().beams.iter().zip(file.grid().beams).map(nearest).collect();
    let SensorGrid { name, range_from_axis, .. } = file.grid();
    OwnedGrid::new(&SensorGrid { name, beams: &beams, range_from_axis, ..packets.grid() })
}

/// What an Ouster's packets can be compared with.
struct OusterIdentity {
    format: OusterFormat,
    serial: Option<u64>,
}

impl OusterIdentity {
    /// How a packet of the right length shows that the metadata are another sensor's, or of another mode.
    fn contradiction(&self, packet: &[u8]) -> Option<String> {
        let serial = self.format.serial_number(packet).zip(self.serial).filter(|(found, expected)| found != expected);
        if let Some((found, expected)) = serial {
            return Some(format!("the packets are of sensor {found}, but the metadata of sensor {expected}"));
        }
        let (found, expected) = (self.format.columns_by_encoder(packet)?, u32::from(self.format.columns_per_frame));
        (found != expected)
            .then(|| format!("the packets' encoder makes {found} columns a turn, but the metadata say {expected}"))
    }
}

fn take(event: Event<'_>, open: &mut [Open; 2], ended: &mut Vec<([Open; 2], Turn)>) {
    match event {
        Event::Column(column) => open[usize::from(column.layer != 0)].add(&column),
        Event::Gap { cause: GapCause::Start, .. } => open[0].begins_late = true,
        Event::Gap { cause: GapCause::Blind, columns } => open[0].blind += columns,
        Event::TurnEnd(turn) => ended.push((std::mem::take(open), turn)),
        _ => {}
    }
}

fn scan(mut open: Open, turn: Turn, sensor: Rc<OwnedGrid>, number: usize, layer: u8) -> Scan {
    let grid = sensor.grid();
    let reaches_end = open
        .ticks
        .last()
        .is_some_and(|&last| u64::from(last) + open.step_q8().max(256) * 2 / 256 > u64::from(grid.ticks));
    let is_whole = !open.begins_late && (turn.end == TurnCut::Wrap || reaches_end);
    let point = |found: &GridReturn| grid.position(found.row.into(), found.tick, found.count).unwrap_or_default();
    let cloud = PointCloud {
        points: open.returns.iter().map(point).map(|point| point.map(|v| v as f32)).collect(),
        intensities: Some(std::mem::take(&mut open.intensities)),
        rings: Some(open.returns.iter().map(|found| found.row).collect()),
    };
    let timestamp_ns = open.time_ns.unwrap_or(0);
    let Open { returns, ticks, times_ns, blind, .. } = open;
    let missing = turn.missing;
    let turn = CapturedTurn { sensor, returns, ticks, times_ns, number, missing, blind, is_whole, layer };
    Scan { cloud, timestamp_ns, turn: Some(turn) }
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
