//! Frame after frame: steps, a display of each body, the files written, a checkpoint now and then.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::checkpoint::Checkpoint;
use super::error::RunError;
use super::job::Job;
use super::observer::{Flow, Observer, Progress};
use super::prepare::{Input, Prepared};
use super::report::{BodyReport, Outcome, RunReport};
use super::stats::{Row, Stats, Times};
use crate::frames::FrameWriter;
use supple::{Display, Simulation};

/// A job under way.
pub(super) struct Running<'a> {
    job: &'a Job,
    /// Shared with the observer, and locked while a frame is worked on.
    simulation: Arc<Mutex<Simulation>>,
    substeps: u32,
    inputs: Vec<Input>,
    /// One for each body.
    writers: Vec<FrameWriter>,
    stats: Option<Stats>,
    fingerprint: String,
    /// The frame after which this run goes on.
    after: Option<u32>,
    /// Steps since the last row of statistics.
    stepping: Duration,
    written: u32,
    /// One per body.
    displays: Vec<Display>,
    /// One per mesh vertex of the body that is being written.
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl<'a> Running<'a> {
    pub(super) fn new(
        job: &'a Job,
        prepared: Prepared,
        writers: Vec<FrameWriter>,
        stats: Option<Stats>,
        fingerprint: String,
        after: Option<u32>,
    ) -> Self {
        let Prepared { simulation, substeps, inputs } = prepared;
        Self {
            job,
            simulation: Arc::new(Mutex::new(simulation)),
            substeps,
            inputs,
            writers,
            stats,
            fingerprint,
            after,
            stepping: Duration::ZERO,
            written: 0,
            displays: Vec::new(),
            positions: Vec::new(),
            normals: Vec::new(),
        }
    }

    /// Runs to the last frame, or until the observer asks to stop.
    pub(super) fn run(mut self, begun: Instant, observer: &mut dyn Observer) -> Result<RunReport, RunError> {
        let last = self.job.scene.simulation.frames;
        let first = self.after.map_or(0, |frame| frame + 1);
        let shared = self.simulation.clone();
        observer.built(&shared, &self.inputs);
        observer.started(first, last);
        let started = Instant::now();
        let mut saved = Instant::now();
        for frame in first..=last {
            let mut simulation = locked(&shared);
            if frame > 0 {
                let stepping = Instant::now();
                simulation.steps(u64::from(self.substeps));
                self.stepping += stepping.elapsed();
            }
            if self.job.keeps(frame) {
                self.write_frame(&simulation, frame)?;
            }
            let time = simulation.time();
            drop(simulation);
            let progress = Progress { frame, last, time, elapsed: started.elapsed() };
            let stop = observer.frame(&progress) == Flow::Stop;
            let simulation = locked(&shared);
            if stop || frame == last {
                std::mem::take(&mut self.writers).into_iter().try_for_each(FrameWriter::finish)?;
                self.save(&simulation, frame)?;
                let outcome = if frame == last { Outcome::Finished } else { Outcome::Stopped };
                return Ok(self.report(&simulation, outcome, first, frame, begun));
            }
            if saved.elapsed() >= self.job.checkpoint_interval {
                self.save(&simulation, frame)?;
                saved = Instant::now();
            }
        }
        // Only a job that goes on after its last frame comes here, and such a job is not begun.
        Ok(self.report(&locked(&shared), Outcome::AlreadyFinished, first, last, begun))
    }

    /// Writes a frame of every body, and its statistics.
    fn write_frame(&mut self, simulation: &Simulation, frame: u32) -> Result<(), RunError> {
        let stepping = std::mem::take(&mut self.stepping);
        let number = self.job.number(frame);
        let mut rows = Vec::new();
        self.displays.resize_with(simulation.bodies().len(), Display::new);
        for (index, display) in self.displays.iter_mut().enumerate() {
            let body = simulation.body(index);
            let vertices = body.mesh().map_or(0, |mesh| mesh.vertices().len());
            let needs_normals = self.writers[index].needs_normals();
            self.positions.resize(vertices, [0.0; 3]);
            self.normals.resize(if needs_normals { vertices } else { 0 }, [0.0; 3]);
            let normals = needs_normals.then_some(&mut self.normals[..]);
            let mut shown = display.evaluate(body);
            shown.surface_into(&mut self.positions, normals);
            let writing = Instant::now();
            self.writers[index].write(number, &self.positions, &self.normals)?;
            if self.stats.is_some() {
                let write = writing.elapsed();
                let step = stepping.div_f64(simulation.bodies().len() as f64);
                let times = Times { step, write, display: shown.times() };
                rows.push(Row::of(number, simulation.time(), &body, &shown.volume_report(), times));
            }
        }
        self.written += 1;
        match &mut self.stats {
            Some(stats) => stats.push(&rows),
            None => Ok(()),
        }
    }

    fn save(&self, simulation: &Simulation, frame: u32) -> Result<(), RunError> {
        let checkpoint = Checkpoint {
            fingerprint: self.fingerprint.clone(),
            level: supple::simd_level().to_string(),
            frame,
            state: simulation.state(),
        };
        checkpoint.write(&self.job.directory)
    }

    fn report(
        &self,
        simulation: &Simulation,
        outcome: Outcome,
        first: u32,
        last: u32,
        begun: Instant,
    ) -> RunReport {
        RunReport {
            directory: self.job.directory.clone(),
            outcome,
            resumed_after: self.after,
            last,
            simulated: (last + 1).saturating_sub(first),
            written: self.written,
            substeps: self.substeps,
            elapsed: begun.elapsed(),
            bodies: (0..simulation.bodies().len())
                .map(|body| BodyReport::of(simulation.body(body)))
                .collect(),
        }
    }
}

/// Ignores poisoning: a panic in a step ends the job, and the calls by which observers change a simulation each leave it
/// whole.
fn locked(simulation: &Mutex<Simulation>) -> MutexGuard<'_, Simulation> {
    simulation.lock().unwrap_or_else(PoisonError::into_inner)
}
