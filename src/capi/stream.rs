//! A stream: a sensor's packets or columns in, datagrams out, as the sensor turns.
#![allow(unsafe_code, reason = "pointers from C; every block says what makes it sound")]

use core::ffi::c_void;

use super::config::{CoderCode, flicr_coder};
use super::context::{FLICR_CONTEXT_ROWS_MAX, flicr_context};
use super::encoder::FLICR_ENCODER_ALIGN;
use super::grid::{FLICR_BEAM_LEN, flicr_packet_stats};
use super::memory::{Outcome, Output, Span, check_apart, check_place, code, deliver, read};
use super::sensor::{FLICR_BEAMS_MAX, flicr_grid_config};
use super::status::flicr_status;
use crate::coder::ContextSettings;
use crate::coder::context::strip::StripTier;
use crate::coder::context::{DenseModel, SmallModel};
use crate::error::ConfigError;
use crate::geometry::Beam;
use crate::packet::{Event, TurnAssembler};
use crate::stream::{self, Aligned, AsFired, Line, StreamConfig, StreamEncoder, StreamTally};

/// Bytes of a datagram at most.
pub const FLICR_DATAGRAM_LEN: usize = 1400;
/// Bytes that a stream takes besides its beams and its coder's state.
pub const FLICR_STREAM_OVERHEAD: usize = 384;
/// Bytes of the state of a stream with FLICR_CODER_SMALL, the datagram included.
pub const FLICR_STREAM_SMALL_STATE_LEN: usize = 5120;
/// Bytes of the state of a stream with FLICR_CODER_DENSE, the datagram included.
pub const FLICR_STREAM_DENSE_STATE_LEN: usize = 7936;
/// Bytes that aligned columns take more: enough for an HDL-64E, and for sensors whose beams look less far apart.
pub const FLICR_STREAM_ALIGNED_LEN: usize = 9728;

/// Where datagrams go: called with each as soon as it is full, with the `context` that was given along with it. The
/// datagram lives as long as the call, which must not use the stream that it comes from.
pub type flicr_send = Option<unsafe extern "C" fn(context: *mut c_void, datagram: *const u8, datagram_len: usize)>;

/// A firing of all beams.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct flicr_column {
    /// When it was, in the sensor's clock, nanoseconds.
    pub time_ns: u64,
    /// Its number in the turn, 0 to 8191. Columns of a turn come in ascending order; one that is left out was lost.
    pub index: u32,
    /// The encoder's tick.
    pub tick: u32,
}

/// What has become of a stream's firings.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct flicr_stream_tally {
    /// Returns that came in and have a level; those of columns that are not kept are among them.
    pub returns: u64,
    /// Returns beyond the largest level; not kept.
    pub beyond_range: u64,
    /// Bytes of the datagrams.
    pub bytes: u64,
    /// Datagrams that went out.
    pub datagrams: u32,
    /// Firings that came in.
    pub firings: u32,
    /// Columns that are in datagrams, or will be in the next.
    pub columns: u32,
    /// Columns that a stride passed over.
    pub thinned: u32,
    /// Columns that flicr_stream_cut cut off.
    pub cut: u32,
    /// Columns that did not fit a datagram alone.
    pub unfit: u32,
}

/// A stream, in memory of the caller's: this head, the coder's state, the beams. To be ended, it needs nothing but its
/// memory's end.
#[derive(Debug)]
#[repr(align(8))]
pub struct flicr_stream {
    magic: u32,
    has_packets: bool,
    /// All of the stream.
    len: usize,
    /// Behind this head, in the same memory.
    coder: *mut dyn AnyStream,
    turns: TurnAssembler,
}

/// Marks memory that holds a stream.
const MAGIC: u32 = u32::from_be_bytes(*b"FLCs");

const GROUPS: usize = FLICR_CONTEXT_ROWS_MAX / 8;
type CStream<M, L> = StreamEncoder<M, GROUPS, FLICR_DATAGRAM_LEN, L>;
/// As [`stream::AlignedHdl64e`].
type CAligned = Aligned<4096, 128>;

