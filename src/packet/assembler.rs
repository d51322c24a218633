//! From datagrams to columns: the one door to this module.

use super::ouster::{self, OusterFormat};
use super::ouster_turns::OusterTurns;
use super::spin::{Frame, SpinPacket};
use super::spin_turns::SpinTurns;
use super::{Event, Model, PacketError, PacketStats, ReturnPolicy, pandar_xt, pandar40p, pandar64, velodyne};

/// Whose packets to expect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Sensor {
    /// Any Velodyne or Hesai sensor: the first good packet tells which, and packets of another are
    /// then refused. An Ouster's packets do not say enough: give its format.
    #[default]
    Auto,
    /// This Velodyne or Hesai sensor only.
    Spinning(Model),
    /// An Ouster that packs its columns like this.
    Ouster(OusterFormat),
}

/// Turns a sensor's datagrams into columns, turns and marked gaps.
///
/// Push each UDP payload as it comes. A payload is checked whole before any of it is used; a bad
/// one is refused with a reason, counted, and leaves its neighbours alone: the columns it should
/// have held come out as a gap. Nothing is stored but where the last packet ended: a few hundred
/// bytes ([`size_of`](core::mem::size_of) tells), on every sensor.
///
/// ```
/// use flicr::packet::{Event, ReturnPolicy, Sensor, TurnAssembler};
///
/// let mut turns = TurnAssembler::new(Sensor::Auto, ReturnPolicy::Strongest);
/// # let datagram = [0; 100];
/// let outcome = turns.push(&datagram, |event| match event {
///     Event::Column(column) => column.for_each_return(|r| {
///         // image[r.beam][r.column] = r.count
///         # let _ = r;
///     }),
///     Event::TurnEnd(turn) => println!("turn {} of {} columns", turn.number, turn.columns),
///     _ => {}
/// });
/// // 100 bytes are no packet of any sensor:
/// assert!(outcome.is_err());
/// assert_eq!(turns.stats().wrong_length, 1);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TurnAssembler {
    sensor: Sensor,
    policy: ReturnPolicy,
    spin: SpinTurns,
    ouster: OusterTurns,
    stats: PacketStats,
}

impl TurnAssembler {
    /// An assembler that cuts turns at azimuth 0.
    #[must_use]
    pub const fn new(sensor: Sensor, policy: ReturnPolicy) -> Self {
        Self { sensor, policy, spin: SpinTurns::new(0), ouster: OusterTurns::new(), stats: PacketStats::new() }
    }

    /// Cuts turns at this azimuth, in ticks, instead of 0. Ouster's turns are always cut where its
    /// frame number goes up.
    #[must_use]
    pub const fn with_cut(mut self, tick: u16) -> Self {
        self.spin = SpinTurns::new(tick % super::model::TICKS_PER_TURN);
        self
    }

    /// The Velodyne or Hesai sensor of this stream, once it is known.
    #[must_use]
    pub const fn model(&self) -> Option<Model> {
        match self.sensor {
            Sensor::Spinning(model) => Some(model),
            Sensor::Auto | Sensor::Ouster(_) => None,
        }
    }

    /// What became of the packets so far.
    #[must_use]
    pub const fn stats(&self) -> PacketStats {
        self.stats
    }

    /// Takes one UDP payload and gives `sink` what follows from it.
    ///
    /// # Errors
    /// Why the packet was refused; then `sink` was not called, and the stream goes on with the next
    /// packet.
    pub fn push(&mut self, packet: &[u8], mut sink: impl FnMut(Event<'_>)) -> Result<(), PacketError> {
        let outcome = match self.sensor {
            Sensor::Ouster(format) => self.push_ouster(packet, &format, &mut sink),
            Sensor::Auto | Sensor::Spinning(_) => self.push_spinning(packet, &mut sink),
        };
        match outcome {
            Ok(()) => self.stats.used = self.stats.used.saturating_add(1),
            Err(error) => self.stats.count_refused(error),
        }
        outcome
    }

    /// Ends the turn that is open, if it has columns, and forgets where the stream was; the next
    /// packet starts it anew.
    pub fn finish(&mut self, mut sink: impl FnMut(Event<'_>)) {
        match self.sensor {
            Sensor::Ouster(_) => self.ouster.finish(&mut self.stats, &mut sink),
            Sensor::Auto | Sensor::Spinning(_) => self.spin.finish(&mut self.stats, &mut sink),
        }
    }

    fn push_spinning(&mut self, packet: &[u8], sink: &mut impl FnMut(Event<'_>)) -> Result<(), PacketError> {
        let checked = SpinPacket::new(packet, check_frame(packet)?)?;
        let model = checked.layout.model;
        if let Some(expected) = self.model()
            && expected != model
        {
            return Err(PacketError::Model { found: model.code(), expected: expected.code() });
        }
        self.spin.push(&checked, self.policy, &mut self.stats, sink)?;
        self.sensor = Sensor::Spinning(model);
        Ok(())
    }

    fn push_ouster(
        &mut self,
        packet: &[u8],
        format: &OusterFormat,
        sink: &mut impl FnMut(Event<'_>),
    ) -> Result<(), PacketError> {
        let expected = format.packet_len();
        if packet.len() != expected {
            return Err(PacketError::Length { found: packet.len() as u32, expected: expected as u32 });
        }
        let checked = ouster::check(packet, format)?;
        self.ouster.push(&checked, format, self.policy, &mut self.stats, sink)
    }
}

/// The format is told by the length; the format's own check finds the model.
fn check_frame(packet: &[u8]) -> Result<Frame, PacketError> {
    match packet.len() {
        velodyne::LEN => velodyne::check(packet),
        len if pandar40p::LENS.contains(&len) => pandar40p::check(packet),
        len if pandar64::LENS.contains(&len) => pandar64::check(packet),
        pandar_xt::LEN => pandar_xt::check(packet),
        len => Err(PacketError::Length { found: len as u32, expected: 0 }),
    }
}
