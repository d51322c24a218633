//! An encoder of points.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use core::ffi::c_void;

use super::config::{
    CoderCode, flicr_coder, flicr_collision, flicr_companding, flicr_config, flicr_encoded, flicr_out_of_view,
    flicr_placement, flicr_stamp, pixels, strips_of,
};
use super::context::{
    CDense, CSmall, FLICR_CONTEXT_BLOCK_COST, FLICR_CONTEXT_BLOCK_LEN, FLICR_CONTEXT_ROWS_MAX, SetsContext,
    flicr_context,
};
use super::memory::{Outcome, Output, Records, Span, StartsAsZeros, check_apart, check_place, code, deliver, read};
use super::planes::{LentPlanes, flicr_planes, numbers_of};
use super::status::flicr_status;
use crate::coder::{Coder, DeflateDefault, DeflateDense, DeflateSmall, Rle, Store, WorstCase};
use crate::config::Config;
use crate::encoder::{OpenFrame, Stamp};
use crate::frame;
use crate::geometry::Placement;
use crate::image::{ImageView, ImageViewMut};
use crate::insert::{Collision, Numbers, OutOfView};
use crate::quantize::Companding;

/// An encoder's memory must start at a multiple of this many bytes.
pub const FLICR_ENCODER_ALIGN: usize = 8;
/// Bytes that an encoder takes besides its image and its coder's state.
pub const FLICR_ENCODER_OVERHEAD: usize = 256;
/// Bytes that a frame takes besides its payload.
pub const FLICR_FRAME_OVERHEAD_LEN: usize = 76;
/// Of these, those that each strip takes.
pub const FLICR_STRIP_OVERHEAD_LEN: usize = 8;
/// Bytes of the state of FLICR_CODER_DEFLATE.
pub const FLICR_DEFLATE_STATE_LEN: usize = 56_556;
/// Bytes of the state of FLICR_CODER_DEFLATE_SMALL.
pub const FLICR_DEFLATE_SMALL_STATE_LEN: usize = 13_548;
/// Bytes of the state of FLICR_CODER_DEFLATE_DENSE.
pub const FLICR_DEFLATE_DENSE_STATE_LEN: usize = 204_012;
/// FLICR_CODER_RLE writes one byte more for each so many pixels that do not repeat.
pub const FLICR_RLE_BLOCK_LEN: usize = 128;
/// FLICR_CODER_DEFLATE writes FLICR_DEFLATE_BLOCK_COST bytes more for each so many pixels that it cannot make smaller.
pub const FLICR_DEFLATE_BLOCK_LEN: usize = 3071;
/// As FLICR_DEFLATE_BLOCK_LEN, for FLICR_CODER_DEFLATE_SMALL.
pub const FLICR_DEFLATE_SMALL_BLOCK_LEN: usize = 1535;
/// As FLICR_DEFLATE_BLOCK_LEN, for FLICR_CODER_DEFLATE_DENSE.
pub const FLICR_DEFLATE_DENSE_BLOCK_LEN: usize = 3071;
/// Bytes that every block costs, with any of the three.
pub const FLICR_DEFLATE_BLOCK_COST: usize = 5;

/// An encoder, in memory of the caller's: this head, the coder's state, the image. To be ended, it needs nothing but
/// its memory's end.
#[derive(Debug)]
#[repr(align(8))]
pub struct flicr_encoder {
    magic: u32,
    layout: Layout,
    columns: usize,
    finish: Finish,
    config: Config,
    frame: Option<OpenFrame>,
}

/// Marks memory that holds an encoder.
const MAGIC: u32 = u32::from_be_bytes(*b"FLCe");

