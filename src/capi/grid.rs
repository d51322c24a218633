//! An encoder on a sensor's own grid: of returns, or of packets.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

mod state;

use core::ffi::c_void;

use super::config::{CoderCode, flicr_coder, flicr_encoded, flicr_stamp, pixels, strips_of};
use super::context::{CDense, CSmall, flicr_context};
use super::memory::{Outcome, Output, Records, Span, code, deliver, read};
use super::planes::{LentPlanes, flicr_planes, numbers_of};
use super::sensor::{FLICR_BEAMS_MAX, flicr_grid_config};
use super::status::flicr_status;
use crate::coder::{DeflateDefault, DeflateDense, DeflateSmall, Rle, Store};
use crate::packet::PacketStats;

pub use state::flicr_grid_encoder;
use state::{Layout, Parts, image, level_len, parts, place, place_context, restart, shape};

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
