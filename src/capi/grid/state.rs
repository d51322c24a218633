//! An encoder on a grid in memory of the caller's: what lies where, how it gets there, and how it is found again.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use core::ffi::c_void;

use super::{FLICR_BEAM_LEN, FLICR_GRID_ENCODER_OVERHEAD, FLICR_GRID_FRAME_OVERHEAD_LEN, flicr_turn};
use crate::capi::config::{flicr_encoded, pixels};
use crate::capi::context::{SetsContext, flicr_context};
use crate::capi::encoder::FLICR_ENCODER_ALIGN;
use crate::capi::memory::{Outcome, Records, Span, StartsAsZeros, check_apart, check_place, read};
use crate::capi::sensor::{FLICR_BEAMS_MAX, flicr_grid_config};
use crate::capi::status::flicr_status;
use crate::coder::Coder;
use crate::config::GridConfig;
use crate::encoder::{OpenFrame, Stamp};
use crate::frame::BeamsHeader;
use crate::geometry::Beam;
use crate::image::{ImageViewMut, Level};
use crate::packet::Turn;
use crate::packet_encoder::TurnFrames;

/// An encoder on a grid, in memory of the caller's: this head, the coder's state, the beams, the image.
#[derive(Debug)]
#[repr(align(8))]
pub struct flicr_grid_encoder {
    magic: u32,
    pub(super) has_packets: bool,
    pub(super) calls: Calls,
    layout: Layout,
    columns: usize,
    /// Its beams lie behind this head, in the same memory.
    pub(super) turns: TurnFrames<GridConfig<'static>, 1>,
}

/// Marks memory that holds an encoder on a grid.
const MAGIC: u32 = u32::from_be_bytes(*b"FLCg");

const _: () = {
    assert!(size_of::<flicr_grid_encoder>() <= FLICR_GRID_ENCODER_OVERHEAD);
    assert!(align_of::<flicr_grid_encoder>() == FLICR_ENCODER_ALIGN);
    assert!(FLICR_GRID_ENCODER_OVERHEAD.is_multiple_of(FLICR_ENCODER_ALIGN));
    assert!(FLICR_BEAM_LEN == BeamsHeader::BEAM_LEN && FLICR_BEAM_LEN == size_of::<Beam>());
    let more = BeamsHeader::HEADER_LEN - crate::frame::HEADER_LEN;
    assert!(FLICR_GRID_FRAME_OVERHEAD_LEN == crate::frame::OVERHEAD_LEN + more);
};

/// Where in an encoder's memory its parts are; the coder's state is at `FLICR_GRID_ENCODER_OVERHEAD`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    beams_at: usize,
    image_at: usize,
    pub(super) pixels: usize,
    pub(super) len: usize,
}

impl Layout {
    pub(super) fn new(state_len: usize, columns: u32, beams: u32, level_bits: u32) -> Outcome<Self> {
        let pixels = pixels(columns, beams)?;
        let beams = beams as usize;
        if beams > FLICR_BEAMS_MAX {
            return Err(flicr_status::Size);
        }
        let beams_at = FLICR_GRID_ENCODER_OVERHEAD + state_len;
        let image_at = beams_at + beams * FLICR_BEAM_LEN;
        Ok(Self { beams_at, image_at, pixels, len: image_at + pixels * level_len(level_bits)? })
    }
}

/// Bytes of a pixel.
pub(super) fn level_len(level_bits: u32) -> Outcome<usize> {
    match level_bits {
        1..=8 => Ok(1),
        9..=16 => Ok(2),
        _ => Err(flicr_status::LevelBits),
    }
}

/// Codes and writes the frame of the returns so far.
type Finish = unsafe fn(&mut flicr_grid_encoder, Lent, Stamp, &mut [u8]) -> Outcome<flicr_encoded>;
/// Takes a packet, or the stream's end.
type Push = unsafe fn(&mut flicr_grid_encoder, Lent, Option<&[u8]>, &mut [u8]) -> Outcome<flicr_turn>;

/// What depends on the coder and the level type.
#[derive(Debug, Clone, Copy)]
pub(super) struct Calls {
    pub(super) insert: unsafe fn(&mut flicr_grid_encoder, *mut c_void, Records),
    pub(super) finish: Finish,
    pub(super) push: Push,
    pub(super) is_wide: bool,
}

impl Calls {
    const fn of<L: Level, C: Coder<L>>() -> Self {
        let is_wide = size_of::<L>() > 1;
        Self { insert: insert_with::<L>, finish: finish_with::<L, C>, push: push_with::<L, C>, is_wide }
    }
}

/// The coder's state and the image, of types that only [`Calls`] know.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lent {
    coder: *mut c_void,
    pub(super) levels: *mut c_void,
}

