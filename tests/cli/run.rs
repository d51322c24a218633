//! Runs the program in a folder of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A folder for one test's files.
pub struct Place {
    folder: TempDir,
}

impl Place {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// With `scan.bin`, a simulated turn.
    pub fn with_scan() -> Self {
        let place = Self::new();
        place.fine(&["simulate", "-o", "scan.bin", "--seed", "3"]);
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// Names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.folder())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    pub fn run(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_flicr")).args(args).current_dir(self.folder()).output().unwrap()
    }

    /// Runs what must succeed without a word on stderr but notes of what was chosen, and gives its stdout.
    pub fn fine(&self, args: &[&str]) -> String {
        self.noted(args).0
    }

    /// As [`fine`](Self::fine), with the notes.
    pub fn noted(&self, args: &[&str]) -> (String, String) {
        let output = self.run(args);
        let (notes, stderr) = without_notes(&String::from_utf8(output.stderr).unwrap());
        assert_eq!((output.status.code(), stderr.as_str()), (Some(0), ""), "{args:?}");
        (String::from_utf8(output.stdout).unwrap(), notes)
    }

    /// Runs what must fail with an exit code, leave the folder as it was, and gives its stderr, notes left out.
    pub fn fails(&self, code: i32, args: &[&str]) -> String {
        let before = self.names();
        let output = self.run(args);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{args:?}: {stderr}");
        assert_eq!(self.names(), before, "{args:?} left something behind");
        without_notes(&stderr).1
    }

    /// Runs what must fail with `flicr: FILE: ...` and all of `words` in it.
    pub fn fails_with(&self, code: i32, args: &[&str], file: &str, words: &[&str]) {
        let stderr = self.fails(code, args);
        assert!(stderr.starts_with(&format!("flicr: {file}: ")), "{args:?}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
        for word in words {
            assert!(stderr.contains(word), "{args:?}: no {word:?} in {stderr}");
        }
    }
}

/// Parts the lines that only tell what was chosen from all others.
pub fn without_notes(stderr: &str) -> (String, String) {
    let (notes, others): (Vec<_>, Vec<_>) = stderr.split_inclusive('\n').partition(|line| line.starts_with("note: "));
    (notes.concat(), others.concat())
}

/// Points in a KITTI file.
pub fn points(bin: &[u8]) -> Vec<[f32; 4]> {
    let (records, rest) = bin.as_chunks::<16>();
    assert!(rest.is_empty());
    let float = |record: &[u8; 16], at: usize| f32::from_le_bytes(record[4 * at..4 * at + 4].try_into().unwrap());
    records.iter().map(|record| [0, 1, 2, 3].map(|at| float(record, at))).collect()
}

/// A KITTI file of points.
pub fn bin(points: &[[f32; 4]]) -> Vec<u8> {
    points.as_flattened().iter().flat_map(|float| float.to_le_bytes()).collect()
}

/// The JSON objects of lines.
pub fn objects(text: &str) -> Vec<serde_json::Map<String, serde_json::Value>> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}
