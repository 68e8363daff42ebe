//! Runs the frame loop of a job: advances the simulation, writes frames and statistics, and saves checkpoints.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::caution::Caution;
use super::checkpoint::Checkpoint;
use super::deviation::{CrushRecord, Softened, VolumeRecord, VolumeRemedy};
use super::error::RunError;
use super::job::Job;
use super::observer::{Flow, Note, Observer, Progress};
use super::output::Output;
use super::pace::Pace;
use super::prepare::{Input, Prepared};
use super::report::{BodyReport, Outcome, RunReport};
use super::states;
use super::stats::{Row, Stats, Times, Touching};
use crate::file::sync_directory;
use crate::frames::{Ending, SetAside};
use supple::Simulation;

/// The output files of a job.
pub(super) struct Files {
    pub(super) output: Output,
    pub(super) stats: Option<Stats>,
    /// Frames of an older run that this job replaces.
    pub(super) aside: SetAside,
}

/// A running job: its simulation, open files and counters.
pub(super) struct Running<'a> {
    job: &'a Job,
    /// Simulation, shared with the observer. It is locked while a frame is computed.
    simulation: Arc<Mutex<Simulation>>,
    substeps: u32,
    pace: Pace,
    inputs: Vec<Input>,
    /// What the author of the scene probably does not expect.
    cautions: Vec<Caution>,
    output: Output,
    stats: Option<Stats>,
    /// Frames of an older run that are not replaced yet. They are removed when the job ends.
    _aside: SetAside,
    /// Checkpoint of the last written frame. It is written from time to time.
    checkpoint: Checkpoint,
    /// Frame of the checkpoint that this run resumes from, from 0; `None` if this run starts at frame 0.
    resumed_after: Option<u32>,
    /// Wall-clock time of the steps since the last row of statistics.
    step_time: Duration,
    /// Number of frames written so far; a frame of all bodies counts once.
    written: u32,
    /// Volume errors of the frames written so far, one record per body.
    volumes: Vec<VolumeRecord>,
    crushes: Vec<CrushRecord>,
}

impl<'a> Running<'a> {
    pub(super) fn new(
        job: &'a Job,
        prepared: Prepared,
        files: Files,
        checkpoint: Checkpoint,
        resumed_after: Option<u32>,
    ) -> Self {
        let Prepared { simulation, substeps, inputs, cautions } = prepared;
        let Files { output, stats, aside } = files;
        Self {
            job,
            simulation: Arc::new(Mutex::new(simulation)),
            pace: Pace::new(&job.scene.simulation.time_scale, job.scene.simulation.fps, substeps),
            substeps,
            inputs,
            cautions,
            output,
            stats,
            _aside: aside,
            checkpoint,
            resumed_after,
            step_time: Duration::ZERO,
            written: 0,
            volumes: Vec::new(),
            crushes: Vec::new(),
        }
    }

    /// Runs to the last frame, or until the observer returns [`Flow::Stop`]. `job_start` is the start of the
    /// job, which includes reading its input.
    pub(super) fn run(
        mut self,
        job_start: Instant,
        observer: &mut dyn Observer,
    ) -> Result<RunReport, RunError> {
        let last = self.job.scene.simulation.frames;
        let first = self.resumed_after.map_or(0, |frame| frame + 1);
        let shared = self.simulation.clone();
        observer.built(&shared, &self.inputs);
        if self.resumed_after.is_none() {
            self.cautions.drain(..).for_each(|caution| observer.note(&Note::Caution(caution)));
        }
        observer.started(first, last);
        let loop_start = Instant::now();
        let mut last_save = Instant::now();
        for frame in first..=last {
            let mut simulation = lock(&shared);
            if frame > 0 {
                let steps_start = Instant::now();
                let steps = self.pace.begin_frame(&mut simulation, frame).map_err(RunError::Simulation)?;
                simulation.steps(steps);
                self.step_time += steps_start.elapsed();
            }
            if self.job.is_written(frame) {
                self.write_frame(&simulation, frame)?;
            }
            let time = simulation.time();
            drop(simulation);
            let progress = Progress { frame, last, time, elapsed: loop_start.elapsed() };
            let stop = observer.frame(&progress) == Flow::Stop;
            let simulation = lock(&shared);
            if self.job.keeps_state(frame) {
                self.keep_state(&simulation, frame)?;
            }
            if stop || frame == last {
                self.output.sync()?;
                // A run that ends before its files are complete completes them when it is resumed.
                self.save(&simulation, frame)?;
                let (outcome, ending) = match frame == last {
                    true => (Outcome::Finished, Ending::Complete),
                    false => (Outcome::Stopped, Ending::Stopped),
                };
                let files = self.output.finish(ending)?;
                self.job.write_manifest(&self.checkpoint, outcome)?;
                return Ok(RunReport { files, ..self.report(&simulation, outcome, first, frame, job_start) });
            }
            if last_save.elapsed() >= self.job.checkpoint_interval {
                self.output.sync()?;
                self.save(&simulation, frame)?;
                last_save = Instant::now();
            }
        }
        // Reached only if a job resumes after its last frame; `Job::run` does not start such a job.
        Ok(self.report(&lock(&shared), Outcome::AlreadyFinished, first, last, job_start))
    }

