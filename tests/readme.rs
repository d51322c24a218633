//! Promise: what the README shows works as it stands there. (Its Rust is a doctest; its `make` verbs and its
//! `cargo install` are run by `.ci/run`.)

#[allow(dead_code, reason = "a part is for firmware")]
mod firmware;

use std::path::Path;
use std::process::Command;

use firmware::{root, run, tool};

const HOST: &str = if cfg!(target_arch = "aarch64") { "aarch64-unknown-linux-gnu" } else { "x86_64-unknown-linux-gnu" };

/// Calls the README's C function with two points, and checks what a user would.
const CALLER: &str = r#"
#include <stdio.h>
int main(void) {
  const float points[2][4] = {{10.0f, 0.0f, -1.0f, 0.5f}, {0.0f, 5.0f, -0.5f, 0.5f}};
  flicr_encoded encoded;
  flicr_status status = send_scan(points, 2, &encoded);
  if (status) { fprintf(stderr, "%s\n", flicr_status_text(status)); return 1; }
  return fwrite(frame, 1, encoded.len, stdout) == encoded.len ? 0 : 2;
}
"#;

/// The README's fenced blocks of a language.
fn blocks(language: &str) -> Vec<String> {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let fences: Vec<&str> = readme.split("```").collect();
    let fenced = fences.iter().skip(1).step_by(2).filter_map(|block| block.strip_prefix(language));
    fenced.filter_map(|block| block.strip_prefix('\n')).map(str::to_owned).collect()
}

/// Every line of the shell blocks that begins with this word.
fn commands(word: &str) -> Vec<String> {
    let shell = blocks("sh").concat();
    shell.lines().filter(|line| line.split(' ').next() == Some(word)).map(str::to_owned).collect()
}

#[test]
fn every_command_is_of_a_kind_that_is_run() {
    let lines: usize = blocks("sh").iter().map(|block| block.lines().count()).sum();
    let ci = std::fs::read_to_string(root().join(".ci/run")).unwrap();
    let (make, install, program) = (commands("make"), commands("cargo"), commands("flicr"));
    assert_eq!(lines, make.len() + install.len() + program.len(), "a command of another kind: run it here");
    for verb in make.iter().map(|line| line.split(' ').nth(1).unwrap()) {
        assert!(ci.contains(verb), ".ci/run has no {verb}");
    }
    let makefile = std::fs::read_to_string(root().join("Makefile")).unwrap();
    for line in &install {
        assert!(ci.contains("package") && makefile.contains(line.as_str()), "`make package` has no {line}");
    }
}

#[test]
fn the_command_line_runs() {
    let folder = tempfile::tempdir().unwrap();
    let lines = commands("flicr");
    assert!(lines.len() >= 6, "{lines:?}");
    for line in lines {
        let args = line.split_whitespace().skip(1);
        let output = Command::new(env!("CARGO_BIN_EXE_flicr")).args(args).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

/// Compiles the README's C with a caller, and gives what it prints.
fn frame_of_c(folder: &Path, library: &str) -> Vec<u8> {
    let (source, program) = (folder.join("readme.c"), folder.join("readme"));
    std::fs::write(&source, blocks("c").concat() + CALLER).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"]).arg(root().join("include"));
    run(compiler.arg(&source).arg(library).arg("-o").arg(&program)).unwrap();
    let output = Command::new(program).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

#[test]
fn the_c_compiles_and_its_frame_decodes() {
    let library = run(tool("staticlib.sh").arg(HOST)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let frame = frame_of_c(folder.path(), library.trim());
    let mut decoder = flicr::Decoder::new(flicr::Limits::default());
    assert_eq!(decoder.decode(&frame).unwrap().points().len(), 2);
}
