//! Columns to datagrams and back: every strip alone, any order, any loss.

#[path = "common/packet_writer.rs"]
mod packet_writer;

use flicr::ImageView;
use flicr::coder::{Coder, ContextSettings, DenseModel, Small, SmallModel, Step};
use flicr::geometry::SensorGrid;
use flicr::geometry::sensors::{hdl64e, velodyne};
use flicr::packet::{Event, Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::simulate::{Simulator, Turn};
use flicr::stream::{DATAGRAM_LEN, DatagramError, ReceivedStrip, StreamConfig, StreamDecoder, StreamEncoder};

/// A turn's counts, firing after firing, from the highest beam on.
fn firings(turn: &Turn) -> Vec<[u32; 64]> {
    let mut firings = vec![[0; 64]; turn.firing_ticks.len()];
    for found in &turn.returns {
        firings[usize::from(found.firing)][usize::from(found.beam)] = found.count;
    }
    firings
}

fn settings(step: u16) -> ContextSettings {
    ContextSettings::FINE.with_step(Step::new(step).unwrap())
}

fn small(step: u16) -> StreamEncoder<SmallModel> {
    StreamEncoder::new(StreamConfig::new(&hdl64e::FIRING_GRID, 1, settings(step)).unwrap()).unwrap()
}

/// The datagrams of turns `0..turns` of a simulated drive.
fn datagrams(stream: &mut StreamEncoder<SmallModel>, turns: usize) -> (Vec<Turn>, Vec<Vec<u8>>) {
    let turns: Vec<_> = Simulator::hdl64e(7).take(turns).collect();
    let mut sent = Vec::new();
    for turn in &turns {
        let mut send = |datagram: &[u8]| sent.push(datagram.to_vec());
        for (index, (counts, &tick)) in (0..).zip(firings(turn).iter().zip(&turn.firing_ticks)) {
            stream.push_counts(index, tick, turn.time_ns, counts, &mut send);
        }
        stream.end_turn(&mut send);
    }
    (turns, sent)
}

fn push_all(stream: &mut StreamDecoder, datagrams: &[Vec<u8>]) {
    for datagram in datagrams {
        stream.push(datagram).unwrap();
    }
}

#[test]
fn every_return_comes_back_within_the_step() {
    for step in [1, 10, 51, 157] {
        let (turns, sent) = datagrams(&mut small(step), 2);
        assert!(sent.iter().all(|datagram| datagram.len() <= DATAGRAM_LEN));
        let mut stream = StreamDecoder::default();
        let error_max = Step::new(step).unwrap().error_max();
        let mut found = Vec::new();
        for datagram in &sent {
            let strip = stream.push(datagram).unwrap();
            found.extend(strip.columns().map(|(tick, levels)| (strip.turn(), tick, levels.to_vec())));
        }
        let given = turns.iter().flat_map(|turn| {
            let ticks = turn.firing_ticks.clone();
            firings(turn).into_iter().zip(ticks).map(|(counts, tick)| (turn.index, tick, counts))
        });
        let mut columns = 0;
        for ((turn, tick, counts), (found_turn, found_tick, levels)) in given.zip(&found) {
            assert_eq!((turn, tick), (u64::from(*found_turn), *found_tick));
            for (count, &level) in counts.into_iter().zip(levels) {
                assert_eq!(count == 0, level == 0);
                assert!(count.abs_diff(level.into()) <= error_max.into(), "{count} {level}");
            }
            columns += 1;
        }
        assert_eq!(columns, found.len());
        let over: Vec<_> = std::iter::from_fn(|| stream.next_turn()).collect();
        assert_eq!(over.len(), 2);
        assert!(over.iter().all(flicr::stream::ReceivedTurn::is_complete));
    }
}

#[test]
fn points_are_the_sensors() {
    let (turns, sent) = datagrams(&mut small(1), 1);
    let mut stream = StreamDecoder::default();
    push_all(&mut stream, &sent);
    stream.flush();
    let mut points = stream.next_turn().unwrap().points();
    let mut given: Vec<[f32; 3]> = turns[0].points.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
    assert_eq!(points.len(), given.len());
    let order = |a: &[f32; 3], b: &[f32; 3]| (a[0] * 50.0).round().total_cmp(&(b[0] * 50.0).round());
    points.sort_by(order);
    given.sort_by(order);
    let sum =
        |points: &[[f32; 3]]| points.iter().fold([0.0_f64; 3], |s, p| std::array::from_fn(|i| s[i] + f64::from(p[i])));
    let (a, b) = (sum(&points), sum(&given));
    let n = points.len() as f64;
    assert!((0..3).all(|i| (a[i] - b[i]).abs() / n < 0.001), "{a:?} {b:?}");
}

#[test]
fn any_order_and_twice_is_the_same() {
    let (_, sent) = datagrams(&mut small(10), 1);
    let mut in_order = StreamDecoder::default();
    push_all(&mut in_order, &sent);
    in_order.flush();
    let mut backwards = StreamDecoder::default();
    for datagram in sent.iter().rev() {
        backwards.push(datagram).unwrap();
        assert!(matches!(backwards.push(datagram), Err(DatagramError::Twice { turn: 0, .. })));
    }
    backwards.flush();
    let (a, b) = (in_order.next_turn().unwrap(), backwards.next_turn().unwrap());
    assert!(a.is_complete() && b.is_complete());
    assert_eq!(a.points(), b.points());
}

#[test]
fn a_lost_datagram_loses_its_columns_only() {
    let (_, sent) = datagrams(&mut small(10), 1);
    let whole = {
        let mut stream = StreamDecoder::default();
        push_all(&mut stream, &sent);
        stream.flush();
        stream.next_turn().unwrap()
    };
    for lost in 0..sent.len() {
        let mut stream = StreamDecoder::default();
        let others = sent.iter().enumerate().filter(|&(number, _)| number != lost);
        for (_, datagram) in others {
            stream.push(datagram).unwrap();
        }
        stream.flush();
        let turn = stream.next_turn().unwrap();
        let expected: Vec<_> = whole
            .strips()
            .iter()
            .filter(|strip| usize::from(strip.number()) != lost)
            .flat_map(ReceivedStrip::points)
            .collect();
        assert_eq!(turn.points(), expected);
        assert!(!turn.is_complete());
        assert_eq!(stream.losses().incomplete_turns, 1);
        let is_last = lost + 1 == sent.len();
        assert_eq!(turn.missing().collect::<Vec<_>>(), if is_last { vec![] } else { vec![lost as u16] });
    }
}

#[test]
fn flipped_bits_and_cut_datagrams_are_refused() {
    let (_, sent) = datagrams(&mut small(10), 1);
    let datagram = &sent[3];
    let mut stream = StreamDecoder::default();
    for bit in 0..8 * datagram.len() {
        let mut flipped = datagram.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(stream.push(&flipped).is_err());
    }
    for len in 0..datagram.len() {
        assert!(stream.push(&datagram[..len]).is_err());
    }
    assert!(stream.push(datagram).is_ok());
    assert_eq!(stream.losses().refused, (9 * datagram.len()) as u64);
}

/// What a turn's strips cost beside one whole image by the same coder, in parts of it.
#[test]
fn strips_cost_an_eighth_at_most() {
    for step in [1, 10, 51, 157] {
        let (turns, sent) = datagrams(&mut small(step), 1);
        let bytes: usize = sent.iter().map(Vec::len).sum();
        let columns = turns[0].firing_ticks.len();
        let mut levels = vec![0_u16; 64 * columns];
        for (column, counts) in firings(&turns[0]).iter().enumerate() {
            for (row, &count) in counts.iter().enumerate() {
                levels[row * columns + column] = count as u16;
            }
        }
        let mut out = vec![0; levels.len() * 2 + 100];
        let image = ImageView::new(&levels, columns).unwrap();
        let whole = Small::<8>::new(settings(step)).encode(image, &mut out).unwrap();
        let share = bytes as f64 / whole as f64;
        println!("step {step}: {} datagrams, {bytes} bytes, {share:.3} of {whole}", sent.len());
        assert!(share < 1.085, "{share}");
    }
}

#[test]
fn dense_is_smaller_and_small_fits_four_kilobytes() {
    let config = StreamConfig::new(&hdl64e::FIRING_GRID, 1, settings(10)).unwrap();
    let mut dense: StreamEncoder<DenseModel> = StreamEncoder::new(config).unwrap();
    assert!(size_of::<StreamEncoder<SmallModel>>() < 3700);
    let turn = Simulator::hdl64e(7).turn(0);
    let mut bytes = 0;
    for (index, (counts, &tick)) in (0..).zip(firings(&turn).iter().zip(&turn.firing_ticks)) {
        dense.push_counts(index, tick, 0, counts, |datagram| bytes += datagram.len());
    }
    dense.end_turn(|datagram| bytes += datagram.len());
    let small: usize = datagrams(&mut small(10), 1).1.iter().map(Vec::len).sum();
    assert!(bytes < small, "{bytes} {small}");
}

/// CRC-32 (ISO-HDLC), bit by bit, of a datagram of this sensor.
fn crc32(bytes: &[u8], sensor: &SensorGrid<'_>) -> u32 {
    let sensor = sensor.checksum().to_le_bytes();
    !bytes.iter().chain(&sensor).fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

/// Damage that a checksum does not tell: by a sender that means harm.
#[test]
fn false_datagrams_never_panic() {
    let (_, sent) = datagrams(&mut small(10), 1);
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let (mut taken, mut refused) = (0, 0);
    for round in 0..3000 {
        let mut datagram = sent[round % sent.len()].clone();
        datagram.truncate(datagram.len() - 4);
        for _ in 0..=random(4) {
            let at = if round % 2 == 0 { 4 + random(20) } else { 4 + random(datagram.len() - 4) };
            let at = if round % 16 == 0 { 1 } else { at };
            datagram[at] = random(256) as u8;
        }
        datagram.extend(crc32(&datagram, &hdl64e::FIRING_GRID).to_le_bytes());
        let mut stream = StreamDecoder::default();
        match stream.push(&datagram) {
            Ok(strip) => {
                taken += 1;
                assert_eq!(strip.points().len(), strip.returns());
            }
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
        }
        stream.flush();
        while let Some(turn) = stream.next_turn() {
            let _ = (turn.mask(), turn.points());
        }
    }
    assert!(taken > 10 && refused > 10, "{taken} {refused}");
}

/// Noise that no model compresses: a column may be longer than its levels, which then stand as they are.
#[test]
fn columns_of_noise_are_stored() {
    let config = StreamConfig::new(&hdl64e::FIRING_GRID, 1, settings(1)).unwrap();
    let mut stream: StreamEncoder<SmallModel, 8, 170> = StreamEncoder::new(config).unwrap();
    let mut receiver = StreamDecoder::default();
    let mut state = 9_u32;
    for index in 0..20_u16 {
        let counts: [u32; 64] = std::array::from_fn(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            1 + (state >> 16) % 65_535
        });
        let mut found = Vec::new();
        let mut receive = |datagram: &[u8]| {
            assert!(datagram.len() <= 170);
            found.extend(receiver.push(datagram).unwrap().columns().flat_map(|(_, levels)| levels.to_vec()));
        };
        stream.push_counts(index, index, 0, &counts, &mut receive);
        stream.end_turn(&mut receive);
        assert!(found.iter().map(|&level| u32::from(level)).eq(counts));
    }
}

/// A sender that begins anew is heard again.
#[test]
fn a_new_start_is_followed() {
    let (_, sent) = datagrams(&mut small(157), 1);
    let at_turn = |turn: u16| {
        sent.iter().map(move |datagram| {
            let mut datagram = datagram[..datagram.len() - 4].to_vec();
            datagram[4..6].copy_from_slice(&turn.to_le_bytes());
            let checksum = crc32(&datagram, &hdl64e::FIRING_GRID);
            datagram.extend(checksum.to_le_bytes());
            datagram
        })
    };
    let mut stream = StreamDecoder::default();
    let mut turns = Vec::new();
    // Around the numbers' end, then from 0 as after a reset, though turn 0 is long over.
    for turn in [65_534, 65_535, 0, 1, 500, 0, 1] {
        at_turn(turn).for_each(|datagram| assert!(stream.push(&datagram).is_ok(), "turn {turn}"));
        turns.extend(std::iter::from_fn(|| stream.next_turn()).map(|turn| (turn.number(), turn.is_complete())));
    }
    assert_eq!(turns, [65_534, 65_535, 0, 1, 500, 0, 1].map(|turn| (turn, true)));
    // One that is late is not taken for a new start.
    let late = at_turn(0).next().unwrap();
    assert_eq!(stream.push(&late).map(ReceivedStrip::turn), Err(DatagramError::TooLate { turn: 0 }));
}

/// From a sensor's packets, with one lost: the columns that there were, at their places.
#[test]
fn packets_go_through() {
    use packet_writer::Plan;
    let plan = Plan::new(Model::Vlp16, false);
    let grid = velodyne::VLP16.grid();
    let mut stream: StreamEncoder<SmallModel, 2> =
        StreamEncoder::new(StreamConfig::new(&grid, 1, settings(1)).unwrap()).unwrap();
    let mut turns = TurnAssembler::new(Sensor::Spinning(Model::Vlp16), ReturnPolicy::Strongest);
    let (mut sent, mut given, mut number) = (Vec::new(), Vec::new(), 0);
    for (_, packet) in plan.packets(160).iter().enumerate().filter(|(nth, _)| *nth != 30) {
        let take = |event: Event<'_>| {
            match &event {
                Event::Column(column) => {
                    let mut counts = [0; 16];
                    column.counts(&mut counts);
                    given.push((number, column.index, column.tick, counts));
                }
                Event::TurnEnd(turn) => number = turn.number as u16 + 1,
                _ => {}
            }
            stream.push(&event, |datagram: &[u8]| sent.push(datagram.to_vec()));
        };
        turns.push(packet, take).unwrap();
    }
    stream.end_turn(|datagram| sent.push(datagram.to_vec()));
    let mut receiver = StreamDecoder::default();
    receiver.know(&grid).unwrap();
    let mut found = Vec::new();
    for datagram in &sent {
        let strip = receiver.push(datagram).unwrap();
        for (column, (tick, levels)) in (strip.first_column()..).zip(strip.columns()) {
            let counts: [u32; 16] = std::array::from_fn(|row| levels[row].into());
            found.push((strip.turn(), column, tick, counts));
        }
    }
    assert!(given.len() > 3000);
    assert_eq!(found, given);
}
