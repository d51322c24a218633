//! Streams whose columns are aligned, thinned or cut off, and streams over bytes.

use std::collections::BTreeMap;

use flicr::coder::{ContextSettings, DenseModel, SmallModel, Step};
use flicr::geometry::SensorGrid;
use flicr::geometry::sensors::hdl64e;
use flicr::simulate::{Simulator, Turn};
use flicr::stream::{
    Aligned, AlignedHdl64e, Deframer, Line, ReceivedStrip, StreamConfig, StreamDecoder, StreamEncoder, framed_len,
    write_framed, write_framed_async,
};

fn settings(step: u16) -> ContextSettings {
    ContextSettings::FINE.with_step(Step::new(step).unwrap())
}

fn config(step: u16) -> StreamConfig<'static> {
    StreamConfig { columns_a_turn: 2150, ..StreamConfig::new(&hdl64e::FIRING_GRID, 1, settings(step)).unwrap() }
}

/// In a box: as a value it would lie on the test's stack.
fn stream<L: Line>(step: u16) -> Box<StreamEncoder<SmallModel, 8, 1400, L>> {
    let mut stream = Box::new(StreamEncoder::BLANK);
    stream.start(config(step)).unwrap();
    stream
}

fn firings(turn: &Turn) -> Vec<[u32; 64]> {
    let mut firings = vec![[0; 64]; turn.firing_ticks.len()];
    for found in &turn.returns {
        firings[usize::from(found.firing)][usize::from(found.beam)] = found.count;
    }
    firings
}

/// Firings of a turn that `each` keeps, with their numbers.
fn feed<M, L: Line>(
    stream: &mut StreamEncoder<M, 8, 1400, L>,
    turn: &Turn,
    mut keep: impl FnMut(u16) -> bool,
    mut send: impl FnMut(&[u8]),
) where
    StreamEncoder<M, 8, 1400, L>: Push,
{
    for (index, (counts, &tick)) in (0..).zip(firings(turn).iter().zip(&turn.firing_ticks)) {
        if keep(index) {
            stream.counts(index, tick, counts, &mut send);
        }
    }
    stream.end(&mut send);
}

/// What tests do with an encoder of any tier.
trait Push {
    fn counts(&mut self, index: u16, tick: u16, counts: &[u32], send: &mut dyn FnMut(&[u8]));
    fn end(&mut self, send: &mut dyn FnMut(&[u8]));
}

macro_rules! push {
    ($($model:ty),*) => { $(
        impl<L: Line> Push for StreamEncoder<$model, 8, 1400, L> {
            fn counts(&mut self, index: u16, tick: u16, counts: &[u32], send: &mut dyn FnMut(&[u8])) {
                self.push_counts(index, tick, 0, counts, send);
            }
            fn end(&mut self, send: &mut dyn FnMut(&[u8])) {
                self.end_turn(send);
            }
        }
    )* };
}
push!(SmallModel, DenseModel);

/// Every return of a strip: where its beam was, and its level. With the turn only as far as beams share one.
fn returns(strip: &ReceivedStrip) -> Vec<((usize, u16), u16)> {
    let columns = strip.columns().enumerate();
    let returns = columns.flat_map(|(column, (_, levels))| {
        let rows = levels.iter().enumerate().filter(|(_, level)| **level != 0);
        rows.map(move |(row, &level)| ((row, strip.tick(column, row).unwrap()), level)).collect::<Vec<_>>()
    });
    returns.collect()
}

/// What the simulated turn has, by beam and tick.
fn measured(turn: &Turn) -> BTreeMap<(usize, u16), u32> {
    let at = |found: &flicr::simulate::Return| (usize::from(found.beam), turn.firing_ticks[usize::from(found.firing)]);
    turn.returns.iter().map(|found| (at(found), found.count)).collect()
}

