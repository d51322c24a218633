//! Streams through the C ABI.

use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use flicr::capi::{flicr_status as Status, *};
use flicr::coder::{DenseModel, SmallModel, Step};
use flicr::geometry::sensors::{hdl64e, velodyne};
use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::stream::{Aligned, AsFired, StreamConfig, StreamEncoder, write_framed};

use crate::writer::Plan;
use crate::{CONTEXT, SETTINGS, ok};

type Init = unsafe extern "C" fn(
    *mut c_void,
    usize,
    *const flicr_grid_config,
    *const flicr_context,
    u32,
    *mut *mut flicr_stream,
) -> Status;

/// What C calls a kind of stream.
#[derive(Clone, Copy)]
struct Kind {
    coder: flicr_coder,
    aligned: u32,
    init: Init,
}

const KINDS: [Kind; 4] = [
    Kind { coder: flicr_coder::Small, aligned: 0, init: flicr_stream_init_small },
    Kind { coder: flicr_coder::Small, aligned: 1, init: flicr_stream_init_small_aligned },
    Kind { coder: flicr_coder::Dense, aligned: 0, init: flicr_stream_init_dense },
    Kind { coder: flicr_coder::Dense, aligned: 1, init: flicr_stream_init_dense_aligned },
];

fn preset(sensor: flicr_sensor, columns: u32) -> flicr_grid_config {
    let mut config = MaybeUninit::uninit();
    // SAFETY: a place for a configuration, which success fills.
    unsafe {
        assert_eq!(flicr_grid_config_init(sensor as u32, columns, config.as_mut_ptr()), Status::Ok);
        config.assume_init()
    }
}

/// A stream in memory full of what was there before, and the datagrams that it has sent.
struct Stream {
    memory: Vec<u64>,
    handle: *mut flicr_stream,
    sent: Vec<Vec<u8>>,
}

unsafe extern "C" fn keep(context: *mut c_void, datagram: *const u8, len: usize) {
    // SAFETY: the context that `Stream` gives along, and what the header promises of a datagram.
    unsafe { (*context.cast::<Vec<Vec<u8>>>()).push(std::slice::from_raw_parts(datagram, len).to_vec()) }
}

impl Stream {
    fn new(kind: Kind, config: &flicr_grid_config, id: u32) -> Result<Self, Status> {
        let len = flicr_stream_size(config.beam_count, kind.coder as u32, kind.aligned);
        let mut memory = vec![0xA5A5_A5A5_A5A5_A5A5_u64; len.div_ceil(8)];
        let (start, len) = (memory.as_mut_ptr().cast(), size_of_val(memory.as_slice()));
        let mut stream = null_mut();
        // SAFETY: the vector's own pointer and length.
        let status = unsafe { (kind.init)(start, len, config, &raw const CONTEXT, id, &raw mut stream) };
        assert_eq!(stream.is_null(), status != Status::Ok, "written only on success");
        ok(status).map(|()| Self { memory, handle: stream, sent: Vec::new() })
    }

    fn push(&mut self, packet: &[u8]) -> Status {
        let context = (&raw mut self.sent).cast();
        // SAFETY: the slice's own pointer and length, and a context of the kind that `keep` takes.
        unsafe { flicr_stream_push_packet(self.handle, packet.as_ptr().cast(), packet.len(), Some(keep), context) }
    }

    fn column(&mut self, column: flicr_column, counts: &[u32]) -> Status {
        let context = (&raw mut self.sent).cast();
        // SAFETY: as above.
        unsafe {
            flicr_stream_push_column(self.handle, &raw const column, counts.as_ptr(), counts.len(), Some(keep), context)
        }
    }

    fn end_turn(&mut self) {
        // SAFETY: as above.
        let status = unsafe { flicr_stream_end_turn(self.handle, Some(keep), (&raw mut self.sent).cast()) };
        assert_eq!(status, Status::Ok);
    }

