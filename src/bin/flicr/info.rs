//! `flicr info`: what a file holds.

mod capture;

use std::path::{Path, PathBuf};

use clap::Args;
use flicr::files::{self, PointCloud};
use flicr::frame::{ColumnMode, ParsedFrame, STRIP_HEADER_LEN, UniformHeader};
use flicr::plane::{IntensityScale, SECTION_HEADER_LEN, SectionKind};
use flicr::{Companding, Decoder, Frame, Geometry, Header, Levels, Limits, Placement, frame};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::capture::CaptureArgs;
use crate::failure::Failure;
use crate::frames::FrameFile;
use crate::input::{self, Scan};
use crate::sensors::by_checksum;
use crate::{console, table};
use capture::CaptureInfo;

/// Say what a file of frames or points holds; frames are decoded, so that damage is found
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Info {
    /// A .flicr file, a scan (.bin, .xyzir.bin or .pcd) or a capture (.pcap or .pcapng)
    input: PathBuf,
    /// One JSON object a frame, each on a line
    #[arg(long)]
    json: bool,
    /// An Ouster's metadata (.json), for its captures
    #[arg(long, value_name = "FILE")]
    metadata: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  flicr info drive.flicr
  flicr info turns.pcap
  flicr info drive.flicr --json | jq .kept";

impl Info {
    pub fn run(self) -> Result<(), Failure> {
        if input::holds_frames(&self.input)? {
            return self.frames();
        }
        input::check_scan_extension(&self.input)?;
        if input::is_capture(&self.input) {
            let args = CaptureArgs { metadata: self.metadata.clone(), ..CaptureArgs::default() };
            return self.say(&CaptureInfo::new(&self.input, &args)?, CaptureInfo::text);
        }
        self.say(&CloudInfo::new(&self.input, files::read(&self.input)?), CloudInfo::text)
    }

    fn frames(&self) -> Result<(), Failure> {
        let file = FrameFile::read(&self.input)?;
        let mut decoder = Decoder::new(Limits::default());
        for (number, offset, bytes) in file.frames() {
            let info = FrameInfo::new(&mut decoder, bytes).map_err(|error| file.damaged(number, error))?;
            let place = Place { file: self.input.display().to_string(), frame: number, offset, bytes: bytes.len() };
            self.say(&FrameInfo { place, ..info }, FrameInfo::text)?;
        }
        file.check_end()
    }

    fn say<T: Serialize>(&self, info: &T, text: impl Fn(&T) -> String) -> Result<(), Failure> {
        let text = if self.json { json(info) } else { text(info) };
        console::line(&ProgressBar::hidden(), text)
    }
}

/// One line of JSON.
pub fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_else(|error| format!("{{\"error\":\"{error}\"}}"))
}

#[derive(Debug, Default, Serialize)]
struct Place {
    file: String,
    frame: usize,
    offset: usize,
    bytes: usize,
}

/// Where pixels lie.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum GeometryInfo {
    Uniform {
        top_deg: f32,
        bottom_deg: f32,
        start_deg: f32,
        span_deg: f32,
        placement: &'static str,
    },
    Beams {
        sensor: String,
        ticks: u32,
        clockwise: bool,
        range_unit_m: f32,
        range_from_axis: bool,
        /// Bytes of the list of firings; null where columns are evenly spread.
        firings_len: Option<u16>,
        /// None where it was not measured.
        point_bound_m: Option<f32>,
    },
    Other,
}

impl GeometryInfo {
    fn new(geometry: Geometry) -> Self {
        match geometry {
            Geometry::Uniform(UniformHeader { view, placement }) => Self::Uniform {
                top_deg: view.top_rad.to_degrees(),
                bottom_deg: view.bottom_rad.to_degrees(),
                start_deg: view.start_rad.to_degrees(),
                span_deg: view.span_rad.to_degrees(),
                placement: placement_word(placement),
            },
            Geometry::Beams(beams) => Self::Beams {
                sensor: sensor_name(beams.sensor),
                ticks: beams.ticks,
                clockwise: beams.clockwise,
                range_unit_m: beams.range_unit_m,
                range_from_axis: beams.range_from_axis,
                firings_len: firings_len(beams.column_mode),
                point_bound_m: Some(beams.point_bound_m).filter(|bound_m| bound_m.is_finite()),
            },
            _ => Self::Other,
        }
    }