    /// Writes frame `frame`, counted from 0, of every body, and one row of statistics per body.
    fn write_frame(&mut self, simulation: &Simulation, frame: u32) -> Result<(), RunError> {
        let Self { output, stats, checkpoint, volumes, crushes, inputs, .. } = self;
        let (number, bodies) = (self.job.number(frame), simulation.bodies().len());
        let step_time = std::mem::take(&mut self.step_time);
        let mut rows = Vec::new();
        let contacts = if stats.is_some() { simulation.contacts() } else { Vec::new() };
        volumes.resize_with(bodies, VolumeRecord::default);
        crushes.resize_with(bodies, CrushRecord::default);
        output.write(number, simulation, inputs, &mut checkpoint.frames, |index, frame, evaluated| {
            let displayed = frame.displayed;
            volumes[index].add(number, displayed.corrections());
            crushes[index].add(displayed.untangling());
            if stats.is_some() {
                let body = simulation.body(index);
                let volumes = frame.volumes();
                let step = step_time.div_f64(bodies as f64);
                let times = Times { step, write: evaluated.elapsed(), display: displayed.times() };
                let touching = Touching::of(index, &body, &contacts);
                rows.push(Row::new(number, simulation.time(), &body, volumes, times, touching));
            }
        })?;
        self.written += 1;
        match stats {
            Some(stats) => stats.append_rows(&rows),
            None => Ok(()),
        }
    }

    /// Writes a checkpoint of the state after `frame`. Everything that it lists is on disk before.
    fn save(&mut self, simulation: &Simulation, frame: u32) -> Result<(), RunError> {
        self.update_checkpoint(frame)?;
        self.checkpoint.write(&self.job.directory, &simulation.state())
    }

    /// Keeps the state after `frame` beside the frames. Everything that it lists is on disk before.
    fn keep_state(&mut self, simulation: &Simulation, frame: u32) -> Result<(), RunError> {
        self.output.sync()?;
        self.update_checkpoint(frame)?;
        let path = states::path(&self.job.directory, self.job.number(frame));
        self.checkpoint.write_to(&path, &simulation.state())
    }

    /// Brings the checkpoint up to `frame`, with the names of its files on disk.
    fn update_checkpoint(&mut self, frame: u32) -> Result<(), RunError> {
        let directory = &self.job.directory;
        sync_directory(directory).map_err(|source| RunError::io("write", directory, source))?;
        self.checkpoint.frame = frame;
        self.checkpoint.stats = match &self.stats {
            Some(stats) => {
                stats.sync()?;
                Some(stats.record())
            }
            None => None,
        };
        Ok(())
    }

    /// Returns the report of the body with the given index.
    fn body_report(&self, simulation: &Simulation, index: usize) -> BodyReport {
        let body = simulation.body(index);
        // Empty if this run wrote no frame.
        let remedy = || VolumeRemedy::of(simulation, index);
        let unkept = self.volumes.get(index).and_then(|record| record.unkept(remedy));
        let softened = Softened::of(body, self.substeps, simulation.dt());
        let crushed = self.crushes.get(index).and_then(CrushRecord::crushed);
        BodyReport::new(body, unkept, crushed, softened)
    }

    /// Returns the report of a run from frame `first` to frame `last`.
    fn report(
        &self,
        simulation: &Simulation,
        outcome: Outcome,
        first: u32,
        last: u32,
        job_start: Instant,
    ) -> RunReport {
        RunReport {
            directory: self.job.directory.clone(),
            outcome,
            resumed_after: self.resumed_after,
            last,
            simulated: (last + 1).saturating_sub(first),
            written: self.written,
            substeps: self.substeps,
            elapsed: job_start.elapsed(),
            bodies: (0..simulation.bodies().len()).map(|index| self.body_report(simulation, index)).collect(),
            files: Vec::new(),
        }
    }
}

/// Locks the simulation and ignores poisoning: a panic in a step ends the job, and all calls with which an
/// observer can change the simulation leave it in a valid state.
fn lock(simulation: &Mutex<Simulation>) -> MutexGuard<'_, Simulation> {
    simulation.lock().unwrap_or_else(PoisonError::into_inner)
}