    fn finish(&mut self) {
        // SAFETY: as above.
        let status = unsafe { flicr_stream_finish(self.handle, Some(keep), (&raw mut self.sent).cast()) };
        assert_eq!(status, Status::Ok);
    }

    fn tally(&self) -> flicr_stream_tally {
        let mut tally = MaybeUninit::uninit();
        // SAFETY: a place for a tally, which success fills.
        unsafe {
            assert_eq!(flicr_stream_get_tally(self.handle, tally.as_mut_ptr()), Status::Ok);
            tally.assume_init()
        }
    }
}

/// Calls `$each` with a stream in Rust of `$kind`.
macro_rules! in_rust {
    ($kind:expr, $config:expr, |$stream:ident| $each:expr) => {{
        fn run<S>(mut $stream: Box<S>, each: impl FnOnce(&mut S) -> Vec<Vec<u8>>) -> Vec<Vec<u8>> {
            each(&mut $stream)
        }
        match ($kind.coder, $kind.aligned) {
            (flicr_coder::Small, 0) => {
                run(Box::new(StreamEncoder::<SmallModel, 16, 1400, AsFired>::BLANK), |$stream| $each)
            }
            (flicr_coder::Small, _) => {
                run(Box::new(StreamEncoder::<SmallModel, 16, 1400, Aligned<4096, 128>>::BLANK), |$stream| $each)
            }
            (_, 0) => run(Box::new(StreamEncoder::<DenseModel, 16, 1400, AsFired>::BLANK), |$stream| $each),
            (_, _) => run(Box::new(StreamEncoder::<DenseModel, 16, 1400, Aligned<4096, 128>>::BLANK), |$stream| $each),
        }
    }};
}

#[test]
fn datagrams_of_packets_are_rusts() {
    let packets = Plan { start_tick: 18_000, ..Plan::new(Model::Vlp32c, true) }.packets(400);
    let beams = velodyne::VLP32C.beams_at::<32>(600).unwrap();
    let grid = velodyne::VLP32C.grid_of(&beams);
    let meant =
        [(flicr_return_policy::Last, ReturnPolicy::Last, 0), (flicr_return_policy::Other, ReturnPolicy::Both, 1)];
    for (kind, (returns, policy, layer)) in KINDS.into_iter().flat_map(|kind| meant.map(|meant| (kind, meant))) {
        let config =
            StreamConfig { id: 3, layer, columns_a_turn: 1800, ..StreamConfig::new(&grid, 5, SETTINGS).unwrap() };
        let expected = in_rust!(kind, config, |stream| {
            stream.start(config).unwrap();
            let mut sent = Vec::new();
            let mut turns = TurnAssembler::new(Sensor::Spinning(Model::Vlp32c), policy);
            for packet in &packets {
                turns.push(packet, |event| stream.push(&event, |datagram| sent.push(datagram.to_vec()))).unwrap();
            }
            turns.finish(|event| stream.push(&event, |datagram| sent.push(datagram.to_vec())));
            stream.finish(|datagram| sent.push(datagram.to_vec()));
            sent
        });
        let mut config = preset(flicr_sensor::Vlp32c, 1800);
        (config.step_m, config.returns) = (5.0 * config.range_unit_m, returns as u32);
        let mut stream = Stream::new(kind, &config, 3).unwrap();
        for packet in &packets {
            assert_eq!(stream.push(packet), Status::Ok);
        }
        assert_eq!(stream.push(&packets[0]), Status::PacketRefused, "late");
        stream.finish();
        assert!(expected.len() > 50 && stream.sent == expected, "{:?} {}", kind.coder, kind.aligned);
        let tally = stream.tally();
        let bytes: usize = expected.iter().map(Vec::len).sum();
        assert_eq!((tally.datagrams as usize, tally.bytes), (expected.len(), bytes as u64));
        assert_eq!((tally.unfit, tally.cut, tally.thinned), (0, 0, 0));
        let mut stats = MaybeUninit::<flicr_packet_stats>::uninit();
        // SAFETY: a place for counts, which success fills.
        let stats = unsafe {
            assert_eq!(flicr_stream_get_packet_stats(stream.handle, stats.as_mut_ptr()), Status::Ok);
            stats.assume_init()
        };
        assert_eq!((stats.used, stats.refused), (400, 1));
    }
}

