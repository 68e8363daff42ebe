//! Writes the manifest of a run: a JSON file beside the frames that lists them, for programs that copy or check them.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;

use serde::Serialize;

use super::checkpoint::Checkpoint;
use super::error::RunError;
use super::report::Outcome;
use super::states;
use crate::file::{remove_if_present, write_durably};
use crate::frames::{Record, Sequence, written_images};

/// Name of the manifest, which is in the directory of the frames.
pub const MANIFEST: &str = "manifest.json";

/// First characters of every manifest, without spaces and line ends.
const HEAD: &str = r#"{"program":"supple","#;

/// A finished or stopped run. The order of the fields is that of the file; `program` is the first one, see [`HEAD`].
#[derive(Debug, Serialize)]
struct Manifest<'a> {
    program: &'a str,
    version: &'a str,
    /// Name of the scene file.
    scene: Option<String>,
    /// XXH3 hash of the [fingerprint](super::fingerprint()) of the scene.
    fingerprint: String,
    outcome: &'a str,
    /// Rate at which the files are played, in frames per second.
    fps: f64,
    /// Number of the first frame.
    first: u64,
    /// Number of the last completed frame.
    last: u64,
    /// Interval between written frames.
    every: u32,
    files: Vec<ListedFile>,
}

/// A file of frames.
#[derive(Debug, Serialize)]
struct ListedFile {
    name: String,
    bytes: u64,
    /// XXH3 hash of a file with one frame. A file with all frames would have to be read again for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    xxh3: Option<String>,
}

/// The complete files of a run.
#[derive(Debug)]
pub(super) struct Files<'a> {
    pub(super) directory: &'a Path,
    pub(super) sequences: Vec<Sequence>,
    /// The bodies whose images, inside of their models, are written beside the frames.
    pub(super) bodies_with_images: Vec<&'a str>,
    pub(super) scene_file: Option<&'a Path>,
    /// Rate at which the files are played, in frames per second.
    pub(super) fps: f64,
}

/// Writes the manifest of the files of a run, and replaces another one. `checkpoint` is that of the last frame.
pub(super) fn write(run: &Files<'_>, checkpoint: &Checkpoint, outcome: Outcome) -> Result<(), RunError> {
    let listed = run.sequences.iter().zip(&checkpoint.frames);
    let listed = listed.map(|(sequence, records)| files(sequence, records));
    let images = written_images(run.directory, &run.bodies_with_images).into_iter();
    let images = images.map(|paths| paths.iter().map(|path| whole_file(run.directory, path)).collect());
    let states =
        states::list(run.directory)?.into_iter().map(|state| hashed_file(run.directory, &state.path));
    let listed = listed.chain(images).chain([states.collect()]);
    let settings = &checkpoint.settings;
    let scene = run.scene_file.and_then(Path::file_name);
    let first = u64::from(settings.start_frame);
    let manifest = Manifest {
        program: "supple",
        version: &settings.version,
        scene: scene.map(|name| name.to_string_lossy().into_owned()),
        fingerprint: hexadecimal(&Record::of(settings.fingerprint.as_bytes())),
        outcome: outcome.name(),
        fps: run.fps,
        first,
        last: first + u64::from(checkpoint.frame),
        every: settings.every,
        files: listed.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect(),
    };
    let path = run.directory.join(MANIFEST);
    let failed = |source| RunError::io("write", &path, source);
    let mut text = serde_json::to_vec_pretty(&manifest).map_err(|error| failed(error.into()))?;
    text.push(b'\n');
    if fs::read(&path).is_ok_and(|existing| existing == text) {
        return Ok(());
    }
    write_durably(&path, |file| file.write_all(&text)).map_err(failed)
}

/// Returns the files of a sequence whose frames have these records.
fn files(sequence: &Sequence, records: &[Record]) -> Result<Vec<ListedFile>, RunError> {
    let directory = &sequence.directory;
    let mut files = Vec::new();
    if !sequence.format.is_per_sequence() {
        let numbers = (0_u64..).map(|index| sequence.first + index * sequence.every);
        files.extend(numbers.zip(records).map(|(frame, record)| ListedFile {
            name: name(directory, &sequence.path(frame)),
            bytes: record.bytes,
            xxh3: Some(hexadecimal(record)),
        }));
    }
    for path in sequence.whole_files() {
        files.push(whole_file(directory, &path)?);
    }
    Ok(files)
}

/// Returns the entry of a file with more than one frame, or with none.
fn whole_file(directory: &Path, path: &Path) -> Result<ListedFile, RunError> {
    let metadata = fs::metadata(path).map_err(|source| RunError::io("read", path, source))?;
    Ok(ListedFile { name: name(directory, path), bytes: metadata.len(), xxh3: None })
}

/// Returns the entry of a file with its hash.
fn hashed_file(directory: &Path, path: &Path) -> Result<ListedFile, RunError> {
    let bytes = fs::read(path).map_err(|source| RunError::io("read", path, source))?;
    let record = Record::of(&bytes);
    Ok(ListedFile { name: name(directory, path), bytes: record.bytes, xxh3: Some(hexadecimal(&record)) })
}

/// Returns a path relative to the directory, with slashes on all systems.
fn name(directory: &Path, path: &Path) -> String {
    let parts = path.strip_prefix(directory).unwrap_or(path).components();
    parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Formats a hash as `xxhsum -H3` does.
fn hexadecimal(record: &Record) -> String {
    format!("{:016x}", record.hash)
}

/// Removes the manifest of a directory, if there is one, because it does not describe the frames of the next run.
pub(super) fn remove(directory: &Path) -> Result<(), RunError> {
    let path = directory.join(MANIFEST);
    remove_if_present(&path).map(drop).map_err(|error| RunError::io("remove", &path, error))
}

/// Checks that a run may replace the file with the name of the manifest in a directory: there is none, or it is a
/// manifest of a run. Other programs use this name too.
pub(super) fn check(directory: &Path) -> Result<(), RunError> {
    let path = directory.join(MANIFEST);
    if path.symlink_metadata().is_err() {
        return Ok(());
    }
    let mut head = String::new();
    let is_file = fs::metadata(&path).is_ok_and(|metadata| metadata.is_file());
    let read = || File::open(&path)?.take(2 * HEAD.len() as u64).read_to_string(&mut head);
    let is_read = is_file && { read }().is_ok();
    head.retain(|character| !character.is_whitespace());
    if is_read && head.starts_with(HEAD) { Ok(()) } else { Err(RunError::ForeignManifest { path }) }
}
