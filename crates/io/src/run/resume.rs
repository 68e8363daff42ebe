//! Decides where a resumed job starts: at frame 0, after the frame of a checkpoint, or not at all. Compares
//! the settings and the files with the checkpoint, and changes no file of the earlier run.

use std::path::PathBuf;

use super::changes::Changes;
use super::checkpoint::{Checkpoint, Saved};
use super::error::RunError;
use super::job::{Job, Resume};
use super::observer::{Note, Observer};
use super::settings::Settings;
use super::stats::read_rows;
use crate::frames::{
    Compare, Listing, Present, Record, Recorder, Renames, Sequence, check, check_link, finish,
};
use supple::SimulationState;

/// Starting point of a job.
#[derive(Debug)]
pub(super) enum Start {
    /// At frame 0. Existing frames are replaced.
    Fresh,
    /// After the frame of a checkpoint.
    After(Box<Earlier>),
    /// All frames exist.
    Finished {
        /// Checkpoint of the earlier run.
        checkpoint: Box<Checkpoint>,
        /// Sequences, with their numbers of frames, whose files lack their final form, which needs the simulation.
        unfinished: Vec<(Sequence, u64)>,
    },
}

/// An earlier run that can be continued.
#[derive(Debug)]
pub(super) struct Earlier {
    /// File of its checkpoint or kept state.
    pub(super) path: PathBuf,
    /// Its checkpoint.
    pub(super) checkpoint: Checkpoint,
    /// State of the simulation at the checkpoint.
    pub(super) state: SimulationState,
    /// Its statistics up to the checkpoint.
    pub(super) stats: Option<Recorder>,
    /// Its files.
    pub(super) listing: Listing,
    /// Its frames that have another number of digits than the frames of this run.
    pub(super) renames: Renames,
    /// The changes of the scene since the state, if the job continues from a kept state: see [`Job::from`].
    pub(super) changes: Option<Changes>,
}

impl Earlier {
    /// Reads the state of a checkpoint or kept state.
    pub(super) fn new(
        saved: Saved,
        stats: Option<Recorder>,
        (listing, renames): (Listing, Renames),
        changes: Option<Changes>,
    ) -> Result<Self, RunError> {
        let (path, state) = (saved.path().to_owned(), saved.state()?);
        Ok(Self { path, checkpoint: saved.checkpoint, state, stats, listing, renames, changes })
    }
}

impl Job {
    /// Returns the starting point of a resumed job, from the contents of its directory.
    pub(super) fn choose_start(
        &self,
        settings: &Settings,
        observer: &mut dyn Observer,
    ) -> Result<Start, RunError> {
        self.find_earlier(settings, observer).or_else(|error| self.start_again(error, observer))
    }

    /// Returns the starting point of a job whose earlier run cannot be continued: frame 0 with [`Resume::Auto`].
    ///
    /// # Errors
    ///
    /// `error`, without [`Resume::Auto`], or if a new run would fail too.
    pub(super) fn start_again(
        &self,
        error: RunError,
        observer: &mut dyn Observer,
    ) -> Result<Start, RunError> {
        match error.restart_reason().filter(|_| self.resume == Resume::Auto) {
            Some(reason) => {
                observer.note(&Note::Restarted { reason });
                Ok(Start::Fresh)
            }
            None => Err(error),
        }
    }

    /// Compares the earlier run in the directory with this one.
    fn find_earlier(&self, settings: &Settings, observer: &mut dyn Observer) -> Result<Start, RunError> {
        let sequences = self.sequences();
        let Some(saved) = Saved::read(&self.directory, settings, sequences.len())? else {
            return Ok(Start::Fresh);
        };
        let last_frame = self.scene.simulation.frames;
        let frame = saved.checkpoint.frame;
        let needed = (frame.min(last_frame) / self.every) as usize + 1;
        let records: Vec<&[Record]> = sequences
            .iter()
            .zip(&saved.checkpoint.frames)
            .map(|(sequence, records)| match sequence.format.needs_all_frames() {
                // Its file has the frames after the last one of this run too.
                true => &records[..],
                false => &records[..needed],
            })
            .collect();
        let listing = Listing::read(&sequences)?;
        let compare = self.compare();
        let renames = match check(&listing, &sequences, &records, (compare, frame < last_frame))? {
            Present::All(renames) => renames,
            Present::Not(reason) => {
                observer.note(&Note::Restarted { reason });
                return Ok(Start::Fresh);
            }
        };
        let stats = self.kept_rows(&saved.checkpoint)?;
        if frame >= last_frame {
            let mut unfinished = Vec::new();
            for (sequence, records) in sequences.into_iter().zip(&saved.checkpoint.frames) {
                let has_more = frame > last_frame && sequence.format.needs_all_frames();
                let is_kept = has_more && sequence.path(0).exists();
                if !is_kept && !finish(&sequence, records, compare)? {
                    unfinished.push((sequence, records.len() as u64));
                }
            }
            return Ok(Start::Finished { checkpoint: Box::new(saved.checkpoint), unfinished });
        }
        sequences.iter().try_for_each(check_link)?;
        Ok(Start::After(Box::new(Earlier::new(saved, stats, (listing, renames), None)?)))
    }

    /// Returns what of the files of an earlier run is compared with its records.
    pub(super) fn compare(&self) -> Compare {
        if self.verify { Compare::Contents } else { Compare::Sizes }
    }

    /// Reads the rows of the statistics up to a checkpoint, if both the job and the checkpoint have statistics.
    pub(super) fn kept_rows(&self, checkpoint: &Checkpoint) -> Result<Option<Recorder>, RunError> {
        let (Some(path), Some(rows)) = (&self.stats, &checkpoint.stats) else { return Ok(None) };
        let last = checkpoint.frame / self.every * self.every;
        read_rows(path, rows, (self.number(0), self.number(last))).map(Some)
    }
}
