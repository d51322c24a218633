//! Ouster OS0, OS1, OS2: every unit tells its own angles, in its metadata JSON.
//!
//! Frame: the sensor's (x towards the connector's far side, z up, origin at its base), as
//! ouster-sdk's; ticks (measurement ids) grow clockwise. Source of the formulas: Ouster's software
//! user manual, "Coordinate Frames and XYZ Calculation".

use super::{Beam, SensorGrid, Spin};
use crate::packet::{MAX_COLUMNS, MAX_ROWS, OusterFormat, OusterProfile};
use serde_json::Value;
use std::{fmt, string::String, vec::Vec};

/// An Ouster as its metadata describes it.
#[derive(Clone, Debug)]
pub struct OusterSensor {
    /// Product line, such as `OS-1-128`.
    pub name: String,
    /// Serial number (`prod_sn`), where the metadata say it: packets but for legacy ones carry it too.
    pub serial_number: Option<u64>,
    /// How its packets are packed.
    pub format: OusterFormat,
    /// How its columns lie.
    pub spin: Spin,
    /// Its beams, highest first.
    pub beams: Vec<Beam>,
    /// Columns by which each row of a destaggered image is shifted to the right
    /// (`pixel_shift_by_row`).
    pub shift_by_row: Vec<i32>,
}

/// Why metadata could not be used.
#[derive(Debug)]
#[non_exhaustive]
pub enum OusterMetadataError {
    /// It is not JSON.
    Json(serde_json::Error),
    /// This field is missing, or not what it should be.
    Field(&'static str),
    /// No reader for this `udp_profile_lidar`.
    Profile(String),
    /// A list has not one entry a row.
    Rows {
        /// The list.
        field: &'static str,
        /// Its entries.
        found: usize,
        /// Rows of the sensor.
        expected: usize,
    },
}

impl fmt::Display for OusterMetadataError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Json(error) => write!(f, "metadata is not JSON: {error}"),
            Self::Field(field) => write!(f, "metadata has no usable {field}"),
            Self::Profile(name) => write!(f, "unknown lidar profile {name}"),
            Self::Rows { field, found, expected } => write!(f, "{field} has {found} entries for {expected} rows"),
        }
    }
}

impl std::error::Error for OusterMetadataError {}

impl OusterSensor {
    /// Reads the metadata that the sensor, or a recording, comes with: the flat form of firmware 2
    /// or the nested one of firmware 3.
    ///
    /// # Errors
    /// [`OusterMetadataError`], naming what is missing or wrong.
    pub fn from_json(text: &str) -> Result<Self, OusterMetadataError> {
        let json: Value = serde_json::from_str(text).map_err(OusterMetadataError::Json)?;
        let metadata = Metadata(&json);
        let format = metadata.format()?;
        let rows = usize::from(format.rows);
        Ok(Self {
            name: metadata.get("prod_line")?.as_str().unwrap_or("OS").into(),
            serial_number: metadata.get("prod_sn").ok().and_then(serial_number),
            format,
            spin: metadata.spin(&format)?,
            beams: metadata.beams(rows)?,
            shift_by_row: metadata.list("pixel_shift_by_row", rows)?.iter().map(|&shift| shift as i32).collect(),
        })
    }
}

impl OusterSensor {
    /// The sensor's own grid: rows are its beams, ticks its measurement ids.
    #[must_use]
    pub fn grid(&self) -> SensorGrid<'_> {
        let Spin { ticks_per_turn, clockwise, zero_rad, range_unit_m, .. } = self.spin;
        let (name, beams) = (self.name.as_str(), self.beams.as_slice());
        SensorGrid { name, beams, ticks: ticks_per_turn, clockwise, zero_rad, range_unit_m, range_from_axis: false }
    }
}

/// Written as text, for the most part.
fn serial_number(value: &Value) -> Option<u64> {
    value.as_u64().or_else(|| value.as_str()?.parse().ok())
}

struct Metadata<'j>(&'j Value);

