//! Turns from packets of blocks: cut by azimuth, gaps found by number, time and azimuth.
//!
//! A packet is believed if it *follows* the one before: its first azimuth lies one step further
//! (then nothing was lost), or its number or time says how much was lost and the azimuth agrees. One
//! that does not follow is refused but remembered, and if the next packet follows *it*, the stream
//! goes on from there. So a damaged azimuth costs its own packet and a restarted sensor the first.

use super::bytes;
use super::column::{CellShape, Cells, Pick};
use super::event::OpenTurn;
use super::model::TICKS_PER_TURN;
use super::spin::{SpinPacket, Sweep, forward, signed};
use super::{Column, Event, GapCause, MAX_COLUMNS, PacketError, PacketStats, ReturnPolicy, TurnCut};

const TURN: i32 = TICKS_PER_TURN as i32;

/// Packets that come later than this are no longer called late: the clock was set back.
const LATE_NS: i64 = 1_000_000_000;

/// Jumps of a sequence number beyond this are no losses: the sensor was restarted.
const MOST_LOST_PACKETS: u32 = 1 << 20;

/// Where a packet begins and ends.
#[derive(Clone, Copy, Debug)]
struct Mark {
    first: u16,
    /// Tick of the last firing.
    last: u16,
    start_ns: u64,
    /// Time of the last firing.
    end_ns: u64,
    sequence: Option<u32>,
    firings: u32,
    /// Ticks a firing, times 256.
    step_q8: u32,
}

/// Where and when a firing is.
#[derive(Clone, Copy, Debug)]
struct Place {
    tick: u16,
    step_q8: u32,
    time_ns: u64,
}

/// A range of azimuth that the sensor is told to leave out.
#[derive(Clone, Copy, Debug)]
struct BlindSector {
    from: u16,
    to: u16,
}

impl BlindSector {
    fn is_like(self, from: u16, to: u16, step_q8: u32) -> bool {
        let near = (step_q8 >> 8) as i32 * 4 + 8;
        signed(self.from, from).abs() <= near && signed(self.to, to).abs() <= near
    }
}

/// A packet that followed nothing, and the jump at its end, if it had one.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    mark: Mark,
    jump: Option<BlindSector>,
}

/// How a packet relates to the one before.
enum Link {
    /// So many columns lie between them, over so many ticks from the last column to the first.
    Follows {
        ticks: i64,
        columns: u32,
    },
    Refused(PacketError),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SpinTurns {
    cut: u16,
    /// Ticks from the cut to the last column; may be a little below zero.
    position: i32,
    last: Option<Mark>,
    candidate: Option<Candidate>,
    blind: Option<BlindSector>,
    /// Whether a step was ever measured.
    step_known: bool,
    turn: OpenTurn,
}

impl SpinTurns {
    pub const fn new(cut: u16) -> Self {
        Self { cut, position: 0, last: None, candidate: None, blind: None, step_known: false, turn: OpenTurn::new() }
    }

    pub fn push(
        &mut self,
        packet: &SpinPacket<'_>,
        policy: ReturnPolicy,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) -> Result<(), PacketError> {
        let sweep = packet.sweep()?;
        let mark = self.mark(packet, &sweep);
        self.approach(packet, &sweep, &mark, stats, sink)?;
        let picks = packet.picks(policy);
        self.emit(packet, &sweep, &mark, picks, stats, sink);
        // A sensor that turns the other way never reaches the cut, but must not count down for ever.
        self.position = self.position.max(-TURN);
        Ok(())
    }

