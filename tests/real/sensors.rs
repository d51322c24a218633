//! How small the context coders make the turns of other sensors, which their priors have never seen.

use std::io::Write;
use std::process::{Command, Stdio};

use flicr::coder::{Coder, ContextSettings, Fast, Step};
use flicr::{Decoder, Dense, ImageView, Levels, Small, frame};

use crate::command_line::Encoded;
use crate::common::data::{self, median};

/// A turn's range counts.
struct Turn {
    levels: Vec<u16>,
    columns: usize,
    count_m: f32,
    /// Bytes of the frame besides the payload.
    other_len: usize,
}

fn turns(capture: &str, options: &[&str]) -> Vec<Turn> {
    let encoded = Encoded::new(capture, &[&["--coder", "store"], options].concat());
    let bytes = std::fs::read(encoded.path()).unwrap();
    let (mut rest, mut turns, mut decoder) = (bytes.as_slice(), Vec::new(), Decoder::default());
    while !rest.is_empty() {
        let (one, after) = rest.split_at(frame::frame_len(rest).unwrap());
        rest = after;
        let decoded = decoder.decode(one).unwrap();
        let Levels::U16(levels) = decoded.levels() else { panic!("16 bits") };
        let (columns, count_m) = (decoded.header().columns.into(), decoded.header().quantizer.step_m());
        turns.push(Turn { levels: levels.clone(), columns, count_m, other_len: one.len() - 2 * levels.len() });
    }
    turns
}

impl Turn {
    fn image(&self) -> ImageView<'_, u16> {
        ImageView::new(&self.levels, self.columns).unwrap()
    }

    /// zstd -19's bytes of the same levels, in the better of two orders.
    fn zstd_len(&self, step: u16) -> usize {
        let quantized = |level: u16| (u32::from(level) + u32::from(step) / 2) / u32::from(step);
        let by_row = self.levels.iter().map(|&level| quantized(level));
        let rows = self.image().rows();
        let by_column = (0..self.columns).flat_map(|column| (0..rows).map(move |row| row * self.columns + column));
        let by_column = by_column.map(|at| quantized(self.levels[at]));
        let bytes =
            |levels: &mut dyn Iterator<Item = u32>| levels.flat_map(|level| (level as u16).to_le_bytes()).collect();
        let [by_row, by_column]: [Vec<u8>; 2] = [bytes(&mut { by_row }), bytes(&mut { by_column })];
        zstd(&by_row).min(zstd(&by_column))
    }
}

fn zstd(bytes: &[u8]) -> usize {
    let mut tool = Command::new("zstd");
    let mut child = tool
        .args(["-19", "-c"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("zstd, which tools/setup.sh installs");
    let mut input = child.stdin.take().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(move || input.write_all(bytes).unwrap());
        child.wait_with_output().unwrap().stdout.len()
    })
}

pub fn no_sensor_takes_more_than_zstd() {
    let metadata = |name: &str| data::path(name).display().to_string();
    let os0 = metadata("ouster/OS-0-32-U1_v2.2.0_1024x10.json");
    let os1 = metadata("ouster/OS-1-128_v2.3.0_1024x10.json");
    println!(
        "{:<12} {:>5} {:>7} {:>7} {:>7} {:>7}   of zstd -19's bytes: small, dense, fast",
        "ratio", "mm", "zstd", "small", "dense", "fast"
    );
    let mut out = vec![0; 1 << 20];
    for (name, capture, options) in [
        ("VLP-16", "velodyne/vlp16_dual.pcap", &[][..]),
        ("VLP-32C", "velodyne/vlp32c_single.pcap", &[]),
        ("Pandar40P", "hesai/pandar40p_dual.pcap", &[]),
        ("XT32", "hesai/xt32_dual.pcap", &["--returns", "last"]),
        ("OS0-32", "ouster/OS-0-32-U1_v2.2.0_1024x10.pcap", &["--metadata", &os0]),
        ("OS1-128", "ouster/OS-1-128_v2.3.0_1024x10_lb_n3.pcap", &["--metadata", &os1]),
    ] {
        let turns = turns(capture, options);
        for mm in [2.0, 20.0, 100.0] {
            let count_mm = 1000.0 * turns[0].count_m;
            let step = Step::new((mm / count_mm).round().max(1.0) as u16).unwrap();
            let of_levels = ContextSettings::of_levels(turns[0].count_m).with_step(step);
            let mut fast: Box<Fast<2>> = Box::new(Fast::new(of_levels));
            let (mut ratios, mut shares) = (Vec::new(), Vec::new());
            for turn in &turns {
                let image = turn.image();
                let for_small = of_levels.for_small(image.rows(), image.columns());
                let lens = [
                    turn.zstd_len(step.levels()),
                    Small::<16>::new(for_small).encode(image, &mut out).unwrap(),
                    Dense::<16>::new(of_levels).encode(image, &mut out).unwrap(),
                    fast.encode(image, &mut out).unwrap(),
                ];
                ratios.push(lens.map(|len| 16.0 * image.occupied() as f64 / (len + turn.other_len) as f64));
                shares.push(lens.map(|len| len as f64 / lens[0] as f64));
            }
            let middle = |of: &[[f64; 4]], at: usize| median(of.iter().map(|values| values[at]));
            let [zstd, small, dense, fast] = [0, 1, 2, 3].map(|at| middle(&ratios, at));
            let of_zstd = [1, 2, 3].map(|at| middle(&shares, at));
            println!(
                "{name:<12} {:>5.1} {zstd:>7.1} {small:>7.1} {dense:>7.1} {fast:>7.1}   {of_zstd:.2?}",
                f32::from(step.levels()) * count_mm
            );
            let most = shares.iter().flatten().fold(0.0, |most: f64, &share| most.max(share));
            assert!(most <= 1.0, "{name} at {mm} mm: {most:.3} of zstd -19's bytes");
        }
    }
}
