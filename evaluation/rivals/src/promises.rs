//! What flicr promises against the codecs a user would pick instead, on raw KITTI scans: `flicr-rivals promises SCAN...`.
//! One core, all in one run, the shortest of several times for each scan; medians of the scans. Fails where a promise is broken.
//!
//! * dense at a PSNR equal to Draco's (-cl 10 -qp 11) or better: fewer than 0.40 of its bytes;
//! * fast at such a PSNR: fewer than 0.5 of its bytes in less than 0.15 of its encode time;
//! * fast, lossless lattice, from x, y, z and back, against Cloudini (zstd, 2 mm): fewer than 0.4 of its bytes, at most 0.5
//!   of its encode time and 1.0 of its decode time.

use std::error::Error;
use std::path::Path;
use std::process::Command;

use flicr::metrics::compare;
use serde_json::{Value, json};

use crate::{Outcome, cloud, codec, stages};

/// Rounds of each timing.
const RUNS: usize = 15;
/// The paper's.
const PEAK_M: f64 = 80.0;
/// Steps that are tried, counts of 2 mm, the coarsest first.
const COUNTS: [u16; 16] = [80, 70, 60, 51, 40, 32, 28, 25, 22, 20, 18, 16, 14, 12, 10, 8];

/// What a share is of, its name in JSON, and the most that it may be.
const OF_CLOUDINI: [(&str, &str, f64); 3] = [
    ("Cloudini's bytes, fast, lossless", "bytes_of_cloudini", 0.40),
    ("Cloudini's encode time, fast, lossless", "encode_of_cloudini", 0.50),
    ("Cloudini's decode time, fast, lossless", "decode_of_cloudini", 1.00),
];
const OF_DRACO: [(&str, &str, f64); 3] = [
    ("Draco's bytes, dense", "dense_of_draco", 0.40),
    ("Draco's bytes, fast", "fast_of_draco", 0.50),
    ("Draco's encode time, fast", "fast_encode_of_draco", 0.15),
];

type Boxed<T> = Result<T, Box<dyn Error>>;