/// What the header and cbindgen must be told in plain numbers, and what C's numbers stand for here.
const _: () = {
    assert!(size_of::<flicr_encoder>() <= FLICR_ENCODER_OVERHEAD);
    assert!(align_of::<flicr_encoder>() == FLICR_ENCODER_ALIGN);
    assert!(FLICR_ENCODER_OVERHEAD.is_multiple_of(FLICR_ENCODER_ALIGN));
    assert!(FLICR_FRAME_OVERHEAD_LEN == frame::OVERHEAD_LEN);
    assert!(FLICR_STRIP_OVERHEAD_LEN == frame::STRIP_HEADER_LEN);
    assert!(is_worst_case::<Rle>(FLICR_RLE_BLOCK_LEN, 1));
    assert!(is_worst_case::<DeflateDefault>(FLICR_DEFLATE_BLOCK_LEN, FLICR_DEFLATE_BLOCK_COST));
    assert!(is_worst_case::<DeflateSmall>(FLICR_DEFLATE_SMALL_BLOCK_LEN, FLICR_DEFLATE_BLOCK_COST));
    assert!(is_worst_case::<DeflateDense>(FLICR_DEFLATE_DENSE_BLOCK_LEN, FLICR_DEFLATE_BLOCK_COST));
    assert!(is_worst_case::<CSmall>(FLICR_CONTEXT_BLOCK_LEN, FLICR_CONTEXT_BLOCK_COST));
    assert!(is_worst_case::<CDense>(FLICR_CONTEXT_BLOCK_LEN, FLICR_CONTEXT_BLOCK_COST));
    assert!(<CSmall as Coder<u8>>::ROWS_MAX == FLICR_CONTEXT_ROWS_MAX);
    // Where one of these does not compile, the compiler says which length is right.
    let _: [u8; size_of::<DeflateDefault>()] = [0; FLICR_DEFLATE_STATE_LEN];
    let _: [u8; size_of::<DeflateSmall>()] = [0; FLICR_DEFLATE_SMALL_STATE_LEN];
    let _: [u8; size_of::<DeflateDense>()] = [0; FLICR_DEFLATE_DENSE_STATE_LEN];
    assert!(flicr_collision::Nearest as u32 == Collision::Nearest as u32);
    assert!(flicr_collision::Farthest as u32 == Collision::Farthest as u32);
    assert!(flicr_collision::First as u32 == Collision::First as u32);
    assert!(flicr_collision::Last as u32 == Collision::Last as u32);
    assert!(flicr_out_of_view::Drop as u32 == OutOfView::Drop as u32);
    assert!(flicr_out_of_view::Clamp as u32 == OutOfView::Clamp as u32);
    assert!(flicr_companding::None as u32 == Companding::None as u32);
    assert!(flicr_companding::SquareRoot as u32 == Companding::SquareRoot as u32);
    assert!(flicr_placement::Center as u32 == Placement::Center as u32);
    assert!(flicr_placement::Corner as u32 == Placement::Corner as u32);
};

const fn is_worst_case<C: Coder<u8>>(len: usize, cost: usize) -> bool {
    let WorstCase { bytes_per_level, block_len, bytes_per_block, .. } = C::WORST_CASE;
    bytes_per_level == 1 && block_len == len && bytes_per_block == cost
}

/// What FLICR_ENCODER_SIZE gives: bytes that an encoder takes. 0 where there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_encoder_size(columns: u32, rows: u32, coder: CoderCode) -> usize {
    size_of_encoder(columns, rows, coder).unwrap_or(0)
}

/// What FLICR_WORST_CASE_LEN gives: output bytes that are enough for every frame. 0 where there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_worst_case_len(columns: u32, rows: u32, coder: CoderCode) -> usize {
    worst_case_len(columns, rows, coder, 1).unwrap_or(0)
}

/// What FLICR_WORST_CASE_LEN_IN_STRIPS gives: output bytes that are enough for every frame of so many strips. 0 where
/// there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_worst_case_len_in_strips(columns: u32, rows: u32, coder: CoderCode, strips: u32) -> usize {
    worst_case_len(columns, rows, coder, strips).unwrap_or(0)
}