    fn text(&self, rows: u16, columns: u16, range_bound_m: f32) -> String {
        match self {
            Self::Uniform { top_deg, bottom_deg, start_deg, span_deg, placement } => format!(
                "{rows} rows from {top_deg:+.2} to {bottom_deg:+.2} degrees, {columns} columns from {start_deg:+.2} over {span_deg:.2} degrees\n  \
                 points at the {placement} of their pixels, ranges within {range_bound_m:.4} m"
            ),
            Self::Beams { sensor, ticks, point_bound_m, firings_len, .. } => {
                let bound = point_bound_m.map_or_else(String::new, |bound_m| format!(", points within {bound_m:.4} m"));
                let columns = match firings_len {
                    Some(len) => format!("{columns} firings at some of its {ticks} ticks (a list of {len} bytes)"),
                    None => format!("{columns} columns over its {ticks} ticks"),
                };
                format!("{rows} beams of {sensor}, {columns}\n  ranges within {range_bound_m:.4} m{bound}")
            }
            Self::Other => format!("{rows} rows, {columns} columns"),
        }
    }
}

const fn firings_len(mode: ColumnMode) -> Option<u16> {
    match mode {
        ColumnMode::Firings { list_len, .. } => Some(list_len),
        _ => None,
    }
}

/// The name of a built-in sensor, else the checksum of its grid.
fn sensor_name(sensor: u32) -> String {
    by_checksum(sensor).unwrap_or_else(|| format!("sensor {sensor:08x}"))
}

#[derive(Debug, Serialize)]
struct FrameInfo {
    #[serde(flatten)]
    place: Place,
    sequence: u32,
    timestamp_ns: u64,
    rows: u16,
    columns: u16,
    #[serde(flatten)]
    geometry: GeometryInfo,
    bits: u32,
    /// Whether levels go by the square root of ranges: then the step is the first level's.
    square_root: bool,
    step_m: f32,
    max_range_m: f32,
    range_bound_m: f32,
    coder: String,
    strips: usize,
    returns: u32,
    kept: usize,
    /// Bytes of the coded ranges.
    ranges_len: usize,
    sections: Vec<SectionInfo>,
}

/// What a frame carries besides ranges.
#[derive(Debug, Serialize)]
struct SectionInfo {
    kind: &'static str,
    bytes: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<ScaleInfo>,
    /// Frames since the key frame, 0 for one itself, and the key frame's sequence number.
    #[serde(skip_serializing_if = "Option::is_none")]
    since_key: Option<[u32; 2]>,
}

#[derive(Debug, Serialize)]
struct ScaleInfo {
    per_unit: f32,
    step: u8,
}

impl SectionInfo {
    /// Those of a frame, each with its head.
    fn all(parsed: &ParsedFrame<'_>, frame: &Frame<'_>) -> Result<Vec<Self>, flicr::DecodeError> {
        let link = parsed.link()?.map(|link| [link.distance, link.key]);
        let info = |section: Result<(SectionKind, &[u8]), _>| {
            section.map(|(kind, body)| Self {
                kind: section_word(kind),
                bytes: SECTION_HEADER_LEN + body.len(),
                scale: frame
                    .intensity_plane()
                    .filter(|_| kind == SectionKind::Intensity)
                    .map(|(_, scale)| scale.into()),
                since_key: link.filter(|_| kind == SectionKind::Previous),
            })
        };
        parsed.sections().map(info).collect()
    }

    fn text(&self) -> String {
        let scale = self.scale.as_ref().map_or_else(String::new, |ScaleInfo { per_unit, step }| {
            format!(" (numbers of 8 bits, {per_unit} for 1, in steps of {step})")
        });
        let link = self.since_key.map_or_else(String::new, |[distance, key]| match distance {
            0 => " (a key frame)".to_owned(),
            _ => format!(" (frame {distance} since key frame {key})"),
        });
        format!("{} {} bytes{scale}{link}", self.kind, group(self.bytes))
    }
}

impl From<IntensityScale> for ScaleInfo {
    fn from(scale: IntensityScale) -> Self {
        Self { per_unit: scale.per_unit(), step: scale.step() }
    }
}

const fn section_word(kind: SectionKind) -> &'static str {
    match kind {
        SectionKind::Intensity => "intensity",
        SectionKind::Times => "times",
        SectionKind::Original => "original",
        SectionKind::Previous => "previous",
        _ => "other",
    }
}