// SAFETY: zeros, of which a value of each of these types is made, or this would not compile.
const _: CStream<SmallModel, CAligned> = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: CStream<DenseModel, CAligned> = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: CStream<SmallModel, AsFired> = unsafe { core::mem::zeroed() };
// SAFETY: as above.
const _: CStream<DenseModel, AsFired> = unsafe { core::mem::zeroed() };

const _: () = {
    assert!(FLICR_DATAGRAM_LEN == stream::DATAGRAM_LEN);
    assert!(size_of::<flicr_stream>() <= FLICR_STREAM_OVERHEAD);
    assert!(align_of::<flicr_stream>() == FLICR_ENCODER_ALIGN);
    assert!(FLICR_STREAM_OVERHEAD.is_multiple_of(FLICR_ENCODER_ALIGN));
};

/// What FLICR_STREAM_SIZE gives: bytes that a stream takes. 0 where there can be none.
#[unsafe(no_mangle)]
pub extern "C" fn flicr_stream_size(beams: u32, coder: CoderCode, aligned: u32) -> usize {
    let state_len = match flicr_coder::from_code(coder) {
        Some(flicr_coder::Small) => FLICR_STREAM_SMALL_STATE_LEN,
        Some(flicr_coder::Dense) => FLICR_STREAM_DENSE_STATE_LEN,
        _ => return 0,
    };
    let more = if aligned == 0 { 0 } else { FLICR_STREAM_ALIGNED_LEN };
    size(state_len + more, beams).unwrap_or(0)
}

/// Makes a stream with FLICR_CODER_SMALL, columns as fired, in memory of at least
/// FLICR_STREAM_SIZE(config->beam_count, FLICR_CODER_SMALL, 0) bytes, aligned to FLICR_ENCODER_ALIGN. `id` says which of
/// the sender's streams it is, where several go to one receiver: 0 to 255.
///
/// Of the configuration count the sensor, its beams and grid, `returns`, and `step_m`, the distance of the levels: 1 to
/// 255 range units; a level has 16 bits. The receiver must know the sensor's grid, with the same `turns_per_minute`.
///
/// FLICR_STATUS_STATE_TOO_SMALL, FLICR_STATUS_MISALIGNED, FLICR_STATUS_CONTEXT, FLICR_STATUS_STEP, FLICR_STATUS_SIZE for
/// the `id` too, and any status that names a member of the configuration.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_init_small(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    context: *const flicr_context,
    id: u32,
    out_stream: *mut *mut flicr_stream,
) -> flicr_status {
    let memory = Memory { state, len: state_len };
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_stream, |result| memory.place::<CStream<SmallModel, AsFired>>(config, context, id, result)) }
}

/// As flicr_stream_init_small, for FLICR_CODER_DENSE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_init_dense(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    context: *const flicr_context,
    id: u32,
    out_stream: *mut *mut flicr_stream,
) -> flicr_status {
    let memory = Memory { state, len: state_len };
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_stream, |result| memory.place::<CStream<DenseModel, AsFired>>(config, context, id, result)) }
}

/// As flicr_stream_init_small, for columns that are aligned: beams that fire together look apart, and a column is made of
/// what looks one way. Fewer bytes, later by as many firings as lie between the first beam and the last, in memory of
/// FLICR_STREAM_SIZE(config->beam_count, FLICR_CODER_SMALL, 1) bytes. config->columns says how many firings a turn has,
/// about.
///
/// FLICR_STATUS_DELAY where the sensor's beams look farther apart than there is room for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_init_small_aligned(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    context: *const flicr_context,
    id: u32,
    out_stream: *mut *mut flicr_stream,
) -> flicr_status {
    let memory = Memory { state, len: state_len };
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_stream, |result| memory.place::<CStream<SmallModel, CAligned>>(config, context, id, result)) }
}

