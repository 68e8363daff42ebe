//! Where a job starts: at frame 0, after a checkpoint, or not at all.

use std::path::Path;

use super::checkpoint::Checkpoint;
use super::error::RunError;
use super::observer::{Note, Observer};
use super::sequence::{Numbering, cache_name, part_name};
use crate::scene::{FormatName, Scene};

/// Where a job starts.
#[derive(Debug)]
pub(super) enum Start {
    /// At frame 0, over whatever is there.
    Fresh,
    /// After the frame of a checkpoint.
    After(Box<Checkpoint>),
    /// All frames are there.
    Finished,
}

/// Decides where a resumed job starts, from what its folder holds.
pub(super) fn decide(
    scene: &Scene,
    folder: &Path,
    numbering: Numbering,
    fingerprint: &str,
    observer: &mut dyn Observer,
) -> Result<Start, RunError> {
    let Some(checkpoint) = Checkpoint::read(folder, fingerprint)? else { return Ok(Start::Fresh) };
    let done = checkpoint.frame.min(numbering.last);
    if let Some(file) = missing(scene, folder, numbering, done) {
        observer.note(&Note::FramesMissing { file });
        return Ok(Start::Fresh);
    }
    if checkpoint.frame >= numbering.last {
        return Ok(Start::Finished);
    }
    Ok(Start::After(Box::new(checkpoint)))
}

/// The first file that should be there after frame `done`, and is not.
fn missing(scene: &Scene, folder: &Path, numbering: Numbering, done: u32) -> Option<String> {
    let format = scene.output.format;
    scene.bodies.iter().find_map(|body| {
        if format == FormatName::Pc2 {
            let name = cache_name(&body.name);
            let there = folder.join(&name).is_file() || folder.join(part_name(&name)).is_file();
            return (!there).then_some(name);
        }
        (0..=done)
            .filter(|&frame| numbering.keeps(frame))
            .map(|frame| numbering.file_name(&body.name, frame, format))
            .find(|name| !folder.join(name).is_file())
    })
}
