//! An encoder on a sensor's own grid: of returns, or of packets.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use core::ffi::c_void;

use super::config::{CoderCode, flicr_coder, flicr_encoded, flicr_stamp, pixels, strips_of};
use super::context::{CDense, CSmall, SetsContext, flicr_context};
use super::encoder::FLICR_ENCODER_ALIGN;
use super::memory::{Outcome, Output, Records, Span, StartsAsZeros, check_apart, check_place, code, deliver, read};
use super::planes::{LentPlanes, flicr_planes, numbers_of};
use super::sensor::{FLICR_BEAMS_MAX, flicr_grid_config};
use super::status::flicr_status;
use crate::coder::{Coder, DeflateDefault, DeflateDense, DeflateSmall, Rle, Store};
use crate::config::GridConfig;
use crate::encoder::{OpenFrame, Stamp};
use crate::frame::BeamsHeader;
use crate::geometry::Beam;
use crate::image::{ImageViewMut, Level};
use crate::packet::{PacketStats, Turn};
use crate::packet_encoder::TurnFrames;

/// Bytes that a grid encoder takes besides its beams, its coder's state and its image.
pub const FLICR_GRID_ENCODER_OVERHEAD: usize = 768;
/// Bytes that a frame on a grid takes besides its payload, and its beams where it carries them.
pub const FLICR_GRID_FRAME_OVERHEAD_LEN: usize = 84;
/// Bytes of a beam, in an encoder and in a frame.
pub const FLICR_BEAM_LEN: usize = 20;

/// One return, in its sensor's own integers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct flicr_return {
    /// The encoder's tick.
    pub tick: u32,
    /// Range in range units; 0 is no return.
    pub count: u32,
    /// The beam; row 0 is the highest.
    pub row: u32,
}

/// A turn that a packet has ended.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct flicr_turn {
    /// The frame's length, and what became of the returns. Its number is the turn's, its time that of the first column
    /// in the sensor's clock, nanoseconds.
    pub encoded: flicr_encoded,
    /// Number of the turn since the stream began, lost ones counted.
    pub number: u32,
    /// Firings in the turn, missing ones counted.
    pub columns: u32,
    /// Firings that are missing: lost, not measured, or from before the stream began.
    pub missing: u32,
}

/// What became of an encoder's packets.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct flicr_packet_stats {
    /// Packets used.
    pub used: u32,
    /// Packets refused.
    pub refused: u32,
    /// Firings in the packets used.
    pub columns: u32,
    /// Firings that packets lost or refused should have held.
    pub lost_columns: u32,
    /// Turns that ended.
    pub turns: u32,
    /// Turns of which nothing was received.
    pub lost_turns: u32,
}

/// An encoder on a grid, in memory of the caller's: this head, the coder's state, the beams, the image.
#[derive(Debug)]
#[repr(align(8))]
pub struct flicr_grid_encoder {
    magic: u32,
    has_packets: bool,
    calls: Calls,
    layout: Layout,
    columns: usize,
    /// Its beams lie behind this head, in the same memory.
    turns: TurnFrames<GridConfig<'static>, 1>,
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

/// What FLICR_GRID_ENCODER_SIZE gives: bytes that an encoder takes. 0 where there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_grid_encoder_size(columns: u32, beams: u32, level_bits: u32, coder: CoderCode) -> usize {
    let layout = |coder: flicr_coder| Layout::new(coder.state_len(), columns, beams, level_bits).ok();
    flicr_coder::from_code(coder).and_then(layout).map_or(0, |layout| layout.len)
}

/// What FLICR_GRID_WORST_CASE_LEN gives: output bytes that are enough for every frame. 0 where there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_grid_worst_case_len(columns: u32, beams: u32, level_bits: u32, coder: CoderCode) -> usize {
    worst_case_len(columns, beams, level_bits, coder, 1).unwrap_or(0)
}

