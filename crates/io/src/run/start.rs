//! Where a job starts: at frame 0, after a checkpoint, or not at all; and its files, opened for that.

use std::path::PathBuf;
use std::time::Instant;

use super::advance::Running;
use super::checkpoint::{CHECKPOINT, Checkpoint};
use super::error::RunError;
use super::fingerprint::fingerprint;
use super::job::Job;
use super::lock::Lock;
use super::observer::{Note, Observer};
use super::prepare::{Input, Prepared, prepare};
use super::report::{Outcome, RunReport};
use super::stats::Stats;
use crate::file::part_of;
use crate::frames::{Format, FrameWriter, OutputError, Sequence, Source};

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

impl Job {
    /// Runs the job: everything that can be wrong with it is looked for before anything is written.
    ///
    /// Frames appear under their names only when they are whole. With [`Job::resume`]: nothing there
    /// starts at frame 0; a finished sequence is left alone; a sequence that ended early, or is now to
    /// be longer, goes on after its checkpoint, with the bits of an uninterrupted run.
    ///
    /// # Errors
    ///
    /// [`RunError::is_input`] tells what the user's input is to blame for from what failed while running.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<RunReport, RunError> {
        let begun = Instant::now();
        self.check()?;
        let fingerprint = fingerprint(&self.scene)?;

        let mut lock = None;
        let mut start = Start::Fresh;
        if self.resume && self.directory.is_dir() {
            lock = Some(Lock::take(&self.directory)?);
            start = self.decide(&fingerprint, observer)?;
        }
        if matches!(start, Start::Finished) {
            return Ok(self.already_finished(begun));
        }

        let prepared = prepare(&self.scene)?;
        let _lock = match lock {
            Some(lock) => lock,
            None => self.open_folder()?,
        };
        let running = match start {
            Start::After(checkpoint) => self.reopen(prepared, *checkpoint, fingerprint, observer)?,
            _ => self.open(prepared, fingerprint)?,
        };
        running.run(begun, observer)
    }

    /// Decides where a resumed job starts, from what its folder holds.
    fn decide(&self, fingerprint: &str, observer: &mut dyn Observer) -> Result<Start, RunError> {
        let Some(checkpoint) = Checkpoint::read(&self.directory, fingerprint)? else {
            return Ok(Start::Fresh);
        };
        let last = self.scene.simulation.frames;
        if let Some(file) = self.missing(checkpoint.frame.min(last)) {
            observer.note(&Note::StartsAgain { reason: format!("{} is not there", file.display()) });
            return Ok(Start::Fresh);
        }
        if checkpoint.frame >= last { Ok(Start::Finished) } else { Ok(Start::After(Box::new(checkpoint))) }
    }

    /// The first file that should be there after frame `done`, and is not.
    fn missing(&self, done: u32) -> Option<PathBuf> {
        self.sequences().into_iter().find_map(|sequence| {
            let file = |frame: u32| sequence.path(self.number(frame));
            let kept = (0..=done).filter(|&frame| self.keeps(frame));
            match sequence.format {
                Format::Pc2 => {
                    // A sequence that is done has its own name.
                    let under_way = done < self.scene.simulation.frames;
                    let there = |path: &PathBuf| path.is_file() || under_way && part_of(path).is_file();
                    Some(file(0)).filter(|path| !there(path))
                }
                _ => kept.map(file).find(|path| !path.is_file()),
            }
        })
    }

    fn open_folder(&self) -> Result<Lock, RunError> {
        std::fs::create_dir_all(&self.directory)
            .map_err(|source| RunError::io("create the folder", &self.directory, source))?;
        Lock::take(&self.directory)
    }

    /// Replaces whatever sequence is there.
    fn open(&self, prepared: Prepared, fingerprint: String) -> Result<Running<'_>, RunError> {
        let stats = self.stats.as_deref().map(Stats::create).transpose()?;
        Checkpoint::remove(&self.directory)?;
        let writers = self.writers(&prepared, FrameWriter::create)?;
        Ok(Running::new(self, prepared, writers, stats, fingerprint, None))
    }

    /// Goes on after a checkpoint.
    fn reopen(
        &self,
        mut prepared: Prepared,
        checkpoint: Checkpoint,
        fingerprint: String,
        observer: &mut dyn Observer,
    ) -> Result<Running<'_>, RunError> {
        let frame = checkpoint.frame;
        let next = self.number(frame) + 1;
        let open = |sequence, source: Source<'_>| FrameWriter::resume(sequence, source, next);
        let writers = match self.writers(&prepared, open) {
            // A cache of other frames of the same motion.
            Err(error @ OutputError::Cache { .. }) => {
                observer.note(&Note::StartsAgain { reason: error.to_string() });
                return self.open(prepared, fingerprint);
            }
            writers => writers?,
        };
        let level = supple::simd_level();
        if checkpoint.level != level {
            observer.note(&Note::OtherLevel { before: checkpoint.level, now: level.to_string() });
        }
        prepared.simulation.restore(&checkpoint.state).map_err(|error| RunError::Checkpoint {
            path: self.directory.join(CHECKPOINT),
            what: error.to_string(),
        })?;
        let last = self.number(frame);
        let stats = self.stats.as_deref().map(|path| Stats::resume(path, last)).transpose()?;
        observer.note(&Note::Resumed { frame });
        Ok(Running::new(self, prepared, writers, stats, fingerprint, Some(frame)))
    }

    /// A frame writer for each body.
    fn writers(
        &self,
        prepared: &Prepared,
        open: impl Fn(Sequence, Source<'_>) -> Result<FrameWriter, OutputError>,
    ) -> Result<Vec<FrameWriter>, OutputError> {
        let open = |(sequence, input): (Sequence, &Input)| {
            let mut writer = open(sequence, input.source())?;
            writer.share(prepared.simulation.executor());
            Ok(writer)
        };
        self.sequences().into_iter().zip(&prepared.inputs).map(open).collect()
    }

    fn already_finished(&self, begun: Instant) -> RunReport {
        RunReport {
            directory: self.directory.clone(),
            outcome: Outcome::AlreadyFinished,
            resumed_after: None,
            last: self.scene.simulation.frames,
            simulated: 0,
            written: 0,
            substeps: 0,
            elapsed: begun.elapsed(),
            bodies: Vec::new(),
        }
    }
}