/// As flicr_stream_init_small_aligned, for FLICR_CODER_DENSE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_init_dense_aligned(
    state: *mut c_void,
    state_len: usize,
    config: *const flicr_grid_config,
    context: *const flicr_context,
    id: u32,
    out_stream: *mut *mut flicr_stream,
) -> flicr_status {
    let memory = Memory { state, len: state_len };
    // SAFETY: the caller's promises about the pointers.
    unsafe { deliver(out_stream, |result| memory.place::<CStream<DenseModel, CAligned>>(config, context, id, result)) }
}

/// Takes one UDP payload of the sensor; calls `send` with each datagram that it fills.
///
/// FLICR_STATUS_PACKET_REFUSED: the packet is not one of the sensor's, is damaged, late or doubled; nothing of it is
/// used, and it is counted. FLICR_STATUS_SENSOR: the configuration names no sensor whose packets are known.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_push_packet(
    stream: *mut flicr_stream,
    packet: *const c_void,
    packet_len: usize,
    send: flicr_send,
    context: *mut c_void,
) -> flicr_status {
    let work = || {
        let (packet, sender) = (Span::new(packet, packet_len)?, Sender::new(send, context)?);
        // SAFETY: the caller's promises about the pointers.
        let (head, packet) = unsafe { (head_of(stream, [packet])?, packet.bytes()) };
        if !head.has_packets {
            return Err(flicr_status::Sensor);
        }
        // SAFETY: the stream's own coder; nobody else uses it meanwhile, as the caller promises.
        let coder = unsafe { &mut *head.coder };
        let pushed = head.turns.push(packet, |event| {
            coder.feed(&event);
            sender.drain(coder);
        });
        pushed.map_err(|_| flicr_status::PacketRefused)
    };
    code(work())
}

/// Takes a firing that a driver has read already: `count` range counts, from the highest beam on, 0 where nothing came
/// back; beams that are left out have no return. Calls `send` with each datagram that this fills.
///
/// FLICR_STATUS_SIZE for an index above 8191 or more counts than beams, FLICR_STATUS_TICKS for a tick above 65535.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_push_column(
    stream: *mut flicr_stream,
    column: *const flicr_column,
    counts: *const u32,
    count: usize,
    send: flicr_send,
    context: *mut c_void,
) -> flicr_status {
    let work = || {
        let sender = Sender::new(send, context)?;
        check_place(counts)?;
        if count > FLICR_BEAMS_MAX {
            return Err(flicr_status::Size);
        }
        let span = Span::new(counts.cast(), count * size_of::<u32>())?;
        // SAFETY: the caller's promises about the pointers; the counts are aligned, and apart from the stream.
        let (column, coder, counts) = unsafe {
            let coder = coder_of(stream, [span])?;
            (read(column)?, coder, core::slice::from_raw_parts(counts, count))
        };
        let index = u16::try_from(column.index).ok().filter(|&index| index < crate::packet::MAX_COLUMNS);
        let index = index.filter(|_| count <= coder.rows()).ok_or(flicr_status::Size)?;
        let tick = u16::try_from(column.tick).map_err(|_| flicr_status::Ticks)?;
        coder.feed_counts(index, tick, column.time_ns, counts);
        sender.drain(coder);
        Ok(())
    };
    code(work())
}

/// Ends the turn that is open: what is coded of it goes out, and the receiver is told that no more will come.
/// flicr_stream_push_packet does it by itself; a driver that pushes columns does it here.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_end_turn(
    stream: *mut flicr_stream,
    send: flicr_send,
    context: *mut c_void,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    code(Sender::new(send, context).and_then(|sender| unsafe {
        let coder = coder_of(stream, [])?;
        coder.feed_turn_end();
        sender.drain(coder);
        Ok(())
    }))
}

/// No more will come, or nothing for a while: all that is held goes out, and the turn is over. The next packet starts
/// anew.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_finish(
    stream: *mut flicr_stream,
    send: flicr_send,
    context: *mut c_void,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    code(Sender::new(send, context).and_then(|sender| unsafe {
        let head = head_of(stream, [])?;
        let coder = &mut *head.coder;
        head.turns.finish(|event| {
            coder.feed(&event);
            sender.drain(coder);
        });
        coder.feed_finish();
        sender.drain(coder);
        Ok(())
    }))
}