/// # Safety
/// `levels` is where [`place`] has put an encoder's image of `L`, and nobody else uses that before the result's last
/// use.
pub(super) unsafe fn image<'a, L: Level>(
    levels: *mut c_void,
    Layout { pixels, .. }: Layout,
    columns: usize,
) -> Outcome<ImageViewMut<'a, L>> {
    // SAFETY: the caller's promise: all of the image was written, and any bytes are levels.
    let levels = unsafe { core::slice::from_raw_parts_mut(levels.cast::<L>(), pixels) };
    ImageViewMut::new(levels, columns).ok_or(flicr_status::Size)
}

/// # Safety
/// As [`image`]; and the records may be read, and nobody writes to them meanwhile.
unsafe fn insert_with<L: Level>(head: &mut flicr_grid_encoder, levels: *mut c_void, scan: Records) {
    // SAFETY: the caller's promise.
    let (image, returns) = unsafe { (image::<L>(levels, head.layout, head.columns), scan.returns()) };
    if let Ok(mut image) = image {
        head.turns.frame_mut().insert_returns(returns, &mut image);
    }
}

/// # Safety
/// As [`image`], for the coder too.
unsafe fn finish_with<L: Level, C: Coder<L>>(
    head: &mut flicr_grid_encoder,
    Lent { coder, levels }: Lent,
    stamp: Stamp,
    out: &mut [u8],
) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promise.
    let (image, coder) = unsafe { (image::<L>(levels, head.layout, head.columns)?, &mut *coder.cast::<C>()) };
    let frame = head.turns.frame_mut();
    *frame.stamp_mut() = stamp;
    Ok(frame.finish(image.as_view(), coder, out)?.into())
}

/// Begins the next frame.
///
/// # Safety
/// As [`image`].
pub(super) unsafe fn restart(head: &mut flicr_grid_encoder, levels: *mut c_void) -> Outcome<()> {
    let (layout, columns) = (head.layout, head.columns);
    // SAFETY: the caller's promise; the levels are as wide as the calls' type.
    unsafe {
        if head.calls.is_wide {
            head.turns.frame_mut().restart(&mut image::<u16>(levels, layout, columns)?);
        } else {
            head.turns.frame_mut().restart(&mut image::<u8>(levels, layout, columns)?);
        }
    }
    Ok(())
}

/// # Safety
/// As [`finish_with`].
unsafe fn push_with<L: Level, C: Coder<L>>(
    head: &mut flicr_grid_encoder,
    Lent { coder, levels }: Lent,
    packet: Option<&[u8]>,
    out: &mut [u8],
) -> Outcome<flicr_turn> {
    // SAFETY: the caller's promise.
    let (image, coder) = unsafe { (image::<L>(levels, head.layout, head.columns)?, &mut *coder.cast::<C>()) };
    let mut ended = None;
    let mut end = |turn: Turn, [frame]: &[OpenFrame<GridConfig<'static>>; 1], [image]: &[ImageViewMut<'_, L>; 1]| {
        ended = Some((turn, frame.finish(image.as_view(), coder, out)));
    };
    match packet {
        Some(packet) => {
            let pushed = head.turns.push(packet, &mut [image], &mut end);
            pushed.map_err(|_| flicr_status::PacketRefused)?;
        }
        None => head.turns.finish(&mut [image], &mut end),
    }
    let (turn, encoded) = ended.ok_or(flicr_status::TurnOpen)?;
    let Turn { number, columns, missing, .. } = turn;
    Ok(flicr_turn { encoded: encoded?.into(), number, columns: columns.into(), missing: missing.into() })
}

