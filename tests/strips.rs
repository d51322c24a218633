//! Promise: a frame of several strips holds the same image as one of a single strip, each strip is coded as if it were alone,
//! and none needs more room than is said.
#![allow(missing_docs)]

use flicr::coder::{Coder, ContextSettings, Fast, Step};
use flicr::frame::{self, UniformHeader};
use flicr::geometry::{Firings, Lattice, sensors::hdl64e};
use flicr::{
    CoderId, Config, ConfigError, Decoder, DeflateDefault, DeflateSmall, Dense, EncodeError, Encoder, FiringsConfig,
    Header, ImageView, LatticeConfig, Level, Levels, Placement, Quantizer, Rle, Small, Stamp, Store, UniformView,
};
use proptest::prelude::*;

fn header<L: Level>(image: ImageView<'_, L>) -> Header<UniformHeader> {
    Header {
        sequence: 0,
        timestamp_ns: 0,
        rows: image.rows() as u16,
        columns: image.columns() as u16,
        quantizer: Quantizer::with_step(L::BITS, 0.002).unwrap(),
        coder: CoderId::Store,
        error_max: 0,
        returns: 0,
        geometry: UniformHeader { view: UniformView::all_around(0.1, -0.4), placement: Placement::Center },
    }
}

/// Levels as they are coded: of the lossless coders, the image's own.
trait Known: Level {
    fn of(levels: &Levels) -> &[Self];
}

impl Known for u8 {
    fn of(levels: &Levels) -> &[u8] {
        if let Levels::U8(levels) = levels { levels } else { panic!("8 bits") }
    }
}

impl Known for u16 {
    fn of(levels: &Levels) -> &[u16] {
        if let Levels::U16(levels) = levels { levels } else { panic!("16 bits") }
    }
}

/// The columns as an image of their own.
fn cut<L: Level>(levels: &[L], columns: usize, first: usize, width: usize) -> Vec<L> {
    levels.chunks(columns).flat_map(|row| &row[first..first + width]).copied().collect()
}

fn check<L: Known, C: Coder<L>>(levels: &[L], columns: usize, strips: u16, coder: &mut C) {
    let image = ImageView::new(levels, columns).unwrap();
    let rows = image.rows();
    let mut out = vec![0xa5; frame::worst_case_len_in_strips::<L, C>(rows, columns, strips)];
    let len = frame::write(header(image), image, strips, coder, &mut out).expect("the worst case is enough");
    let mut decoder = Decoder::default();
    assert!(L::of(decoder.decode(&out[..len]).unwrap().levels()) == levels, "{:?} in {strips} strips", C::ID);
    let found: Vec<_> = frame::parse(&out[..len]).unwrap().strips().map(Result::unwrap).collect();
    assert_eq!(found.len(), usize::from(strips));
    let widths = found.iter().map(|strip| strip.columns);
    assert!(widths.clone().max().unwrap() - widths.min().unwrap() <= 1, "not even");
    let mut payload = vec![0; C::WORST_CASE.len(levels.len())];
    for strip in found {
        let width = usize::from(strip.columns);
        let alone = cut(levels, columns, strip.first_column.into(), width);
        let len = coder.encode(ImageView::new(&alone, width).unwrap(), &mut payload).unwrap();
        assert!(strip.payload == &payload[..len], "{:?}: the strip at {}", C::ID, strip.first_column);
    }
}

fn check_all<L: Known>(levels: &[L], columns: usize, strips: u16)
where
    DeflateDefault: Coder<L>,
    DeflateSmall: Coder<L>,
{
    let settings = ContextSettings::FINE;
    check(levels, columns, strips, &mut Store::new());
    check(levels, columns, strips, &mut Rle::new());
    check(levels, columns, strips, &mut *Box::new(DeflateDefault::new()));
    check(levels, columns, strips, &mut *Box::new(DeflateSmall::new()));
    check(levels, columns, strips, &mut Small::<12>::new(settings));
    check(levels, columns, strips, &mut Dense::<12>::new(settings));
    check(levels, columns, strips, &mut *Box::new(Fast::<2, 400>::new(settings)));
}