/// What FLICR_GRID_WORST_CASE_LEN_IN_STRIPS gives: output bytes that are enough for every frame of so many strips. 0 where
/// there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_grid_worst_case_len_in_strips(
    columns: u32,
    beams: u32,
    level_bits: u32,
    coder: CoderCode,
    strips: u32,
) -> usize {
    worst_case_len(columns, beams, level_bits, coder, strips).unwrap_or(0)
}

/// Makes an encoder that stores levels as they are, in memory of at least FLICR_GRID_ENCODER_SIZE(config->columns,
/// config->beam_count, config->level_bits, FLICR_CODER_STORE) bytes, aligned to FLICR_ENCODER_ALIGN.
///
/// FLICR_STATUS_STATE_TOO_SMALL, FLICR_STATUS_MISALIGNED, and any status that names a member of the configuration.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_grid_encoder_init_store(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    out_encoder: *mut *mut flicr_grid_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoder, |result| place::<Store>(state, state_len, &read(config)?, result)) }
}

/// As flicr_grid_encoder_init_store, for FLICR_CODER_RLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_grid_encoder_init_rle(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    out_encoder: *mut *mut flicr_grid_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoder, |result| place::<Rle>(state, state_len, &read(config)?, result)) }
}

/// As flicr_grid_encoder_init_store, for FLICR_CODER_DEFLATE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_grid_encoder_init_deflate(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    out_encoder: *mut *mut flicr_grid_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoder, |result| place::<DeflateDefault>(state, state_len, &read(config)?, result)) }
}

/// As flicr_grid_encoder_init_store, for FLICR_CODER_DEFLATE_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_grid_encoder_init_deflate_small(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    out_encoder: *mut *mut flicr_grid_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoder, |result| place::<DeflateSmall>(state, state_len, &read(config)?, result)) }
}

/// As flicr_grid_encoder_init_store, for FLICR_CODER_DEFLATE_DENSE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_grid_encoder_init_deflate_dense(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    out_encoder: *mut *mut flicr_grid_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoder, |result| place::<DeflateDense>(state, state_len, &read(config)?, result)) }
}

/// As flicr_grid_encoder_init_store, for FLICR_CODER_SMALL with these settings.
///
/// FLICR_STATUS_CONTEXT.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_grid_encoder_init_small(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    context: *const flicr_context,
    out_encoder: *mut *mut flicr_grid_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoder, |result| place_context::<CSmall>(state, state_len, config, context, result)) }
}

/// As flicr_grid_encoder_init_small, for FLICR_CODER_DENSE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_grid_encoder_init_dense(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    context: *const flicr_context,
    out_encoder: *mut *mut flicr_grid_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoder, |result| place_context::<CDense>(state, state_len, config, context, result)) }
}

/// Puts returns into the frame that is open: `count` records, `stride_bytes` apart, each starting with a flicr_return,
/// at any alignment. Of the last record only these 12 bytes are read. Returns on a row or tick that the grid does not
/// have are counted as out of view.
///
/// FLICR_STATUS_STRIDE, FLICR_STATUS_TOO_MANY_POINTS, FLICR_STATUS_OVERLAP: none of the returns are in the frame then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_insert_returns(
    encoder: *mut flicr_grid_encoder,
    returns: *const c_void,
    count: usize,
    stride_bytes: usize,
) -> flicr_status {
    // SAFETY: the caller's promises about `encoder` and `returns`.
    code(Records::new(returns, count, stride_bytes).and_then(|scan| unsafe { insert(encoder, scan) }))
}

/// Codes the frame of the returns so far to the front of `out`, and begins the next.
///
/// FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_GRID_WORST_CASE_LEN bytes, and FLICR_STATUS_OVERLAP: the frame stays
/// open then, to be finished elsewhere.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_finish_returns(
    encoder: *mut flicr_grid_encoder,
    stamp: flicr_stamp,
    out: *mut c_void,
    out_len: usize,
    out_encoded: *mut flicr_encoded,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoded, |result| finish(encoder, stamp, Output::new(out, out_len)?, result)) }
}

