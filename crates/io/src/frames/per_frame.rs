//! Compares the files of a sequence that has a file per frame with the records of the frames.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::listing::ListedFile;
use super::record::{Compare, Record};
use super::{OutputError, Sequence};

/// Frames whose numbers have another number of digits than the names of their sequence: present path and new
/// path.
#[derive(Debug, Default)]
pub(crate) struct Renames(Vec<(PathBuf, PathBuf)>);

impl Renames {
    /// Renames the frames. If this is interrupted, each frame exists under one of its two names.
    pub(crate) fn apply(&self) -> Result<(), OutputError> {
        self.0.iter().try_for_each(|(from, to)| fs::rename(from, to).map_err(OutputError::io("rename", from)))
    }
}

/// Checks the frames of a sequence with one file per frame. Returns the first problem, and appends the frames
/// to rename.
pub(super) fn check_files(
    files: &[ListedFile],
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
    renames: &mut Renames,
) -> Result<Option<String>, OutputError> {
    let mut by_frame: BTreeMap<u64, Vec<&Path>> = BTreeMap::new();
    for file in files.iter().filter(|file| !file.is_part) {
        if let Some(frame) = file.frame {
            by_frame.entry(frame).or_default().push(&file.path);
        }
    }
    let mut number = sequence.first;
    for record in records {
        let path = sequence.path(number);
        // The path with the digits of this run comes first.
        let mut candidates = by_frame.remove(&number).unwrap_or_default();
        candidates.sort_by_key(|candidate| **candidate != *path);
        let mut problem = None;
        let mut intact = None;
        for candidate in candidates {
            match check_file(candidate, record, compare)? {
                None => {
                    intact = Some(candidate);
                    break;
                }
                found => problem = problem.or(found),
            }
        }
        match intact {
            Some(intact) if *intact == *path => {}
            Some(intact) => renames.0.push((intact.to_owned(), path)),
            None => return Ok(Some(problem.unwrap_or_else(|| missing(&path)))),
        }
        number += sequence.every;
    }
    // Frames after the checkpoint keep their numbers, and are written again.
    for (number, paths) in by_frame.split_off(&number) {
        let path = sequence.path(number);
        if !paths.contains(&&*path) {
            renames.0.push((paths[0].to_owned(), path));
        }
    }
    Ok(None)
}

fn missing(path: &Path) -> String {
    format!("{} is missing", path.display())
}

/// Compares a file with its record. Returns the problem if they differ.
fn check_file(path: &Path, record: &Record, compare: Compare) -> Result<Option<String>, OutputError> {
    let found = match fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => metadata.len(),
        Err(error) if error.kind() != ErrorKind::NotFound => {
            return Err(OutputError::io("read", path)(error));
        }
        _ => return Ok(Some(missing(path))),
    };
    let path_text = path.display();
    if found != record.bytes {
        return Ok(Some(format!("{path_text} has {found} instead of {} bytes", record.bytes)));
    }
    if compare == Compare::Contents {
        let found = Record::of_range(path, 0, record.bytes).map_err(OutputError::io("read", path))?;
        if found != *record {
            return Ok(Some(format!("{path_text} has changed since it was written")));
        }
    }
    Ok(None)
}
