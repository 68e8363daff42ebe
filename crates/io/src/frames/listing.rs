//! Lists the files of sequences in a directory, and checks that frames do not replace inputs.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::sequence::FileName;
use super::{Format, OutputError, Sequence};
use crate::file::{parent, part_path};

/// The files in a directory that belong to sequences with this directory.
#[derive(Debug, Default)]
pub(crate) struct Listing {
    /// Files of each sequence, sorted by path.
    files: Vec<Vec<ListedFile>>,
}

/// Frames of an older run under their temporary names. Dropping this removes those that were not replaced.
#[derive(Debug, Default)]
pub(crate) struct SetAside(Vec<PathBuf>);

impl Drop for SetAside {
    fn drop(&mut self) {
        // Most files do not exist any more. What cannot be removed does not harm: the next run removes it.
        self.0.iter().for_each(|path| drop(fs::remove_file(path)));
    }
}

/// A file of a sequence.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ListedFile {
    pub(super) path: PathBuf,
    /// Number of the frame; `None` for a file with all frames.
    pub(super) frame: Option<u64>,
    /// Whether the name ends in `.part`.
    pub(super) is_part: bool,
}

impl Listing {
    /// Lists the directory of `sequences` once. All sequences have the same directory.
    pub(crate) fn read(sequences: &[Sequence]) -> Result<Self, OutputError> {
        let mut files = vec![Vec::new(); sequences.len()];
        let Some(Sequence { directory, .. }) = sequences.first() else { return Ok(Self::default()) };
        let entries = match fs::read_dir(directory) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Self { files }),
            Err(error) => return Err(OutputError::io("read", directory)(error)),
        };
        let indexed = sequences.iter().enumerate();
        let indices: HashMap<(Format, &str), usize> =
            indexed.map(|(index, sequence)| ((sequence.format, &*sequence.name), index)).collect();
        let formats = formats(sequences);
        for entry in entries {
            let name = entry.map_err(OutputError::io("read", directory))?.file_name();
            let Some(text) = name.to_str() else { continue };
            for &format in &formats {
                let Some(FileName { body, frame, is_part }) = FileName::parse(text, format) else { continue };
                if let Some(&index) = indices.get(&(format, body)) {
                    files[index].push(ListedFile { path: directory.join(&name), frame, is_part });
                }
            }
        }
        files.iter_mut().for_each(|files| files.sort());
        Ok(Self { files })
    }

    /// Returns the files of a sequence, by its index in the argument of [`Listing::read`], sorted by path.
    pub(super) fn files(&self, sequence: usize) -> &[ListedFile] {
        &self.files[sequence]
    }

    /// Returns the listing without the files up to the frame `number`, and without those with all frames.
    pub(crate) fn after(mut self, number: u64) -> Self {
        let is_after = |file: &ListedFile| file.frame.is_some_and(|frame| frame > number);
        self.files.iter_mut().for_each(|files| files.retain(is_after));
        self
    }

    /// Renames the frames that `sequences` write again to their temporary names, and removes all other files.
    /// `sequences` is the argument of [`Listing::read`].
    ///
    /// Writing a frame replaces its temporary file. If all files were removed before the first one is created, 20,000
    /// files could take a minute: ext4 does not use inodes again that were freed in the last seconds, and each new file
    /// searches them all.
    pub(crate) fn set_aside(self, sequences: &[Sequence]) -> Result<SetAside, OutputError> {
        let mut aside = SetAside::default();
        for (files, sequence) in self.files.into_iter().zip(sequences) {
            for ListedFile { path, frame, .. } in files {
                let is_file = fs::symlink_metadata(&path).is_ok_and(|metadata| metadata.is_file());
                let again = frame.filter(|frame| is_file && sequence.writes(*frame));
                let again = again.map(|frame| sequence.path(frame));
                let part = again.as_deref().map(part_path);
                match part {
                    Some(part) if part == path => aside.0.push(part),
                    Some(part) if again.as_ref() == Some(&path) => {
                        fs::rename(&path, &part).map_err(OutputError::io("rename", &path))?;
                        aside.0.push(part);
                    }
                    _ => remove(&path)?,
                }
            }
        }
        Ok(aside)
    }

    /// Removes all files.
    pub(crate) fn remove_all(self) -> Result<(), OutputError> {
        self.files.into_iter().flatten().try_for_each(|file| remove(&file.path))
    }

    /// Removes incomplete frames. Incomplete files with all frames stay: point caches and stages can be continued, and
    /// the next page replaces an incomplete one.
    pub(crate) fn remove_parts(&self) -> Result<(), OutputError> {
        let parts = self.files.iter().flatten().filter(|file| file.is_part && file.frame.is_some());
        parts.map(|file| &file.path).try_for_each(|path| remove(path))
    }
}