/// Runs of like levels, gaps, and noise.
fn levels() -> impl Strategy<Value = (Vec<u16>, usize)> {
    let run = (prop_oneof![Just(0_u16), any::<u16>()], 1_usize..30, prop_oneof![Just(0_u16), 0_u16..40]);
    (1_usize..90, 1_usize..60, prop::collection::vec(run, 1..200)).prop_map(|(rows, columns, runs)| {
        let runs = runs.iter().cycle().flat_map(|&(level, len, noise)| {
            (0..len as u16).map(move |n| if level == 0 { 0 } else { level.saturating_add(n * noise % 41) })
        });
        (runs.take(rows * columns).collect(), columns)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn strips_are_coded_as_if_alone((levels, columns) in levels(), strips in 1_u16..=60) {
        let strips = strips.min(columns as u16);
        check_all(&levels, columns, strips);
        let bytes: Vec<u8> = levels.iter().map(|&level| (level >> 8) as u8).collect();
        check_all(&bytes, columns, strips);
    }
}

#[test]
fn a_view_of_a_strip_is_that_of_its_columns() {
    let levels: Vec<u16> = (0..7 * 11).collect();
    let image = ImageView::new(&levels, 11).unwrap();
    for (first, width) in (0..11).flat_map(|first| (1..=11 - first).map(move |width| (first, width))) {
        let strip = image.strip(first, width).unwrap();
        assert_eq!((strip.rows(), strip.columns(), strip.pixels()), (7, width, 7 * width));
        assert_eq!(strip.row_levels().flatten().copied().collect::<Vec<_>>(), cut(&levels, 11, first, width));
        assert_eq!(strip.occupied(), 7 * width - usize::from(first == 0));
        assert_eq!(strip.levels().is_some(), width == 11);
        // A strip of a strip.
        let last = strip.strip(width - 1, 1).unwrap();
        assert_eq!(last.row_levels().flatten().copied().collect::<Vec<_>>(), cut(&levels, 11, first + width - 1, 1));
    }
    for (first, width) in [(0, 0), (11, 1), (0, 12), (5, 7), (usize::MAX, 2), (1, usize::MAX)] {
        assert!(image.strip(first, width).is_none(), "{first}, {width}");
    }
}

#[test]
fn encoders_cut_frames_and_say_where_they_cannot() {
    let points: Vec<[f32; 3]> =
        (0..4000).map(|n| (n as f32 * 0.01).sin_cos()).map(|(y, x)| [9.0 * x, 9.0 * y, -1.0]).collect();
    let mut encoder: Encoder<64, 256, u8, Rle> = Encoder::new(Rle::new());
    let mut decoder = Decoder::default();
    let mut whole = None;
    for strips in [1, 2, 16, 255, 256] {
        let mut out = vec![0; Encoder::<64, 256, u8, Rle>::worst_case_len_in_strips(strips)];
        let config = Config { strips, ..Config::UNIFORM };
        let encoded = encoder.encode(&config, points.as_slice(), Stamp::default(), &mut out).unwrap();
        let frame = decoder.decode(&out[..encoded.len]).unwrap();
        assert_eq!(*whole.get_or_insert_with(|| frame.points()), frame.points());
        let (have, worst_case) = (encoded.len - 1, out.len());
        let refused = encoder.encode(&config, points.as_slice(), Stamp::default(), &mut out[..have]);
        assert_eq!(refused, Err(EncodeError::OutputTooSmall { have, worst_case }));
    }
    for found in [0, 257] {
        let config = Config { strips: found, ..Config::UNIFORM };
        let refused = encoder.encode(&config, points.as_slice(), Stamp::default(), &mut [0; 100]);
        assert_eq!(refused, Err(ConfigError::Strips { found, max: 256 }.into()));
    }
}

#[test]
fn a_column_a_firing_in_strips() {
    let firings: Firings<125> = Firings::new(4000, (0..4000).step_by(2)).unwrap();
    let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, 4000).unwrap();
    let every_tick = LatticeConfig { strips: 16, table: true, ..LatticeConfig::new(&lattice) };
    let config = FiringsConfig { every_tick, firings: &firings };
    let settings = ContextSettings::FINE.with_step(Step::new(10).unwrap());
    let mut encoder: Encoder<64, 2000, u16, Small> = Encoder::new(Small::new(settings));
    let mut out = vec![0; config.worst_case_len::<u16, Small>()];
    let points: Vec<[f32; 3]> =
        (0..900).map(|n| (n as f32 * 0.007).sin_cos()).map(|(y, x)| [9.0 * x, 9.0 * y, -1.0]).collect();
    let encoded = encoder.encode(&config, points.as_slice(), Stamp::default(), &mut out).unwrap();
    let mut decoder = Decoder::default();
    assert_eq!(decoder.decode(&out[..encoded.len]).unwrap().points().len() as u32, encoded.tally.kept());
    assert_eq!(frame::parse(&out[..encoded.len]).unwrap().strips().count(), 16);
}
