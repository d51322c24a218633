//! The sensor file: TOML, one line a beam, exact for every `f32`.

use std::borrow::ToOwned as _;
use std::format;
use std::string::String;
use std::vec::Vec;

use core::fmt::{self, Write as _};

use serde::Deserialize;

use super::{Beam, Sensor};
use crate::geometry::SensorGrid;

/// The layout this version reads and writes.
const FORMAT: u32 = 1;
/// Why a sensor file was not read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SensorFileError {
    /// Not TOML, or a field is missing, unknown or of the wrong type.
    Syntax {
        /// Line of the trouble, from 1; 0 if the parser names none.
        line: usize,
        /// Column of the trouble, from 1; 0 if the parser names none.
        column: usize,
        /// What the parser found and expected, with the field's name.
        message: String,
    },
    /// A number is outside what a sensor can have.
    Value {
        /// Line of the number, from 1.
        line: usize,
        /// Name of the field.
        field: &'static str,
        /// Index of the beam, if the field is a beam's.
        beam: Option<usize>,
        /// What stands there.
        found: f64,
        /// What may stand there, in words.
        expected: String,
    },
}

impl fmt::Display for SensorFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Syntax { line, column, message } => {
                write!(f, "line {line}, column {column}: {}", message.trim_end())
            }
            Self::Value { line, field, beam, found, expected } => {
                write!(f, "line {line}: {field}")?;
                if let Some(beam) = beam {
                    write!(f, " of beam {beam}")?;
                }
                write!(f, " is {found}, expected {expected}")
            }
        }
    }
}

impl core::error::Error for SensorFileError {}

/// A value that remembers the line it stood on.
type Spanned<T> = toml::Spanned<T>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorFile {
    format: Spanned<u32>,
    name: String,
    ticks_per_turn: Spanned<u32>,
    range_unit_m: Spanned<f32>,
    #[serde(default)]
    range_from_axis: bool,
    beams: Spanned<Vec<BeamLine>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BeamLine {
    slope: Spanned<f32>,
    z_offset_m: Spanned<f32>,
    h_offset_m: Spanned<f32>,
    azimuth_phase_rad: Spanned<f32>,
    range_phase_m: Spanned<f32>,
}

impl Sensor {
    /// Reads a sensor file.
    ///
    /// ```
    /// let text = r#"
    /// format = 1
    /// name = "two beams"
    /// ticks_per_turn = 4000
    /// range_unit_m = 0.002
    /// beams = [
    ///   { slope = 0.1, z_offset_m = 0.2, h_offset_m = 0.026, azimuth_phase_rad = 0, range_phase_m = 0 },
    ///   { slope = 0.0, z_offset_m = 0.2, h_offset_m = -0.026, azimuth_phase_rad = 0, range_phase_m = 0 },
    /// ]
    /// "#;
    /// let sensor = flicr::sensor::Sensor::from_toml(text).unwrap();
    /// assert_eq!(sensor.beams[1].h_offset_m, -0.026);
    ///
    /// let error = flicr::sensor::Sensor::from_toml(&text.replace("4000", "0")).unwrap_err();
    /// assert_eq!(error.to_string(), "line 4: ticks_per_turn is 0, expected 1 to 1048576");
    /// ```
    ///
    /// # Errors
    /// [`SensorFileError::Syntax`] for text that is not TOML or not these fields,
    /// [`SensorFileError::Value`] for numbers that no sensor has.
    pub fn from_toml(text: &str) -> Result<Self, SensorFileError> {
        let file: SensorFile = toml::from_str(text).map_err(|error| syntax(text, &error))?;
        check_head(text, &file)?;
        let lines = file.beams.into_inner();
        let beams = lines.iter().enumerate().map(|(index, line)| line.check(text, index));
        let beams = beams.collect::<Result<_, _>>()?;
        check_order(text, &lines)?;
        Ok(Self {
            beams,
            name: file.name,
            ticks_per_turn: file.ticks_per_turn.into_inner(),
            range_unit_m: file.range_unit_m.into_inner(),
            range_from_axis: file.range_from_axis,
        })
    }

    /// Writes a sensor file; [`Sensor::from_toml`] gives back the same bits.
    ///
    /// The fields are written as they are: only a sensor that `from_toml` would
    /// accept (finite numbers in range) makes a file that it will read.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!(
            "# A LiDAR's own grid. One line a beam, the highest first; slope = tan(elevation).\n\
             format = {FORMAT}\nname = {}\nticks_per_turn = {}\nrange_unit_m = {}\n{}beams = [\n",
            quoted(&self.name),
            self.ticks_per_turn,
            decimal(self.range_unit_m),
            if self.range_from_axis { "range_from_axis = true\n" } else { "" },
        );
        for beam in &self.beams {
            let _ = writeln!(
                text,
                "  {{ slope = {}, z_offset_m = {}, h_offset_m = {}, azimuth_phase_rad = {}, range_phase_m = {} }},",
                decimal(beam.slope),
                decimal(beam.z_offset_m),
                decimal(beam.h_offset_m),
                decimal(beam.azimuth_phase_rad),
                decimal(beam.range_phase_m),
            );
        }
        text.push_str("]\n");
        text
    }
}

