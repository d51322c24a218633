//! Any bytes as a framed line: the same datagrams however they are cut, none longer than there is room for; and any
//! datagram comes back from its frame, whatever came before it.
#![no_main]

use flicr::stream::{Deframer, framed_len, write_framed};
use libfuzzer_sys::fuzz_target;

const LEN: usize = 300;

fn deframed<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> (Vec<Vec<u8>>, u32) {
    let (mut deframer, mut found) = (Deframer::<LEN>::new(), Vec::new());
    for piece in pieces {
        deframer.push(piece, |datagram| found.push(datagram.to_vec()));
    }
    (found, deframer.refused())
}

fuzz_target!(|data: &[u8]| {
    let Some((&cut, line)) = data.split_first() else { return };
    let whole = deframed([line]);
    assert!(whole.0.iter().all(|datagram| datagram.len() <= LEN));
    assert_eq!(whole, deframed(line.chunks(usize::from(cut) + 1)));
    assert_eq!(whole, deframed(line.chunks(1)));
    let datagram = &line[..line.len().min(LEN)];
    let mut framed = line.to_vec();
    write_framed(&mut framed, datagram).expect("a vector has room");
    assert!(framed.len() - line.len() <= framed_len(datagram.len()));
    assert_eq!(deframed([framed.as_slice()]).0.last().map(Vec::as_slice), Some(datagram));
});
