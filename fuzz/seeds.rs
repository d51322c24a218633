//! Writes what each target begins with: frames of every coder, datagrams, files. `seeds FOLDER`.

use std::path::Path;

use flicr::coder::{Coder, ContextSettings, Fast, Predictor, Step};
use flicr::files::{PointCloud, pcd};
use flicr::frame::{self, UniformHeader};
use flicr::geometry::{
    Firings, Lattice,
    sensors::{hdl64e, velodyne},
};
use flicr::sensor::Sensor;
use flicr::stream::{Aligned, StreamConfig, StreamEncoder, write_framed};
use flicr::{
    DeflateSmall, Dense, FiringsConfig, Header, ImageView, ImageViewMut, LatticeConfig, Level, Placement, Quantizer,
    Rle, Settings, Small, Stamp, Store, UniformView, encode,
};

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).expect("usage: seeds FOLDER");
    let folder = Path::new(&folder);
    let mut seeds = Vec::new();
    for settings in settings() {
        payloads(settings, &mut seeds);
    }
    whole_frames(&mut seeds);
    datagrams(&mut seeds);
    files(&mut seeds);
    seeds.push(("calibrate", vec![1, 200, 10, 1, 5, 3, 0, 1, 9]));
    seeds.push(("calibrate", vec![3, 100, 0, 3, 1, 30, 0, 2, 200]));
    seeds.push(("packets", vec![0; 64]));
    seeds.push(("packet_frames", vec![0; 64]));
    for (number, (target, bytes)) in seeds.iter().enumerate() {
        let folder = folder.join(target);
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join(format!("seed-{number}")), bytes)?;
    }
    Ok(())
}

fn settings() -> impl Iterator<Item = ContextSettings> {
    [1, 3, 50].into_iter().flat_map(|step| {
        let settings = ContextSettings::FINE.with_step(Step::new(step).expect("a step"));
        [settings, ContextSettings { predictor: Predictor::MedianEdge, ..settings }]
    })
}

/// Surfaces with gaps.
fn image(rows: usize, columns: usize) -> Vec<u16> {
    let level = |at: usize| {
        let (row, column) = (at / columns, at % columns);
        let surface = 900 + 40 * (row / 5) + 3 * column + (at * 7919) % 5;
        if (row + column) % 11 < 2 || row > 3 * rows / 4 { 0 } else { surface as u16 }
    };
    (0..rows * columns).map(level).collect()
}

