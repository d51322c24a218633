//! What a decoded frame gives back: levels, planes, points, the file it was made from.

use std::vec::Vec;

use super::rows::put_rows;
use super::{Levels, Places};
use crate::error::DecodeError;
use crate::frame::{Geometry, Header};
use crate::image::Level;
use crate::original::{self, FrameReturn};
use crate::plane::decode::DecodedPlanes;
use crate::plane::{IntensityScale, SectionKind};
use crate::quantize::Companding;
use crate::smooth::smooth_row;

/// A decoded frame; its pixels are lent by the [`Decoder`](super::Decoder).
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    pub(super) header: Header,
    pub(super) levels: &'a Levels,
    pub(super) planes: &'a DecodedPlanes,
    pub(super) places: &'a Places,
}

impl<'a> Frame<'a> {
    /// What the frame says of itself.
    #[must_use]
    pub const fn header(&self) -> &Header {
        &self.header
    }

    /// Levels, row-major, 0 = no return.
    #[must_use]
    pub const fn levels(&self) -> &'a Levels {
        self.levels
    }

    /// The intensities' numbers, row-major, 0 where there is no return, and what they mean; `None` where the frame carries
    /// none.
    #[must_use]
    pub fn intensity_plane(&self) -> Option<(&'a [u8], IntensityScale)> {
        let image = &self.planes.intensity;
        image.scale.map(|scale| (image.numbers.as_slice(), scale))
    }

    /// The intensity of each of the [points](Self::points), in the same order; `None` where the frame carries none.
    #[must_use]
    pub fn intensities(&self) -> Option<Vec<f32>> {
        let (numbers, scale) = self.intensity_plane()?;
        let of_number: Vec<f32> = (0..=u8::MAX).map(|number| scale.intensity(number)).collect();
        let of = |is_return: bool, &number: &u8| is_return.then_some(of_number[usize::from(number)]);
        Some(match self.levels {
            Levels::U8(levels) => levels.iter().zip(numbers).filter_map(|(l, n)| of(*l != 0, n)).collect(),
            Levels::U16(levels) => levels.iter().zip(numbers).filter_map(|(l, n)| of(*l != 0, n)).collect(),
        })
    }

    /// The time of each column, nanoseconds of the epoch of the header's time: of each firing in order, where the columns are a
    /// sensor's firings. `None` where the frame carries none.
    #[must_use]
    pub fn column_times_ns(&self) -> Option<&'a [u64]> {
        self.planes.times_ns.as_deref()
    }

    /// The time of each of the [points](Self::points), in the same order; `None` where the frame carries none.
    #[must_use]
    pub fn times_ns(&self) -> Option<Vec<u64>> {
        let times_ns = self.column_times_ns()?;
        let columns = usize::from(self.header.columns);
        let of_row = |row: usize| match self.header.geometry {
            Geometry::Beams(_) => self.places.turn.first_column(row),
            Geometry::Uniform(_) => 0,
        };
        let time = |at: usize| times_ns[(of_row(at / columns) + at % columns) % columns];
        Some(match self.levels {
            Levels::U8(levels) => (0..).zip(levels).filter(|(_, l)| **l != 0).map(|(at, _)| time(at)).collect(),
            Levels::U16(levels) => (0..).zip(levels).filter(|(_, l)| **l != 0).map(|(at, _)| time(at)).collect(),
        })
    }

    /// The bytes of the file that the frame was made from; `None` where it does not tell ([`original::append`]).
    ///
    /// # Errors
    /// [`DecodeError::Section`] where what tells is damaged.
    pub fn original(&self) -> Result<Option<Vec<u8>>, DecodeError> {
        let fault = |fault| DecodeError::Section { kind: SectionKind::Original as u8, fault };
        let body = self.planes.original.as_deref();
        body.map(|body| original::decode(self, body)).transpose().map_err(fault)
    }

    /// The returns, row by row from the top, each in order of columns, with more digits than points have.
    pub(crate) fn returns(&self) -> Vec<FrameReturn> {
        let columns = usize::from(self.header.columns);
        let level = |at: usize| match self.levels {
            Levels::U8(levels) => u16::from(levels[at]),
            Levels::U16(levels) => levels[at],
        };
        let plane = self.intensity_plane();
        let is_square_root = self.header.quantizer.companding() == Companding::SquareRoot;
        let mut returns = Vec::new();
        for at in (0..self.header.pixels()).filter(|&at| level(at) != 0) {
            let (row, column) = (at / columns, at % columns);
            let position = match self.header.geometry {
                Geometry::Uniform(_) => {
                    let (row, columns) = (self.places.sphere.row(row), self.places.sphere.columns());
                    xyz(row.at(&columns[column], self.header.quantizer.range_m(level(at)))).map(f64::from)
                }
                Geometry::Beams(_) => {
                    let (columns, row) = self.places.turn.row(row);
                    let level = u32::from(level(at));
                    row.at_exactly(&columns[column], f64::from(if is_square_root { level * level } else { level }))
                }
            };
            let intensity = plane.map_or(0.0, |(numbers, scale)| scale.intensity(numbers[at]));
            returns.push(FrameReturn { row: row as u16, column: column as u16, position, intensity });
        }
        returns
    }

    /// The points, x, y, z in meters, row by row from the top, each in order of columns.
    #[must_use]
    pub fn points(&self) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        self.points_into(&mut points);
        points
    }

    /// As [`points`](Self::points), into a vector whose memory is used again.
    pub fn points_into(&self, points: &mut Vec<[f32; 3]>) {
        match self.levels {
            Levels::U8(levels) => self.push_points(levels, points),
            Levels::U16(levels) => self.push_points(levels, points),
        }
    }

    /// As [`points`](Self::points), with the stairs that a coarse step makes of a surface evened out: each range is moved
    /// towards the mean of up to four pixels on either side in its row, not across edges, by at most the half of its cell
    /// that the frame's [bound](Header::range_bound_m) speaks of. So a range may be off by **twice** that bound; on
    /// average it is nearer.
    ///
    /// For a sensor's own grid with steps of 5 cm and more: on KITTI's scans it gains 0.7 dB at 5 cm, 1.0 at 10 to 31 cm, 1.6
    /// with 8 bits without a dead zone. At 2 cm it costs 0.8 dB, at 1 cm 2.3, for what it smooths there are the things
    /// themselves; with evenly spread rows and columns it does next to nothing, for their errors are sideways.
    /// `docs/PERFORMANCE.md` has the figures.
    #[must_use]
    pub fn smooth_points(&self) -> Vec<[f32; 3]> {
        match self.levels {
            Levels::U8(levels) => self.smooth_points_of(levels),
            Levels::U16(levels) => self.smooth_points_of(levels),
        }
    }

    fn smooth_points_of<L: Level>(&self, levels: &[L]) -> Vec<[f32; 3]> {
        let (columns_len, step_m) = (usize::from(self.header.columns), self.header.quantizer.step_m());
        let cell = 0.5 + f32::from(self.header.error_max);
        let is_square_root = self.header.quantizer.companding() == Companding::SquareRoot;
        let steps = |level: f32| if is_square_root { level * level } else { level };
        let (mut points, mut smoothed) = (Vec::new(), Vec::new());
        for (number, levels) in levels.chunks_exact(columns_len).enumerate() {
            smooth_row(levels, cell, &mut smoothed);
            let returns = smoothed.iter().enumerate().filter(|&(_, &level)| level > 0.0);
            match self.header.geometry {
                Geometry::Uniform(_) => {
                    let (row, columns) = (self.places.sphere.row(number), self.places.sphere.columns());
                    points.extend(returns.map(|(at, &level)| xyz(row.at(&columns[at], steps(level) * step_m))));
                }
                Geometry::Beams(_) => {
                    let (columns, row) = self.places.turn.row(number);
                    points.extend(returns.map(|(at, &level)| xyz(row.at_fraction(&columns[at], steps(level).into()))));
                }
            }
        }
        points
    }

    fn push_points<L: Level>(&self, levels: &[L], points: &mut Vec<[f32; 3]>) {
        let quantizer = self.header.quantizer;
        let is_square_root = quantizer.companding() == Companding::SquareRoot;
        let columns = usize::from(self.header.columns);
        match self.header.geometry {
            Geometry::Uniform(_) => {
                let sphere = &self.places.sphere;
                put_rows(levels, columns, points, |row| {
                    let row = sphere.row(row);
                    (sphere.columns(), move |column, level| row.at(column, quantizer.range_m(level)))
                });
            }
            Geometry::Beams(_) if is_square_root => {
                let turn = &self.places.turn;
                put_rows(levels, columns, points, |row| {
                    let (columns, row) = turn.row(row);
                    (columns, move |column, level| {
                        row.at_fraction(column, f64::from(u32::from(level) * u32::from(level)))
                    })
                });
            }
            Geometry::Beams(_) => {
                let turn = &self.places.turn;
                put_rows(levels, columns, points, |row| {
                    let (columns, row) = turn.row(row);
                    (columns, move |column, level| row.at(column, level))
                });
            }
        }
    }
}

const fn xyz([x, y, z, _]: [f32; 4]) -> [f32; 3] {
    [x, y, z]
}