/// As flicr_insert_returns, with an intensity for each return: `numbers` are `count` of them, and that of a return that a
/// pixel keeps goes into planes->intensities.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_insert_lit_returns(
    encoder: *mut flicr_grid_encoder,
    returns: *const c_void,
    count: usize,
    stride_bytes: usize,
    numbers: *const u8,
    planes: *const flicr_planes,
) -> flicr_status {
    let scan = Records::new(returns, count, stride_bytes);
    // SAFETY: the caller's promises about the pointers.
    code(scan.and_then(|scan| unsafe { insert_lit(encoder, scan, numbers_of(&scan, numbers)?, read(planes)?) }))
}

/// As flicr_finish_returns, with planes besides the ranges.
///
/// FLICR_STATUS_PLANE; FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_PLANES_WORST_CASE_LEN bytes more than the frame
/// takes without.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_finish_returns_with(
    encoder: *mut flicr_grid_encoder,
    stamp: flicr_stamp,
    planes: *const flicr_planes,
    out: *mut c_void,
    out_len: usize,
    out_encoded: *mut flicr_encoded,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    let work = |result| unsafe { finish_planes(encoder, stamp, read(planes)?, Output::new(out, out_len)?, result) };
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoded, work) }
}

/// Takes one UDP payload of the sensor. Where it ends a turn, FLICR_STATUS_OK: the turn's frame is at the front of
/// `out`, and what the packet holds of the next turn is kept. Until then FLICR_STATUS_TURN_OPEN.
///
/// FLICR_STATUS_PACKET_REFUSED: the packet is not one of the sensor's, is damaged, late or doubled; nothing of it is
/// used, and it is counted. FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_GRID_WORST_CASE_LEN bytes: the turn is
/// lost, the next has begun. FLICR_STATUS_SENSOR: the configuration names no sensor whose packets are known.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_push_packet(
    encoder: *mut flicr_grid_encoder,
    packet: *const c_void,
    packet_len: usize,
    out: *mut c_void,
    out_len: usize,
    out_turn: *mut flicr_turn,
) -> flicr_status {
    let work = |result| {
        let (packet, out) = (Span::new(packet, packet_len)?, Output::new(out, out_len)?);
        // SAFETY: the caller's promises about the pointers.
        unsafe { push(encoder, Some(packet), out, result) }
    };
    // SAFETY: the caller's promise about `out_turn`.
    unsafe { deliver(out_turn, work) }
}

/// Ends the turn that is open, as flicr_push_packet does; the next packet starts the stream anew.
/// FLICR_STATUS_TURN_OPEN where there was none.
///
/// FLICR_STATUS_OUTPUT_TOO_SMALL, FLICR_STATUS_SENSOR.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_finish_packets(
    encoder: *mut flicr_grid_encoder,
    out: *mut c_void,
    out_len: usize,
    out_turn: *mut flicr_turn,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_turn, |result| push(encoder, None, Output::new(out, out_len)?, result)) }
}

/// Says what became of the packets so far.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_get_packet_stats(
    encoder: *mut flicr_grid_encoder,
    out_stats: *mut flicr_packet_stats,
) -> flicr_status {
    // SAFETY: the caller's promises about both pointers.
    unsafe { deliver(out_stats, |result| Ok(parts(encoder, [result])?.head.turns.stats().into())) }
}

/// Where in an encoder's memory its parts are; the coder's state is at `FLICR_GRID_ENCODER_OVERHEAD`.
#[derive(Debug, Clone, Copy)]
struct Layout {
    beams_at: usize,
    image_at: usize,
    pixels: usize,
    len: usize,
}

