//! What a capture holds.

use std::path::Path;

use serde::Serialize;

use super::group;
use crate::capture::{CaptureArgs, Turns};
use crate::failure::Failure;

#[derive(Debug, Serialize)]
pub struct CaptureInfo {
    file: String,
    sensor: String,
    packets: u32,
    refused: u32,
    /// Datagrams to other ports.
    elsewhere: u64,
    lost_columns: u32,
    /// Null where there is nothing to complain of.
    complaint: Option<String>,
    turns: Vec<TurnInfo>,
}

#[derive(Debug, Serialize)]
struct TurnInfo {
    /// The number by which `--turn` knows it; null where it is not whole.
    turn: Option<usize>,
    timestamp_ns: u64,
    firings: usize,
    missing: u16,
    /// Those of the missing columns in which the sensor is told not to measure.
    blind: u16,
    returns: usize,
}

impl CaptureInfo {
    pub fn new(file: &Path, args: &CaptureArgs) -> Result<Self, Failure> {
        let mut opened = Turns::open(file, args, None)?;
        let (mut turns, mut sensor, mut whole) = (Vec::new(), String::new(), 0);
        for scan in opened.by_ref() {
            let scan = scan?;
            let Some(turn) = scan.turn else { continue };
            turn.sensor.grid().name.clone_into(&mut sensor);
            turns.push(TurnInfo {
                turn: turn.is_whole.then_some(whole),
                timestamp_ns: scan.timestamp_ns,
                firings: turn.ticks.len(),
                missing: turn.missing,
                blind: turn.blind,
                returns: turn.returns.len(),
            });
            whole += usize::from(turn.is_whole && turn.layer == 0);
        }
        let stats = opened.stats();
        Ok(Self {
            file: file.display().to_string(),
            sensor,
            packets: stats.used,
            refused: stats.refused(),
            elsewhere: opened.elsewhere(),
            lost_columns: stats.lost_columns,
            complaint: opened.complaint(),
            turns,
        })
    }

    pub fn text(&self) -> String {
        let Self { file, sensor, packets, turns, .. } = self;
        let whole = turns.iter().filter(|turn| turn.turn.is_some()).count();
        let (packets, all) = (group(*packets as usize), turns.len());
        let mut lines = vec![format!("{file}: {sensor}, {packets} packets, turns: {all}, whole: {whole}")];
        if self.elsewhere > 0 {
            lines.push(format!("{} datagrams to other ports", group(self.elsewhere as usize)));
        }
        lines.extend(self.complaint.clone());
        lines.extend(turns.iter().map(TurnInfo::text));
        lines.join("\n  ")
    }
}

impl TurnInfo {
    fn text(&self) -> String {
        let Self { turn, timestamp_ns, firings, missing, blind, returns } = self;
        let name = turn.map_or_else(|| "cut turn".to_owned(), |turn| format!("turn {turn}"));
        let (firings, returns) = (group(*firings), group(*returns));
        let missing = match blind {
            0 => format!("{missing} columns missing"),
            _ => format!("{} columns missing, {blind} not measured", missing.saturating_sub(*blind)),
        };
        format!("{name}: {firings} firings, {missing}, {returns} returns, time {timestamp_ns} ns")
    }
}
