//! Writes files atomically: under a temporary name, and renames them when they are complete.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Suffix of files that are not complete yet.
pub(crate) const PART: &str = ".part";

/// Returns `path` with `.part` appended.
pub(crate) fn part_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(PART);
    name.into()
}

/// Writes a file atomically: writes to `path` with `.part` appended, then renames it to `path`.
///
/// # Errors
///
/// The error of `write` or of the file system. The `.part` file is then removed, and a file that existed at
/// `path` is unchanged.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let part = part_path(path);
    let written = File::create(&part).and_then(|mut file| write(&mut file));
    let result = written.and_then(|()| fs::rename(&part, path));
    if result.is_err() {
        // The error of `write` or `rename` is returned; an error of the removal would add nothing.
        let _ = fs::remove_file(&part);
    }
    result
}
