//! The C ABI: header
#[test]
fn header() {
    let config = cbindgen::Config::from_file("cbindgen.toml").unwrap();
    let bindings = cbindgen::Builder::new().with_config(config).with_src("src/capi.rs").generate().unwrap();
    let mut fresh = Vec::new();
    bindings.write(&mut fresh);
    std::fs::write("include/flicr.h", fresh).unwrap();
}
