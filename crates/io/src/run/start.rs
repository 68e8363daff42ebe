//! Starts a job: decides whether to start at frame 0, after a checkpoint or not at all, and opens the files.

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
    /// At frame 0. Existing frames are replaced.
    Fresh,
    /// After the frame of a checkpoint.
    After(Box<Checkpoint>),
    /// Nothing to do, because all frames exist.
    Finished,
}

impl Job {
    /// Runs the job. All input is checked before any frame is written.
    ///
    /// A frame gets its final name only when it is complete.
    ///
    /// With [`Job::resume`], a finished sequence is not changed. A sequence that was stopped, or that has
    /// more frames in this job, continues after its checkpoint; its frames are bit-identical to the frames of
    /// an uninterrupted run at the same SIMD level. If there is no checkpoint, or a frame is missing, the job
    /// starts at frame 0. A checkpoint of a scene with another motion is an error.
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
            Start::After(checkpoint) => self.start_after(prepared, *checkpoint, fingerprint, observer)?,
            _ => self.start_fresh(prepared, fingerprint)?,
        };
        running.run(job_start, observer)
    }

    /// Returns the starting point of a resumed job, from the contents of its directory.
    fn choose_start(&self, fingerprint: &str, observer: &mut dyn Observer) -> Result<Start, RunError> {
        let Some(checkpoint) = Checkpoint::read(&self.directory, fingerprint)? else {
            return Ok(Start::Fresh);
        };
        let last_frame = self.scene.simulation.frames;
        if let Some(file) = self.missing_file(checkpoint.frame.min(last_frame)) {
            observer.note(&Note::Restarted { reason: format!("{} is missing", file.display()) });
            return Ok(Start::Fresh);
        }
        Ok(if checkpoint.frame >= last_frame { Start::Finished } else { Start::After(Box::new(checkpoint)) })
    }

    /// Returns the first missing file of the frames up to `last_done`, counted from 0.
    fn missing_file(&self, last_done: u32) -> Option<PathBuf> {
        self.sequences().into_iter().find_map(|sequence| {
            let file = |frame: u32| sequence.path(self.number(frame));
            let written = (0..=last_done).filter(|&frame| self.is_written(frame));
            match sequence.format {
                Format::Pc2 => {
                    // The name of a point cache ends in `.part` until its run ends.
                    let is_unfinished = last_done < self.scene.simulation.frames;
                    let exists =
                        |path: &PathBuf| path.is_file() || is_unfinished && part_path(path).is_file();
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

    /// Opens the files of a run from frame 0, and removes an existing sequence.
    fn start_fresh(&self, prepared: Prepared, fingerprint: String) -> Result<Running<'_>, RunError> {
        let stats = self.stats.as_deref().map(Stats::create).transpose()?;
        Checkpoint::remove(&self.directory)?;
        let writers = self.writers(&prepared, FrameWriter::create)?;
        Ok(Running::new(self, prepared, writers, stats, fingerprint, None))
    }

    /// Opens the files of a run that continues after a checkpoint.
    fn start_after(
        &self,
        mut prepared: Prepared,
        checkpoint: Checkpoint,
        fingerprint: String,
        observer: &mut dyn Observer,
    ) -> Result<Running<'_>, RunError> {
        let frame = checkpoint.frame;
        let done_number = self.number(frame);
        let resume_writer =
            |sequence, source: Source<'_>| FrameWriter::resume(sequence, source, done_number + 1);
        let writers = match self.writers(&prepared, resume_writer) {
            // The point cache has another point count, first frame or frame interval, or too few frames.
            Err(OutputError::Cache { path, reason }) => {
                let reason = format!("cannot continue {}: {reason}", path.display());
                observer.note(&Note::Restarted { reason });
                return self.start_fresh(prepared, fingerprint);
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
        let stats = self.stats.as_deref().map(|path| Stats::resume(path, done_number)).transpose()?;
        observer.note(&Note::Resumed { frame });
        Ok(Running::new(self, prepared, writers, stats, fingerprint, Some(frame)))
    }

    /// Creates the frame writer of each body with `new_writer`.
    fn writers(
        &self,
        prepared: &Prepared,
        new_writer: impl Fn(Sequence, Source<'_>) -> Result<FrameWriter, OutputError>,
    ) -> Result<Vec<FrameWriter>, OutputError> {
        let writer_of_body = |(sequence, input): (Sequence, &Input)| {
            let mut writer = new_writer(sequence, input.source())?;
            writer.set_executor(prepared.simulation.executor());
            Ok(writer)
        };
        self.sequences().into_iter().zip(&prepared.inputs).map(writer_of_body).collect()
    }

    /// Returns the report of a job that was finished before this run.
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
