//! Whole files or none.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::OutputError;

/// The ending of files that are not whole yet.
pub(super) const PART: &str = ".part";

/// `path` with `.part` at its end.
pub(crate) fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(PART);
    name.into()
}

/// Writes `texts` one after another to a file beside `path` and renames it. If anything fails nothing of it stays,
/// and an older file at `path` is as it was.
pub(super) fn replace<'a>(path: &Path, mut texts: impl Iterator<Item = &'a [u8]>) -> Result<(), OutputError> {
    let part = part_of(path);
    let result = File::create(&part)
        .and_then(|mut file| texts.try_for_each(|text| file.write_all(text)))
        .map_err(OutputError::io("write", path))
        .and_then(|()| fs::rename(&part, path).map_err(OutputError::io("rename to", path)));
    if result.is_err() {
        // Whatever is wrong with the directory is told by the first error.
        let _ = fs::remove_file(&part);
    }
    result
}
