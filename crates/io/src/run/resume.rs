//! Where a job starts: at frame 0, after a checkpoint, or not at all.

use super::checkpoint::Checkpoint;
use super::error::RunError;
use super::job::Job;
use super::observer::{Note, Observer};
use super::sinks;

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
pub(super) fn decide(job: &Job, fingerprint: &str, observer: &mut dyn Observer) -> Result<Start, RunError> {
    let Some(checkpoint) = Checkpoint::read(&job.directory, fingerprint)? else { return Ok(Start::Fresh) };
    let last = job.scene.simulation.frames;
    if let Some(file) = sinks::missing(job, checkpoint.frame.min(last)) {
        observer.note(&Note::StartsAgain { reason: format!("{} is not there", file.display()) });
        return Ok(Start::Fresh);
    }
    if checkpoint.frame >= last { Ok(Start::Finished) } else { Ok(Start::After(Box::new(checkpoint))) }
}