/// Keeps ranges in other steps: from the next turn on, or, with `now` other than 0, from the next datagram on.
///
/// FLICR_STATUS_CONTEXT.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_set_context(
    stream: *mut flicr_stream,
    context: *const flicr_context,
    now: u32,
) -> flicr_status {
    // SAFETY: the caller's promises about the pointers.
    let work = || unsafe {
        let settings = read(context)?.to_settings()?;
        let coder = coder_of(stream, [])?;
        if now == 0 {
            coder.set(settings);
        } else {
            coder.set_now(settings);
        }
        Ok(())
    };
    code(work())
}

/// Keeps one column of `stride`, 1 to 255, from the next turn on.
///
/// FLICR_STATUS_SIZE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_set_stride(stream: *mut flicr_stream, stride: u32) -> flicr_status {
    let work = || {
        let stride = u8::try_from(stride).ok().filter(|&stride| stride > 0).ok_or(flicr_status::Size)?;
        // SAFETY: the caller's promise about the pointer.
        unsafe { coder_of(stream, [])? }.set_stride(stride);
        Ok(())
    };
    code(work())
}

/// Leaves out what is left of the turn: where a link has no more room for it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_cut(stream: *mut flicr_stream) -> flicr_status {
    // SAFETY: the caller's promise about the pointer.
    code(unsafe { coder_of(stream, []) }.map(AnyStream::cut))
}

/// Says what has become of the firings so far.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_get_tally(
    stream: *mut flicr_stream,
    out_tally: *mut flicr_stream_tally,
) -> flicr_status {
    // SAFETY: the caller's promises about both pointers.
    unsafe { deliver(out_tally, |result| Ok(coder_of(stream, [result])?.tally().into())) }
}

/// Says what became of the packets so far.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_stream_get_packet_stats(
    stream: *mut flicr_stream,
    out_stats: *mut flicr_packet_stats,
) -> flicr_status {
    // SAFETY: the caller's promises about both pointers.
    unsafe { deliver(out_stats, |result| Ok(head_of(stream, [result])?.turns.stats().into())) }
}

/// Writes a datagram as it goes over a byte stream, a UART: between zeros, and without zeros in it. FLICR_FRAMED_LEN
/// bytes are enough.
///
/// FLICR_STATUS_OUTPUT_TOO_SMALL, FLICR_STATUS_OVERLAP.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flicr_frame_datagram(
    datagram: *const c_void,
    datagram_len: usize,
    out: *mut c_void,
    out_len: usize,
    out_framed_len: *mut usize,
) -> flicr_status {
    let work = |result: Span| {
        let (datagram, out) = (Span::new(datagram, datagram_len)?, Output::new(out, out_len)?);
        check_apart(out.span, [datagram, result])?;
        // SAFETY: the caller's promises about the pointers, which are apart.
        let (datagram, out) = unsafe { (datagram.bytes(), out.bytes()) };
        stream::frame_into(datagram, out).ok_or(flicr_status::OutputTooSmall)
    };
    // SAFETY: the caller's promise about the place of the result.
    unsafe { deliver(out_framed_len, work) }
}

fn size(state_len: usize, beams: u32) -> Option<usize> {
    let beams = beams as usize;
    (1..=FLICR_BEAMS_MAX).contains(&beams).then_some(FLICR_STREAM_OVERHEAD + state_len + beams * FLICR_BEAM_LEN)
}