/// A made-up firing of an HDL-64E.
fn counts(firing: u32) -> Vec<u32> {
    (0..64)
        .map(
            |row| {
                if (firing / 3 + row).is_multiple_of(7) { 0 } else { 2_000 + row * 150 + (firing * 37 + row * 11) % 90 }
            },
        )
        .collect()
}

#[test]
fn columns_settings_strides_and_cuts_are_rusts() {
    let coarse = flicr_context { step_levels: 20, ..CONTEXT };
    let coarse_settings = SETTINGS.with_step(Step::new(20).unwrap());
    for kind in KINDS {
        let config =
            StreamConfig { columns_a_turn: 900, ..StreamConfig::new(&hdl64e::FIRING_GRID, 1, SETTINGS).unwrap() };
        let expected = in_rust!(kind, config, |stream| {
            stream.start(config).unwrap();
            let mut sent = Vec::new();
            for turn in 0..4 {
                for index in 0..900 {
                    let (at, time_ns) = (index as u16, u64::from(index) * 46_000);
                    stream.push_counts(at, at * 4, time_ns, &counts(index), |datagram| sent.push(datagram.to_vec()));
                    match (turn, index) {
                        (0, 300) => stream.set(coarse_settings),
                        (1, 200) => stream.set_now(SETTINGS),
                        (1, 250) => stream.set_stride(3),
                        (3, 400) => stream.cut(),
                        _ => {}
                    }
                }
                stream.end_turn(|datagram| sent.push(datagram.to_vec()));
            }
            stream.finish(|datagram| sent.push(datagram.to_vec()));
            sent
        });
        let mut stream = Stream::new(kind, &preset(flicr_sensor::Hdl64eFirings, 900), 0).unwrap();
        for turn in 0..4 {
            for index in 0..900 {
                let column = flicr_column { time_ns: u64::from(index) * 46_000, index, tick: index * 4 };
                assert_eq!(stream.column(column, &counts(index)), Status::Ok);
                // SAFETY: the stream's own pointer.
                let status = unsafe {
                    match (turn, index) {
                        (0, 300) => flicr_stream_set_context(stream.handle, &raw const coarse, 0),
                        (1, 200) => flicr_stream_set_context(stream.handle, &raw const CONTEXT, 1),
                        (1, 250) => flicr_stream_set_stride(stream.handle, 3),
                        (3, 400) => flicr_stream_cut(stream.handle),
                        _ => Status::Ok,
                    }
                };
                assert_eq!(status, Status::Ok);
            }
            stream.end_turn();
        }
        stream.finish();
        assert!(expected.len() > 20 && stream.sent == expected, "{:?} {}", kind.coder, kind.aligned);
        let tally = stream.tally();
        assert!(tally.thinned > 800 && tally.cut > 400 && tally.firings >= 3600, "{tally:?}");
    }
}

#[test]
fn datagrams_are_framed_as_rust_does() {
    for len in [0, 1, 253, 254, 255, 508, 1400] {
        let datagram: Vec<u8> = (0..len).map(|at| if at % 300 < 260 { 7 } else { 0 }).collect();
        let mut expected = Vec::new();
        write_framed(&mut expected, &datagram).unwrap();
        let mut out = vec![0xEE; expected.len()];
        let mut framed_len = 0;
        let mut frame = |out: &mut [u8]| {
            // SAFETY: the slices' own pointers and lengths.
            unsafe {
                let (from, to) = (datagram.as_ptr().cast(), out.as_mut_ptr().cast());
                flicr_frame_datagram(from, datagram.len(), to, out.len(), &raw mut framed_len)
            }
        };
        assert_eq!(frame(&mut out), Status::Ok);
        let short = expected.len() - 1;
        assert_eq!(frame(&mut out.clone()[..short]), Status::OutputTooSmall);
        assert_eq!((framed_len, out), (expected.len(), expected));
    }
}