impl<'j> Metadata<'j> {
    /// A field at the top or one level below: the two forms differ in that only.
    fn get(&self, field: &'static str) -> Result<&'j Value, OusterMetadataError> {
        let top = self.0.as_object();
        top.and_then(|top| top.get(field))
            .or_else(|| top.and_then(|top| top.values().find_map(|inner| inner.get(field))))
            .ok_or(OusterMetadataError::Field(field))
    }

    fn number(&self, field: &'static str) -> Result<f64, OusterMetadataError> {
        self.get(field)?.as_f64().ok_or(OusterMetadataError::Field(field))
    }

    fn integer<T: TryFrom<u64>>(&self, field: &'static str) -> Result<T, OusterMetadataError> {
        let number = self.get(field)?.as_u64();
        number.and_then(|number| T::try_from(number).ok()).ok_or(OusterMetadataError::Field(field))
    }

    fn list(&self, field: &'static str, len: usize) -> Result<Vec<f64>, OusterMetadataError> {
        let entries = self.get(field)?.as_array().ok_or(OusterMetadataError::Field(field))?;
        if entries.len() != len {
            return Err(OusterMetadataError::Rows { field, found: entries.len(), expected: len });
        }
        entries.iter().map(|entry| entry.as_f64().ok_or(OusterMetadataError::Field(field))).collect()
    }

    fn format(&self) -> Result<OusterFormat, OusterMetadataError> {
        let name = self.get("udp_profile_lidar")?.as_str().unwrap_or("");
        let profile = OusterProfile::from_name(name).ok_or_else(|| OusterMetadataError::Profile(name.into()))?;
        let rows: u8 = self.integer("pixels_per_column")?;
        let columns: u16 = self.integer("columns_per_frame")?;
        let packet: u8 = self.integer("columns_per_packet")?;
        if rows == 0 || usize::from(rows) > MAX_ROWS {
            return Err(OusterMetadataError::Field("pixels_per_column"));
        }
        if columns == 0 || columns > MAX_COLUMNS {
            return Err(OusterMetadataError::Field("columns_per_frame"));
        }
        if packet == 0 || u16::from(packet) > columns {
            return Err(OusterMetadataError::Field("columns_per_packet"));
        }
        Ok(OusterFormat {
            columns_per_packet: packet,
            window: self.window(columns)?,
            ..OusterFormat::new(profile, rows, columns)
        })
    }

    /// The first and the last column that the sensor sends.
    fn window(&self, columns: u16) -> Result<[u16; 2], OusterMetadataError> {
        const FIELD: &str = "column_window";
        let ends = self.list(FIELD, 2)?;
        let is_column = |&end: &f64| end.fract() == 0.0 && (0.0..f64::from(columns)).contains(&end);
        if ends.iter().all(is_column) {
            Ok([ends[0] as u16, ends[1] as u16])
        } else {
            Err(OusterMetadataError::Field(FIELD))
        }
    }

    /// The frame: the sensor's transform is a turn about z and a lift.
    fn spin(&self, format: &OusterFormat) -> Result<Spin, OusterMetadataError> {
        let transform = self.transform()?;
        Ok(Spin {
            ticks_per_turn: u32::from(format.columns_per_frame),
            clockwise: true,
            zero_rad: transform[4].atan2(transform[0]) as f32,
            range_unit_m: f32::from(format.profile.range_unit_um()) * 1e-6,
            // All beams fire together: any period will do.
            period_ns: 1,
        })
    }

    fn transform(&self) -> Result<Vec<f64>, OusterMetadataError> {
        const FIELD: &str = "lidar_to_sensor_transform";
        let transform = self.list(FIELD, 16)?;
        let turns_about_z = [2, 3, 6, 7, 8, 9].iter().all(|&at| transform[at].abs() < 1e-6);
        if turns_about_z { Ok(transform) } else { Err(OusterMetadataError::Field(FIELD)) }
    }

    /// The beams leave a circle of `lidar_origin_to_beam_origin_mm` around the axis, in the
    /// direction of the column, and the range counts from the axis along that way.
    fn beams(&self, rows: usize) -> Result<Vec<Beam>, OusterMetadataError> {
        let lens_m = self.number("lidar_origin_to_beam_origin_mm")? * 1e-3;
        let lift_m = self.transform()?[11] * 1e-3;
        let elevations = self.list("beam_altitude_angles", rows)?;
        let azimuths = self.list("beam_azimuth_angles", rows)?;
        let beams = elevations.iter().zip(&azimuths);
        Ok(beams.map(|(&elevation, &azimuth)| beam(elevation, azimuth, lens_m, lift_m)).collect())
    }
}

fn beam(elevation_deg: f64, azimuth_deg: f64, lens_m: f64, lift_m: f64) -> Beam {
    let (slope, cos) = {
        let elevation = elevation_deg.to_radians();
        (elevation.tan(), elevation.cos())
    };
    // Ouster's beam azimuths are clockwise: theta_a = -azimuth.
    let phase = -azimuth_deg.to_radians();
    let along = lens_m * phase.cos();
    let aside = lens_m * phase.sin();
    // The model counts its range from the foot of the perpendicular from the origin on the beam.
    let foot_m = along * cos + lift_m * slope * cos;
    let z_offset_m = lift_m - along * slope;
    let range_phase_m = foot_m - lens_m;
    Beam {
        slope: slope as f32,
        z_offset_m: z_offset_m as f32,
        h_offset_m: aside as f32,
        azimuth_phase_rad: phase as f32,
        range_phase_m: range_phase_m as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use std::string::ToString as _;

    fn metadata() -> Value {
        json!({
            "prod_line": "OS-1-2",
            "lidar_origin_to_beam_origin_mm": 15.8,
            "lidar_to_sensor_transform": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.2, 0, 0, 0, 1],
            "beam_altitude_angles": [10.0, -10.0],
            "beam_azimuth_angles": [3.0, -3.0],
            "data_format": {
                "udp_profile_lidar": "RNG15_RFL8_NIR8",
                "pixels_per_column": 2,
                "columns_per_frame": 1024,
                "columns_per_packet": 16,
                "column_window": [1000, 23],
                "pixel_shift_by_row": [12, -12]
            }
        })
    }

    #[test]
    fn formats_that_no_packet_can_have_are_refused() {
        let good = OusterSensor::from_json(&metadata().to_string()).expect("good metadata");
        assert_eq!((good.format.columns_per_packet, good.format.window), (16, [1000, 23]));
        for (field, wrong) in [
            ("pixels_per_column", json!(0)),
            ("pixels_per_column", json!(129)),
            ("columns_per_frame", json!(0)),
            ("columns_per_frame", json!(8193)),
            ("columns_per_packet", json!(0)),
            ("columns_per_packet", json!(256)),
            ("column_window", json!([0, 1024])),
            ("column_window", json!([-1, 1023])),
            ("column_window", json!([0.5, 1023])),
            ("column_window", json!([0, "1023"])),
        ] {
            let mut metadata = metadata();
            metadata["data_format"][field] = wrong.clone();
            let refused = OusterSensor::from_json(&metadata.to_string());
            assert!(matches!(refused, Err(OusterMetadataError::Field(name)) if name == field), "{field} {wrong}");
        }
    }
}