/// Three turns whose delay line runs across their borders, with firings that never came: each return comes out once, at its
/// beam and tick, within the step.
#[test]
fn aligned_columns_hold_every_return() {
    for step in [1, 10, 157] {
        let error_max = u32::from(Step::new(step).unwrap().error_max());
        let mut stream = stream::<AlignedHdl64e>(step);
        assert!(stream.delay() < 128);
        let mut receiver = StreamDecoder::default();
        let (mut found, mut sent, mut turns_over) = (Vec::new(), Vec::new(), 0);
        let turns: Vec<_> = Simulator::hdl64e(3).take(3).collect();
        let was_lost = |turn: usize, index: u16| turn == 1 && (500..517).contains(&index);
        for (number, turn) in turns.iter().enumerate() {
            feed(&mut stream, turn, |index| !was_lost(number, index), |datagram| sent.push(datagram.to_vec()));
        }
        stream.finish(|datagram| sent.push(datagram.to_vec()));
        for datagram in &sent {
            let strip = receiver.push(datagram).unwrap();
            assert!(strip.is_aligned());
            found.extend(returns(strip));
            while let Some(turn) = receiver.next_turn() {
                assert!(turn.is_complete());
                turns_over += 1;
            }
        }
        while let Some(turn) = receiver.next_turn() {
            assert!(turn.is_complete());
            turns_over += 1;
        }
        // The first beams look into the turn before the first, the last ones into that behind the last.
        assert_eq!(turns_over, 5);
        let mut given = BTreeMap::<_, Vec<u32>>::new();
        for (number, turn) in turns.iter().enumerate() {
            let lost: Vec<u16> = (500..517).map(|index| turn.firing_ticks[index]).collect();
            for ((row, tick), count) in measured(turn) {
                if number != 1 || !lost.contains(&tick) {
                    given.entry((row, tick)).or_default().push(count);
                }
            }
        }
        assert_eq!(given.values().map(Vec::len).sum::<usize>(), found.len());
        for (at, level) in found {
            let counts = given.get_mut(&at).unwrap_or_else(|| panic!("no return at {at:?}"));
            let near = counts.iter().position(|count| count.abs_diff(level.into()) <= error_max);
            counts.remove(near.unwrap_or_else(|| panic!("{level} at {at:?}: {counts:?}")));
        }
    }
}

/// The points of aligned columns are those of columns as fired, in another order.
#[test]
fn aligned_points_are_the_same() {
    let turn = Simulator::hdl64e(7).turn(0);
    let points = |sent: &[Vec<u8>]| {
        let mut receiver = StreamDecoder::default();
        let mut points: Vec<[u32; 3]> = sent
            .iter()
            .flat_map(|datagram| receiver.push(datagram).unwrap().points())
            .map(|p| p.map(f32::to_bits))
            .collect();
        points.sort_unstable();
        points
    };
    let mut fired = Vec::new();
    feed(&mut stream::<flicr::stream::AsFired>(1), &turn, |_| true, |datagram| fired.push(datagram.to_vec()));
    let (mut line, mut aligned) = (stream::<AlignedHdl64e>(1), Vec::new());
    feed(&mut line, &turn, |_| true, |datagram| aligned.push(datagram.to_vec()));
    line.finish(|datagram| aligned.push(datagram.to_vec()));
    let (fired, aligned) = (points(&fired), points(&aligned));
    assert!(fired.len() > 50_000);
    assert!(fired == aligned, "{} {}", fired.len(), aligned.len());
}

#[test]
fn room_is_what_it_takes() {
    let (cells, firings) = AlignedHdl64e::room(&hdl64e::FIRING_GRID, 2300);
    println!(
        "{cells} cells, {firings} firings; {} bytes",
        size_of::<StreamEncoder<SmallModel, 8, 1400, AlignedHdl64e>>()
    );
    assert!(cells <= 4096 && firings <= 128);
    assert!(size_of::<StreamEncoder<SmallModel, 8, 1400, AlignedHdl64e>>() <= 14_000);
    assert!(size_of::<StreamEncoder<DenseModel, 8, 1400, AlignedHdl64e>>() <= 17_000);
    assert!(size_of::<StreamEncoder>() <= 3700);
    let mut small: Box<StreamEncoder<SmallModel, 8, 1400, Aligned<4000, 64>>> = Box::new(StreamEncoder::BLANK);
    assert!(matches!(small.start(config(1)), Err(flicr::ConfigError::Delay { firings: 110.., firings_max: 64, .. })));
    // What was not started makes nothing of what it gets.
    feed(&mut small, &Simulator::hdl64e(7).turn(0), |_| true, |_| panic!("a datagram"));
}

/// One column of three: those are exact, the others are not there, and the receiver knows.
#[test]
fn thinned_columns_keep_their_places() {
    fn check<L: Line>(is_aligned: bool) {
        let mut stream = stream::<L>(1);
        stream.set_stride(3);
        let turns: Vec<_> = Simulator::hdl64e(5).take(2).collect();
        let (mut receiver, mut found) = (StreamDecoder::default(), 0_usize);
        let mut sent = Vec::new();
        for turn in &turns {
            feed(&mut stream, turn, |_| true, |datagram| sent.push(datagram.to_vec()));
        }
        stream.finish(|datagram| sent.push(datagram.to_vec()));
        let all: Vec<_> = turns.iter().map(measured).collect();
        for datagram in &sent {
            let strip = receiver.push(datagram).unwrap();
            assert_eq!((strip.stride(), strip.first_column() % 3, strip.is_aligned()), (3, 0, is_aligned));
            for (at, level) in returns(strip) {
                assert!(all.iter().any(|turn| turn.get(&at) == Some(&level.into())), "{at:?}");
                found += 1;
            }
        }
        receiver.flush();
        let first = std::iter::from_fn(|| receiver.next_turn()).find(|turn| turn.number() == 0);
        let mask = first.unwrap().mask();
        assert!(mask.len().abs_diff(turns[0].firing_ticks.len()) < 3 && mask.iter().all(|&has| has));
        let given: usize = all.iter().map(BTreeMap::len).sum();
        assert!((3 * found).abs_diff(given) < given / 50, "{found} {given}");
        let tally = stream.tally();
        assert_eq!(tally.cut + tally.unfit, 0);
        assert!(tally.thinned.abs_diff(2 * tally.columns) < 10);
    }
    check::<flicr::stream::AsFired>(false);
    check::<AlignedHdl64e>(true);
}

