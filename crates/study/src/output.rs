//! Writes the output files of studies, and formats numbers for tables.

use std::fs;
use std::path::Path;

use serde::Serialize;
use supple_io::run::RunError;

use crate::error::StudyError;

/// Creates a directory if it does not exist. If the path is a file, the error is an input error.
pub(crate) fn create_directory(directory: &Path) -> Result<(), StudyError> {
    if directory.exists() && !directory.is_dir() {
        return Err(RunError::OutputIsAFile { path: directory.to_owned() }.into());
    }
    fs::create_dir_all(directory).map_err(|error| StudyError::file("create", directory, error))
}

/// Writes the bytes to a temporary file with the extension `part` and renames it to `path`. On an error, an
/// existing file at `path` is kept.
pub(crate) fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), StudyError> {
    let temporary = path.with_extension("part");
    fs::write(&temporary, bytes)
        .and_then(|()| fs::rename(&temporary, path))
        .map_err(|error| StudyError::file("write", path, error))
}

/// Writes a value as JSON.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), StudyError> {
    let text =
        serde_json::to_string_pretty(value).map_err(|error| StudyError::file("write", path, error.into()))?;
    write_atomically(path, text.as_bytes())
}

/// Writes records as CSV.
pub(crate) fn write_csv(path: &Path, records: &[Vec<String>]) -> Result<(), StudyError> {
    let failed = |error: csv::Error| StudyError::file("write", path, std::io::Error::other(error));
    let mut writer = csv::Writer::from_writer(Vec::new());
    records.iter().try_for_each(|record| writer.write_record(record)).map_err(failed)?;
    write_atomically(path, &writer.into_inner().map_err(|error| failed(error.into_error().into()))?)
}

/// Formats a number with two to four digits, for example `0.129` or `3.1e-7`; most results have at most six
/// columns. `None` gives `-`.
pub(crate) fn compact(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) if (0.01..10.0).contains(&value.abs()) => format!("{value:.3}"),
        Some(value) => format!("{value:.1e}"),
    }
}
