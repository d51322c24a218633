//! Sensors by name or file, and which of them a scan is of.

use std::fs;
use std::path::Path;
use std::rc::Rc;

use flicr::geometry::sensors::ouster::OusterSensor;
use flicr::geometry::sensors::{self, SensorGeometry, hdl64e, hesai, robosense, velodyne};
use flicr::geometry::{Beam, SensorGrid};
use flicr::sensor::Sensor;

use crate::failure::Failure;

/// A sensor's grid with its beams.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnedGrid {
    name: String,
    beams: Vec<Beam>,
    /// Everything else; its name and beams are none.
    rest: SensorGrid<'static>,
}

impl OwnedGrid {
    pub fn new(grid: &SensorGrid<'_>) -> Self {
        let SensorGrid { name, beams, ticks, clockwise, zero_rad, range_unit_m, range_from_axis } = *grid;
        let rest = SensorGrid { name: "", beams: &[], ticks, clockwise, zero_rad, range_unit_m, range_from_axis };
        Self { name: name.to_owned(), beams: beams.to_vec(), rest }
    }

    pub fn with_beams(&self, beams: Vec<Beam>) -> Self {
        Self { beams, ..self.clone() }
    }

    pub fn grid(&self) -> SensorGrid<'_> {
        SensorGrid { name: &self.name, beams: &self.beams, ..self.rest }
    }

    /// Whether it counts azimuths and ranges as another does.
    pub fn counts_as(&self, other: &Self) -> bool {
        self.rest.ticks == other.rest.ticks && (self.rest.range_unit_m - other.rest.range_unit_m).abs() < 1e-6
    }

    /// With a designed beam in each row that this one lacks: calibration does not see a beam that nothing came back from.
    /// `None` where beams are not the design's: two in one row, or few of them.
    pub fn completed(&self, design: &Self) -> Option<Self> {
        let mut beams = design.beams.clone();
        if self.beams.len() == beams.len() {
            return Some(self.clone());
        }
        for (row, beam) in self.rows_in(design)?.into_iter().zip(&self.beams) {
            beams[row] = *beam;
        }
        Some(self.with_beams(beams))
    }

    /// The design's beams that this one lacks; `None` as of [`completed`](Self::completed).
    pub fn unseen(&self, design: &Self) -> Option<Vec<Beam>> {
        let rows = self.rows_in(design)?;
        let beams = design.beams.iter().enumerate();
        Some(beams.filter(|(row, _)| !rows.contains(row)).map(|(_, beam)| *beam).collect())
    }

    /// The design's row that each beam is nearest to.
    fn rows_in(&self, design: &Self) -> Option<Vec<usize>> {
        let off = |row: usize, beam: &Beam| (design.beams[row].slope - beam.slope).abs();
        let nearest =
            |beam| (0..design.beams.len()).min_by(|&a: &usize, &b: &usize| off(a, beam).total_cmp(&off(b, beam)));
        let rows: Vec<usize> = self.beams.iter().map(nearest).collect::<Option<_>>()?;
        let is_most = 2 * rows.len() > design.beams.len();
        (is_most && rows.is_sorted_by(|a, b| a < b)).then_some(rows)
    }

    /// Whether decoders know it without being told.
    pub fn is_known(&self) -> bool {
        let checksum = self.grid().checksum();
        sensors::ALL.iter().any(|known| known.checksum() == checksum)
    }
}

/// A sensor whose beams fire one after another, as they look at a rotation rate.
pub fn turning(geometry: &SensorGeometry, turns_per_minute: u32) -> OwnedGrid {
    let mut beams = geometry.beams.to_vec();
    let _ = geometry.fill_beams_at(turns_per_minute, &mut beams);
    OwnedGrid::new(&geometry.grid_of(&beams))
}

/// What most of them turn at.
const TURNS_PER_MINUTE: u32 = 600;

const TURNING: [(&str, &SensorGeometry); 9] = [
    ("hdl32e", &velodyne::HDL32E),
    ("vlp16", &velodyne::VLP16),
    ("puck-hi-res", &velodyne::PUCK_HI_RES),
    ("vlp32c", &velodyne::VLP32C),
    ("vls128", &velodyne::VLS128),
    ("pandar40p", &hesai::PANDAR40P),
    ("pandar64", &hesai::PANDAR64),
    ("xt32", &hesai::PANDAR_XT32),
    ("helios16p", &robosense::HELIOS16P),
];