impl Layout {
    fn new(state_len: usize, columns: u32, beams: u32, level_bits: u32) -> Outcome<Self> {
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
fn level_len(level_bits: u32) -> Outcome<usize> {
    match level_bits {
        1..=8 => Ok(1),
        9..=16 => Ok(2),
        _ => Err(flicr_status::LevelBits),
    }
}

fn worst_case_len(columns: u32, beams: u32, level_bits: u32, coder: CoderCode, strips: u32) -> Option<usize> {
    pixels(columns, beams).ok().filter(|_| beams as usize <= FLICR_BEAMS_MAX)?;
    let (coder, strips) = (flicr_coder::from_code(coder)?, strips_of(columns, strips)?);
    let len = match level_len(level_bits).ok()? {
        1 => coder.worst_case_len::<u8>(beams as usize, columns as usize, strips),
        _ => coder.worst_case_len::<u16>(beams as usize, columns as usize, strips),
    };
    let more = FLICR_GRID_FRAME_OVERHEAD_LEN - crate::frame::OVERHEAD_LEN;
    Some(len + more + beams as usize * FLICR_BEAM_LEN)
}

/// Codes and writes the frame of the returns so far.
type Finish = unsafe fn(&mut flicr_grid_encoder, Lent, Stamp, &mut [u8]) -> Outcome<flicr_encoded>;
/// Takes a packet, or the stream's end.
type Push = unsafe fn(&mut flicr_grid_encoder, Lent, Option<&[u8]>, &mut [u8]) -> Outcome<flicr_turn>;

/// What depends on the coder and the level type.
#[derive(Debug, Clone, Copy)]
struct Calls {
    insert: unsafe fn(&mut flicr_grid_encoder, *mut c_void, Records),
    finish: Finish,
    push: Push,
    is_wide: bool,
}

impl Calls {
    const fn of<L: Level, C: Coder<L>>() -> Self {
        let is_wide = size_of::<L>() > 1;
        Self { insert: insert_with::<L>, finish: finish_with::<L, C>, push: push_with::<L, C>, is_wide }
    }
}

/// The coder's state and the image, of types that only [`Calls`] know.
#[derive(Debug, Clone, Copy)]
struct Lent {
    coder: *mut c_void,
    levels: *mut c_void,
}

/// # Safety
/// `levels` is where [`place`] has put an encoder's image of `L`, and nobody else uses that before the result's last
/// use.
unsafe fn image<'a, L: Level>(
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
unsafe fn restart(head: &mut flicr_grid_encoder, levels: *mut c_void) -> Outcome<()> {
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
unsafe fn place<C: StartsAsZeros>(
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
unsafe fn place_context<C: StartsAsZeros + SetsContext>(
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
struct Parts<'a> {
    head: &'a mut flicr_grid_encoder,
    lent: Lent,
}

/// Checks that memory is an encoder's, and that the `others` have no part in it or in one another.
///
/// # Safety
/// `encoder` is null or points to memory that is large enough for a head, holds whatever `place` and the functions below
/// have written, and is used by nobody else before the result's last use.
unsafe fn parts<'a, const N: usize>(encoder: *mut flicr_grid_encoder, others: [Span; N]) -> Outcome<Parts<'a>> {
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

/// # Safety
/// As the header demands of `flicr_insert_returns`.
unsafe fn insert(encoder: *mut flicr_grid_encoder, scan: Records) -> Outcome<()> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    unsafe {
        let Parts { head, lent } = parts(encoder, [scan.span])?;
        let before = head.turns.frame_mut().tally().points;
        before.checked_add(scan.count).ok_or(flicr_status::TooManyPoints)?;
        (head.calls.insert)(head, lent.levels, scan);
    }
    Ok(())
}

/// # Safety
/// As the header demands of `flicr_finish_returns`.
unsafe fn finish(
    encoder: *mut flicr_grid_encoder,
    stamp: flicr_stamp,
    out: Output,
    result: Span,
) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    unsafe {
        let Parts { head, lent } = parts(encoder, [out.span, result])?;
        let finished = (head.calls.finish)(head, lent, stamp.into(), out.bytes())?;
        restart(head, lent.levels)?;
        Ok(finished)
    }
}

/// # Safety
/// As the header demands of `flicr_insert_lit_returns`.
unsafe fn insert_lit(
    encoder: *mut flicr_grid_encoder,
    scan: Records,
    numbers: Span,
    planes: flicr_planes,
) -> Outcome<()> {
    // SAFETY: the caller's promises; the second `parts` has found all that is borrowed here to be apart.
    unsafe {
        let (layout, columns) = shape(encoder)?;
        let planes = LentPlanes::new(planes, layout.pixels, columns)?;
        let [plane, state, times] = planes.spans();
        let Parts { head, lent } = parts(encoder, [scan.span, numbers, plane, state, times])?;
        let before = head.turns.frame_mut().tally().points;
        before.checked_add(scan.count).ok_or(flicr_status::TooManyPoints)?;
        let (returns, plane) = (scan.returns().zip(numbers.bytes().iter().copied()), planes.numbers()?);
        let keep = |pixel: usize, number: u8| {
            if let Some(kept) = plane.get_mut(pixel) {
                *kept = number;
            }
        };
        let is_wide = head.calls.is_wide;
        let frame = head.turns.frame_mut();
        if is_wide {
            frame.insert_returns_with(returns, &mut image::<u16>(lent.levels, layout, columns)?, keep);
        } else {
            frame.insert_returns_with(returns, &mut image::<u8>(lent.levels, layout, columns)?, keep);
        }
    }
    Ok(())
}

/// # Safety
/// As the header demands of `flicr_finish_returns_with`.
unsafe fn finish_planes(
    encoder: *mut flicr_grid_encoder,
    stamp: flicr_stamp,
    planes: flicr_planes,
    out: Output,
    result: Span,
) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promises; the second `parts` has found all that is borrowed here to be apart.
    unsafe {
        let (layout, columns) = shape(encoder)?;
        let planes = LentPlanes::new(planes, layout.pixels, columns)?;
        let [plane, state, times] = planes.spans();
        let Parts { head, lent } = parts(encoder, [out.span, result, plane, state, times])?;
        let out = out.bytes();
        let mut finished = (head.calls.finish)(head, lent, stamp.into(), out)?;
        finished.len = if head.calls.is_wide {
            let image = image::<u16>(lent.levels, layout, columns)?;
            planes.append(image.as_view(), stamp.timestamp_ns, finished.len, out)?
        } else {
            let image = image::<u8>(lent.levels, layout, columns)?;
            planes.append(image.as_view(), stamp.timestamp_ns, finished.len, out)?
        };
        restart(head, lent.levels)?;
        Ok(finished)
    }
}

/// Where an encoder's parts are, and its columns.
///
/// # Safety
/// As [`parts`].
unsafe fn shape(encoder: *mut flicr_grid_encoder) -> Outcome<(Layout, usize)> {
    // SAFETY: the caller's promise.
    let Parts { head, .. } = unsafe { parts(encoder, [])? };
    Ok((head.layout, head.columns))
}

/// # Safety
/// As the header demands of `flicr_push_packet`.
unsafe fn push(
    encoder: *mut flicr_grid_encoder,
    packet: Option<Span>,
    out: Output,
    result: Span,
) -> Outcome<flicr_turn> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    unsafe {
        let Parts { head, lent } = parts(encoder, [packet.unwrap_or(Span::NONE), out.span, result])?;
        if !head.has_packets {
            return Err(flicr_status::Sensor);
        }
        (head.calls.push)(head, lent, packet.map(|packet| packet.bytes()), out.bytes())
    }
}

impl From<PacketStats> for flicr_packet_stats {
    fn from(stats: PacketStats) -> Self {
        let PacketStats { used, columns, lost_columns, turns, lost_turns, .. } = stats;
        Self { used, refused: stats.refused(), columns, lost_columns, turns, lost_turns }
    }
}
