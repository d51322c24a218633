//! Turns from Ouster packets: frame and measurement ids say what is missing, the time whether they
//! can be believed.

use super::event::OpenTurn;
use super::ouster::{OusterFormat, OusterPacket};
use super::{Column, Event, GapCause, PacketError, PacketStats, ReturnPolicy, TurnCut};

/// A column that a packet starts or ends with.
#[derive(Clone, Copy, Debug)]
struct Place {
    frame: u16,
    id: u16,
    time_ns: u64,
    /// Time from one column to the next.
    period_ns: u64,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct OusterTurns {
    last: Option<Place>,
    /// Where a refused packet ended: the next one may follow it.
    candidate: Option<Place>,
    turn: OpenTurn,
}

impl OusterTurns {
    pub const fn new() -> Self {
        Self { last: None, candidate: None, turn: OpenTurn::new() }
    }

    pub fn push(
        &mut self,
        packet: &OusterPacket<'_>,
        format: &OusterFormat,
        policy: ReturnPolicy,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) -> Result<(), PacketError> {
        let [first, end] = ends(packet);
        self.believe(first, end, format)?;
        self.advance(first, format, stats, sink);
        for nth in 0..packet.len() {
            self.give(packet, nth, policy, stats, sink);
        }
        self.last = Some(end);
        Ok(())
    }

    pub fn finish(&mut self, stats: &mut PacketStats, sink: &mut impl FnMut(Event<'_>)) {
        if self.turn.next() > 0 {
            self.turn.end(TurnCut::Finish, stats, sink);
        }
        self.last = None;
        self.candidate = None;
    }

    /// Refuses a packet that neither follows the last one nor a refused one.
    fn believe(&mut self, first: Place, end: Place, format: &OusterFormat) -> Result<(), PacketError> {
        let Some(last) = self.last else { return Ok(()) };
        let refusal = match follows(last, first, format) {
            Ok(()) => {
                self.candidate = None;
                return Ok(());
            }
            Err(refusal) => refusal,
        };
        if matches!(refusal, PacketError::Late | PacketError::Duplicate) {
            return Err(refusal);
        }
        match self.candidate.replace(end) {
            Some(before) if follows(before, first, format).is_ok() => {
                self.candidate = None;
                Ok(())
            }
            _ => Err(refusal),
        }
    }

    /// Goes up to `first`, marking what is missing on the way.
    fn advance(
        &mut self,
        first: Place,
        format: &OusterFormat,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) {
        let started = self.last.is_some();
        if let Some(last) = self.last
            && (last.frame != first.frame || first.id < self.turn.next())
        {
            self.gap(format.columns_per_frame, started, format, stats, sink);
            self.turn.end(TurnCut::Wrap, stats, sink);
            // A frame number that steps back is a restart, of unknown length.
            let frames = first.frame.wrapping_sub(last.frame);
            if frames < 1 << 15 {
                self.turn.lose(u32::from(frames.saturating_sub(1)), stats, sink);
            }
        }
        self.gap(first.id, started, format, stats, sink);
    }

    /// Marks the columns up to `to` as missing: blind ones apart from lost ones.
    fn gap(
        &mut self,
        to: u16,
        started: bool,
        format: &OusterFormat,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) {
        while self.turn.next() < to {
            let from = self.turn.next();
            let sends = format.sends(from);
            let same = (from..to).take_while(|&id| format.sends(id) == sends);
            let cause = match sends {
                false => GapCause::Blind,
                true if started => GapCause::Lost,
                true => GapCause::Start,
            };
            self.turn.gap(same.count() as u32, cause, stats, sink);
            if self.turn.next() == from {
                // Past the most columns that a turn can have.
                return;
            }
        }
    }

    fn give(
        &mut self,
        packet: &OusterPacket<'_>,
        nth: u16,
        policy: ReturnPolicy,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) {
        if !packet.is_valid(nth) {
            self.turn.gap(1, GapCause::Invalid, stats, sink);
            return;
        }
        for (&pick, layer) in packet.picks(policy).iter().zip(0..) {
            let id = packet.first_id.wrapping_add(nth);
            sink(Event::Column(Column {
                index: id,
                tick: id,
                step_q8: 256,
                layer,
                time_ns: packet.time_ns(nth),
                cells: packet.cells(nth, &packet.shape(pick)),
            }));
        }
        self.turn.count_column(stats);
    }
}

/// First and last column of a packet.
fn ends(packet: &OusterPacket<'_>) -> [Place; 2] {
    let steps = packet.len().saturating_sub(1);
    let (start_ns, end_ns) = (packet.time_ns(0), packet.time_ns(steps));
    let place = |nth: u16, time_ns| Place {
        frame: packet.frame,
        id: packet.first_id.wrapping_add(nth),
        time_ns,
        period_ns: end_ns.saturating_sub(start_ns) / u64::from(steps.max(1)),
    };
    [place(0, start_ns), place(steps, end_ns)]
}

/// Whether the column `first` can come after `last`.
fn follows(last: Place, first: Place, format: &OusterFormat) -> Result<(), PacketError> {
    let per_frame = i64::from(format.columns_per_frame);
    let frames = i64::from(first.frame.wrapping_sub(last.frame).cast_signed());
    let columns = frames * per_frame + i64::from(first.id) - i64::from(last.id);
    if columns == 1 {
        return Ok(());
    }
    let elapsed_ns = first.time_ns.wrapping_sub(last.time_ns).cast_signed();
    if columns <= 0 && elapsed_ns <= 0 {
        return Err(if columns == 1 - i64::from(format.columns_per_packet) {
            PacketError::Duplicate
        } else {
            PacketError::Late
        });
    }
    let by_time = elapsed_ns / first.period_ns.clamp(1, 1 << 40).cast_signed();
    // Rotation speed wanders, and the clock may be disciplined: 1 in 8, and a packet or two.
    let tolerance = 32 + columns / 8;
    if columns > 0 && by_time.abs_diff(columns) <= tolerance.unsigned_abs() {
        return Ok(());
    }
    Err(PacketError::Discontinuity { found: first.id, expected: ((i64::from(last.id) + 1) % per_frame.max(1)) as u16 })
}