#[test]
fn streams_fit_a_microcontroller() {
    // As fired, with 64 beams: at most 8 KB; aligned 16 KB.
    assert!(flicr_stream_size(64, flicr_coder::Small as u32, 0) <= 8 << 10);
    assert!(flicr_stream_size(64, flicr_coder::Small as u32, 1) <= (16 << 10) + 1024);
    for (beams, coder) in [(0, flicr_coder::Small), (129, flicr_coder::Small), (64, flicr_coder::Rle)] {
        assert_eq!(flicr_stream_size(beams, coder as u32, 0), 0);
    }
}

/// What takes a stream to return the statuses that nothing else returns, and some that others do.
pub fn refused(expect: &mut impl FnMut(Status, Status)) {
    let [kind, aligned, ..] = KINDS;
    let base = preset(flicr_sensor::Hdl64eFirings, 2150);
    let error = |kind, config: &flicr_grid_config, id| Stream::new(kind, config, id).map(|_| ()).unwrap_err();
    expect(error(kind, &flicr_grid_config { step_m: 0.003, ..base }, 0), Status::Step);
    expect(error(kind, &flicr_grid_config { step_m: 0.6, ..base }, 0), Status::Step);
    expect(error(kind, &flicr_grid_config { step_m: f32::NAN, ..base }, 0), Status::Step);
    expect(error(kind, &base, 256), Status::Size);
    expect(error(kind, &flicr_grid_config { beam_count: 63, ..base }, 0), Status::Sensor);
    expect(error(aligned, &flicr_grid_config { columns: 9000, ..base }, 0), Status::Delay);
    expect(error(aligned, &flicr_grid_config { columns: 4500, ..base }, 0), Status::Delay);

    let mut stream = Stream::new(kind, &base, 0).unwrap();
    let column = |index, tick| flicr_column { time_ns: 0, index, tick };
    expect(stream.column(column(8192, 0), &[0; 64]), Status::Size);
    expect(stream.column(column(0, 65_536), &[0; 64]), Status::Ticks);
    expect(stream.column(column(0, 0), &[0; 65]), Status::Size);
    expect(stream.push(&[0; 1206]), Status::Sensor);
    let (state, len) = (stream.memory.as_mut_ptr().cast::<c_void>(), size_of_val(stream.memory.as_slice()));
    let mut other = null_mut();
    // SAFETY: nothing is read or written where the status says why not.
    unsafe {
        expect((kind.init)(state, 100, &raw const base, &raw const CONTEXT, 0, &raw mut other), Status::StateTooSmall);
        expect(
            (kind.init)(state.wrapping_byte_add(1), len, &raw const base, &raw const CONTEXT, 0, &raw mut other),
            Status::Misaligned,
        );
        expect(
            (kind.init)(null_mut(), len, &raw const base, &raw const CONTEXT, 0, &raw mut other),
            Status::NullPointer,
        );
        expect((kind.init)(state, len, &raw const base, null(), 0, &raw mut other), Status::NullPointer);
        expect((kind.init)(state, len, &raw const base, &raw const CONTEXT, 0, state.cast()), Status::Overlap);
        expect(flicr_stream_end_turn(stream.handle, None, null_mut()), Status::NullPointer);
        expect(flicr_stream_set_stride(stream.handle, 0), Status::Size);
        expect(flicr_stream_set_stride(stream.handle, 256), Status::Size);
        let bad = flicr_context { step_levels: 0, ..CONTEXT };
        expect(flicr_stream_set_context(stream.handle, &raw const bad, 0), Status::Context);
        let mut framed_len = 0;
        expect(flicr_frame_datagram(state, 8, state, 20, &raw mut framed_len), Status::Overlap);
        stream.memory.fill(0);
        expect(flicr_stream_cut(stream.handle), Status::NotInitialized);
    }
}
