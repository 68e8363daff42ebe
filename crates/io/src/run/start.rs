//! Starts a job: checks its input, and opens the files.

use std::time::Instant;

use super::advance::{Files, Running};
use super::checkpoint::Checkpoint;
use super::error::RunError;
use super::fingerprint::fingerprint;
use super::job::{Job, Resume};
use super::lock::Lock;
use super::manifest;
use super::observer::{Flow, Note, Observer};
use super::output::Output;
use super::pace::Pace;
use super::prepare::{Input, Prepared};
use super::preroll::preroll;
use super::report::{Outcome, RunReport};
use super::resume::{Earlier, Start};
use super::settings::Settings;
use super::states;
use super::stats::Stats;
use crate::frames::{Ending, FrameRun, Listing, SetAside, check_run, open_sink};

impl Job {
    /// Runs the job. All input is checked before any frame is written.
    ///
    /// A frame gets its final name only when it is complete.
    ///
    /// With [`Resume::Yes`], a finished sequence is not changed. A sequence that was stopped, or that has
    /// more frames in this job, continues after its checkpoint; its frames are bit-identical to the frames of
    /// an uninterrupted run, also on another machine. If there is no checkpoint, or a frame is missing or has
    /// another size than in the checkpoint, the job starts at frame 0. It is an error if the motion, the
    /// format, the numbers of the frames or the version of the program differ from the checkpoint, if
    /// [`Job::stats`] was set and is not or the reverse, and if rows of the statistics are lost. With
    /// [`Resume::Auto`], the job starts at frame 0 in these cases too.
    ///
    /// With [`Job::from`], the job continues after a kept state with the scene as it is now.
    ///
    /// # Errors
    ///
    /// If the input is invalid or the run fails; [`RunError::is_input`] distinguishes the two.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<RunReport, RunError> {
        let job_start = Instant::now();
        self.check()?;
        let settings = self.settings(fingerprint(&self.scene)?);

        let mut lock = None;
        let mut start = Start::Fresh;
        if let Some(from) = self.from.map(u64::from).filter(|&from| from > self.number(0)) {
            if self.directory.is_dir() {
                lock = Some(Lock::acquire(&self.directory)?);
            }
            start = Start::After(Box::new(self.find_state(&settings, from)?));
        } else if self.resume != Resume::No && self.directory.is_dir() {
            lock = Some(Lock::acquire(&self.directory)?);
            start = self.choose_start(&settings, observer)?;
        }
        if let Start::Finished { checkpoint, unfinished } = &start
            && unfinished.is_empty()
        {
            return self.already_finished(checkpoint, job_start);
        }

