//! Any bytes as the code of each strip of a context frame, every tier: an error or an image whose every pixel was written,
//! within bounds, no panic.
//!
//! Eight bytes pick tier, step, size and strips; then each strip is a u16 length and its code. Headers and checksums fit.
#![no_main]

use flicr::frame::{self, UniformHeader};
use flicr::{
    Coder, CoderId, Decoder, Header, ImageView, Level, Levels, Limits, OutputFull, Placement, Quantizer, Store,
    UniformView, WorstCase,
};
use libfuzzer_sys::fuzz_target;

/// Writes what the fuzzer says, whatever the image.
struct Raw<'a> {
    prefix: [u8; 6],
    strips: &'a [u8],
}

impl<L: Level> Coder<L> for Raw<'_> {
    const ID: CoderId = CoderId::Context;
    const WORST_CASE: WorstCase = WorstCase { bytes_per_level: 2, block_len: 1, bytes_per_block: 8, gathers: false };

    fn error_max(&self) -> u16 {
        u16::MAX
    }

    fn encode(&mut self, _: ImageView<'_, L>, out: &mut [u8]) -> Result<usize, OutputFull> {
        let (len, rest) = self.strips.split_first_chunk::<2>().unwrap_or((&[0; 2], &[]));
        let (code, rest) = rest.split_at(usize::from(u16::from_le_bytes(*len)).min(rest.len()));
        self.strips = rest;
        let payload = [&self.prefix, code].concat();
        out.get_mut(..payload.len()).ok_or(OutputFull)?.copy_from_slice(&payload);
        Ok(payload.len())
    }
}

fn framed<L: Level>(levels: &[L], columns: usize, strips: u16, mut coder: impl Coder<L>) -> Option<Vec<u8>> {
    let image = ImageView::new(levels, columns)?;
    let header = Header {
        sequence: 0,
        timestamp_ns: 0,
        rows: image.rows() as u16,
        columns: columns as u16,
        quantizer: Quantizer::with_step(L::BITS, 0.002).ok()?,
        coder: CoderId::Store,
        error_max: 0,
        returns: 0,
        geometry: UniformHeader { view: UniformView::all_around(0.1, -0.4), placement: Placement::Center },
    };
    let mut out = vec![0; 1 << 17];
    let header = Header { coder: coder_id(&coder), error_max: coder.error_max(), ..header };
    let len = frame::write(header, image, strips, &mut coder, &mut out).ok()?;
    out.truncate(len);
    Some(out)
}

fn coder_id<L: Level, C: Coder<L>>(_: &C) -> CoderId {
    C::ID
}

fn check<L: Level>(full: L, [rows, columns]: [usize; 2], strips: u16, coder: Raw<'_>) {
    let levels = vec![full; rows * columns];
    let Some(bytes) = framed(&levels, columns, strips, coder) else { return };
    let limits = Limits { pixels: rows * columns, ..Limits::default() };
    let mut fresh = Decoder::new(limits);
    let Ok(decoded) = fresh.decode(&bytes) else { return };
    let header = *decoded.header();
    let max = header.quantizer.max_level();
    assert!(match decoded.levels() {
        Levels::U8(levels) => levels.len() == rows * columns,
        Levels::U16(levels) => levels.len() == rows * columns && levels.iter().all(|&level| level <= max),
    });
    assert!(decoded.points().len() <= rows * columns);
    // A pixel that is not written shows what was there before.
    let mut used = Decoder::new(limits);
    used.decode(&framed(&levels, columns, 1, Store::new()).expect("a frame")).expect("our own frame");
    assert!(used.decode(&bytes).expect("as before").levels() == decoded.levels());
}

fuzz_target!(|data: &[u8]| {
    let Some((&[kind, noise, s0, s1, m0, m1, rows, columns], rest)) = data.split_first_chunk() else { return };
    let Some((&strips, rest)) = rest.split_first() else { return };
    let size = [usize::from(rows % 160) + 1, usize::from(columns % 64) + 1];
    let strips = u16::from(strips) % size[1] as u16 + 1;
    let coder = Raw { prefix: [kind & 0x7f, noise, s0, s1, m0, m1], strips: rest };
    if kind & 0x80 == 0 { check(7_u16, size, strips, coder) } else { check(7_u8, size, strips, coder) }
});
