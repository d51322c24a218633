//! Budgets are kept, soon, by coarser steps first and fewer columns last; on a simulated link too.

#[path = "common/link.rs"]
mod link;

use flicr::coder::{ContextSettings, SmallModel, Step};
use flicr::control::{Bounds, Budget, Control, TurnReport};
use flicr::geometry::sensors::hdl64e;
use flicr::simulate::{Simulator, Turn};
use flicr::stream::{AlignedHdl64e, AsFired, DATAGRAM_LEN, Line, StreamConfig, StreamEncoder};

use link::{Link, run};

/// And the one that tells the turn's end.
const ONE_DATAGRAM: u32 = DATAGRAM_LEN as u32 + 32;

fn step(levels: u16) -> Step {
    Step::new(levels).unwrap()
}

fn bounds(finest: u16, coarsest: u16, stride_max: u8) -> Bounds {
    Bounds { finest: step(finest), coarsest: step(coarsest), stride_max }
}

fn stream<L: Line>() -> Box<StreamEncoder<SmallModel, 8, 1400, L>> {
    let grid = &hdl64e::FIRING_GRID;
    let config = StreamConfig { columns_a_turn: 2150, ..StreamConfig::new(grid, 1, ContextSettings::FINE).unwrap() };
    let mut stream = Box::new(StreamEncoder::BLANK);
    stream.start(config).unwrap();
    stream
}

fn firings(turn: &Turn) -> Vec<[u32; 64]> {
    let mut firings = vec![[0; 64]; turn.firing_ticks.len()];
    for found in &turn.returns {
        firings[usize::from(found.firing)][usize::from(found.beam)] = found.count;
    }
    firings
}

/// Turns under the budget that `budget` gives each; what became of them.
fn reports<L: Line>(turns: usize, bounds: Bounds, mut budget: impl FnMut(usize) -> Budget) -> Vec<TurnReport> {
    let mut stream = stream::<L>();
    let mut control = Control::new(budget(0), bounds);
    control.begin(&mut stream);
    let mut reports = Vec::new();
    for (number, turn) in Simulator::hdl64e(9).take(turns).enumerate() {
        control.set_budget(budget(number));
        let time_ns = 100_000_000 * number as u64;
        for (index, (counts, &tick)) in (0..).zip(firings(&turn).iter().zip(&turn.firing_ticks)) {
            stream.feed_counts(index, tick, time_ns + u64::from(index) * 46_500, counts);
            while let Some(datagram) = stream.next_datagram() {
                // So many instructions a byte, as if.
                let instructions = 200 * datagram.len() as u32;
                reports.extend(control.sent(&mut stream, instructions));
            }
        }
        stream.feed_turn_end();
        while let Some(datagram) = stream.next_datagram() {
            let instructions = 200 * datagram.len() as u32;
            reports.extend(control.sent(&mut stream, instructions));
        }
    }
    reports
}

/// Whatever the budget does, no turn takes more than it and one datagram.
#[test]
fn no_turn_takes_more_than_a_datagram_too_much() {
    let budgets = [90_000, 60_000, 20_000, 5_000, 1_000, 0, 40_000, 120_000, 15_000, 15_000];
    let of = |number: usize| Budget::BytesATurn(budgets[number]);
    for reports in [
        reports::<AsFired>(budgets.len(), bounds(1, 157, 4), of),
        reports::<AsFired>(budgets.len(), bounds(10, 51, 1), of),
        reports::<AlignedHdl64e>(budgets.len(), bounds(1, 157, 2), |_| Budget::BytesATurn(30_000)),
    ] {
        assert!(reports.len() >= budgets.len());
        for report in &reports {
            assert!(report.bytes <= report.budget + ONE_DATAGRAM, "{report:?}");
        }
    }
}