/// Makes an encoder that stores levels as they are, in memory of at least
/// FLICR_ENCODER_SIZE(config->columns, config->rows, FLICR_CODER_STORE) bytes, aligned to FLICR_ENCODER_ALIGN. What the
/// memory held does not matter.
///
/// FLICR_STATUS_STATE_TOO_SMALL, FLICR_STATUS_MISALIGNED, and any status that names a member of the configuration.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_store(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, |result| place_encoder::<Store>(state, state_len, &read(config)?, result)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_RLE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_rle(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, |result| place_encoder::<Rle>(state, state_len, &read(config)?, result)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_DEFLATE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_deflate(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, |result| place_encoder::<DeflateDefault>(state, state_len, &read(config)?, result)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_DEFLATE_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_deflate_small(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, |result| place_encoder::<DeflateSmall>(state, state_len, &read(config)?, result)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_DEFLATE_DENSE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_deflate_dense(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoder, |result| place_encoder::<DeflateDense>(state, state_len, &read(config)?, result)) }
}

/// As flicr_encoder_init_store, for FLICR_CODER_SMALL with these settings.
///
/// FLICR_STATUS_CONTEXT; FLICR_STATUS_SIZE with more than FLICR_CONTEXT_ROWS_MAX rows, too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_small(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    context: *const flicr_context,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the four pointers.
    unsafe { deliver(out_encoder, |result| place_context::<CSmall>(state, state_len, config, context, result)) }
}

/// As flicr_encoder_init_small, for FLICR_CODER_DENSE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_encoder_init_dense(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    context: *const flicr_context,
    out_encoder: *mut *mut flicr_encoder,
) -> flicr_status {
    // SAFETY: the caller's promises about the four pointers.
    unsafe { deliver(out_encoder, |result| place_context::<CDense>(state, state_len, config, context, result)) }
}

/// Encodes a whole scan to the front of `out`: `count` records, `stride_bytes` apart, each starting with x, y, z as
/// float, meters (x forward, y left, z up), at any alignment. Of the last record only these 12 bytes are read. A frame
/// that was started is dropped.
///
/// FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_WORST_CASE_LEN bytes; FLICR_STATUS_STRIDE,
/// FLICR_STATUS_TOO_MANY_POINTS, FLICR_STATUS_OVERLAP.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "C has no slices")]
pub unsafe extern "C" fn flicr_encode(
    encoder: *mut flicr_encoder,
    points: *const c_void,
    count: usize,
    stride_bytes: usize,
    stamp: flicr_stamp,
    out: *mut c_void,
    out_len: usize,
    out_encoded: *mut flicr_encoded,
) -> flicr_status {
    let scan = || Records::new(points, count, stride_bytes);
    // SAFETY: the caller's promises about the four pointers.
    unsafe { deliver(out_encoded, |result| encode(encoder, scan()?, stamp, Output::new(out, out_len)?, result)) }
}

/// Begins a frame whose points come piece by piece. A frame that was started before is dropped.
///
/// FLICR_STATUS_SCALE_NEEDS_WHOLE_SCAN where the configuration has no largest range.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_start(encoder: *mut flicr_encoder, stamp: flicr_stamp) -> flicr_status {
    // SAFETY: the caller's promise about `encoder`.
    code(unsafe { start(encoder, stamp) })
}

/// Puts points into the frame that was started; as in flicr_encode.
///
/// FLICR_STATUS_NOT_STARTED, FLICR_STATUS_STRIDE, FLICR_STATUS_TOO_MANY_POINTS, FLICR_STATUS_OVERLAP: none of the
/// points are in the frame then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_insert(
    encoder: *mut flicr_encoder,
    points: *const c_void,
    count: usize,
    stride_bytes: usize,
) -> flicr_status {
    // SAFETY: the caller's promises about `encoder` and `points`.
    code(Records::new(points, count, stride_bytes).and_then(|scan| unsafe { insert(encoder, scan) }))
}