fn remove(path: &Path) -> Result<(), OutputError> {
    fs::remove_file(path).map_err(OutputError::io("remove", path))
}

impl Sequence {
    /// Returns the files in the directory that belong to a sequence of this name and format with any number of frames,
    /// sorted. A file belongs to the sequence if its name is exactly `NAME_<digits>.<extension>` (four digits or more),
    /// `NAME.pc2`, `NAME.usd` or `NAME.html`. Incomplete files, with `.part` appended, and the data of pages are
    /// included.
    ///
    /// # Errors
    /// If the directory exists but cannot be read.
    pub fn existing(&self) -> Result<Vec<PathBuf>, OutputError> {
        let files = Listing::read(std::slice::from_ref(self))?.files;
        Ok(files.into_iter().flatten().map(|file| file.path).collect())
    }

    /// Removes the files that [`Sequence::existing`] returns.
    ///
    /// # Errors
    /// If the directory cannot be read or a file cannot be removed.
    pub fn remove_existing(&self) -> Result<(), OutputError> {
        Listing::read(std::slice::from_ref(self))?.remove_all()
    }
}

/// Returns the formats of sequences, each once.
fn formats(sequences: &[Sequence]) -> Vec<Format> {
    let mut formats = Vec::new();
    for sequence in sequences {
        if !formats.contains(&sequence.format) {
            formats.push(sequence.format);
        }
    }
    formats
}

/// Returns an error if frames of `sequences`, which have the same directory, would replace one of
/// `inputs`, if it would be removed as an older frame, or if it is the file `other` of the directory.
pub(crate) fn check_inputs<'a>(
    sequences: &[Sequence],
    other: &[&str],
    inputs: impl Iterator<Item = &'a Path>,
) -> Result<(), OutputError> {
    let Some(Sequence { directory, .. }) = sequences.first() else { return Ok(()) };
    // If the directory is missing, no input is in it.
    let Ok(directory) = fs::canonicalize(directory) else { return Ok(()) };
    let names: HashSet<(Format, &str)> =
        sequences.iter().map(|sequence| (sequence.format, &*sequence.name)).collect();
    let formats = formats(sequences);
    let is_output = |name: &str| {
        let is_frame = |format: &Format| {
            FileName::parse(name, *format).is_some_and(|file| names.contains(&(*format, file.body)))
        };
        let is_other = |other: &&str| name == *other || part_path(Path::new(other)).as_os_str() == name;
        formats.iter().any(is_frame) || other.iter().any(is_other)
    };
    let whole = sequences.iter().flat_map(Sequence::whole_files);
    let whole: HashSet<PathBuf> = whole.filter_map(|path| fs::canonicalize(path).ok()).collect();
    let mut in_directory: HashMap<PathBuf, bool> = HashMap::new();
    for input in inputs.collect::<BTreeSet<_>>() {
        // If `input` is a link, checks the link and its target.
        for path in [Some(input.to_owned()), fs::canonicalize(input).ok()].into_iter().flatten() {
            let is_inside = *in_directory.entry(parent(&path).to_owned()).or_insert_with_key(|parent| {
                fs::canonicalize(parent).is_ok_and(|parent| parent == directory)
            });
            if whole.contains(&path) {
                return Err(OutputError::OverwritesInput { path });
            }
            if is_inside && path.file_name().and_then(|name| name.to_str()).is_some_and(is_output) {
                return Err(OutputError::OverwritesInput { path });
            }
        }
    }
    Ok(())
}