/// A budget that falls to a third, or comes back: within two turns a turn takes no more and is not cut, and what the budget
/// leaves room for is used.
#[test]
fn it_reacts_within_two_turns() {
    let at = |number: usize| if (4..10).contains(&number) { 22_000 } else { 66_000 };
    let reports = reports::<AsFired>(16, bounds(1, 157, 2), |number| Budget::BytesATurn(at(number)));
    for (number, report) in reports.iter().enumerate() {
        println!("{number}: {report:?}");
        let is_settled = number >= 2 && at(number) == at(number - 2) && at(number) == at(number - 1);
        if is_settled {
            assert!(report.cut == 0 && report.bytes <= at(number), "{number}: {report:?}");
            assert!(report.bytes >= at(number) * 4 / 5, "{number}: {report:?}");
        }
    }
}

/// Columns are left out only where the coarsest step does not do.
#[test]
fn coarser_first_fewer_columns_last() {
    for (budget, strides) in [(80_000, 1..=1), (30_000, 1..=1), (13_000, 2..=3), (6_000, 3..=8)] {
        let reports = reports::<AsFired>(6, bounds(5, 100, 8), |_| Budget::BytesATurn(budget));
        let last = reports.last().unwrap();
        println!("{budget}: {last:?}");
        assert!(strides.contains(&last.stride) && last.cut == 0, "{budget}: {last:?}");
        assert!(last.stride == 1 || last.finest > 50, "{budget}: {last:?}");
        assert!(last.bytes <= budget);
    }
}

/// Bounds are bounds, and what does not fit in them is cut off.
#[test]
fn bounds_are_kept() {
    let rich = reports::<AsFired>(4, bounds(10, 20, 1), |_| Budget::BytesATurn(1_000_000));
    assert!(rich[1..].iter().all(|report| (report.finest, report.coarsest, report.cut) == (10, 10, 0)));
    let poor = reports::<AsFired>(4, bounds(10, 20, 1), |_| Budget::BytesATurn(10_000));
    assert!(poor.iter().all(|report| report.coarsest <= 20 && report.stride == 1 && report.cut > 1000));
}

/// A budget of bytes a second goes by the sensor's clock.
#[test]
fn bytes_a_second() {
    let reports = reports::<AsFired>(8, bounds(1, 157, 2), |_| Budget::BytesASecond(400_000));
    let bytes: u32 = reports.iter().map(|report| report.bytes).sum();
    assert!((8 * 33_000..=8 * 40_000 + ONE_DATAGRAM).contains(&bytes), "{bytes}");
    assert!(reports[2..].iter().all(|report| report.cut == 0));
}

/// A budget of instructions: nothing is cut off for it, and the turns come to it.
#[test]
fn instructions_a_turn() {
    let reports = reports::<AsFired>(8, bounds(1, 157, 4), |_| Budget::InstructionsATurn(6_000_000));
    for report in &reports {
        assert!(report.cut == 0);
    }
    assert!(reports[2..].iter().all(|report| report.instructions <= 6_000_000), "{reports:?}");
}

/// A link whose bandwidth goes up and down, which loses datagrams and tells the sender late: the queue stays short, turns
/// come in time, and all that is missing is what the link lost, and what was cut off.
#[test]
fn a_link_that_changes() {
    let link = Link { loss: 0.01, delay_us: 30_000, feedback_us: 40_000, seed: 5 };
    let turns = run(link, 30, bounds(1, 157, 4));
    for turn in &turns {
        println!("{turn:?}");
    }
    let late = turns.iter().filter(|turn| turn.latency_us > 100_000 + 30_000 + 100_000).count();
    // What had been sent before the sender heard of the link's fall has to go through first.
    assert!(late <= 4, "{late}");
    assert!(turns[12..].iter().all(|turn| turn.latency_us < 200_000));
    let sent: usize = turns.iter().map(|turn| turn.strips_sent).sum();
    let lost: usize = turns.iter().map(|turn| turn.strips_sent - turn.strips_received).sum();
    assert!(lost * 20 < sent && lost > 0, "{lost} {sent}");
}