impl FrameInfo {
    fn new(decoder: &mut Decoder, bytes: &[u8]) -> Result<Self, flicr::DecodeError> {
        let parsed = frame::parse(bytes)?;
        let (strips, ranges_len) = parsed
            .strips()
            .flatten()
            .fold((0, 0), |(count, len), strip| (count + 1, len + STRIP_HEADER_LEN + strip.payload.len()));
        let frame = decoder.decode(bytes)?;
        let Header { sequence, timestamp_ns, rows, columns, quantizer, coder, returns, geometry, .. } = *frame.header();
        Ok(Self {
            place: Place::default(),
            sequence,
            timestamp_ns,
            rows,
            columns,
            geometry: GeometryInfo::new(geometry),
            bits: quantizer.level_bits(),
            square_root: quantizer.companding() == Companding::SquareRoot,
            step_m: quantizer.step_m(),
            max_range_m: quantizer.max_range_m(),
            range_bound_m: frame.header().range_bound_m(),
            coder: format!("{coder:?}").to_lowercase(),
            strips,
            returns,
            kept: occupied(frame.levels()),
            ranges_len,
            sections: SectionInfo::all(&parsed, &frame)?,
        })
    }

    fn text(&self) -> String {
        let Self { place: Place { file, frame, offset, bytes }, rows, columns, coder, .. } = self;
        let mut parts = vec![format!("ranges {} bytes", group(self.ranges_len))];
        parts.extend(self.sections.iter().map(SectionInfo::text));
        let lines = [
            format!("{file}: frame {frame}, {} bytes from byte {}", group(*bytes), group(*offset)),
            format!("sequence {}, time {} ns", self.sequence, self.timestamp_ns),
            self.geometry.text(*rows, *columns, self.range_bound_m),
            self.levels_text(),
            format!("coder {coder}, strips {}", self.strips),
            parts.join(", "),
            format!("{} returns, {} kept", group(self.returns as usize), group(self.kept)),
        ];
        lines.join("\n  ")
    }
}

impl FrameInfo {
    fn levels_text(&self) -> String {
        let Self { bits, step_m, max_range_m, .. } = self;
        let how = if self.square_root { "by the square root of ranges, the first at" } else { "in steps of" };
        format!("{bits} bits {how} {step_m:.4} m, up to {max_range_m:.2} m")
    }
}

const fn placement_word(placement: Placement) -> &'static str {
    match placement {
        Placement::Center => "center",
        Placement::Corner => "corner",
    }
}

fn occupied(levels: &Levels) -> usize {
    match levels {
        Levels::U8(levels) => levels.iter().filter(|&&level| level != 0).count(),
        Levels::U16(levels) => levels.iter().filter(|&&level| level != 0).count(),
    }
}

fn group(number: usize) -> String {
    table::grouped(number as u64)
}

#[derive(Debug, Serialize)]
struct CloudInfo {
    file: String,
    points: usize,
    returns: usize,
    intensities: bool,
    rings: bool,
    /// Smallest and largest x, y, z of the returns; null without any.
    min_m: Option<[f32; 3]>,
    max_m: Option<[f32; 3]>,
    max_range_m: f32,
}

impl CloudInfo {
    fn new(file: &Path, cloud: PointCloud) -> Self {
        let (intensities, rings) = (cloud.intensities.is_some(), cloud.rings.is_some());
        let scan = Scan { cloud, ..Scan::default() };
        let returns = scan.returns();
        let extreme = |pick: fn(f32, f32) -> f32| {
            returns.iter().copied().reduce(|a, b| [pick(a[0], b[0]), pick(a[1], b[1]), pick(a[2], b[2])])
        };
        Self {
            file: file.display().to_string(),
            points: scan.cloud.points.len(),
            returns: returns.len(),
            intensities,
            rings,
            min_m: extreme(f32::min),
            max_m: extreme(f32::max),
            max_range_m: returns.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).fold(0.0, f32::max),
        }
    }

    fn text(&self) -> String {
        let Self { file, points, returns, .. } = self;
        let has = |has: bool| if has { "with" } else { "without" };
        let ([x0, y0, z0], [x1, y1, z1]) = (self.min_m.unwrap_or_default(), self.max_m.unwrap_or_default());
        let lines = [
            format!("{file}: {} points, {} of them returns", group(*points), group(*returns)),
            format!("{} intensities, {} rings", has(self.intensities), has(self.rings)),
            format!("x {x0:.2} to {x1:.2} m, y {y0:.2} to {y1:.2} m, z {z0:.2} to {z1:.2} m"),
            format!("farthest {:.2} m away", self.max_range_m),
        ];
        lines.join("\n  ")
    }
}
