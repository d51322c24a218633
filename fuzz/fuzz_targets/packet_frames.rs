//! Any datagrams and any returns to frames: no panic, every cell counted, and each frame decodes to what was kept.
//!
//! The first eight bytes pick the columns, the step, the level bits and the policies; then each record is a u16 length and
//! its bytes, as in `packets`. A length of 0xfffe stands for a return of ten bytes, which goes into a frame of its own.
#![no_main]

use flicr::geometry::{Beam, SensorGrid};
use flicr::packet::{ReturnPolicy, Sensor, TurnAssembler};
use flicr::{
    Collision, Decoder, EncodedTurn, FrameEncoder, GridConfig, GridReturn, ImageViewMut, Levels, Limits, PacketEncoder,
    Rle, Scale, Stamp,
};
use libfuzzer_sys::fuzz_target;

const BEAMS: usize = 40;

fn beams() -> [Beam; BEAMS] {
    core::array::from_fn(|row| Beam { slope: 0.3 - 0.01 * row as f32, ..Beam::default() })
}

fn check(turn: &EncodedTurn<2>, out: &[u8]) {
    let mut at = 0;
    for frame in &turn.frames {
        check_frame(&out[at..at + frame.len], frame.tally.kept());
        at += frame.len;
    }
}

fn check_frame(bytes: &[u8], kept: u32) {
    let mut decoder = Decoder::new(Limits::default());
    let frame = decoder.decode(bytes).expect("our own frame");
    let Levels::U16(levels) = frame.levels() else { panic!("16 bits") };
    assert_eq!(levels.iter().filter(|&&level| level != 0).count(), kept as usize);
}

fuzz_target!(|data: &[u8]| {
    let Some((&[c0, c1, s0, s1, bits, policy, cut, unit], mut rest)) = data.split_first_chunk() else {
        return;
    };
    let beams = beams();
    let columns = u16::from_le_bytes([c0, c1]) % 1024 + 1;
    let range_unit_m = 0.000_5 * (f32::from(unit) + 1.0);
    let grid = SensorGrid {
        name: "",
        beams: &beams,
        ticks: 36_000,
        clockwise: true,
        zero_rad: 0.0,
        range_unit_m,
        range_from_axis: false,
    };
    let collisions = [Collision::Nearest, Collision::Farthest, Collision::First, Collision::Last];
    let config = GridConfig {
        level_bits: 9 + u32::from(bits % 8),
        scale: Scale::Step { step_m: 1e-5 * (1.0 + f32::from(u16::from_le_bytes([s0, s1]))) },
        collision: collisions[usize::from(policy % 4)],
        table: true,
        ..GridConfig::new(grid, columns)
    };
    let policies = [ReturnPolicy::Strongest, ReturnPolicy::Last, ReturnPolicy::Both];
    let turns = TurnAssembler::new(Sensor::Auto, policies[usize::from(policy / 4 % 3)]).with_cut(u16::from(cut) * 141);
    let pixels = BEAMS * usize::from(columns);
    let mut levels = [(); 3].map(|()| vec![0_u16; pixels]);
    let [first, second, third] = levels.each_mut().map(|levels| ImageViewMut::new(levels, columns.into()).unwrap());
    let (mut coder, mut other) = (Rle::new(), Rle::new());
    let mut encoder = PacketEncoder::new(&config, turns, [first, second], &mut coder).expect("a configuration");
    let mut frame = FrameEncoder::start(&config, Stamp::default(), third, &mut other).expect("a configuration");
    let mut out = vec![0; 2 * config.worst_case_len::<u16, Rle>()];
    let (mut datagram, mut returns, mut pushed) = (Vec::new(), 0, 0);
    while let Some((&len, after)) = rest.split_first_chunk::<2>() {
        let len = usize::from(u16::from_le_bytes(len));
        rest = after;
        if let (0xfffe, Some((&[r0, r1, t0, t1, t2, t3, n0, n1, n2, n3], after))) = (len, rest.split_first_chunk()) {
            let (row, tick) = (u16::from_le_bytes([r0, r1]), u32::from_le_bytes([t0, t1, t2, t3]));
            frame.insert_returns([GridReturn { row, tick, count: u32::from_le_bytes([n0, n1, n2, n3]) }]);
            (rest, returns) = (after, returns + 1);
            continue;
        }
        match (len, rest.split_first_chunk::<6>()) {
            (0xffff, Some((&[at, high, change @ ..], after))) => {
                rest = after;
                let at = usize::from(u16::from_le_bytes([at, high]));
                for (byte, change) in datagram.iter_mut().skip(at).zip(change) {
                    *byte ^= change;
                }
            }
            _ => {
                let (bytes, after) = rest.split_at(len.min(rest.len()));
                datagram = bytes.to_vec();
                rest = after;
            }
        }
        pushed += 1;
        if let Ok(Some(turn)) = encoder.push(&datagram, &mut out) {
            check(&turn, &out);
        }
    }
    if let Some(turn) = encoder.finish(&mut out).expect("the worst case fits") {
        check(&turn, &out);
    }
    let stats = encoder.stats();
    assert_eq!(stats.used + stats.refused(), pushed);
    let encoded = frame.finish(&mut out).expect("the worst case fits");
    assert_eq!(encoded.tally.points, returns);
    check_frame(&out[..encoded.len], encoded.tally.kept());
});
