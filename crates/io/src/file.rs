//! Whole files or none.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// The ending of files that are not whole yet.
pub(crate) const PART: &str = ".part";

/// `path` with `.part` at its end.
pub(crate) fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(PART);
    name.into()
}

/// Writes a file beside `path`, called as it with `.part` at its end, and renames it.
///
/// # Errors
///
/// What `write` or the system says. Nothing of the new file stays then, and an older one at `path` is as it was.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let part = part_of(path);
    let written = File::create(&part).and_then(|mut file| write(&mut file));
    let result = written.and_then(|()| fs::rename(&part, path));
    if result.is_err() {
        // Whatever is wrong with the directory is told by the first error.
        let _ = fs::remove_file(&part);
    }
    result
}