/// The built-in sensor whose grid has this checksum, and the rate at which it turns where its grid depends on that.
pub fn by_checksum(checksum: u32) -> Option<String> {
    if let Some(grid) = sensors::ALL.iter().find(|grid| grid.checksum() == checksum) {
        return Some(grid.name.to_owned());
    }
    // From the usual rates on: as far as motors are built for.
    TURNING.iter().find_map(|(_, geometry)| {
        let rate = (1..=2400).find(|&rate| turning(geometry, rate).grid().checksum() == checksum)?;
        Some(format!("{} at {rate} turns a minute", turning(geometry, rate).name))
    })
}

/// What sensors are called on the command line.
fn names() -> String {
    let turning = TURNING.map(|(name, _)| name);
    ["hdl64e"].iter().chain(&turning).copied().collect::<Vec<_>>().join(", ")
}

/// All built-in sensors.
pub fn built_in() -> Vec<Rc<OwnedGrid>> {
    let turning = TURNING.iter().map(|(_, geometry)| turning(geometry, TURNS_PER_MINUTE));
    std::iter::once(OwnedGrid::new(&hdl64e::GRID)).chain(turning).map(Rc::new).collect()
}

/// Of the built-in sensor that a calibrated one is but for beams that nothing came back from: its name, how many beams it
/// has, and those.
pub fn unseen(calibrated: &OwnedGrid) -> Option<(String, usize, Vec<Beam>)> {
    let alike = || built_in().into_iter().filter(|design| calibrated.counts_as(design));
    if alike().any(|design| design.beams.len() == calibrated.beams.len()) {
        return None;
    }
    let found = alike().filter_map(|design| Some((calibrated.unseen(&design)?, design)));
    let (beams, design) = found.min_by_key(|(beams, _)| beams.len())?;
    (!beams.is_empty()).then(|| (design.grid().name.to_owned(), design.beams.len(), beams))
}

/// A sensor that was asked for.
#[derive(Debug, Clone)]
pub enum Asked {
    Grid(Rc<OwnedGrid>),
    /// From a sensor file: measured on one unit, so better than the built-in numbers of its model.
    File(Rc<OwnedGrid>),
    /// From an Ouster's metadata, which also says how to read its packets.
    Ouster(Rc<OusterSensor>),
}

impl Asked {
    /// By a built-in sensor's name, or from a sensor file or an Ouster's metadata.
    pub fn named(name: &str) -> Result<Self, Failure> {
        let bare = |text: &str| text.to_lowercase().replace(['-', '_', ' '], "");
        if bare(name) == "hdl64e" {
            return Ok(Self::Grid(Rc::new(OwnedGrid::new(&hdl64e::GRID))));
        }
        if let Some((_, geometry)) = TURNING.iter().find(|(known, _)| bare(known) == bare(name)) {
            return Ok(Self::Grid(Rc::new(turning(geometry, TURNS_PER_MINUTE))));
        }
        let path = Path::new(name);
        match path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase).as_deref() {
            Some("toml") => sensor_file(path),
            Some("json") => metadata(path).map(|sensor| Self::Ouster(Rc::new(sensor))),
            _ => {
                let names = names();
                let wrong = format!("no such sensor: expected auto, {names}, or a file that ends in .toml or .json");
                Err(Failure::Usage(format!("{name}: {wrong}")))
            }
        }
    }

    pub fn grid(&self) -> Rc<OwnedGrid> {
        match self {
            Self::Grid(grid) | Self::File(grid) => grid.clone(),
            Self::Ouster(sensor) => Rc::new(OwnedGrid::new(&sensor.grid())),
        }
    }
}

fn sensor_file(path: &Path) -> Result<Asked, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::data(path, error))?;
    let sensor = Sensor::from_toml(&text).map_err(|error| Failure::data(path, error))?;
    sensor.grid().check().map_err(|error| Failure::data(path, error))?;
    Ok(Asked::File(Rc::new(OwnedGrid::new(&sensor.grid()))))
}

/// An Ouster as its metadata describes it.
pub fn metadata(path: &Path) -> Result<OusterSensor, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::data(path, error))?;
    let sensor = OusterSensor::from_json(&text).map_err(|error| Failure::data(path, error))?;
    sensor.grid().check().map_err(|error| Failure::data(path, error))?;
    Ok(sensor)
}