/// A stream of any tier, columns as fired or aligned.
trait AnyStream {
    fn start(&mut self, config: StreamConfig<'_>) -> Result<(), ConfigError>;
    fn rows(&self) -> usize;
    fn feed(&mut self, event: &Event<'_>);
    fn feed_counts(&mut self, index: u16, tick: u16, time_ns: u64, counts: &[u32]);
    fn feed_turn_end(&mut self);
    fn feed_finish(&mut self);
    fn next_datagram(&mut self) -> Option<&[u8]>;
    fn set(&mut self, settings: ContextSettings);
    fn set_now(&mut self, settings: ContextSettings);
    fn set_stride(&mut self, stride: u8);
    fn cut(&mut self);
    fn tally(&self) -> StreamTally;
}

/// A stream that starts as zeros, where it is to stay: one that is made elsewhere and moved there goes through the stack.
///
/// # Safety
/// Zeros must be a value of the type.
unsafe trait StartsAsZeros: AnyStream + Sized + 'static {
    /// Bytes that are kept for it; the header says them.
    const STATE_LEN: usize;
}

// SAFETY: shown by a constant above.
unsafe impl StartsAsZeros for CStream<SmallModel, AsFired> {
    const STATE_LEN: usize = FLICR_STREAM_SMALL_STATE_LEN;
}
// SAFETY: as above.
unsafe impl StartsAsZeros for CStream<DenseModel, AsFired> {
    const STATE_LEN: usize = FLICR_STREAM_DENSE_STATE_LEN;
}
// SAFETY: as above.
unsafe impl StartsAsZeros for CStream<SmallModel, CAligned> {
    const STATE_LEN: usize = FLICR_STREAM_SMALL_STATE_LEN + FLICR_STREAM_ALIGNED_LEN;
}
// SAFETY: as above.
unsafe impl StartsAsZeros for CStream<DenseModel, CAligned> {
    const STATE_LEN: usize = FLICR_STREAM_DENSE_STATE_LEN + FLICR_STREAM_ALIGNED_LEN;
}

impl<M: StripTier, L: Line> AnyStream for CStream<M, L> {
    fn start(&mut self, config: StreamConfig<'_>) -> Result<(), ConfigError> {
        self.start(config)
    }

    fn rows(&self) -> usize {
        self.rows()
    }

    fn feed(&mut self, event: &Event<'_>) {
        self.feed(event);
    }

    fn feed_counts(&mut self, index: u16, tick: u16, time_ns: u64, counts: &[u32]) {
        self.feed_counts(index, tick, time_ns, counts);
    }

    fn feed_turn_end(&mut self) {
        self.feed_turn_end();
    }

    fn feed_finish(&mut self) {
        self.feed_finish();
    }

    fn next_datagram(&mut self) -> Option<&[u8]> {
        self.next_datagram()
    }

    fn set(&mut self, settings: ContextSettings) {
        self.set(settings);
    }

    fn set_now(&mut self, settings: ContextSettings) {
        self.set_now(settings);
    }

    fn set_stride(&mut self, stride: u8) {
        self.set_stride(stride);
    }

    fn cut(&mut self) {
        self.cut();
    }

    fn tally(&self) -> StreamTally {
        self.tally()
    }
}

/// Where datagrams go.
#[derive(Clone, Copy)]
struct Sender {
    send: unsafe extern "C" fn(*mut c_void, *const u8, usize),
    context: *mut c_void,
}

impl Sender {
    fn new(send: flicr_send, context: *mut c_void) -> Outcome<Self> {
        Ok(Self { send: send.ok_or(flicr_status::NullPointer)?, context })
    }

