//! A sensor's packets in, a frame for every turn out.

use core::fmt;

use crate::coder::Coder;
use crate::config::GridSettings;
use crate::encoder::{Encoded, OpenFrame, Stamp};
use crate::error::EncodeError;
use crate::image::{ImageViewMut, Level};
use crate::packet::{Column, Event, PacketError, PacketStats, Turn, TurnAssembler};
use crate::returns::ReturnScale;

/// A turn that has been encoded: one frame a layer, back to back in the output.
///
/// Frames carry the turn's number as their sequence number, and the time of its first column in the sensor's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EncodedTurn<const LAYERS: usize = 1> {
    /// The turn, with how many of its columns are missing.
    pub turn: Turn,
    /// The frames' lengths, and what became of the returns.
    pub frames: [Encoded; LAYERS],
}

/// Why a packet gave no frame.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PushError {
    /// The packet was refused: nothing of it is in any frame, and the stream goes on with the next.
    Packet(PacketError),
    /// The packet ended a turn whose frame cannot be written. The turn is lost; the next one has begun.
    Encode(EncodeError),
}

impl From<PacketError> for PushError {
    fn from(error: PacketError) -> Self {
        Self::Packet(error)
    }
}

impl From<EncodeError> for PushError {
    fn from(error: EncodeError) -> Self {
        Self::Encode(error)
    }
}