pub fn run(scans: &[&str]) -> Outcome {
    let folder = std::env::temp_dir().join(format!("flicr-promises-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let found: Boxed<Vec<Value>> = scans.iter().map(|scan| shares(Path::new(scan), &folder)).collect();
    std::fs::remove_dir_all(&folder)?;
    let found = found?;
    println!("{:<38} {:>8} {:>8}", "share of", "median", "promised");
    let mut broken = table(&OF_CLOUDINI, &found)?;
    if Draco::is_installed() {
        broken.extend(table(&OF_DRACO, &found)?);
    } else {
        println!("Draco's bytes and encode time: left out, no draco_encoder here (Debian's package: draco)");
    }
    if broken.is_empty() { Ok(json!(found)) } else { Err(broken.join("; ").into()) }
}

/// Prints medians of the scans, and gives those that are more than was promised.
fn table(promises: &[(&str, &str, f64)], found: &[Value]) -> Boxed<Vec<String>> {
    let mut broken = Vec::new();
    for &(name, key, promised) in promises {
        let mut shares = found.iter().map(|scan| number(&scan[key])).collect::<Boxed<Vec<f64>>>()?;
        shares.sort_by(f64::total_cmp);
        let median = shares[shares.len() / 2];
        println!("{name:<38} {median:>8.3} {promised:>8.2}");
        if median > promised {
            broken.push(format!("{name}: {median:.3}, promised {promised}"));
        }
    }
    Ok(broken)
}

/// Of one scan.
fn shares(path: &Path, folder: &Path) -> Boxed<Value> {
    let scan = cloud::read(path)?;
    let ours = stages::run("native:fast:1", &scan, RUNS)?;
    let theirs = codec::run("cloudini:0.002:zstd", &scan, &folder.join("cloud.bin"), RUNS)?;
    let share = |part: &dyn Fn(&Value) -> Boxed<f64>| Boxed::Ok(part(&ours)? / part(&theirs)?);
    let mut shares = json!({
        "scan": path.display().to_string(),
        "bytes_of_cloudini": share(&|of| number(&of["bytes"]))?,
        "encode_of_cloudini": share(&|of| number(&of["encode"]["cpu_ns"]))?,
        "decode_of_cloudini": share(&|of| number(&of["decode"]["cpu_ns"]))?,
        "encode_ms": number(&ours["encode"]["cpu_ns"])? / 1e6,
        "decode_ms": number(&ours["decode"]["cpu_ns"])? / 1e6,
        "stages": ours["stages"],
    });
    if Draco::is_installed() {
        add_draco(&mut shares, &scan, folder)?;
    }
    Ok(shares)
}

fn add_draco(shares: &mut Value, scan: &[[f32; 4]], folder: &Path) -> Boxed<()> {
    let points: Vec<[f32; 3]> = cloud::returns(scan);
    let draco = Draco::of(&points, folder)?;
    for tier in ["dense", "fast"] {
        let (counts, bytes) = coarsest(tier, scan, &points, draco.psnr_db)?;
        shares[format!("{tier}_counts")] = json!(counts);
        shares[format!("{tier}_of_draco")] = json!(bytes as f64 / draco.bytes as f64);
    }
    // Draco's tool tells time on the clock.
    let ours = stages::run(&format!("native:fast:{}", shares["fast_counts"]), scan, RUNS)?;
    shares["fast_encode_of_draco"] = json!(number(&ours["encode"]["ns"])? / draco.encode_ns);
    shares["draco"] = json!({ "bytes": draco.bytes, "psnr_db": draco.psnr_db, "encode_ms": draco.encode_ns / 1e6 });
    Ok(())
}

fn number(value: &Value) -> Boxed<f64> {
    value.as_f64().ok_or_else(|| format!("no number: {value}").into())
}

/// The coarsest step that is as good, and its bytes.
fn coarsest(tier: &str, scan: &[[f32; 4]], points: &[[f32; 3]], psnr_db: f64) -> Boxed<(u16, usize)> {
    for counts in COUNTS {
        let (bytes, decoded) = stages::there_and_back(tier, counts, scan)?;
        if psnr(points, &decoded)? >= psnr_db {
            return Ok((counts, bytes));
        }
    }
    Err(format!("{tier}: no step is as good as {psnr_db:.2} dB").into())
}

/// The worse of both directions.
fn psnr(points: &[[f32; 3]], decoded: &[[f32; 3]]) -> Boxed<f64> {
    let found = compare(points, decoded, PEAK_M)?;
    Ok(found.psnr_db.min(found.psnr_reverse_db))
}

/// What Draco's own tools make of a cloud.
struct Draco {
    bytes: u64,
    encode_ns: f64,
    psnr_db: f64,
}

impl Draco {
    fn is_installed() -> bool {
        ["draco_encoder", "draco_decoder"].iter().all(|tool| Command::new(tool).arg("-h").output().is_ok())
    }

    fn of(points: &[[f32; 3]], folder: &Path) -> Boxed<Self> {
        let [cloud, coded, back] = ["cloud.ply", "cloud.drc", "back.ply"].map(|name| folder.join(name));
        write_ply(&cloud, points)?;
        let times = (0..RUNS).map(|_| Self::encode(&cloud, &coded)).collect::<Boxed<Vec<f64>>>()?;
        run_tool(Command::new("draco_decoder").arg("-i").arg(&coded).arg("-o").arg(&back))?;
        let psnr_db = psnr(points, &read_ply(&back)?)?;
        let encode_ns = times.into_iter().fold(f64::INFINITY, f64::min);
        Ok(Self { bytes: std::fs::metadata(&coded)?.len(), encode_ns, psnr_db })
    }

    /// The nanoseconds that the tool says it took to encode, reading and writing apart.
    fn encode(cloud: &Path, coded: &Path) -> Boxed<f64> {
        let mut tool = Command::new("draco_encoder");
        let tool = tool.args(["-point_cloud", "-cl", "10", "-qp", "11", "-i"]).arg(cloud).arg("-o").arg(coded);
        let said = run_tool(tool)?;
        // `Encoded point cloud saved to FILE (53 ms to encode).`
        let ms =
            said.split_once(" ms to encode").and_then(|(before, _)| before.rsplit('(').next()?.parse::<f64>().ok());
        Ok(1e6 * ms.ok_or_else(|| format!("draco_encoder said: {said}"))?)
    }
}

fn run_tool(tool: &mut Command) -> Boxed<String> {
    let output = tool.output()?;
    let said = String::from_utf8(output.stdout)?;
    if output.status.success() { Ok(said) } else { Err(format!("{tool:?} failed: {said}").into()) }
}

fn write_ply(path: &Path, points: &[[f32; 3]]) -> Boxed<()> {
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        points.len()
    );
    Ok(std::fs::write(path, [head.as_bytes(), bytemuck::cast_slice(points)].concat())?)
}

/// What draco_decoder writes: a binary file of x, y and z.
fn read_ply(path: &Path) -> Boxed<Vec<[f32; 3]>> {
    const END: &[u8] = b"end_header\n";
    let bytes = std::fs::read(path)?;
    let head_len = bytes.windows(END.len()).position(|at| at == END).ok_or("no PLY")? + END.len();
    Ok(bytes[head_len..].chunks_exact(12).map(bytemuck::pod_read_unaligned).collect())
}
