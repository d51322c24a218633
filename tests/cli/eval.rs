//! What `eval` says agrees with what the other commands make.

use super::run::{Place, bin, objects, points};

const FIELDS: [&str; 27] = [
    "file",
    "preset",
    "geometry",
    "sensor",
    "why",
    "columns",
    "rows",
    "coder",
    "tier",
    "bits",
    "step_m",
    "range_bound_m",
    "points",
    "kept",
    "bytes",
    "ratio_xyz",
    "ratio_xyzi",
    "bpp",
    "se",
    "psnr_db",
    "psnr_reverse_db",
    "cd_m2",
    "cd_mean_m",
    "epsnr_db",
    "max_error_m",
    "encode_ns",
    "decode_ns",
];

#[test]
fn json_has_these_fields_in_this_order() {
    let place = Place::with_scan();
    let text = place.fine(&["eval", "scan.bin", "--json", "--columns", "256"]);
    // serde_json's map sorts its keys: the order is looked for in the text.
    let places: Vec<usize> = FIELDS.iter().map(|field| text.find(&format!("\"{field}\":")).unwrap()).collect();
    assert!(places.is_sorted());
    let [object] = objects(&text).try_into().unwrap();
    assert_eq!(object.len(), FIELDS.len());
    let words = ["file", "preset", "geometry", "sensor", "why", "coder", "tier"];
    assert!(words.iter().all(|&field| object[field].is_string()));
    let numbers = FIELDS.iter().filter(|field| !words.contains(field));
    assert!(numbers.map(|&field| object[field].as_f64().unwrap()).all(|number| number >= 0.0));
}

#[test]
fn eval_agrees_with_encode_and_decode() {
    let place = Place::with_scan();
    // A point at the origin is in the file, but is no return.
    let mut scan = points(&place.read("scan.bin"));
    scan.push([0.0; 4]);
    place.write("scan.bin", &bin(&scan));
    let options = ["--preset", "paper", "--columns", "512", "--coder", "rle", "--bits", "10", "--max-range", "90"];
    let [eval] = objects(&place.fine(&[&["eval", "scan.bin", "--json"], &options[..]].concat())).try_into().unwrap();
    place.fine(&[&["encode", "scan.bin", "-o", "f.flicr"], &options[..]].concat());
    place.fine(&["decode", "f.flicr", "-o", "back.bin"]);
    let (bytes, decoded) = (place.read("f.flicr").len() as f64, points(&place.read("back.bin")).len());
    let number = |field: &str| eval[field].as_f64().unwrap();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs();
    assert_eq!((&eval["file"], &eval["preset"], &eval["coder"]), (&"scan.bin".into(), &"paper".into(), &"rle".into()));
    assert_eq!((number("columns"), number("rows")), (512.0, 64.0));
    assert_eq!(eval["kept"], decoded);
    assert_eq!(eval["points"], scan.len() - 1);
    assert!(near(number("bytes"), bytes));
    assert!(near(number("ratio_xyz"), 12.0 * scan.len() as f64 / bytes));
    assert!(near(number("ratio_xyzi"), 16.0 * scan.len() as f64 / bytes));
    assert!(near(number("bpp"), 8.0 * bytes / scan.len() as f64));
    assert!(near(number("se"), 1.0 - decoded as f64 / (scan.len() - 1) as f64));
    assert!(number("epsnr_db") < number("psnr_db") && number("psnr_reverse_db") < number("psnr_db"));
    assert!(number("encode_ns") > 0.0 && number("decode_ns") > 0.0);
}

#[test]
fn better_settings_measure_better() {
    let place = Place::with_scan();
    let psnr = |options: &[&str]| {
        let text = place.fine(&[&["eval", "scan.bin", "--json"], options].concat());
        objects(&text)[0]["psnr_db"].as_f64().unwrap()
    };
    let (paper, uniform, fine) =
        (psnr(&["--preset", "paper"]), psnr(&["--preset", "uniform"]), psnr(&["--preset", "uniform", "--bits", "14"]));
    assert!(paper + 0.5 < uniform && uniform + 3.0 < fine, "{paper} {uniform} {fine}");
}

#[test]
fn several_columns_are_measured_of_each_file() {
    let place = Place::new();
    place.fine(&["simulate", "-o", "t.bin", "--turns", "2"]);
    let args = ["eval", "t-000000.bin", "t-000001.bin", "--columns", "1024,256", "--preset", "uniform"];
    let found: Vec<_> = objects(&place.fine(&[&args[..], &["--json"]].concat()))
        .iter()
        .map(|object| (object["file"].as_str().unwrap().to_owned(), object["columns"].as_u64().unwrap()))
        .collect();
    let [first, second] = ["t-000000.bin", "t-000001.bin"].map(str::to_owned);
    assert_eq!(found, [(first.clone(), 1024), (first, 256), (second.clone(), 1024), (second, 256)]);
    let table = place.fine(&args);
    assert_eq!(table.matches("median of 2").count(), 2, "{table}");
    assert!(table.contains("uniform, 1024 x 64, 8 bits, deflate"), "{table}");
    let widths: Vec<usize> = table.lines().skip(1).take(4).map(|line| line.chars().count()).collect();
    assert!(widths.iter().all(|&width| width == widths[0]), "{table}");
}

#[test]
fn a_scan_without_a_return_cannot_be_measured() {
    let place = Place::new();
    place.write("none.bin", &[0; 32]);
    place.fails_with(1, &["eval", "none.bin"], "none.bin", &["expected"]);
}

#[test]
fn several_tiers_and_steps_are_measured_and_told_apart() {
    let place = Place::with_scan();
    let args = [
        "eval",
        "scan.bin",
        "--columns",
        "512",
        "--tier",
        "dense,small,dense",
        "--step",
        "native,0.1",
        "--coder",
        "context,rle",
    ];
    let found = objects(&place.fine(&[&args[..], &["--json"]].concat()));
    let told: Vec<_> =
        found.iter().map(|o| (o["coder"].as_str().unwrap(), o["tier"].as_str(), o["step_m"].as_f64())).collect();
    let near = |step_m: Option<f64>, expected: f64| (step_m.unwrap() - expected).abs() < 1e-6;
    assert_eq!(told.len(), 6);
    for (told, (coder, tier, step_m)) in told.iter().zip([
        ("context", Some("dense"), 0.002),
        ("context", Some("dense"), 0.1),
        ("context", Some("small"), 0.002),
        ("context", Some("small"), 0.1),
        ("rle", None, 0.002),
        ("rle", None, 0.1),
    ]) {
        assert!((told.0, told.1) == (coder, tier) && near(told.2, step_m), "{told:?}");
    }
    let number = |at: usize, field: &str| found[at][field].as_f64().unwrap();
    for finer in [0, 2, 4] {
        assert!(number(finer, "bytes") > number(finer + 1, "bytes"));
        assert!(number(finer, "range_bound_m") < number(finer + 1, "range_bound_m"));
    }
    assert!(number(0, "bytes") < number(2, "bytes") && number(2, "bytes") < number(4, "bytes"));
    let table = place.fine(&args);
    for heading in
        ["16 bits, context dense, step 0.002 m", "16 bits, context small, step 0.100 m", "16 bits, rle, step 0.100 m"]
    {
        assert_eq!(table.matches(heading).count(), 1, "{heading}: {table}");
    }
}
