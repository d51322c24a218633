//! The decoder's memory of the frame before.

use std::vec;
use std::vec::Vec;

use super::{LINK_LEN, Link, nearest};
use crate::error::{DecodeError, PayloadFault};
use crate::frame::ParsedFrame;
use crate::plane::SectionKind;

/// The frame that was decoded last, of those that others go on from.
#[derive(Debug, Default)]
pub(crate) struct Before {
    /// Row-major, at the columns of the frame that is being decoded.
    pub(crate) levels: Vec<u16>,
    rows: usize,
    columns: usize,
    /// Of the firings that its columns are.
    ticks: Vec<u16>,
    /// Its checksum; `None` where there is none to go on from.
    checksum: Option<u32>,
}

impl Before {
    /// Makes ready for a frame; gives what it says of the frame before, if it says anything. Until [`end`](Self::end), no other
    /// goes on from here.
    pub(crate) fn begin(&mut self, parsed: &ParsedFrame<'_>, firings: &[u32]) -> Result<Option<Link>, DecodeError> {
        let Some(link) = link_of(parsed)? else { return Ok(None) };
        let have = self.checksum;
        if link.distance > 0 && have != Some(link.checksum) {
            let Link { key, distance, checksum: need } = link;
            return Err(DecodeError::PreviousMissing { key, distance, need, have });
        }
        self.checksum = None;
        let (rows, columns) = (usize::from(parsed.header.rows), usize::from(parsed.header.columns));
        let is_fired = parsed.header.geometry.firings_len() > 0;
        let ticks: Vec<u16> = if is_fired { firings.iter().map(|&tick| tick as u16).collect() } else { Vec::new() };
        if link.distance == 0 {
            self.levels.clear();
            self.levels.resize(rows * columns, 0);
        } else {
            let has_place = self.columns == columns || !self.ticks.is_empty();
            if self.rows != rows || !has_place || self.ticks.is_empty() == is_fired {
                return Err(malformed());
            }
            if is_fired {
                self.move_columns(&ticks);
            }
        }
        (self.rows, self.columns, self.ticks) = (rows, columns, ticks);
        Ok(Some(link))
    }

    fn move_columns(&mut self, ticks: &[u16]) {
        let mut at = 0;
        let mut map = vec![0; ticks.len()];
        for (place, &tick) in map.iter_mut().zip(ticks) {
            at = nearest(&self.ticks, at, tick.into());
            *place = at;
        }
        let rows = self.levels.chunks_exact(self.columns.max(1));
        self.levels = rows.flat_map(|row| map.iter().map(|&from| row[from])).collect();
    }

    /// The frame was decoded.
    pub(crate) fn end(&mut self, _: Link, checksum: Option<u32>) {
        self.checksum = checksum;
    }
}

/// What a frame says of the frame before.
pub(crate) fn link_of(parsed: &ParsedFrame<'_>) -> Result<Option<Link>, DecodeError> {
    if !parsed.has_sections() {
        return Ok(None);
    }
    for section in parsed.sections() {
        if let (SectionKind::Previous, body) = section? {
            if body.is_empty() {
                return Ok(Some(Link { distance: 0, key: parsed.header.sequence, checksum: 0 }));
            }
            let body: [u8; LINK_LEN] = body.try_into().map_err(|_| malformed())?;
            return Some(Link::from_bytes(body)).filter(|link| link.distance > 0).ok_or(malformed()).map(Some);
        }
    }
    Ok(None)
}

const fn malformed() -> DecodeError {
    DecodeError::Section { kind: SectionKind::Previous as u8, fault: PayloadFault::Malformed }
}
