//! Files that appear under their names only when all of them are complete.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use flicr::files::{self, FileError, Format, PointCloud};
use tempfile::TempPath;

use crate::failure::Failure;

/// Files that are written under temporary names beside their own; dropped before [`commit`](Self::commit), they are
/// gone.
#[derive(Debug, Default)]
pub struct Outputs {
    /// Files that must not be written over, canonical.
    inputs: Vec<PathBuf>,
    staged: Vec<(TempPath, PathBuf)>,
}

impl Outputs {
    /// Outputs that must be none of `inputs`.
    pub fn new(inputs: &[PathBuf]) -> Self {
        Self { inputs: inputs.iter().filter_map(|input| input.canonicalize().ok()).collect(), staged: Vec::new() }
    }

    /// Refuses a destination that cannot be meant: an input, or one that is written already.
    pub fn check(&self, destination: &Path) -> Result<(), Failure> {
        if destination.canonicalize().is_ok_and(|path| self.inputs.contains(&path)) {
            return Err(Failure::usage(destination, "found an input there, expected another name for the output"));
        }
        if self.staged.iter().any(|(_, other)| other == destination) {
            return Err(Failure::usage(destination, "two outputs would have this name, expected one"));
        }
        Ok(())
    }

    /// Has `write` write a file, for now under another name with the same extension.
    pub fn stage(
        &mut self,
        destination: &Path,
        write: impl FnOnce(&Path) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        self.check(destination)?;
        let temporary = temporary(destination).map_err(|error| Failure::data(destination, error))?;
        write(&temporary)?;
        self.staged.push((temporary, destination.into()));
        Ok(())
    }

    /// Stages a point cloud in the format of its destination's extension.
    pub fn stage_cloud(&mut self, destination: &Path, cloud: &PointCloud) -> Result<(), Failure> {
        self.stage(destination, |temporary| {
            files::write(temporary, cloud).map_err(|error| match error {
                // The destination's name says more than the temporary's.
                FileError::Io { error, .. } => Failure::data(destination, error),
                error => error.into(),
            })
        })
    }

    /// Gives all files their names.
    pub fn commit(self) -> Result<(), Failure> {
        for (temporary, destination) in self.staged {
            put(temporary, &destination).map_err(|error| Failure::data(&destination, error))?;
        }
        Ok(())
    }
}

/// A file beside the one that it will become, so that renaming is enough. Pipes and devices have no such place.
fn temporary(destination: &Path) -> io::Result<TempPath> {
    let folder = match destination.parent() {
        _ if is_special(destination) => std::env::temp_dir(),
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let mut suffix = std::ffi::OsString::from("-");
    suffix.push(destination.file_name().unwrap_or_default());
    let mut builder = tempfile::Builder::new();
    builder.prefix(".flicr-").suffix(&suffix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    Ok(builder.tempfile_in(folder)?.into_temp_path())
}

/// Something that is there and no regular file: to be written into, never to be replaced.
fn is_special(destination: &Path) -> bool {
    fs::metadata(destination).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

fn put(temporary: TempPath, destination: &Path) -> io::Result<()> {
    if is_special(destination) {
        let mut device = OpenOptions::new().write(true).open(destination)?;
        return io::copy(&mut File::open(&temporary)?, &mut device).map(|_| ());
    }
    // A link stays one; what it points to is replaced.
    let real = destination.canonicalize().unwrap_or_else(|_| destination.into());
    temporary.persist(real).map_err(|error| error.error)
}

/// Refuses an output whose extension stands for no format of point clouds. Folders get `.bin` files.
pub fn check_cloud_extension(out: &Path) -> Result<(), Failure> {
    if out.is_dir() || Format::of(out).is_some() {
        return Ok(());
    }
    Err(Failure::usage(out, "unknown kind of file: expected .bin, .xyzir.bin, .pcd, .ply or a folder"))
}

/// Names of `count` outputs: `out` itself if it is one, else `drive-000000.pcd` and so on for `drive.pcd`;
/// `000000.bin` and so on in a folder.
pub fn numbered(out: &Path, count: usize) -> Vec<PathBuf> {
    if out.is_dir() {
        return (0..count).map(|number| out.join(format!("{number:06}.bin"))).collect();
    }
    if count == 1 {
        return vec![out.into()];
    }
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    let (stem, extension) = name.split_at(name.len() - extension_len(out));
    (0..count).map(|number| out.with_file_name(format!("{stem}-{number:06}{extension}"))).collect()
}

/// Bytes of a cloud's extension, dot included.
fn extension_len(file: &Path) -> usize {
    match Format::of(file) {
        Some(Format::KittiRing) if file.to_string_lossy().to_ascii_lowercase().ends_with(".pcd.bin") => {
            ".pcd.bin".len()
        }
        Some(Format::KittiRing) => ".xyzir.bin".len(),
        Some(_) => ".bin".len(),
        None => 0,
    }
}