/// Codes the frame that was started to the front of `out`, and ends it.
///
/// FLICR_STATUS_NOT_STARTED; FLICR_STATUS_OUTPUT_TOO_SMALL and FLICR_STATUS_OVERLAP: the frame stays as it is then, to
/// be finished elsewhere.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_finish(
    encoder: *mut flicr_encoder,
    out: *mut c_void,
    out_len: usize,
    out_encoded: *mut flicr_encoded,
) -> flicr_status {
    // SAFETY: the caller's promises about the three pointers.
    unsafe { deliver(out_encoded, |result| finish(encoder, Output::new(out, out_len)?, result)) }
}

/// As flicr_insert, with an intensity for each point: `numbers` are `count` of them, and that of a point that a pixel keeps
/// goes into planes->intensities.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_insert_lit(
    encoder: *mut flicr_encoder,
    points: *const c_void,
    count: usize,
    stride_bytes: usize,
    numbers: *const u8,
    planes: *const flicr_planes,
) -> flicr_status {
    let scan = Records::new(points, count, stride_bytes);
    // SAFETY: the caller's promises about the pointers.
    code(scan.and_then(|scan| unsafe { insert_lit(encoder, scan, numbers_of(&scan, numbers)?, read(planes)?) }))
}

/// As flicr_finish, with planes besides the ranges.
///
/// FLICR_STATUS_PLANE; FLICR_STATUS_SIZE where there are intensities of more than FLICR_INTENSITY_ROWS_MAX rows;
/// FLICR_STATUS_OUTPUT_TOO_SMALL, never with FLICR_PLANES_WORST_CASE_LEN bytes more than the frame takes without.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_finish_with(
    encoder: *mut flicr_encoder,
    planes: *const flicr_planes,
    out: *mut c_void,
    out_len: usize,
    out_encoded: *mut flicr_encoded,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    let work = |result| unsafe { finish_planes(encoder, read(planes)?, Output::new(out, out_len)?, result) };
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_encoded, work) }
}

/// Where in an encoder's memory its parts are; the coder's state is at `FLICR_ENCODER_OVERHEAD`.
#[derive(Debug, Clone, Copy)]
struct Layout {
    image_at: usize,
    len: usize,
}

impl Layout {
    const fn new(state_len: usize, pixels: usize) -> Self {
        let image_at = FLICR_ENCODER_OVERHEAD + state_len;
        Self { image_at, len: image_at + pixels }
    }
}

fn size_of_encoder(columns: u32, rows: u32, coder: CoderCode) -> Option<usize> {
    let pixels = pixels(columns, rows).ok()?;
    Some(Layout::new(flicr_coder::from_code(coder)?.state_len(), pixels).len)
}

fn worst_case_len(columns: u32, rows: u32, coder: CoderCode, strips: u32) -> Option<usize> {
    pixels(columns, rows).ok()?;
    let strips = strips_of(columns, strips)?;
    Some(flicr_coder::from_code(coder)?.worst_case_len::<u8>(rows as usize, columns as usize, strips))
}

/// Codes and writes a frame, with the coder's state at the pointer.
type Finish = unsafe fn(*mut c_void, &OpenFrame, ImageView<'_, u8>, &mut [u8]) -> Outcome<flicr_encoded>;

/// # Safety
/// `state` is where [`place_encoder`] has put a `C`, and nobody else uses that meanwhile.
unsafe fn finish_with<C: Coder<u8>>(
    state: *mut c_void,
    frame: &OpenFrame,
    image: ImageView<'_, u8>,
    out: &mut [u8],
) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promise.
    let coder = unsafe { &mut *state.cast::<C>() };
    Ok(frame.finish(image, coder, out)?.into())
}