/// What is cut off is counted, and the turn's end is still told.
#[test]
fn a_turn_can_be_cut_off() {
    let mut stream = stream::<flicr::stream::AsFired>(10);
    let turns: Vec<_> = Simulator::hdl64e(5).take(2).collect();
    let mut receiver = StreamDecoder::default();
    for (number, turn) in turns.iter().enumerate() {
        for (index, (counts, &tick)) in (0..).zip(firings(turn).iter().zip(&turn.firing_ticks)) {
            if number == 0 && index == 1000 {
                stream.cut();
            }
            stream.push_counts(index, tick, 0, counts, |datagram| assert!(receiver.push(datagram).is_ok()));
        }
        stream.end_turn(|datagram| assert!(receiver.push(datagram).is_ok()));
        let turn = receiver.next_turn().unwrap();
        assert!(turn.is_complete());
        assert_eq!(turn.mask().len(), if number == 0 { 1000 } else { turns[1].firing_ticks.len() });
    }
    assert_eq!(stream.tally().cut as usize, turns[0].firing_ticks.len() - 1000);
}

/// Steps that change within a turn are those of the next strip on.
#[test]
fn steps_change_within_a_turn() {
    let mut stream = stream::<flicr::stream::AsFired>(1);
    let turn = Simulator::hdl64e(5).turn(0);
    let (mut receiver, mut steps) = (StreamDecoder::default(), Vec::new());
    let mut receive = |datagram: &[u8]| steps.push(receiver.push(datagram).unwrap().step());
    for (index, (counts, &tick)) in (0..).zip(firings(&turn).iter().zip(&turn.firing_ticks)) {
        if index == 1000 {
            stream.set_now(settings(51));
        }
        stream.push_counts(index, tick, 0, counts, &mut receive);
    }
    stream.end_turn(&mut receive);
    let fine = steps.iter().filter(|&&step| step == 1).count();
    assert!(fine > 10 && steps[fine..].iter().all(|&step| step == 51) && steps.len() > fine + 5, "{steps:?}");
}

/// Two sensors' streams and two of the same sensor, all mixed, to one receiver.
#[test]
fn streams_are_told_apart() {
    let other = SensorGrid { zero_rad: 1.0, ..hdl64e::FIRING_GRID };
    let mut receiver = StreamDecoder::default();
    receiver.know(&other).unwrap();
    let kinds = [(&hdl64e::FIRING_GRID, 0), (&hdl64e::FIRING_GRID, 3), (&other, 0)];
    let mut sent: Vec<Vec<Vec<u8>>> = Vec::new();
    for (grid, id) in kinds {
        let mut stream: StreamEncoder = StreamEncoder::new(StreamConfig { id, grid, ..config(51) }).unwrap();
        let turn = Simulator::hdl64e(5 + u64::from(id)).turn(0);
        let mut datagrams = Vec::new();
        feed(&mut stream, &turn, |_| true, |datagram| datagrams.push(datagram.to_vec()));
        sent.push(datagrams);
    }
    for at in 0..sent.iter().map(Vec::len).max().unwrap() {
        for datagram in sent.iter().filter_map(|sent| sent.get(at)) {
            receiver.push(datagram).unwrap();
        }
    }
    let over: Vec<_> = std::iter::from_fn(|| receiver.next_turn()).collect();
    assert!(over.iter().all(flicr::stream::ReceivedTurn::is_complete));
    let kinds: Vec<_> = kinds.iter().map(|(grid, id)| (grid.checksum(), *id)).collect();
    assert_eq!(over.iter().map(|turn| (turn.sensor(), turn.stream())).collect::<Vec<_>>(), kinds);
}

/// The dense tier in aligned columns, and fewer bytes than the small one's.
#[test]
fn dense_is_smaller() {
    let turn = Simulator::hdl64e(7).turn(0);
    let mut dense: Box<StreamEncoder<DenseModel, 8, 1400, AlignedHdl64e>> = Box::new(StreamEncoder::BLANK);
    dense.start(config(10)).unwrap();
    let mut receiver = StreamDecoder::default();
    feed(&mut dense, &turn, |_| true, |datagram| assert!(receiver.push(datagram).is_ok()));
    let mut small = stream::<AlignedHdl64e>(10);
    feed(&mut small, &turn, |_| true, |_| ());
    assert!(dense.tally().bytes < small.tally().bytes);
}

