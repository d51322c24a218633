//! The command line on captures and other sensors' clouds.

use std::path::Path;
use std::process::Command;

use flicr::files::{self, PointCloud};
use flicr::metrics::{PAPER_MAX_RANGE_M, compare};
use flicr::{Decoder, Levels};
use tempfile::TempDir;

use crate::common::{data, xyz};
use crate::moved::{self, MOTIONS};
use crate::packets::captures::npy_u32;

/// Runs the program; gives its stdout and stderr.
fn flicr(args: &[&str]) -> (String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_flicr")).args(args).output().unwrap();
    let [stdout, stderr] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(output.status.success(), "{args:?}: {stderr}");
    (stdout, stderr)
}

/// A file that the program encoded, lossless.
pub struct Encoded {
    folder: TempDir,
    notes: String,
}

impl Encoded {
    pub fn new(name: &str, options: &[&str]) -> Self {
        Self::of(&data::path(name), options)
    }

    fn of(file: &Path, options: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (file.display().to_string(), folder.path().join("f.flicr").display().to_string());
        let (_, notes) = flicr(&[&["encode", &input, "-o", &output, "--step", "native"], options].concat());
        Self { folder, notes }
    }

    pub fn path(&self) -> String {
        self.folder.path().join("f.flicr").display().to_string()
    }

    /// Returns and kept ones of each frame.
    fn frames(&self) -> Vec<(u64, u64)> {
        let (text, _) = flicr(&["info", &self.path(), "--json"]);
        let object = |line| serde_json::from_str::<serde_json::Value>(line).unwrap();
        let number = |object: &serde_json::Value, field| object[field].as_u64().unwrap();
        text.lines().map(object).map(|info| (number(&info, "returns"), number(&info, "kept"))).collect()
    }

    fn decoded(&self) -> PointCloud {
        let output = self.folder.path().join("back.bin");
        flicr(&["decode", &self.path(), "-o", &output.display().to_string()]);
        files::read(&output).unwrap()
    }
}

/// Every whole turn of every capture becomes a frame, and no return is lost.
pub fn captures_are_encoded_without_loss() {
    let metadata = |name: &str| data::path(name).display().to_string();
    let os0 = metadata("ouster/OS-0-32-U1_v2.2.0_1024x10.json");
    let os1 = metadata("ouster/OS-1-128_v2.3.0_1024x10.json");
    for (capture, sensor, turns, options) in [
        ("velodyne/vlp16_dual.pcap", "VLP-16", 7, &[][..]),
        ("velodyne/vlp16_dual.pcap", "VLP-16", 7, &["--returns", "last"]),
        ("velodyne/vlp32c_single.pcap", "VLP-32C", 4, &[]),
        ("hesai/pandar40p_dual.pcap", "Pandar40P", 3, &[]),
        ("hesai/xt32_dual.pcap", "PandarXT-32", 3, &["--returns", "last"]),
        ("ouster/OS-0-32-U1_v2.2.0_1024x10.pcap", "OS-0-32-U1", 1, &["--metadata", &os0]),
        ("ouster/OS-1-128_v2.3.0_1024x10_lb_n3.pcap", "OS-1-128", 3, &["--sensor", &os1]),
    ] {
        let encoded = Encoded::new(capture, options);
        assert!(encoded.notes.contains(&format!("{sensor}, firings: ")), "{}", encoded.notes);
        assert!(!encoded.notes.contains("lost"), "{}", encoded.notes);
        let frames = encoded.frames();
        assert_eq!(frames.len(), turns, "{capture}");
        assert!(frames.iter().all(|&(returns, kept)| returns == kept && kept > 10_000), "{capture}: {frames:?}");
    }
}

/// Nothing came back from the VLP-16's lowest beam: what calibration finds without it is good for its captures.
pub fn a_beam_without_returns_is_taken_from_the_design() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("room.toml").display().to_string();
    let clouds = ["00", "03"].map(|scan| data::path(&format!("velodyne/vlp16_dual.scan{scan}.xyzir.bin")));
    let [first, second] = clouds.map(|cloud| cloud.display().to_string());
    let (text, _) = flicr(&["calibrate", &first, &second, "-o", &file]);
    assert!(text.contains("15 of VLP-16's 16 beams") && text.contains(" -15.000 degrees"), "{text}");
    let encoded = Encoded::new("velodyne/vlp16_dual.pcap", &["--sensor", &file]);
    let frames = encoded.frames();
    assert!(frames.len() == 7 && frames.iter().all(|&(returns, kept)| returns == kept), "{frames:?}");
}

/// The VLP-32C was told to leave half of the turn out: nothing is missing for that.
pub fn what_is_not_measured_is_told_from_what_is_missing() {
    let (text, _) = flicr(&["info", &data::path("velodyne/vlp32c_single.pcap").display().to_string()]);
    let whole: Vec<&str> = text.lines().filter(|line| line.trim_start().starts_with("turn ")).collect();
    assert_eq!(whole.len(), 4);
    for turn in whole {
        let blind = turn.split(" firings, 0 columns missing, ").nth(1).and_then(|rest| rest.split(' ').next());
        let blind: u32 = blind.unwrap_or_else(|| panic!("{turn}")).parse().unwrap();
        assert!((885..=905).contains(&blind) && turn.contains(" not measured, "), "{turn}");
    }
}

