//! What `compare` says is so: on clouds whose distances are plain to see, and on a frame that `eval` measured.

use super::run::{Place, bin, objects, points};

#[test]
fn distances_are_those_of_a_ruler() {
    let place = Place::new();
    // The point at the origin is no return.
    place.write("scan.bin", &bin(&[[3.0, 0.0, 0.0, 0.5], [0.0, 4.0, 0.0, 0.5], [0.0, 4.5, 0.0, 0.5], [0.0; 4]]));
    place.write("back.bin", &bin(&[[3.0, 0.0, 0.25, 0.0], [0.0, 4.0, 0.0, 0.0]]));
    let [found] = objects(&place.fine(&["compare", "scan.bin", "back.bin", "--json"])).try_into().unwrap();
    let near = |field: &str, expected: f64| {
        let number = found[field].as_f64().unwrap();
        assert!((number - expected).abs() < 1e-9, "{field}: {number} for {expected}");
    };
    let (mse_m2, mse_reverse_m2) = (0.0625 / 2.0, (0.0625 + 0.25) / 3.0);
    near("points", 3.0);
    near("decoded", 2.0);
    near("se", 1.0 / 3.0);
    near("psnr_db", 10.0 * (6400.0_f64 / mse_m2).log10());
    near("psnr_reverse_db", 10.0 * (6400.0_f64 / mse_reverse_m2).log10());
    near("cd_m2", mse_m2 + mse_reverse_m2);
    near("cd_mean_m", 0.5 * (0.25 / 2.0 + 0.75 / 3.0));
    near("max_error_m", 0.25);
    near("max_error_reverse_m", 0.5);
    let f = (-2.0 / 3.0 / 0.5_f64).exp() - 0.15;
    near("epsnr_db", 10.0 * (6400.0_f64 / mse_m2).log10() * (1.0 - f / 3.0));
    let peak = place.fine(&["compare", "scan.bin", "back.bin", "--json", "--peak", "120"]);
    let [peak] = objects(&peak).try_into().unwrap();
    let louder = peak["psnr_db"].as_f64().unwrap() - found["psnr_db"].as_f64().unwrap();
    assert!((louder - 20.0 * 1.5_f64.log10()).abs() < 1e-9, "{louder}");
    let table = place.fine(&["compare", "scan.bin", "back.bin"]);
    assert!(table.contains("33.33") && table.contains("0.2500"), "{table}");
}

#[test]
fn points_that_were_never_there_leave_no_share_of_lost_ones() {
    let place = Place::new();
    place.write("scan.bin", &bin(&[[3.0, 0.0, 0.0, 0.0]]));
    place.write("back.bin", &bin(&[[3.0, 0.0, 0.0, 0.0], [5.0, 0.0, 0.0, 0.0]]));
    let [found] = objects(&place.fine(&["compare", "scan.bin", "back.bin", "--json"])).try_into().unwrap();
    assert!(found["se"].is_null() && found["epsnr_db"].is_null());
    assert!(found["psnr_reverse_db"].is_null(), "every original point came back: infinite");
    assert_eq!(found["max_error_m"].as_f64(), Some(2.0));
}

#[test]
fn it_agrees_with_eval() {
    let place = Place::with_scan();
    let options = ["--preset", "uniform", "--columns", "512"];
    let [eval] = objects(&place.fine(&[&["eval", "scan.bin", "--json"], &options[..]].concat())).try_into().unwrap();
    place.fine(&[&["encode", "scan.bin", "-o", "f.flicr"], &options[..]].concat());
    place.fine(&["decode", "f.flicr", "-o", "back.bin"]);
    let [found] = objects(&place.fine(&["compare", "scan.bin", "back.bin", "--json"])).try_into().unwrap();
    assert_eq!(found["decoded"], points(&place.read("back.bin")).len());
    for field in ["points", "se", "psnr_db", "psnr_reverse_db", "cd_m2", "cd_mean_m", "epsnr_db", "max_error_m"] {
        assert_eq!(found[field], eval[field], "{field}");
    }
}

#[test]
fn clouds_without_a_distance_are_refused() {
    let place = Place::with_scan();
    place.write("empty.bin", b"");
    place.write("back.ply", b"ply\n");
    place.fails_with(1, &["compare", "scan.bin", "empty.bin"], "empty.bin", &["has no points"]);
    place.fails_with(1, &["compare", "empty.bin", "scan.bin"], "empty.bin", &["has no points"]);
    place.fails_with(2, &["compare", "scan.bin", "back.ply"], "back.ply", &["expected", ".pcd"]);
    place.fails(2, &["compare", "scan.bin", "scan.bin", "--peak", "0"]);
}