/// # Safety
/// `state` is null or may be written for `state_len` bytes; `settings.beams` is null or may be read.
pub(super) unsafe fn place<C: StartsAsZeros>(
    state: *mut c_void,
    state_len: usize,
    settings: &flicr_grid_config,
    result: Span,
) -> Outcome<*mut flicr_grid_encoder> {
    const { assert!(align_of::<C>() <= FLICR_ENCODER_ALIGN && C::STATE_LEN.is_multiple_of(align_of::<Beam>())) };
    const { assert!(size_of::<C>() <= C::STATE_LEN && <C as Coder<u8>>::ROWS_MAX >= FLICR_BEAMS_MAX) };
    let layout = Layout::new(C::STATE_LEN, settings.columns, settings.beam_count, settings.level_bits)?;
    let assembler = settings.assembler()?;
    let encoder = state.cast::<flicr_grid_encoder>();
    check_place(encoder)?;
    if state_len < layout.len {
        return Err(flicr_status::StateTooSmall);
    }
    check_apart(Span::new(state, layout.len)?, [result])?;
    if !settings.beams.is_null() {
        let beams = Span::new(settings.beams.cast(), settings.beam_count as usize * FLICR_BEAM_LEN)?;
        check_apart(Span::new(state, layout.len)?, [beams])?;
    }
    // SAFETY: the caller's promise; a count that is too large was found above.
    let still = unsafe { settings.still_beams()? };
    check(settings, still)?;
    // SAFETY: `layout.len` bytes may be written. Zeros are a coder that has been vouched for, and an image without
    // returns. The beams are read only from here on, as long as the head is there; they share no byte with the other
    // parts.
    let beams = unsafe {
        state.write_bytes(0, layout.len);
        let place = state.wrapping_byte_add(layout.beams_at).cast::<Beam>();
        place.copy_from_nonoverlapping(still.as_ptr(), still.len());
        let beams = core::slice::from_raw_parts_mut(place, still.len());
        settings.turn(beams)?;
        &*beams
    };
    let (config, columns) = (settings.to_config(beams)?, settings.columns as usize);
    let levels = state.wrapping_byte_add(layout.image_at);
    // SAFETY: the image lies there, and is nobody else's yet.
    let (turns, calls) = unsafe {
        if level_len(settings.level_bits)? == 1 {
            let image = image::<u8>(levels, layout, columns)?;
            (TurnFrames::new(&config, assembler, &mut [image])?, Calls::of::<u8, C>())
        } else {
            let image = image::<u16>(levels, layout, columns)?;
            (TurnFrames::new(&config, assembler, &mut [image])?, Calls::of::<u16, C>())
        }
    };
    let (has_packets, turns) = (settings.has_packets(), turns.with_first_layer(settings.layer()));
    let head = flicr_grid_encoder { magic: MAGIC, has_packets, calls, layout, columns, turns };
    // SAFETY: the head's place, aligned.
    unsafe { encoder.write(head) };
    Ok(encoder)
}

/// # Safety
/// As [`place`]; `config` and `context` are null or may be read.
pub(super) unsafe fn place_context<C: StartsAsZeros + SetsContext>(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    context: *const flicr_context,
    result: Span,
) -> Outcome<*mut flicr_grid_encoder> {
    // SAFETY: the caller's promise; the coder's state lies behind the head, and is nobody else's yet.
    unsafe {
        let settings = read(context)?.to_settings()?;
        let encoder = place::<C>(state, state_len, &read(config)?, result)?;
        let coder = encoder.cast::<c_void>().wrapping_byte_add(FLICR_GRID_ENCODER_OVERHEAD);
        (*coder.cast::<C>()).set_context(settings);
        Ok(encoder)
    }
}

/// Finds now what would be found with the first frame.
fn check(settings: &flicr_grid_config, beams: &[Beam]) -> Outcome<()> {
    let config = settings.to_config(beams)?;
    let (rows, columns) = (beams.len(), settings.columns as usize);
    match level_len(settings.level_bits)? {
        1 => OpenFrame::new::<u8>(&config, || None, Stamp::default(), rows, columns).map(|_| ())?,
        _ => OpenFrame::new::<u16>(&config, || None, Stamp::default(), rows, columns).map(|_| ())?,
    }
    Ok(())
}

/// An encoder's parts.
#[derive(Debug)]
pub(super) struct Parts<'a> {
    pub(super) head: &'a mut flicr_grid_encoder,
    pub(super) lent: Lent,
}

/// Checks that memory is an encoder's, and that the `others` have no part in it or in one another.
///
/// # Safety
/// `encoder` is null or points to memory that is large enough for a head, holds whatever `place` and the functions below
/// have written, and is used by nobody else before the result's last use.
pub(super) unsafe fn parts<'a, const N: usize>(
    encoder: *mut flicr_grid_encoder,
    others: [Span; N],
) -> Outcome<Parts<'a>> {
    check_place(encoder)?;
    // SAFETY: neither null nor misaligned; a number may have any value.
    if unsafe { (&raw const (*encoder).magic).read() } != MAGIC {
        return Err(flicr_status::NotInitialized);
    }
    // SAFETY: so `place` wrote a head here.
    let layout = unsafe { (*encoder).layout };
    check_apart(Span { start: encoder.cast(), len: layout.len }, others)?;
    let at = |offset| encoder.cast::<c_void>().wrapping_byte_add(offset);
    let lent = Lent { coder: at(FLICR_GRID_ENCODER_OVERHEAD), levels: at(layout.image_at) };
    // SAFETY: as above; the head shares no byte with the other parts.
    Ok(Parts { head: unsafe { &mut *encoder }, lent })
}

/// Where an encoder's parts are, and its columns.
///
/// # Safety
/// As [`parts`].
pub(super) unsafe fn shape(encoder: *mut flicr_grid_encoder) -> Outcome<(Layout, usize)> {
    // SAFETY: the caller's promise.
    let Parts { head, .. } = unsafe { parts(encoder, [])? };
    Ok((head.layout, head.columns))
}