/// # Safety
/// `state` is null or may be written for `state_len` bytes.
unsafe fn place_encoder<C: StartsAsZeros>(
    state: *mut c_void,
    state_len: usize,
    settings: &flicr_config,
    result: Span,
) -> Outcome<*mut flicr_encoder> {
    const { assert!(align_of::<C>() <= FLICR_ENCODER_ALIGN && size_of::<C>() <= C::STATE_LEN) };
    let layout = Layout::new(C::STATE_LEN, pixels(settings.columns, settings.rows)?);
    if settings.rows as usize > <C as Coder<u8>>::ROWS_MAX {
        return Err(flicr_status::Size);
    }
    let head = flicr_encoder::new(settings, layout, finish_with::<C>)?;
    let encoder = state.cast::<flicr_encoder>();
    check_place(encoder)?;
    if state_len < layout.len {
        return Err(flicr_status::StateTooSmall);
    }
    check_apart(Span::new(state, layout.len)?, [result])?;
    // SAFETY: `layout.len` bytes may be written, the head at their aligned start. Zeros are a coder that has been
    // vouched for, and an image without returns.
    unsafe {
        state.write_bytes(0, layout.len);
        encoder.write(head);
    }
    Ok(encoder)
}

/// # Safety
/// As [`place_encoder`]; `config` and `context` are null or may be read.
unsafe fn place_context<C: StartsAsZeros + SetsContext>(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_config,
    context: *const flicr_context,
    result: Span,
) -> Outcome<*mut flicr_encoder> {
    // SAFETY: the caller's promise; the coder's state lies behind the head, and is nobody else's yet.
    unsafe {
        let settings = read(context)?.to_settings()?;
        let encoder = place_encoder::<C>(state, state_len, &read(config)?, result)?;
        (*coder_of(encoder).cast::<C>()).set_context(settings);
        Ok(encoder)
    }
}

const fn coder_of(encoder: *mut flicr_encoder) -> *mut c_void {
    encoder.cast::<c_void>().wrapping_byte_add(FLICR_ENCODER_OVERHEAD)
}

impl flicr_encoder {
    fn new(settings: &flicr_config, layout: Layout, finish: Finish) -> Outcome<Self> {
        let config = settings.to_config()?;
        let (rows, columns) = (settings.rows as usize, settings.columns as usize);
        // Finds now what would be found with every frame.
        OpenFrame::new::<u8>(&config, || Some(1.0), Stamp::default(), rows, columns)?;
        Ok(Self { magic: MAGIC, layout, columns, finish, config, frame: None })
    }
}

/// An encoder's parts. The coder's state stays a pointer: its type is known to `finish` alone.
#[derive(Debug)]
struct Parts<'a> {
    head: &'a mut flicr_encoder,
    coder: *mut c_void,
    image: ImageViewMut<'a, u8>,
}

/// Checks that memory is an encoder's, and that the `others` have no part in it or in one another.
///
/// # Safety
/// `encoder` is null or points to memory that is large enough for a head, holds whatever `place_encoder` and the
/// functions below have written, and is used by nobody else before the result's last use.
unsafe fn parts<'a, const N: usize>(encoder: *mut flicr_encoder, others: [Span; N]) -> Outcome<Parts<'a>> {
    check_place(encoder)?;
    // SAFETY: neither null nor misaligned; a number may have any value.
    if unsafe { (&raw const (*encoder).magic).read() } != MAGIC {
        return Err(flicr_status::NotInitialized);
    }
    // SAFETY: so `place_encoder` wrote a head here.
    let layout = unsafe { (*encoder).layout };
    check_apart(Span { start: encoder.cast(), len: layout.len }, others)?;
    // SAFETY: as above; and behind the head it wrote the coder's state and the image, to `layout.len`. The three share
    // no byte.
    unsafe {
        let head = &mut *encoder;
        let start = encoder.cast::<u8>();
        let levels = core::slice::from_raw_parts_mut(start.add(layout.image_at), layout.len - layout.image_at);
        let image = ImageViewMut::new(levels, head.columns).ok_or(flicr_status::Size)?;
        Ok(Parts { head, coder: coder_of(encoder), image })
    }
}

/// # Safety
/// As the header demands of `flicr_encode`.
unsafe fn encode(
    encoder: *mut flicr_encoder,
    scan: Records,
    stamp: flicr_stamp,
    out: Output,
    result: Span,
) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    unsafe {
        let Parts { head, coder, mut image } = parts(encoder, [scan.span, out.span, result])?;
        head.frame = None;
        let frame = OpenFrame::of_scan(&head.config, &scan.points()?, stamp.into(), &mut image)?;
        (head.finish)(coder, &frame, image.as_view(), out.bytes())
    }
}

