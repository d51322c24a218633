//! The fast tier's bytes of real scans: other ones are another version of the format.

use flicr::ImageView;
use flicr::coder::fast_lab::decode;
use flicr::coder::{Coder, ContextSettings, Fast, Step};

use crate::common::data;
use crate::firing_turns::{ROWS, Turn, turns};

/// By step in counts of 2 mm.
const CHECKSUMS: [(u16, u32); 6] =
    [(1, 0xaba4_190a), (5, 0x4224_e24f), (10, 0xebff_d501), (51, 0xa4ce_f931), (101, 0x1119_9598), (157, 0x7cc4_dca7)];

/// The payload of a turn, each of whose levels comes back within the step's bound.
fn payload(turn: &Turn, step: Step) -> Vec<u8> {
    let mut out = vec![0; 2 * turn.levels.len() + 6];
    let mut coder = Box::new(Fast::<1>::new(ContextSettings::FINE.with_step(step)));
    let len = coder.encode(ImageView::new(&turn.levels, turn.columns).unwrap(), &mut out).unwrap();
    out.truncate(len);
    let mut back = vec![7_u16; turn.levels.len()];
    decode(&out, ROWS, &mut back).unwrap();
    for (&level, &back) in turn.levels.iter().zip(&back) {
        assert!((level == 0) == (back == 0) && level.abs_diff(back) <= step.error_max(), "{level}: {back}, {step:?}");
    }
    out
}

pub fn the_bytes_are_those_of_the_format() {
    let scans = [0, 1].map(|scan| data::read_points(&data::path(&format!("kitti/paper/{scan}.bin"))));
    let turns = turns(scans.iter().map(Vec::as_slice));
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let found = CHECKSUMS.map(|(levels, _)| {
        let mut digest = crc.digest();
        for turn in &turns {
            digest.update(&payload(turn, Step::new(levels).unwrap()));
        }
        (levels, digest.finalize())
    });
    assert_eq!(found, CHECKSUMS);
}