        let mut prepared = observer.prepare(&self.scene)?;
        prepared.check_topologies(&self.scene.output.format)?;
        let new_run = self.frame_run(&prepared, None);
        self.sequences()
            .iter()
            .try_for_each(|sequence| check_run(sequence, self.body_of(sequence), &new_run))?;
        if let Start::Finished { checkpoint, unfinished } = start {
            // The files of a run with more frames can be continued.
            let is_longer = checkpoint.frame > self.scene.simulation.frames;
            let ending = if is_longer { Ending::Stopped } else { Ending::Complete };
            if !is_longer {
                manifest::remove(&self.directory)?;
            }
            let mut files = Vec::new();
            for (sequence, frames) in unfinished {
                let body = self.body_of(&sequence);
                let sink = open_sink(sequence, body, &self.frame_run(&prepared, Some(frames)))?;
                files.extend(sink.finish(ending)?);
            }
            return Ok(RunReport { files, ..self.already_finished(&checkpoint, job_start)? });
        }
        if let Start::After(earlier) = &start {
            let changes = earlier.changes.as_ref();
            if let Err(error) = prepared.restore(&earlier.state, changes, &earlier.path) {
                start = self.start_again(error, observer)?;
            }
        }
        let simulation = &self.scene.simulation;
        Pace::new(&simulation.time_scale, simulation.fps, prepared.substeps).check()?;
        // No file is changed before this: all checks are done.
        let _lock = match lock {
            Some(lock) => lock,
            None => self.create_directory()?,
        };
        let running = match start {
            Start::After(earlier) => self.start_after(prepared, *earlier, settings, observer)?,
            _ => {
                let proceed = |done| observer.preroll(done) == Flow::Continue;
                match preroll(&mut prepared.simulation, simulation.preroll, proceed) {
                    Ok(true) => self.start_fresh(prepared, settings)?,
                    Ok(false) => return Err(RunError::Stopped),
                    Err(error) => return Err(RunError::Simulation(error)),
                }
            }
        };
        running.run(job_start, observer)
    }

    /// Returns the run whose files are opened, which keep `kept` frames.
    fn frame_run<'a>(&self, prepared: &'a Prepared, kept: Option<u64>) -> FrameRun<'a> {
        FrameRun {
            simulation: &prepared.simulation,
            sources: prepared.inputs.iter().map(Input::source).collect(),
            name: self.name(),
            fps: self.fps(),
            space: self.space(),
            options: self.scene.output.format_options(),
            kept,
        }
    }

    /// Creates the output directory and acquires its lock.
    fn create_directory(&self) -> Result<Lock, RunError> {
        std::fs::create_dir_all(&self.directory)
            .map_err(|source| RunError::io("create the output directory", &self.directory, source))?;
        Lock::acquire(&self.directory)
    }

    /// Opens the files of a run from frame 0, and removes or sets aside an existing sequence.
    fn start_fresh(&self, prepared: Prepared, settings: Settings) -> Result<Running<'_>, RunError> {
        let sequences = self.sequences();
        let existing = Listing::read(&sequences)?;
        let stats = self.stats.as_deref().map(Stats::create).transpose()?;
        manifest::remove(&self.directory)?;
        // The checkpoint is removed first, so that it never describes frames of another run.
        Checkpoint::remove(&self.directory)?;
        states::remove(&self.directory, None)?;
        let aside = existing.set_aside(&sequences)?;
        let checkpoint =
            Checkpoint { settings, frame: 0, frames: vec![Vec::new(); sequences.len()], stats: None };
        let output = Output::open(sequences, &self.frame_run(&prepared, None))?;
        Ok(Running::new(self, prepared, Files { output, stats, aside }, checkpoint, None))
    }

    /// Opens the files of a run that continues after a checkpoint or a kept state, whose state the simulation has. Later
    /// frames and states of a run that continues from a kept state are removed.
    fn start_after(
        &self,
        prepared: Prepared,
        earlier: Earlier,
        settings: Settings,
        observer: &mut dyn Observer,
    ) -> Result<Running<'_>, RunError> {
        let Earlier { mut checkpoint, stats, listing, renames, changes, .. } = earlier;
        let frame = checkpoint.frame;
        let stats = match (&self.stats, stats) {
            (Some(path), Some(rows)) => Some(Stats::resume(path, rows)?),
            _ => None,
        };
        manifest::remove(&self.directory)?;
        if changes.is_some() {
            // From here on, a job that is killed can be resumed with the scene as it is now.
            states::remove(&self.directory, Some(self.number(frame)))?;
            checkpoint.settings = settings;
            checkpoint.write(&self.directory, &prepared.simulation.state())?;
        }
        listing.remove_parts()?;
        renames.apply()?;
        let aside = match changes {
            None => SetAside::default(),
            Some(_) => {
                let sequences = self.sequences();
                Listing::read(&sequences)?.after(self.number(frame)).set_aside(&sequences)?
            }
        };
        let kept = u64::from(frame / self.every) + 1;
        let output = Output::open(self.sequences(), &self.frame_run(&prepared, Some(kept)))?;
        observer.note(&Note::Resumed { frame });
        let files = Files { output, stats, aside };
        Ok(Running::new(self, prepared, files, checkpoint, Some(frame)))
    }

    /// Returns the report of a job that was finished before this run. Writes the manifest if the earlier run was killed
    /// before, or had been stopped at what is now the last frame.
    fn already_finished(&self, checkpoint: &Checkpoint, job_start: Instant) -> Result<RunReport, RunError> {
        let is_whole = checkpoint.frame == self.scene.simulation.frames;
        if is_whole {
            self.write_manifest(checkpoint, Outcome::Finished)?;
        }
        Ok(RunReport {
            directory: self.directory.clone(),
            outcome: Outcome::AlreadyFinished,
            resumed_after: None,
            last: self.scene.simulation.frames,
            simulated: 0,
            written: 0,
            substeps: 0,
            elapsed: job_start.elapsed(),
            bodies: Vec::new(),
            files: Vec::new(),
        })
    }
}