    pub fn finish(&mut self, stats: &mut PacketStats, sink: &mut impl FnMut(Event<'_>)) {
        if self.turn.next() > 0 {
            self.turn.end(TurnCut::Finish, stats, sink);
        }
        *self = Self { turn: self.turn, ..Self::new(self.cut) };
    }

    fn mark(&self, packet: &SpinPacket<'_>, sweep: &Sweep) -> Mark {
        let per_block = packet.layout.firings_per_block;
        let step_q8 = sweep
            .step_q8(per_block)
            .or_else(|| self.first_step(packet))
            .or(self.last.map(|last| last.step_q8))
            .unwrap_or_else(|| nominal_step_q8(packet.period_ns()));
        let azimuths = packet.azimuths();
        let (first, last) = match azimuths {
            &[first, .., last] => (first, last),
            &[only] => (only, only),
            [] => (0, 0),
        };
        let firings = packet.firings() as u32;
        let lasts_ns = u64::from(firings.saturating_sub(1)) * u64::from(packet.period_ns());
        Mark {
            first,
            last: nth_tick(last, per_block.saturating_sub(1), step_q8),
            start_ns: packet.time_ns,
            end_ns: packet.time_ns + lasts_ns,
            sequence: packet.sequence,
            firings,
            step_q8,
        }
    }

    /// The very first step where packets hold one firing: two packets a period apart tell it.
    fn first_step(&self, packet: &SpinPacket<'_>) -> Option<u32> {
        let last = self.last.filter(|_| !self.step_known)?;
        let first = *packet.azimuths().first()?;
        let elapsed_ns = since(last.end_ns, packet.time_ns, packet.clock_wrap_ns);
        let period = i64::from(packet.period_ns());
        let step = signed(last.last, first);
        let most = i32::from(packet.most_ticks_a_group());
        let tells = (elapsed_ns - period).abs() < period / 2 && (1..=most).contains(&step);
        tells.then_some(step.unsigned_abs() * 256)
    }

    /// Goes up to the packet's first column, marking what is missing on the way.
    fn approach(
        &mut self,
        packet: &SpinPacket<'_>,
        sweep: &Sweep,
        mark: &Mark,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) -> Result<(), PacketError> {
        let Some(last) = self.last else {
            return self.start(packet, sweep, mark, stats, sink);
        };
        match self.judge(packet, sweep, &last, mark) {
            Link::Follows { ticks, columns } => {
                if self.candidate.is_some() {
                    self.learn_blind_sector(packet, mark);
                }
                if columns == 0 {
                    self.step(ticks as i32, stats, sink);
                } else {
                    let cause = self.cause(last.last, mark);
                    self.skip(ticks, columns, cause, stats, sink);
                }
                Ok(())
            }
            Link::Refused(error) => self.doubt(error, packet, sweep, mark, &last, stats, sink),
        }
    }

    /// The first packet of a stream: the turn up to it is a gap.
    fn start(
        &mut self,
        packet: &SpinPacket<'_>,
        sweep: &Sweep,
        mark: &Mark,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) -> Result<(), PacketError> {
        if let Some(group) = sweep.jump_to_group
            && !(2..packet.azimuths().len().saturating_sub(1)).contains(&group)
        {
            return Err(jump_error(packet, group));
        }
        self.position = i32::from(forward(self.cut, mark.first));
        let before = columns_in(self.position, mark.step_q8);
        self.turn.gap(before, GapCause::Start, stats, sink);
        Ok(())
    }

    /// Whether the packet follows `last`, and its own jump can be believed.
    fn judge(&self, packet: &SpinPacket<'_>, sweep: &Sweep, last: &Mark, mark: &Mark) -> Link {
        match (sweep.jump_to_group, link(packet, last, mark)) {
            // Nothing after the jump confirms it.
            (Some(group), _)
                if group + 1 == packet.azimuths().len() && !self.is_blind(mark.last, packet, mark.step_q8) =>
            {
                Link::Refused(jump_error(packet, group))
            }
            // Only the packet before can confirm what is before the jump.
            (Some(1), Link::Follows { ticks, columns }) if !is_near(ticks, columns, packet, mark) => {
                Link::Refused(jump_error(packet, 1))
            }
            (_, link) => link,
        }
    }

    fn is_blind(&self, to: u16, packet: &SpinPacket<'_>, step_q8: u32) -> bool {
        let &[.., from, _] = packet.azimuths() else { return false };
        self.blind.is_some_and(|blind| blind.is_like(from, to, step_q8))
    }

    /// The packet before was refused for a jump at its end; this one goes on from there, so the jump
    /// was real.
    fn learn_blind_sector(&mut self, packet: &SpinPacket<'_>, mark: &Mark) {
        let Some(Candidate { mark: before, jump: Some(jump) }) = self.candidate.take() else {
            return;
        };
        if let Link::Follows { columns: 0, .. } = link(packet, &before, mark) {
            self.blind = Some(jump);
        }
    }

    fn cause(&self, from: u16, mark: &Mark) -> GapCause {
        match self.blind {
            Some(blind) if blind.is_like(from, mark.first, mark.step_q8) => GapCause::Blind,
            _ => GapCause::Lost,
        }
    }

    /// A packet that does not follow: if it follows the refused one before it, both were right.
    #[allow(clippy::too_many_arguments)]
    fn doubt(
        &mut self,
        error: PacketError,
        packet: &SpinPacket<'_>,
        sweep: &Sweep,
        mark: &Mark,
        last: &Mark,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) -> Result<(), PacketError> {
        if matches!(error, PacketError::Late | PacketError::Duplicate) {
            return Err(error);
        }
        let jump = match (sweep.jump_to_group, packet.azimuths()) {
            (Some(_), &[.., from, to]) => Some(BlindSector { from, to }),
            _ => None,
        };
        let candidate = Candidate { mark: *mark, jump };
        let Some(before) = self.candidate.replace(candidate) else {
            return Err(error);
        };
        if jump.is_some() || !matches!(link(packet, &before.mark, mark), Link::Follows { .. }) {
            return Err(error);
        }
        self.candidate = None;
        self.blind = before.jump.or(self.blind);
        // The clock does not tell how long the stream was away, the azimuth tells modulo a turn.
        let ticks = i32::from(forward(last.last, mark.first));
        let columns = columns_in(ticks, mark.step_q8).saturating_sub(1);
        self.skip(i64::from(ticks), columns, GapCause::Lost, stats, sink);
        Ok(())
    }

    /// Turns to the next column, which mostly is of the same turn.
    #[inline(always)]
    fn step(&mut self, ticks: i32, stats: &mut PacketStats, sink: &mut impl FnMut(Event<'_>)) {
        let position = self.position + ticks;
        if position < TURN {
            self.position = position;
        } else {
            self.skip(ticks.into(), 0, GapCause::Lost, stats, sink);
        }
    }

    /// Turns by `ticks` to the next column; `missing` columns lie between.
    fn skip(
        &mut self,
        ticks: i64,
        missing: u32,
        cause: GapCause,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) {
        let to_cut = i64::from(TURN - self.position);
        if ticks < to_cut {
            self.turn.gap(missing, cause, stats, sink);
            self.position += ticks as i32;
            return;
        }
        // Spread the missing columns evenly over the ticks, to find on which side of the cut they lie.
        // Unsigned from here on: nothing is negative, and a division then cannot overflow.
        let (steps, span) = (u64::from(missing) + 1, ticks.max(1).unsigned_abs());
        let reached = (to_cut - 1).max(0).unsigned_abs() * steps / span;
        let before = reached.min(u64::from(missing)) as u32;
        self.turn.gap(before, cause, stats, sink);
        self.turn.end(TurnCut::Wrap, stats, sink);
        let beyond = ticks.saturating_sub(to_cut).unsigned_abs();
        let whole = beyond / u64::from(TICKS_PER_TURN);
        self.turn.lose(whole.min(u64::from(u32::MAX)) as u32, stats, sink);
        let in_whole = (whole * u64::from(TICKS_PER_TURN)).saturating_mul(steps) / span;
        let after = u64::from(missing - before).saturating_sub(in_whole);
        self.turn.gap(after.min(u64::from(MAX_COLUMNS)) as u32, cause, stats, sink);
        self.position = (beyond % u64::from(TICKS_PER_TURN)) as i32;
    }

    /// Gives out the packet's columns. The way to the first one is made already.
    fn emit(
        &mut self,
        packet: &SpinPacket<'_>,
        sweep: &Sweep,
        mark: &Mark,
        picks: &[Pick],
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) {
        let layout = packet.layout;
        let (run_len, period_ns) = (layout.run_len * layout.cell_len, u64::from(packet.period_ns()));
        let shape = packet.shape(picks.first().copied().unwrap_or(Pick::Only));
        let second = picks.get(1).map(|&pick| CellShape { pick, ..shape });
        let mut at = mark.first;
        let mut time_ns = packet.time_ns;
        for ((azimuth, bytes), group) in packet.groups().zip(0..) {
            if sweep.jump_to_group == Some(group) {
                time_ns += self.leap(at, azimuth, mark.step_q8, packet, stats, sink);
                at = azimuth;
            }
            let mut bytes = bytes::tail(bytes, layout.cells_at);
            for nth in 0..layout.firings_per_block {
                let tick = if nth == 0 { azimuth } else { nth_tick(azimuth, nth, mark.step_q8) };
                // Mostly the way on is short and needs no other way to be compared with.
                let ahead = i32::from(tick) - i32::from(at);
                let ahead = if (0..=TURN / 2).contains(&ahead) { ahead } else { signed(at, tick) };
                self.step(ahead, stats, sink);
                at = tick;
                let place = Place { tick, step_q8: mark.step_q8, time_ns };
                self.give(place, bytes, &shape, second.as_ref(), stats, sink);
                bytes = bytes::tail(bytes, run_len);
                time_ns += period_ns;
            }
        }
        let end_ns = time_ns - period_ns;
        self.last = Some(Mark { end_ns, step_q8: self.smooth_step(packet, mark), ..*mark });
    }

    /// Gives out one column, once for each layer.
    #[inline(always)]
    fn give(
        &mut self,
        Place { tick, step_q8, time_ns }: Place,
        bytes: &[u8],
        shape: &CellShape,
        second: Option<&CellShape>,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) {
        if self.turn.next() >= MAX_COLUMNS {
            self.turn.end(TurnCut::Overflow, stats, sink);
        }
        let index = self.turn.next();
        sink(Event::Column(Column { index, tick, step_q8, layer: 0, time_ns, cells: Cells { bytes, shape } }));
        if let Some(shape) = second {
            sink(Event::Column(Column { index, tick, step_q8, layer: 1, time_ns, cells: Cells { bytes, shape } }));
        }
        self.turn.count_column(stats);
    }

    /// Passes over the blind sector inside a packet; says how long that takes.
    fn leap(
        &mut self,
        from: u16,
        to: u16,
        step_q8: u32,
        packet: &SpinPacket<'_>,
        stats: &mut PacketStats,
        sink: &mut impl FnMut(Event<'_>),
    ) -> u64 {
        let ticks = forward(from, to);
        let missing = columns_in(i32::from(ticks), step_q8).saturating_sub(1);
        self.skip(i64::from(ticks), missing, GapCause::Blind, stats, sink);
        // `skip` already stands at `to`; the column itself turns no further.
        self.blind = Some(BlindSector { from, to });
        u64::from(missing) * u64::from(packet.period_ns())
    }

    /// The step of a packet; of one firing only, from packet to packet.
    fn smooth_step(&mut self, packet: &SpinPacket<'_>, mark: &Mark) -> u32 {
        let Some(last) = self.last.filter(|_| packet.azimuths().len() == 1) else {
            return mark.step_q8;
        };
        let step = signed(last.last, mark.first) * 256;
        let old = mark.step_q8 as i32;
        if !(1..2 * old).contains(&step) {
            return mark.step_q8;
        }
        let known = core::mem::replace(&mut self.step_known, true);
        let share = if known { 8 } else { 1 };
        (old + (step - old) / share) as u32
    }
}

/// Ten turns a second, in 1/256 tick a firing.
fn nominal_step_q8(period_ns: u32) -> u32 {
    (u64::from(period_ns) * 10 * u64::from(TICKS_PER_TURN) * 256 / 1_000_000_000) as u32
}

/// Tick of the `nth` firing of a block.
fn nth_tick(azimuth: u16, nth: usize, step_q8: u32) -> u16 {
    let tick = u32::from(azimuth) + ((nth as u32 * step_q8 + 128) >> 8);
    // Mostly it is within the turn, and a comparison costs less than the remainder.
    if tick < u32::from(TICKS_PER_TURN) { tick as u16 } else { (tick % u32::from(TICKS_PER_TURN)) as u16 }
}

/// Columns that fit into `ticks`, to the nearest.
fn columns_in(ticks: i32, step_q8: u32) -> u32 {
    let ticks_q8 = ticks.max(0).unsigned_abs() << 8;
    (ticks_q8 + step_q8 / 2) / step_q8.max(1)
}

fn jump_error(packet: &SpinPacket<'_>, group: usize) -> PacketError {
    let azimuth = |at: usize| packet.azimuths().get(at).copied().unwrap_or(0);
    PacketError::Azimuth { block: group as u8, found: azimuth(group), expected: azimuth(group.saturating_sub(1)) }
}

/// How `mark`, of `packet`, follows `last`.
fn link(packet: &SpinPacket<'_>, last: &Mark, mark: &Mark) -> Link {
    let elapsed_ns = since(last.end_ns, mark.start_ns, packet.clock_wrap_ns);
    let again_ns = since(last.start_ns, mark.start_ns, packet.clock_wrap_ns);
    if again_ns == 0 && mark.first == last.first {
        return Link::Refused(PacketError::Duplicate);
    }
    let period_ns = packet.period_ns();
    contiguous(last, mark, elapsed_ns, period_ns)
        .or_else(|| by_number(last, mark))
        .or_else(|| by_time(last, mark, elapsed_ns, period_ns))
        .unwrap_or_else(|| Link::Refused(why_not(last, mark, again_ns, period_ns)))
}

/// The sequence numbers say what is between.
fn by_number(last: &Mark, mark: &Mark) -> Option<Link> {
    let missed = mark.sequence?.wrapping_sub(last.sequence?).wrapping_sub(1);
    if missed > MOST_LOST_PACKETS {
        return None;
    }
    lost_columns(last, mark, u64::from(missed) * u64::from(mark.firings))
}

/// The azimuth goes on where it stopped: nothing is between.
///
/// Or whole turns are: that is believed only if number and time agree on it, since one damaged
/// field must not move the packets after it. So without sequence numbers, an outage that ends within
/// half a packet of where it began is not noticed.
fn contiguous(last: &Mark, mark: &Mark, elapsed_ns: i64, period_ns: u32) -> Option<Link> {
    let step = i64::from(mark.step_q8 >> 8);
    let ticks = i64::from(signed(last.last, mark.first));
    let half = (i64::from(mark.step_q8) * i64::from(mark.firings)) >> 9;
    if (ticks - step).abs() > half.max(1) {
        return None;
    }
    // Most sensors have no numbers: then the time, which costs a division, need not be asked.
    if let Some(Link::Follows { ticks, columns }) = by_number(last, mark)
        && let Some(Link::Follows { columns: timed, .. }) = by_time(last, mark, elapsed_ns, period_ns)
        && columns.abs_diff(timed) < mark.firings
    {
        return Some(Link::Follows { ticks, columns });
    }
    Some(Link::Follows { ticks, columns: 0 })
}

/// The time says how many firings are between.
fn by_time(last: &Mark, mark: &Mark, elapsed_ns: i64, period_ns: u32) -> Option<Link> {
    let period = i64::from(period_ns.max(1));
    let firings = elapsed_ns.checked_add(period / 2)? / period;
    if elapsed_ns <= 0 || firings < 1 {
        return None;
    }
    lost_columns(last, mark, firings as u64 - 1)
}

/// `columns` are between, if the azimuth agrees.
fn lost_columns(last: &Mark, mark: &Mark, columns: u64) -> Option<Link> {
    let columns = u32::try_from(columns).ok()?;
    let packet = i64::from(mark.step_q8) * i64::from(mark.firings) / 256;
    let expected = (i64::from(columns) + 1) * i64::from(mark.step_q8) / 256;
    let at = (i64::from(last.last) + expected) % i64::from(TURN);
    let off = i64::from(signed(at as u16, mark.first));
    // The longer the silence, the less is known of how fast the sensor turned meanwhile.
    let tolerance = (packet * 3 / 4).max(expected / 32);
    (off.abs() <= tolerance).then_some(Link::Follows { ticks: expected + off, columns })
}

/// Whether a packet starts within two blocks' turning of where it should.
fn is_near(ticks: i64, columns: u32, packet: &SpinPacket<'_>, mark: &Mark) -> bool {
    let expected = (i64::from(columns) + 1) * i64::from(mark.step_q8) / 256;
    let block = i64::from(mark.step_q8) * packet.layout.firings_per_block as i64 / 256;
    (ticks - expected).abs() <= 2 * block
}

/// What is wrong with a packet that does not follow.
fn why_not(last: &Mark, mark: &Mark, again_ns: i64, period_ns: u32) -> PacketError {
    let period = i64::from(period_ns.max(1));
    let firings_back = (period / 2).saturating_sub(again_ns) / period;
    let behind = firings_back * i64::from(mark.step_q8) / 256;
    let turned_back = i64::from(forward(mark.first, last.first));
    let packet = i64::from(mark.step_q8) * i64::from(mark.firings) / 256;
    let off = (behind - turned_back).rem_euclid(i64::from(TURN));
    let off = off.min(i64::from(TURN) - off);
    if (-LATE_NS..0).contains(&again_ns) && off <= packet.max(behind / 32) {
        return PacketError::Late;
    }
    let expected = u32::from(last.last) + (mark.step_q8 >> 8);
    PacketError::Discontinuity { found: mark.first, expected: (expected % u32::from(TICKS_PER_TURN)) as u16 }
}

/// Time from `from` to `to` on a clock that starts again after `wrap` (0: never).
fn since(from: u64, to: u64, wrap: u64) -> i64 {
    let ahead = to.wrapping_sub(from).cast_signed();
    if wrap == 0 {
        return ahead;
    }
    // Both are below `wrap`, but for a packet's length.
    let wrap = wrap.cast_signed();
    match ahead {
        _ if ahead > wrap / 2 => ahead.wrapping_sub(wrap),
        _ if ahead < -wrap / 2 => ahead.wrapping_add(wrap),
        _ => ahead,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packet::{Turn, velodyne};

    /// A VLP-32C's packet that starts at `first` and turns back by 70 ticks a firing.
    fn backward(first: i32) -> [u8; velodyne::LEN] {
        let mut packet = [0; velodyne::LEN];
        for (block, nth) in packet[..1200].chunks_exact_mut(100).zip(0..) {
            block[..2].copy_from_slice(&[0xff, 0xee]);
            block[2..4].copy_from_slice(&((first - 70 * nth).rem_euclid(TURN) as u16).to_le_bytes());
        }
        packet[1204..].copy_from_slice(&[0x37, 0x28]);
        packet
    }

    #[test]
    fn a_sensor_that_turns_the_other_way_does_not_count_down_for_ever() {
        let (mut turns, mut stats, mut ended) = (SpinTurns::new(0), PacketStats::new(), 0);
        for nth in 0..5000 {
            let bytes = backward(-840 * nth);
            let packet = SpinPacket::new(&bytes, velodyne::check(&bytes).unwrap()).unwrap();
            let pushed = turns.push(&packet, ReturnPolicy::Strongest, &mut stats, &mut |event| {
                ended += u32::from(matches!(event, Event::TurnEnd(Turn { end: TurnCut::Overflow, .. })));
            });
            assert_eq!(pushed, Ok(()));
            assert!(turns.position >= -TURN);
        }
        assert_eq!((ended, stats.columns), (60_000 / u32::from(MAX_COLUMNS), 60_000));
    }
}
