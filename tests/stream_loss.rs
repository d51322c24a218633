//! Links that drop, double, reorder, flip and truncate: no wrong point is ever delivered, and no more is lost than was.

#[path = "common/small_sensor.rs"]
mod small_sensor;

use flicr::coder::{ContextSettings, SmallModel, Step};
use flicr::stream::{Aligned, AsFired, Line, StreamConfig, StreamDecoder, StreamEncoder, StreamLimits};
use small_sensor::{GRID, Place, ROWS, TICKS, tick};

const TURNS: u16 = 250;
const COLUMNS: usize = 600;
const STEP: u16 = 5;

/// Ticks from column to column.
const TICK_STEP: usize = TICKS as usize / COLUMNS;

/// What the sensor measured, by turn, column and beam.
type Measured = Vec<Vec<[u32; ROWS]>>;

/// Datagrams of a drive, each with the returns in it; and what was measured.
struct Sent {
    datagrams: Vec<(Vec<u8>, usize)>,
    measured: Measured,
}

fn send<L: Line>() -> Sent {
    let settings = ContextSettings::FINE.with_step(Step::new(STEP).unwrap());
    let config = StreamConfig { columns_a_turn: COLUMNS as u16, ..StreamConfig::new(&GRID, 1, settings).unwrap() };
    let mut stream: StreamEncoder<SmallModel, 2, 300, L> = StreamEncoder::new(config).unwrap();
    let (mut place, mut sent, mut measured) = (Place::new(1), Vec::new(), Measured::new());
    for _ in 0..TURNS {
        let mut turn = Vec::new();
        for column in 0..COLUMNS {
            let (counts, tick) = (place.column(), tick(column, COLUMNS));
            turn.push(counts);
            stream.push_counts(column as u16, tick, 0, &counts, |datagram| sent.push(datagram.to_vec()));
        }
        stream.end_turn(|datagram| sent.push(datagram.to_vec()));
        measured.push(turn);
    }
    stream.finish(|datagram| sent.push(datagram.to_vec()));
    let mut receiver = receiver();
    let datagrams = sent.into_iter().map(|datagram| {
        let returns = receiver.push(&datagram).unwrap().returns();
        (datagram, returns)
    });
    Sent { datagrams: datagrams.collect(), measured }
}