/// # Safety
/// As the header demands of `flicr_start`.
unsafe fn start(encoder: *mut flicr_encoder, stamp: flicr_stamp) -> Outcome<()> {
    // SAFETY: the caller's promise.
    let Parts { head, mut image, .. } = unsafe { parts(encoder, []) }?;
    head.frame = None;
    head.frame = Some(OpenFrame::start(&head.config, stamp.into(), &mut image)?);
    Ok(())
}

/// # Safety
/// As the header demands of `flicr_insert`.
unsafe fn insert(encoder: *mut flicr_encoder, scan: Records) -> Outcome<()> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    let (Parts { head, mut image, .. }, points) = unsafe { (parts(encoder, [scan.span])?, scan.points()?) };
    let frame = head.frame.as_mut().ok_or(flicr_status::NotStarted)?;
    frame.tally().points.checked_add(scan.count).ok_or(flicr_status::TooManyPoints)?;
    frame.insert(&points, &mut image, ());
    Ok(())
}

/// # Safety
/// As the header demands of `flicr_finish`.
unsafe fn finish(encoder: *mut flicr_encoder, out: Output, result: Span) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promises; `parts` has found all that is borrowed here to be apart.
    unsafe {
        let Parts { head, coder, image } = parts(encoder, [out.span, result])?;
        let frame = head.frame.as_ref().ok_or(flicr_status::NotStarted)?;
        let finished = (head.finish)(coder, frame, image.as_view(), out.bytes())?;
        head.frame = None;
        Ok(finished)
    }
}

/// # Safety
/// As the header demands of `flicr_insert_lit`.
unsafe fn insert_lit(encoder: *mut flicr_encoder, scan: Records, numbers: Span, planes: flicr_planes) -> Outcome<()> {
    // SAFETY: the caller's promises; the second `parts` has found all that is borrowed here to be apart.
    unsafe {
        let view = parts(encoder, [])?.image;
        let lent = LentPlanes::new(planes, view.as_view().pixels(), view.as_view().columns())?;
        let [plane, state, times] = lent.spans();
        let Parts { head, mut image, .. } = parts(encoder, [scan.span, numbers, plane, state, times])?;
        let frame = head.frame.as_mut().ok_or(flicr_status::NotStarted)?;
        frame.tally().points.checked_add(scan.count).ok_or(flicr_status::TooManyPoints)?;
        let (numbers, plane) = (numbers.bytes(), lent.numbers()?);
        let of = |index: usize| numbers.get(index).copied().unwrap_or(0);
        frame.insert(&scan.points()?, &mut image, Numbers { of, first: 0, plane });
    }
    Ok(())
}

/// # Safety
/// As the header demands of `flicr_finish_with`.
unsafe fn finish_planes(
    encoder: *mut flicr_encoder,
    planes: flicr_planes,
    out: Output,
    result: Span,
) -> Outcome<flicr_encoded> {
    // SAFETY: the caller's promises; the second `parts` has found all that is borrowed here to be apart.
    unsafe {
        let view = parts(encoder, [])?.image;
        let lent = LentPlanes::new(planes, view.as_view().pixels(), view.as_view().columns())?;
        let [plane, state, times] = lent.spans();
        let Parts { head, coder, image } = parts(encoder, [out.span, result, plane, state, times])?;
        let frame = head.frame.as_ref().ok_or(flicr_status::NotStarted)?;
        let (out, timestamp_ns) = (out.bytes(), frame.stamp().timestamp_ns);
        let mut finished = (head.finish)(coder, frame, image.as_view(), out)?;
        finished.len = lent.append(image.as_view(), timestamp_ns, finished.len, out)?;
        head.frame = None;
        Ok(finished)
    }
}