/// Ouster's columns are firings: with the beams' shifts, the image is the vendor's in every pixel, and points are where
/// its SDK has them.
fn equals_the_sdk(capture: &str, metadata: &str, unit_m: f64) {
    let metadata = data::path(metadata).display().to_string();
    let encoded = Encoded::new(&format!("{capture}.pcap"), &["--metadata", &metadata, "--turn", "0"]);
    let (reference, columns) = npy_u32(&format!("{capture}.scan000.range_mm.npy"));
    let bytes = std::fs::read(encoded.path()).unwrap();
    let mut decoder = Decoder::default();
    let frame = decoder.decode(&bytes).unwrap();
    assert_eq!(usize::from(frame.header().columns), columns);
    let Levels::U16(levels) = frame.levels() else { panic!("16 bits") };
    let unit_mm = (unit_m * 1000.0) as u32;
    let ours: Vec<u32> = levels.iter().map(|&level| u32::from(level) * unit_mm).collect();
    // The vendor's image as a whole begins some columns elsewhere.
    let turned = |by: usize| {
        let mut rows = ours.chunks_exact(columns).zip(reference.chunks_exact(columns));
        let same = |(ours, vendor): (&[u32], &[u32])| {
            ours[by..] == vendor[..columns - by] && ours[..by] == vendor[columns - by..]
        };
        rows.all(same)
    };
    assert!((0..columns).any(turned), "{capture}");

    let sdk = files::read(&data::path(&format!("{capture}.scan000.xyzir.bin"))).unwrap().points;
    let decoded = encoded.decoded().points;
    assert_eq!(decoded.len(), sdk.len());
    for (one, other) in [(&sdk, &decoded), (&decoded, &sdk)] {
        let farthest_m = compare(one, other, PAPER_MAX_RANGE_M).unwrap().max_error_m;
        println!("{capture}: {:.3} mm", 1000.0 * farthest_m);
        assert!(farthest_m <= unit_m + 0.002, "{capture}: {farthest_m}");
    }
}

pub fn ouster_frames_equal_the_sdk() {
    let os1 = "ouster/OS-1-128_v2.3.0_1024x10";
    equals_the_sdk(&format!("{os1}_lb_n3"), &format!("{os1}.json"), 0.008);
    let os0 = "ouster/OS-0-32-U1_v2.2.0_1024x10";
    equals_the_sdk(os0, &format!("{os0}.json"), 0.001);
}

/// Helios by its built-in model: nothing lost. HDL-32E: this sweep was motion-compensated and a quarter of it are points
/// at the sensor, which share their places; of those beyond a meter at most a thousandth is lost at every tick, and what
/// is lost and why is said.
pub fn clouds_of_other_sensors() {
    let helios = Encoded::new("robosense/helios16p.scan00.xyzir.bin", &[]);
    assert!(helios.notes.contains("Helios-16P, every-tick"), "{}", helios.notes);
    let [(returns, kept)] = helios.frames().try_into().unwrap();
    assert_eq!((returns, kept), (15_258, 15_258));

    // Its beams are up to 0.15 degrees below the design's, which are 0.33 apart.
    let pandar = Encoded::new("hesai/pandar40p_dual.reference.pcd", &[]);
    assert!(pandar.notes.contains("Pandar40P, even-columns"), "{}", pandar.notes);

    // The file's extension does not say that it has rings.
    let folder = tempfile::tempdir().unwrap();
    let sweep = folder.path().join("sweep.xyzir.bin");
    std::fs::copy(data::path("nuscenes/hdl32e_with_ring.bin"), &sweep).unwrap();
    let all = Encoded::of(&sweep, &["--columns", "36000"]);
    assert!(all.notes.contains("off the sensor's grid") && all.notes.contains("% are lost"), "{}", all.notes);
    assert!(all.notes.contains("rings"), "{}", all.notes);
    let mut cloud = files::read(&sweep).unwrap();
    let far: Vec<bool> = cloud.points.iter().map(|&[x, y, _]| x.hypot(y) > 1.0).collect();
    let mut keep = far.iter();
    cloud.points.retain(|_| *keep.next().unwrap());
    let mut keep = far.iter();
    cloud.rings.as_mut().unwrap().retain(|_| *keep.next().unwrap());
    cloud.intensities = None;
    let beyond = folder.path().join("beyond.xyzir.bin");
    files::write(&beyond, &cloud).unwrap();
    let [(returns, kept)] = Encoded::of(&beyond, &["--columns", "36000"]).frames().try_into().unwrap();
    println!("HDL-32E beyond a meter: {} of {returns} lost", returns - kept);
    assert!(returns > 26_000 && 1000 * (returns - kept) <= returns, "{kept} of {returns}");
}

/// Without being told anything: `--sensor auto` finds the beams of scans that were moved by a meter and more.
pub fn moved_scans_are_encoded_on_their_beams() {
    let place = tempfile::tempdir().unwrap();
    for name in ["kitti/object/000000.bin", "kitti/drive/000003.bin"] {
        let raw = xyz(&data::read_points(&data::path(name)));
        for motion in MOTIONS {
            let points = moved::moved(&raw, motion);
            let file = place.path().join("moved.bin");
            let bytes: Vec<u8> =
                points.iter().flat_map(|&[x, y, z]| [x, y, z, 0.0]).flat_map(f32::to_le_bytes).collect();
            std::fs::write(&file, bytes).unwrap();
            let encoded = Encoded::of(&file, &[]);
            let [(returns, kept)] = encoded.frames().try_into().unwrap();
            println!("{name} {motion:?}: {kept} of {returns}; {}", encoded.notes.trim());
            assert!(encoded.notes.contains("HDL-64E (KITTI), beams-in-order"), "{name} {motion:?}: {}", encoded.notes);
            assert!((returns - kept) * 100 <= returns, "{name} {motion:?}: {kept} of {returns}");
        }
    }
}