fn receiver() -> StreamDecoder {
    let mut receiver = StreamDecoder::new(StreamLimits { open_turns: 3, ..StreamLimits::default() });
    receiver.know(&GRID).unwrap();
    receiver
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Damage {
    Dropped,
    Doubled,
    Reordered,
    Flipped,
    Truncated,
    All,
}

/// Datagrams that did not come as they were sent, alone or at all; and the returns in them.
#[derive(Debug, Default, Clone, Copy)]
struct Lost {
    datagrams: usize,
    returns: usize,
}

/// What arrives of the datagrams, in order, and what is lost of them.
fn damaged(sent: &Sent, damage: Damage, share: f64, random: &mut Place) -> (Vec<Vec<u8>>, Lost) {
    let mut arriving: Vec<(usize, Vec<u8>)> = Vec::new();
    let mut lost = Lost::default();
    for (at, (datagram, returns)) in sent.datagrams.iter().enumerate() {
        let mut hit = |kind: Damage| {
            (damage == kind || damage == Damage::All) && (random.random(1 << 20) as f64) < share * f64::from(1 << 20)
        };
        let [dropped, doubled, reordered, flipped, truncated] =
            [Damage::Dropped, Damage::Doubled, Damage::Reordered, Damage::Flipped, Damage::Truncated].map(&mut hit);
        let mut bytes = datagram.clone();
        if flipped {
            for _ in 0..=random.random(3) {
                let bit = random.random(8 * bytes.len() as u64) as usize;
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
        }
        if truncated {
            bytes.truncate(random.random(bytes.len() as u64) as usize);
        }
        if dropped || bytes != *datagram {
            lost.datagrams += 1;
            lost.returns += returns;
        }
        // Up to twenty datagrams late: a turn has more.
        let place = if reordered { at + random.random(20) as usize } else { at };
        if !dropped {
            arriving.push((place, bytes.clone()));
        }
        if doubled && !dropped {
            arriving.push((place + random.random(20) as usize, bytes));
        }
    }
    arriving.sort_by_key(|(place, _)| *place);
    (arriving.into_iter().map(|(_, bytes)| bytes).collect(), lost)
}

/// Returns received; each checked against what was measured.
fn received(sent: &Sent, arriving: &[Vec<u8>]) -> usize {
    let mut receiver = receiver();
    let (mut found, mut in_turns) = (0, 0);
    let error_max = u32::from(Step::new(STEP).unwrap().error_max());
    for datagram in arriving {
        if let Ok(strip) = receiver.push(datagram) {
            let number = strip.turn();
            for (column, (_, levels)) in strip.columns().enumerate() {
                for (row, &level) in levels.iter().enumerate().filter(|(_, level)| **level != 0) {
                    let tick = usize::from(strip.tick(column, row).unwrap());
                    assert_eq!(tick % TICK_STEP, 0);
                    // Aligned columns hold firings of the turns beside theirs.
                    let turns = [number.wrapping_sub(1), number, number.wrapping_add(1)].map(usize::from);
                    let mut counts =
                        turns.iter().filter_map(|&turn| Some(sent.measured.get(turn)?[tick / TICK_STEP][row]));
                    let is_near = |count: u32| count != 0 && count.abs_diff(level.into()) <= error_max;
                    assert!(counts.any(is_near), "{level} at {tick} {row} of turn {number}");
                    found += 1;
                }
            }
        }
        while let Some(turn) = receiver.next_turn() {
            in_turns += turn.strips().iter().map(flicr::stream::ReceivedStrip::returns).sum::<usize>();
        }
    }
    receiver.flush();
    while let Some(turn) = receiver.next_turn() {
        in_turns += turn.strips().iter().map(flicr::stream::ReceivedStrip::returns).sum::<usize>();
    }
    // What came at once is what came as turns.
    assert_eq!(found, in_turns);
    found
}

/// Runs are added until so many datagrams were lost: how much a datagram holds differs, so that the share of points in
/// a few of them says nothing about a link.
const LOST_MIN: usize = 60;

/// What was lost in that many runs, and the runs.
fn lost_in_runs(sent: &Sent, damage: Damage, share: f64, random: &mut Place) -> (Lost, usize) {
    let returns: usize = sent.datagrams.iter().map(|datagram| datagram.1).sum();
    let (mut sum, mut runs) = (Lost::default(), 0);
    loop {
        let (arriving, lost) = damaged(sent, damage, share, random);
        let found = received(sent, &arriving);
        // Every return of what came whole, and no other.
        assert_eq!(found, returns - lost.returns, "{damage:?} {share}: {lost:?}");
        sum = Lost { datagrams: sum.datagrams + lost.datagrams, returns: sum.returns + lost.returns };
        runs += 1;
        if sum.datagrams >= LOST_MIN || matches!(damage, Damage::Doubled | Damage::Reordered) {
            return (sum, runs);
        }
    }
}

fn check<L: Line>(kinds: &[Damage]) {
    let sent = send::<L>();
    let returns: usize = sent.datagrams.iter().map(|datagram| datagram.1).sum();
    let measured = sent.measured.iter().flatten().flatten().filter(|count| **count != 0).count();
    assert_eq!(returns, measured);
    let mut random = Place::new(7);
    for &damage in kinds {
        for share in [0.001, 0.01, 0.05, 0.2] {
            let (lost, runs) = lost_in_runs(&sent, damage, share, &mut random);
            let datagrams = lost.datagrams as f64 / (runs * sent.datagrams.len()) as f64;
            let points = lost.returns as f64 / (runs * returns) as f64;
            println!("{damage:?} {share}: {runs} runs; datagrams {datagrams:.5}, points {points:.5} lost");
            assert!(points <= 1.2 * datagrams, "{damage:?} {share}: {points} {datagrams}");
        }
    }
}

#[test]
fn as_fired() {
    use Damage::{All, Doubled, Dropped, Flipped, Reordered, Truncated};
    check::<AsFired>(&[Dropped, Doubled, Reordered, Flipped, Truncated, All]);
}

#[test]
fn aligned() {
    check::<Aligned<512, 16>>(&[Damage::Dropped, Damage::All]);
}