impl fmt::Display for PushError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Packet(error) => write!(f, "packet refused: {error}"),
            Self::Encode(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for PushError {}

/// Encodes a sensor's packets: one image, and so one frame a turn, for each layer.
///
/// `LAYERS` is 1, or 2 for both returns of [`ReturnPolicy::Both`](crate::packet::ReturnPolicy::Both): then the second
/// frame holds the returns that the first leaves. Layers for which there is no image are left out.
///
/// RAM: the images and the coder, which are borrowed, and a few hundred bytes
/// ([`size_of`](core::mem::size_of) tells).
///
/// ```
/// use flicr::geometry::sensors::velodyne;
/// use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
/// use flicr::{GridConfig, PacketEncoder, RangeImage, Rle};
///
/// let (mut image, mut coder) = (RangeImage::<16, 1800, u16>::new(), Rle::new());
/// // The beams fire one after another while the sensor turns, here at 600 turns a minute.
/// let beams = velodyne::VLP16.beams_at::<16>(600).expect("16 beams");
/// let config = GridConfig::new(velodyne::VLP16.grid_of(&beams), 1800);
/// let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
///
/// let turns = TurnAssembler::new(Sensor::Spinning(Model::Vlp16), ReturnPolicy::Strongest);
/// let mut encoder = PacketEncoder::new(&config, turns, [image.view_mut()], &mut coder)?;
/// # let datagrams = [[0; 100]];
/// for datagram in &datagrams {
///     match encoder.push(datagram, &mut out) {
///         Ok(Some(encoded)) => println!("{} bytes of turn {}", encoded.frames[0].len, encoded.turn.number),
///         Ok(None) => {} // the turn goes on
///         Err(error) => println!("{error}"),
///     }
/// }
/// # Ok::<(), flicr::EncodeError>(())
/// ```
#[derive(Debug)]
pub struct PacketEncoder<'a, L: Level, C, S: GridSettings, const LAYERS: usize = 1> {
    turns: TurnFrames<S, LAYERS>,
    images: [ImageViewMut<'a, L>; LAYERS],
    coder: &'a mut C,
}

impl<'a, L: Level, C: Coder<L>, S: GridSettings, const LAYERS: usize> PacketEncoder<'a, L, C, S, LAYERS> {
    /// Empties the images and begins the first turn. `turns` says whose packets come, which of two returns is meant
    /// and where turns are cut.
    ///
    /// # Errors
    /// As [`FrameEncoder::start`](crate::FrameEncoder::start).
    pub fn new(
        config: &S,
        turns: TurnAssembler,
        mut images: [ImageViewMut<'a, L>; LAYERS],
        coder: &'a mut C,
    ) -> Result<Self, EncodeError> {
        Ok(Self { turns: TurnFrames::new(config, turns, &mut images)?, images, coder })
    }

    /// Takes one UDP payload. Where it ends a turn, the turn's frames are written to the front of `out`; what it holds
    /// of the next turn is kept.
    ///
    /// A packet ends one turn at most: should it end two, by jumping over most of one, the columns between are put into
    /// the next.
    ///
    /// # Errors
    /// [`PushError`]; [`PushError::Encode`] never with `LAYERS` times
    /// [`GridConfig::worst_case_len`](crate::GridConfig::worst_case_len) bytes.
    pub fn push(&mut self, packet: &[u8], out: &mut [u8]) -> Result<Option<EncodedTurn<LAYERS>>, PushError> {
        let mut ended = None;
        let mut end = |turn, frames: &[OpenFrame<S>; LAYERS], images: &[ImageViewMut<'a, L>; LAYERS]| {
            ended = Some(encode_turn(turn, frames, images, self.coder, out));
        };
        self.turns.push(packet, &mut self.images, &mut end)?;
        // Not by `transpose`: that would copy as much where no turn ended.
        match ended {
            None => Ok(None),
            Some(Ok(turn)) => Ok(Some(turn)),
            Some(Err(error)) => Err(error.into()),
        }
    }

    /// Ends the turn that is open, if it has columns, and writes its frames as [`push`](Self::push) does; the next
    /// packet starts the stream anew.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    pub fn finish(&mut self, out: &mut [u8]) -> Result<Option<EncodedTurn<LAYERS>>, EncodeError> {
        let mut ended = None;
        let mut end = |turn, frames: &[OpenFrame<S>; LAYERS], images: &[ImageViewMut<'a, L>; LAYERS]| {
            ended = Some(encode_turn(turn, frames, images, self.coder, out));
        };
        self.turns.finish(&mut self.images, &mut end);
        ended.transpose()
    }

    /// What became of the packets so far.
    #[must_use]
    pub const fn stats(&self) -> PacketStats {
        self.turns.stats()
    }
}

fn encode_turn<L: Level, C: Coder<L>, S: GridSettings, const LAYERS: usize>(
    turn: Turn,
    frames: &[OpenFrame<S>; LAYERS],
    images: &[ImageViewMut<'_, L>; LAYERS],
    coder: &mut C,
    out: &mut [u8],
) -> Result<EncodedTurn<LAYERS>, EncodeError> {
    let mut encoded = [Encoded::NONE; LAYERS];
    let mut at = 0;
    for ((frame, image), encoded) in frames.iter().zip(images).zip(&mut encoded) {
        *encoded = frame.finish(image.as_view(), coder, out.get_mut(at..).unwrap_or(&mut []))?;
        at += encoded.len;
    }
    Ok(EncodedTurn { turn, frames: encoded })
}

/// The frames of the turn that is open. Images and coder are lent to each step, as to [`OpenFrame`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct TurnFrames<S: GridSettings, const LAYERS: usize> {
    assembler: TurnAssembler,
    frames: [OpenFrame<S>; LAYERS],
    scale: ReturnScale,
    /// The layer of the first frame; those before it are left out.
    #[cfg(feature = "capi")]
    first_layer: u8,
}

impl<S: GridSettings, const LAYERS: usize> TurnFrames<S, LAYERS> {
    pub(crate) fn new<L: Level>(
        config: &S,
        assembler: TurnAssembler,
        images: &mut [ImageViewMut<'_, L>; LAYERS],
    ) -> Result<Self, EncodeError> {
        const { assert!(LAYERS > 0, "an image at least") };
        let mut frame = OpenFrame::start(config, Stamp::default(), &mut images[0])?;
        for image in images.iter_mut().skip(1) {
            frame = OpenFrame::start(config, Stamp::default(), image)?;
        }
        Ok(Self {
            assembler,
            scale: frame.return_scale(),
            frames: [frame; LAYERS],
            #[cfg(feature = "capi")]
            first_layer: 0,
        })
    }

    /// The same with the first frame for another layer than the first.
    #[cfg(feature = "capi")]
    pub(crate) const fn with_first_layer(self, first_layer: u8) -> Self {
        Self { first_layer, ..self }
    }

    pub(crate) const fn stats(&self) -> PacketStats {
        self.assembler.stats()
    }

    /// The first layer's frame, for returns that are no packets'.
    #[cfg(feature = "capi")]
    pub(crate) const fn frame_mut(&mut self) -> &mut OpenFrame<S> {
        &mut self.frames[0]
    }

    /// Takes a packet; calls `end` with the frames of the turn that it ends.
    pub(crate) fn push<'i, L: Level>(
        &mut self,
        packet: &[u8],
        images: &mut [ImageViewMut<'i, L>; LAYERS],
        end: &mut impl FnMut(Turn, &[OpenFrame<S>; LAYERS], &[ImageViewMut<'i, L>; LAYERS]),
    ) -> Result<(), PacketError> {
        #[cfg(feature = "capi")]
        let first_layer = self.first_layer;
        #[cfg(not(feature = "capi"))]
        let first_layer = 0;
        let Self { assembler, frames, scale, .. } = self;
        let mut ended = false;
        assembler.push(packet, |event| match &event {
            Event::Column(column) => insert(column, column.layer.wrapping_sub(first_layer), scale, frames, images),
            Event::TurnEnd(turn) if !ended => {
                ended = true;
                end_turn(*turn, frames, images, end);
            }
            _ => {}
        })
    }

    /// Ends the stream; calls `end` with the frames of the turn that was open.
    pub(crate) fn finish<'i, L: Level>(
        &mut self,
        images: &mut [ImageViewMut<'i, L>; LAYERS],
        end: &mut impl FnMut(Turn, &[OpenFrame<S>; LAYERS], &[ImageViewMut<'i, L>; LAYERS]),
    ) {
        let Self { assembler, frames, .. } = self;
        assembler.finish(|event| {
            if let Event::TurnEnd(turn) = event {
                end_turn(turn, frames, images, end);
            }
        });
    }
}

#[inline]
fn insert<S: GridSettings, L: Level, const LAYERS: usize>(
    column: &Column<'_>,
    layer: u8,
    scale: &ReturnScale,
    frames: &mut [OpenFrame<S>; LAYERS],
    images: &mut [ImageViewMut<'_, L>; LAYERS],
) {
    let layer = usize::from(layer);
    if let (Some(frame), Some(image)) = (frames.get_mut(layer), images.get_mut(layer)) {
        if layer == 0 && frame.tally().points == 0 {
            frame.stamp_mut().timestamp_ns = column.time_ns;
        }
        frame.insert_column(column, scale, image);
    }
}

#[cold]
#[inline(never)]
fn end_turn<'i, S: GridSettings, L: Level, const LAYERS: usize>(
    turn: Turn,
    frames: &mut [OpenFrame<S>; LAYERS],
    images: &mut [ImageViewMut<'i, L>; LAYERS],
    end: &mut impl FnMut(Turn, &[OpenFrame<S>; LAYERS], &[ImageViewMut<'i, L>; LAYERS]),
) {
    // Layer 0 is never without columns where another has some.
    let stamp = Stamp { sequence: turn.number, ..*frames[0].stamp_mut() };
    for frame in frames.iter_mut() {
        *frame.stamp_mut() = stamp;
    }
    end(turn, frames, images);
    for (frame, image) in frames.iter_mut().zip(images) {
        frame.restart(image);
    }
}