// The limits are those of `SensorGrid::check`: what is read can be encoded with.
fn check_head(text: &str, file: &SensorFile) -> Result<(), SensorFileError> {
    let value = |offset: usize, field, found: f64, expected: String| {
        Err(SensorFileError::Value { line: line_of(text, offset), field, beam: None, found, expected })
    };
    let (format, ticks) = (*file.format.get_ref(), *file.ticks_per_turn.get_ref());
    let (unit_m, beam_count) = (*file.range_unit_m.get_ref(), file.beams.get_ref().len());
    let (ticks_max, unit_max_m, beams_max) =
        (SensorGrid::TICKS_MAX, SensorGrid::RANGE_UNIT_MAX_M, SensorGrid::BEAMS_MAX);
    if format != FORMAT {
        return value(file.format.span().start, "format", f64::from(format), format!("{FORMAT}"));
    }
    if !(1..=ticks_max).contains(&ticks) {
        let expected = format!("1 to {ticks_max}");
        return value(file.ticks_per_turn.span().start, "ticks_per_turn", f64::from(ticks), expected);
    }
    if !(unit_m > 0.0 && unit_m <= unit_max_m) {
        let expected = format!("over 0, up to {unit_max_m}");
        return value(file.range_unit_m.span().start, "range_unit_m", f64::from(unit_m), expected);
    }
    if !(1..=beams_max).contains(&beam_count) {
        let expected = format!("1 to {beams_max}");
        return value(file.beams.span().start, "number of beams", beam_count as f64, expected);
    }
    Ok(())
}

/// Refuses a beam that is not below the one before.
fn check_order(text: &str, lines: &[BeamLine]) -> Result<(), SensorFileError> {
    let slope = |line: &BeamLine| *line.slope.get_ref();
    let falls = |pair: &[BeamLine]| slope(&pair[1]) < slope(&pair[0]);
    let Some(before) = lines.windows(2).position(|pair| !falls(pair)) else { return Ok(()) };
    let wrong = &lines[before + 1].slope;
    Err(SensorFileError::Value {
        line: line_of(text, wrong.span().start),
        field: "slope",
        beam: Some(before + 1),
        found: f64::from(*wrong.get_ref()),
        expected: format!("less than {}, the slope of the beam before", slope(&lines[before])),
    })
}

impl BeamLine {
    fn check(&self, text: &str, beam: usize) -> Result<Beam, SensorFileError> {
        let within = |number: &Spanned<f32>, field, limit: f32| {
            let found = *number.get_ref();
            let line = line_of(text, number.span().start);
            // Written so that NaN fails.
            if found.abs() <= limit {
                Ok(found)
            } else {
                let expected = format!("-{limit} to {limit}");
                Err(SensorFileError::Value { line, field, beam: Some(beam), found: f64::from(found), expected })
            }
        };
        Ok(Beam {
            slope: within(&self.slope, "slope", Beam::SLOPE_MAX)?,
            z_offset_m: within(&self.z_offset_m, "z_offset_m", Beam::Z_OFFSET_MAX_M)?,
            h_offset_m: within(&self.h_offset_m, "h_offset_m", Beam::H_OFFSET_MAX_M)?,
            azimuth_phase_rad: within(&self.azimuth_phase_rad, "azimuth_phase_rad", Beam::AZIMUTH_PHASE_MAX_RAD)?,
            range_phase_m: within(&self.range_phase_m, "range_phase_m", Beam::RANGE_PHASE_MAX_M)?,
        })
    }
}

fn syntax(text: &str, error: &toml::de::Error) -> SensorFileError {
    let start = error.span().map(|span| span.start.min(text.len()));
    let line = start.map_or(0, |start| line_of(text, start));
    let line_start = start.and_then(|start| text.as_bytes()[..start].iter().rposition(|&b| b == b'\n'));
    let column = start.map_or(0, |start| start - line_start.map_or(0, |at| at + 1) + 1);
    SensorFileError::Syntax { line, column, message: error.message().to_owned() }
}

fn line_of(text: &str, offset: usize) -> usize {
    let before = &text.as_bytes()[..offset.min(text.len())];
    1 + before.split(|&byte| byte == b'\n').skip(1).count()
}

#[allow(clippy::cast_possible_truncation, reason = "f64 -> f32 is the rounding that reading does")]
/// The shortest decimal that reads back as the same bits.
///
/// TOML numbers are `f64`; rounding a decimal twice can miss by one, so the
/// short form is tried and the exact one kept for when it fails.
fn decimal(value: f32) -> String {
    let shortest = format!("{value:?}");
    let back = shortest.parse::<f64>().map(|wide| (wide as f32).to_bits());
    if back == Ok(value.to_bits()) { shortest } else { format!("{:?}", f64::from(value)) }
}

/// A TOML basic string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            control if control.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(control));
            }
            plain => quoted.push(plain),
        }
    }
    quoted.push('"');
    quoted
}