/// Bytes that framing must get right: none, zeros, and runs around 254 long.
fn messages() -> Vec<Vec<u8>> {
    let mut messages = vec![vec![], vec![0], vec![0, 0], vec![1, 0, 0, 2]];
    for len in [253, 254, 255, 508, 509, 762, 1400] {
        messages.push(vec![7; len]);
        messages.push([vec![7; len], vec![0]].concat());
        messages.push((0..len).map(|at| (at % 255) as u8).collect());
    }
    messages
}

#[test]
fn framing_is_cobs() {
    for message in messages() {
        let mut line = Vec::new();
        write_framed(&mut line, &message).unwrap();
        assert!(line.len() <= framed_len(message.len()), "{}", message.len());
        assert!(line[1..line.len() - 1].iter().all(|&byte| byte != 0));
        let theirs = cobs::decode_with_crate(&line[1..]);
        assert!(theirs == message);
        let mut found = Vec::new();
        let mut deframer: Deframer<1500> = Deframer::new();
        deframer.push(&line, |datagram| found.push(datagram.to_vec()));
        deframer.push(&cobs::encode_with_crate(&message), |datagram| found.push(datagram.to_vec()));
        assert!(found == [message.clone(), message]);
        assert_eq!(deframer.refused(), 0);
    }
}

/// The crate of this name, without its allocating half.
mod cobs {
    extern crate cobs as theirs;

    pub fn decode_with_crate(line: &[u8]) -> Vec<u8> {
        let mut out = vec![0; line.len()];
        let len = theirs::decode(line, &mut out).unwrap().frame_size();
        out.truncate(len);
        out
    }

    pub fn encode_with_crate(message: &[u8]) -> Vec<u8> {
        let mut out = vec![0; theirs::max_encoding_length(message.len()) + 2];
        let len = theirs::encode_including_sentinels(message, &mut out);
        out.truncate(len);
        out
    }
}

/// Whatever comes between: the next datagram is whole again, and none is made up that does not pass its checksum.
#[test]
fn a_byte_stream_is_found_again() {
    let turn = Simulator::hdl64e(5).turn(0);
    let mut sent = Vec::new();
    feed(&mut stream::<flicr::stream::AsFired>(51), &turn, |_| true, |datagram| sent.push(datagram.to_vec()));
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..50 {
        let (mut line, mut whole) = (Vec::new(), Vec::new());
        for datagram in &sent {
            let mut framed = Vec::new();
            write_framed(&mut framed, datagram).unwrap();
            match random(4) {
                0 => framed.truncate(1 + random(framed.len() - 2)),
                1 => {
                    let at = 1 + random(framed.len() - 2);
                    framed[at] ^= 1 << random(8);
                }
                2 => line.extend((0..random(40)).map(|_| random(256) as u8)),
                _ => {}
            }
            let mut intact = Vec::new();
            write_framed(&mut intact, datagram).unwrap();
            if framed == intact {
                whole.push(datagram.clone());
            }
            line.extend(framed);
        }
        let mut receiver = StreamDecoder::default();
        let (mut deframer, mut found): (Deframer, _) = (Deframer::new(), Vec::new());
        // In pieces, as they come from a UART.
        while !line.is_empty() {
            let piece: Vec<u8> = line.drain(..(1 + random(300)).min(line.len())).collect();
            deframer.push(&piece, |datagram| {
                if receiver.push(datagram).is_ok() {
                    found.push(datagram.to_vec());
                }
            });
        }
        assert!(found == whole);
    }
}

/// The same bytes where waiting is asynchronous.
#[test]
fn framing_is_the_same_asynchronously() {
    struct Line(Vec<u8>);
    impl embedded_io::ErrorType for Line {
        type Error = core::convert::Infallible;
    }
    impl embedded_io_async::Write for Line {
        async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
            // Not all at once.
            let len = bytes.len().min(100);
            self.0.extend(&bytes[..len]);
            Ok(len)
        }
        async fn flush(&mut self) -> Result<(), Self::Error> {
            Ok(())
        }
    }
    for message in messages() {
        let mut line = Line(Vec::new());
        let mut context = std::task::Context::from_waker(std::task::Waker::noop());
        {
            let future = std::pin::pin!(write_framed_async(&mut line, &message));
            assert!(future.poll(&mut context).is_ready());
        }
        let mut expected = Vec::new();
        write_framed(&mut expected, &message).unwrap();
        assert!(line.0 == expected);
    }
}
