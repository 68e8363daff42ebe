//! Compares the frames on disk with the records of an earlier run, and completes files with all frames.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::listing::{ListedFile, Listing};
use super::record::{Compare, Record};
use super::{Format, OutputError, Sequence, page, pc2, stage};

/// Result of comparing the frames on disk with their records.
#[derive(Debug)]
pub(crate) enum Present {
    /// Every recorded frame exists, perhaps with more or fewer digits in its name.
    All(Renames),
    /// A recorded frame is missing or has changed. The text describes the problem.
    Not(String),
}

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

/// Compares the files of `sequences` with `records`: for each sequence, the record of each frame, in order
/// from the first frame of the sequence.
pub(crate) fn check(
    listing: &Listing,
    sequences: &[Sequence],
    records: &[&[Record]],
    compare: Compare,
) -> Result<Present, OutputError> {
    let mut renames = Renames::default();
    for (index, (sequence, records)) in sequences.iter().zip(records).enumerate() {
        let problem = match sequence.format {
            Format::Pc2 => pc2::check(sequence, records, compare)?,
            Format::Usd => stage::check(sequence, records, compare)?,
            Format::Html => page::check(sequence, records, compare)?,
            Format::Obj | Format::Ply => {
                check_files(listing.files(index), sequence, records, compare, &mut renames)?
            }
        };
        if let Some(problem) = problem {
            return Ok(Present::Not(problem));
        }
    }
    Ok(Present::All(renames))
}

/// Gives the unfinished file of a sequence that has all frames its final form and name, without the frames after
/// `records`. Returns false if this needs the simulation.
pub(crate) fn finish(sequence: &Sequence, records: &[Record], compare: Compare) -> Result<bool, OutputError> {
    match sequence.format {
        Format::Pc2 => pc2::finish(sequence, records)?,
        Format::Html => page::finish(sequence, records)?,
        Format::Usd => return stage::is_complete(sequence, records, compare),
        Format::Obj | Format::Ply => {}
    }
    Ok(true)
}

/// Returns an error if the existing file of a sequence is a link, which would have to be followed to continue it.
pub(crate) fn check_link(sequence: &Sequence) -> Result<(), OutputError> {
    match sequence.format {
        Format::Pc2 | Format::Usd => sequence.check_continued_path(),
        Format::Html => page::check_link(sequence),
        Format::Obj | Format::Ply => Ok(()),
    }
}

/// Checks the frames of a sequence with one file per frame. Returns the first problem, and appends the frames
/// to rename.
fn check_files(
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