    fn drain(self, coder: &mut dyn AnyStream) {
        while let Some(datagram) = coder.next_datagram() {
            // SAFETY: the caller's function, with the caller's context; the datagram may be read meanwhile.
            unsafe { (self.send)(self.context, datagram.as_ptr(), datagram.len()) };
        }
    }
}

/// Memory of the caller's for a stream.
#[derive(Clone, Copy)]
struct Memory {
    state: *mut c_void,
    len: usize,
}

impl Memory {
    /// Makes a stream there.
    ///
    /// # Safety
    /// `state` is null or may be written for `len` bytes; `config` and `context` are null or may be read, and so are the
    /// configuration's beams.
    unsafe fn place<S: StartsAsZeros>(
        self,
        config: *const flicr_grid_config,
        context: *const flicr_context,
        id: u32,
        result: Span,
    ) -> Outcome<*mut flicr_stream> {
        const { assert!(align_of::<S>() <= FLICR_ENCODER_ALIGN && S::STATE_LEN.is_multiple_of(align_of::<Beam>())) };
        const { assert!(size_of::<S>() <= S::STATE_LEN) };
        // SAFETY: the caller's promises.
        let (settings, coding) = unsafe { (read(config)?, read(context)?.to_settings()?) };
        let len = size(S::STATE_LEN, settings.beam_count).ok_or(flicr_status::Size)?;
        let (counts_a_level, id) = (counts_a_level(&settings)?, u8::try_from(id).map_err(|_| flicr_status::Size)?);
        let stream = self.state.cast::<flicr_stream>();
        check_place(stream)?;
        if self.len < len {
            return Err(flicr_status::StateTooSmall);
        }
        let whole = Span::new(self.state, len)?;
        // SAFETY: the caller's promise; a count that is too large was found above.
        let still = unsafe { settings.still_beams()? };
        check_apart(whole, [result, Span::new(still.as_ptr().cast(), size_of_val(still))?])?;
        // SAFETY: `len` bytes may be written. The beams share no byte with the other parts.
        let beams = unsafe {
            self.state.write_bytes(0, len);
            let place = self.state.wrapping_byte_add(FLICR_STREAM_OVERHEAD + S::STATE_LEN).cast::<Beam>();
            place.copy_from_nonoverlapping(still.as_ptr(), still.len());
            core::slice::from_raw_parts_mut(place, still.len())
        };
        settings.turn(beams)?;
        let columns = settings.to_config(beams)?;
        let mut config = StreamConfig::new(&columns.grid, counts_a_level, coding)?;
        (config.id, config.columns_a_turn, config.layer) = (id, columns.columns, settings.layer());
        let coder = self.state.wrapping_byte_add(FLICR_STREAM_OVERHEAD).cast::<S>();
        // SAFETY: zeros, of which the type's implementation says that they are one; nobody else's yet.
        unsafe { (*coder).start(config)? };
        let (has_packets, turns) = (settings.has_packets(), settings.assembler()?);
        // SAFETY: the head's place, aligned.
        unsafe { stream.write(flicr_stream { magic: MAGIC, has_packets, len, coder, turns }) };
        Ok(stream)
    }
}

/// Levels are whole range counts: a stream knows no other.
fn counts_a_level(settings: &flicr_grid_config) -> Outcome<u8> {
    let counts = settings.step_m / settings.range_unit_m;
    let whole = crate::kernel::to_index(counts + 0.5, 256);
    // Not for NaN either.
    let is_near = (counts - whole as f32).abs() < 1e-3;
    u8::try_from(whole).ok().filter(|&whole| is_near && whole > 0).ok_or(flicr_status::Step)
}

/// Checks that memory is a stream's, and that the `others` have no part in it or in one another.
///
/// # Safety
/// `stream` is null or points to memory that is large enough for a head, holds whatever `place` and the functions above
/// have written, and is used by nobody else before the result's last use.
unsafe fn head_of<'a, const N: usize>(stream: *mut flicr_stream, others: [Span; N]) -> Outcome<&'a mut flicr_stream> {
    check_place(stream)?;
    // SAFETY: neither null nor misaligned; a number may have any value.
    if unsafe { (&raw const (*stream).magic).read() } != MAGIC {
        return Err(flicr_status::NotInitialized);
    }
    // SAFETY: so `place` wrote a head here.
    let len = unsafe { (*stream).len };
    check_apart(Span { start: stream.cast(), len }, others)?;
    // SAFETY: as above; the head shares no byte with the other parts.
    Ok(unsafe { &mut *stream })
}

/// # Safety
/// As [`head_of`].
unsafe fn coder_of<'a, const N: usize>(stream: *mut flicr_stream, others: [Span; N]) -> Outcome<&'a mut dyn AnyStream> {
    // SAFETY: the caller's promise; `place` has put it there.
    unsafe { Ok(&mut *head_of(stream, others)?.coder) }
}

impl From<StreamTally> for flicr_stream_tally {
    fn from(tally: StreamTally) -> Self {
        let StreamTally { firings, returns, beyond_range, columns, thinned, cut, unfit, datagrams, bytes } = tally;
        Self { returns, beyond_range, bytes, datagrams, firings, columns, thinned, cut, unfit }
    }
}