fn payloads(settings: ContextSettings, seeds: &mut Vec<(&'static str, Vec<u8>)>) {
    let (rows, columns) = (40_usize, 24_usize);
    let levels = image(rows, columns);
    let bytes: Vec<u8> = levels.iter().map(|&level| (level >> 3) as u8).collect();
    let put = |level_bits: u8, payload: &[u8], seeds: &mut Vec<_>| {
        let head = [level_bits | payload[0], payload[1], payload[2], payload[3], payload[4], payload[5]];
        let size = [rows as u8 - 1, columns as u8 - 1, 0];
        let code = &payload[6..];
        seeds.push(("payload", [&head[..], &size, &(code.len() as u16).to_le_bytes(), code].concat()));
    };
    for payload in coded(&levels, columns, settings) {
        put(0, &payload, seeds);
    }
    for payload in coded(&bytes, columns, settings) {
        put(0x80, &payload, seeds);
    }
}

fn coded<L: Level>(levels: &[L], columns: usize, settings: ContextSettings) -> Vec<Vec<u8>> {
    let image = ImageView::new(levels, columns).expect("an image");
    let by = |coder: &mut dyn FnMut(&mut [u8]) -> usize| {
        let mut out = vec![0; 1 << 16];
        let len = coder(&mut out);
        out.truncate(len);
        out
    };
    let (mut small, mut dense) = (Small::<8>::new(settings), Dense::<8>::new(settings));
    let mut fast: Box<Fast<1>> = Box::new(Fast::new(settings));
    vec![
        by(&mut |out| small.encode(image, out).expect("room")),
        by(&mut |out| dense.encode(image, out).expect("room")),
        by(&mut |out| fast.encode(image, out).expect("room")),
    ]
}

fn points() -> Vec<[f32; 3]> {
    (0..900).map(|n| (n as f32 * 0.07).sin_cos()).map(|(y, x)| [9.0 * x, 9.0 * y, -1.0 + 0.1 * y]).collect()
}

fn whole_frames(seeds: &mut Vec<(&'static str, Vec<u8>)>) {
    let settings = ContextSettings::FINE.with_step(Step::new(10).expect("a step"));
    for strips in [1, 4] {
        uniform::<u8, _>(strips, Store::new(), seeds);
        uniform::<u8, _>(strips, Rle::new(), seeds);
        uniform::<u8, _>(strips, DeflateSmall::new(), seeds);
        uniform::<u16, _>(strips, Small::<8>::new(settings), seeds);
        let firings: Firings<125> = Firings::new(4000, (0..4000).step_by(125)).expect("firings");
        let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, 4000).expect("a lattice");
        let every_tick = LatticeConfig { strips, table: strips == 4, ..LatticeConfig::new(&lattice) };
        scan(&FiringsConfig { every_tick, firings: &firings }, 32, Dense::<8>::new(settings), seeds);
        let lattice = Lattice::<66>::new(hdl64e::GRID, 48).expect("a lattice");
        let config = LatticeConfig { strips, table: strips == 1, ..LatticeConfig::new(&lattice) };
        scan(&config, 48, Rle::new(), seeds);
    }
}

fn uniform<L: Level, C: Coder<L>>(strips: u16, mut coder: C, seeds: &mut Vec<(&'static str, Vec<u8>)>) {
    let levels: Vec<L> = image(16, 40).into_iter().map(|level| L::new(level >> (16 - L::BITS) / 2)).collect();
    let header = Header {
        sequence: 1,
        timestamp_ns: 2,
        rows: 16,
        columns: 40,
        quantizer: Quantizer::with_step(L::BITS, 0.002).expect("a quantizer"),
        coder: C::ID,
        error_max: coder.error_max(),
        returns: 0,
        geometry: UniformHeader { view: UniformView::all_around(0.1, -0.4), placement: Placement::Center },
    };
    let mut out = vec![0; 1 << 16];
    let image = ImageView::new(&levels, 40).expect("an image");
    let len = frame::write(header, image, strips, &mut coder, &mut out).expect("room");
    push_frame(&out[..len], seeds);
}

fn scan<C: Coder<u16>>(config: &impl Settings, columns: usize, mut coder: C, seeds: &mut Vec<(&'static str, Vec<u8>)>) {
    let (mut levels, mut out) = (vec![0_u16; 64 * columns], vec![0; 1 << 17]);
    let image = ImageViewMut::new(&mut levels, columns).expect("an image");
    let points = points();
    let encoded = encode(config, points.as_slice(), Stamp::default(), image, &mut coder, &mut out).expect("a frame");
    push_frame(&out[..encoded.len], seeds);
}

/// The last byte odd: the target then makes length and checksum fit.
fn push_frame(frame: &[u8], seeds: &mut Vec<(&'static str, Vec<u8>)>) {
    let mut frame = frame.to_vec();
    if let Some(last) = frame.last_mut() {
        *last |= 1;
    }
    seeds.push(("decode", frame));
}

fn datagrams(seeds: &mut Vec<(&'static str, Vec<u8>)>) {
    let grid = velodyne::VLP16.grid();
    let settings = ContextSettings::FINE.with_step(Step::new(5).expect("a step"));
    let config = StreamConfig::new(&grid, 1, settings).expect("a stream");
    let mut sent = Vec::new();
    let mut as_fired: StreamEncoder<flicr::coder::SmallModel, 8, 300> = StreamEncoder::new(config).expect("a stream");
    turn(|index, tick, counts| as_fired.push_counts(index, tick, 0, counts, |bytes| sent.push(bytes.to_vec())));
    as_fired.finish(|bytes| sent.push(bytes.to_vec()));
    let config = StreamConfig { columns_a_turn: 200, ..config };
    let mut aligned: Box<StreamEncoder<flicr::coder::DenseModel, 8, 300, Aligned<4096, 256>>> =
        Box::new(StreamEncoder::new(config).expect("a stream"));
    turn(|index, tick, counts| aligned.push_counts(index, tick, 0, counts, |bytes| sent.push(bytes.to_vec())));
    aligned.finish(|bytes| sent.push(bytes.to_vec()));
    let mut line = vec![40];
    for datagrams in sent.chunks(4) {
        let mut seed = Vec::new();
        for datagram in datagrams {
            let body = &datagram[..datagram.len() - 4];
            seed.extend((body.len() as u16 | 0xd000).to_le_bytes());
            seed.extend(body);
            write_framed(&mut line, &body[..body.len().min(40)]).expect("room");
        }
        seeds.push(("stream", seed));
    }
    seeds.push(("framing", line));
}

fn turn(mut push: impl FnMut(u16, u16, &[u32])) {
    for index in 0..200_u16 {
        let count = |row: u32| if (row + u32::from(index)) % 7 == 0 { 0 } else { 3000 + 9 * u32::from(index) + row };
        let counts: Vec<u32> = (0..16).map(count).collect();
        push(index, index * 180, &counts);
    }
}

fn files(seeds: &mut Vec<(&'static str, Vec<u8>)>) {
    let points: Vec<[f32; 3]> = points().into_iter().take(20).collect();
    let rings = Some((0..20).collect());
    let cloud = PointCloud { intensities: Some(vec![0.5; 20]), rings, points };
    let mut bytes = vec![1];
    pcd::write(&mut bytes, &cloud).expect("room");
    seeds.push(("files", bytes));
    seeds.push(("files", b"\x01VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n".to_vec()));
    let grid = velodyne::VLP16.grid();
    let sensor = Sensor {
        name: "made up".into(),
        beams: grid.beams[..4].to_vec(),
        ticks_per_turn: grid.ticks,
        range_unit_m: grid.range_unit_m,
        range_from_axis: false,
    };
    seeds.push(("files", [b"\x02", sensor.to_toml().as_bytes()].concat()));
}
