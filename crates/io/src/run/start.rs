//! Starts a job: decides whether it starts at frame 0, after a checkpoint or not at all, and opens its files.

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
use crate::file::part_path;
use crate::frames::{Format, FrameWriter, OutputError, Sequence, Source};

/// Starting point of a job.
#[derive(Debug)]
pub(super) enum Start {
    /// At frame 0; existing frames are replaced.
    Fresh,
    /// After the frame of a checkpoint.
    After(Box<Checkpoint>),
    /// Nothing to do: all frames exist.
    Finished,
}

impl Job {
    /// Runs the job. All input is checked before any frame is written.
    ///
    /// Frames appear under their final names only when they are complete. With [`Job::resume`],
    /// a finished sequence is left unchanged, and a sequence that ended early, or that is now longer, continues
    /// after its checkpoint. On the same SIMD level it is bit-identical to an uninterrupted run. Without a
    /// checkpoint, or if a frame is missing, the job starts at frame 0. A checkpoint of another motion is an
    /// error.
    ///
    /// # Errors
    ///
    /// If the input is invalid or the run fails; [`RunError::is_input`] distinguishes the two.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<RunReport, RunError> {
        let job_start = Instant::now();
        self.check()?;
        let fingerprint = fingerprint(&self.scene)?;

        let mut lock = None;
        let mut start = Start::Fresh;
        if self.resume && self.directory.is_dir() {
            lock = Some(Lock::acquire(&self.directory)?);
            start = self.choose_start(&fingerprint, observer)?;
        }
        if matches!(start, Start::Finished) {
            return Ok(self.already_finished(job_start));
        }

        let prepared = prepare(&self.scene)?;
        let _lock = match lock {
            Some(lock) => lock,
            None => self.create_directory()?,
        };
        let running = match start {
            Start::After(checkpoint) => self.reopen(prepared, *checkpoint, fingerprint, observer)?,
            _ => self.open(prepared, fingerprint)?,
        };
        running.run(job_start, observer)
    }

    /// Returns the starting point of a resumed job, from the contents of its directory.
    fn choose_start(&self, fingerprint: &str, observer: &mut dyn Observer) -> Result<Start, RunError> {
        let Some(checkpoint) = Checkpoint::read(&self.directory, fingerprint)? else {
            return Ok(Start::Fresh);
        };
        let last = self.scene.simulation.frames;
        if let Some(file) = self.missing_file(checkpoint.frame.min(last)) {
            observer.note(&Note::Restarted { reason: format!("{} is missing", file.display()) });
            return Ok(Start::Fresh);
        }
        if checkpoint.frame >= last { Ok(Start::Finished) } else { Ok(Start::After(Box::new(checkpoint))) }
    }

    /// Returns the first missing file of the frames up to `done`.
    fn missing_file(&self, done: u32) -> Option<PathBuf> {
        self.sequences().into_iter().find_map(|sequence| {
            let file = |frame: u32| sequence.path(self.number(frame));
            let written = (0..=done).filter(|&frame| self.is_written(frame));
            match sequence.format {
                Format::Pc2 => {
                    // A point cache is called `.part` until its run ends.
                    let unfinished = done < self.scene.simulation.frames;
                    let exists = |path: &PathBuf| path.is_file() || unfinished && part_path(path).is_file();
                    Some(file(0)).filter(|path| !exists(path))
                }
                _ => written.map(file).find(|path| !path.is_file()),
            }
        })
    }

    /// Creates the output directory and acquires its lock.
    fn create_directory(&self) -> Result<Lock, RunError> {
        std::fs::create_dir_all(&self.directory)
            .map_err(|source| RunError::io("create the directory", &self.directory, source))?;
        Lock::acquire(&self.directory)
    }

    /// Opens the files of a run from frame 0 and removes an existing sequence.
    fn open(&self, prepared: Prepared, fingerprint: String) -> Result<Running<'_>, RunError> {
        let stats = self.stats.as_deref().map(Stats::create).transpose()?;
        Checkpoint::remove(&self.directory)?;
        let writers = self.writers(&prepared, FrameWriter::create)?;
        Ok(Running::new(self, prepared, writers, stats, fingerprint, None))
    }

    /// Opens the files of a run that continues after a checkpoint.
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
            // The point cache does not fit: other point count, first frame or frame step, or too few frames.
            Err(error @ OutputError::Cache { .. }) => {
                observer.note(&Note::Restarted { reason: error.to_string() });
                return self.open(prepared, fingerprint);
            }
            writers => writers?,
        };
        let level = supple::simd_level();
        if checkpoint.level != level {
            observer.note(&Note::SimdLevelDiffers { before: checkpoint.level, now: level.to_string() });
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

    /// Opens a frame writer for each body.
    fn writers(
        &self,
        prepared: &Prepared,
        open: impl Fn(Sequence, Source<'_>) -> Result<FrameWriter, OutputError>,
    ) -> Result<Vec<FrameWriter>, OutputError> {
        let open = |(sequence, input): (Sequence, &Input)| {
            let mut writer = open(sequence, input.source())?;
            writer.set_executor(prepared.simulation.executor());
            Ok(writer)
        };
        self.sequences().into_iter().zip(&prepared.inputs).map(open).collect()
    }

    /// Returns the report of a job whose frames all exist.
    fn already_finished(&self, job_start: Instant) -> RunReport {
        RunReport {
            directory: self.directory.clone(),
            outcome: Outcome::AlreadyFinished,
            resumed_after: None,
            last: self.scene.simulation.frames,
            simulated: 0,
            written: 0,
            substeps: 0,
            elapsed: job_start.elapsed(),
            bodies: Vec::new(),
        }
    }
}
