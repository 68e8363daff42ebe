//! Frame after frame: steps, a look, what is written, a checkpoint now and then.

use std::time::{Duration, Instant};

use super::checkpoint::Checkpoint;
use super::error::RunError;
use super::job::Job;
use super::observer::{Flow, Observer, Progress};
use super::prepare::Prepared;
use super::report::{BodyReport, Outcome, RunReport};
use super::sinks::Sinks;
use super::stats::{Row, Stats};

/// A job under way.
pub(super) struct Running<'a> {
    job: &'a Job,
    prepared: Prepared,
    sinks: Sinks,
    stats: Option<Stats>,
    fingerprint: String,
    /// The frame after which this run goes on.
    after: Option<u32>,
    /// Steps since the last row of statistics.
    stepping: Duration,
    written: u32,
    bytes: u64,
    bodies: Vec<BodyReport>,
}

impl<'a> Running<'a> {
    pub(super) fn new(
        job: &'a Job,
        prepared: Prepared,
        sinks: Sinks,
        stats: Option<Stats>,
        fingerprint: String,
        after: Option<u32>,
    ) -> Self {
        let report = |body: &crate::Body| BodyReport {
            name: body.name().to_owned(),
            lattice_vertices: body.lattice().len(),
            volume_rest: 0.0,
            volume_drift: 0.0,
            capped: 0,
        };
        let bodies = prepared.simulation.bodies().iter().map(report).collect();
        Self {
            job,
            prepared,
            sinks,
            stats,
            fingerprint,
            after,
            stepping: Duration::ZERO,
            written: 0,
            bytes: 0,
            bodies,
        }
    }

    /// Runs to the last frame, or until the observer asks to stop.
    pub(super) fn run(mut self, begun: Instant, observer: &mut dyn Observer) -> Result<RunReport, RunError> {
        let last = self.job.scene.simulation.frames;
        let first = self.after.map_or(0, |frame| frame + 1);
        observer.started(first, last);
        let started = Instant::now();
        let mut saved = Instant::now();
        for frame in first..=last {
            if frame > 0 {
                let stepping = Instant::now();
                self.prepared.simulation.steps(u64::from(self.prepared.substeps));
                self.stepping += stepping.elapsed();
            }
            if self.job.numbering().keeps(frame) {
                self.look(frame)?;
            }
            let time = self.prepared.simulation.time();
            let progress = Progress { frame, last, time, elapsed: started.elapsed() };
            let stop = observer.frame(&progress) == Flow::Stop;
            if stop || frame == last {
                self.sinks.finish()?;
                self.save(frame)?;
                let outcome = if frame == last { Outcome::Finished } else { Outcome::Stopped };
                return Ok(self.report(outcome, first, frame, begun));
            }
            if saved.elapsed() >= self.job.checkpoint_interval {
                self.sinks.flush()?;
                self.save(frame)?;
                saved = Instant::now();
            }
        }
        // Only a job that goes on after its last frame comes here, and such a job is not begun.
        Ok(self.report(Outcome::AlreadyFinished, first, last, begun))
    }

    /// Writes a frame of every body, and its statistics.
    fn look(&mut self, frame: u32) -> Result<(), RunError> {
        let stepping = std::mem::take(&mut self.stepping);
        let count = self.prepared.simulation.bodies().len();
        let time = self.prepared.simulation.time();
        let mut rows = Vec::with_capacity(count);
        for index in 0..count {
            let body = &mut self.prepared.simulation.bodies_mut()[index];
            let look = body.look();
            let writing = Instant::now();
            self.bytes += self.sinks.write(index, frame, look.positions, look.normals)?;
            self.written += 1;
            let report = &mut self.bodies[index];
            report.volume_rest = look.report.rest;
            report.volume_drift = report.volume_drift.max((look.report.after / look.report.rest - 1.0).abs());
            report.capped += u32::from(look.report.capped);
            rows.push(Row {
                frame: self.job.numbering().number(frame),
                time,
                body: report.name.clone(),
                ms_step: milliseconds(stepping) / count as f64,
                ms_volume: milliseconds(look.volume_time),
                ms_embed: milliseconds(look.embed_time),
                ms_write: milliseconds(writing.elapsed()),
                volume_rest: look.report.rest,
                volume_before: look.report.before,
                volume_after: look.report.after,
                lambda: look.report.lambda,
                residual: look.report.residual,
                capped: look.report.capped,
                energy_kinetic: body.kinetic_energy(),
                max_speed: body.max_speed(),
            });
        }
        match &mut self.stats {
            Some(stats) => stats.push(&rows),
            None => Ok(()),
        }
    }

    fn save(&self, frame: u32) -> Result<(), RunError> {
        let checkpoint = Checkpoint {
            fingerprint: self.fingerprint.clone(),
            level: crate::simd_level().to_string(),
            frame,
            state: self.prepared.simulation.state(),
        };
        checkpoint.write(&self.job.directory)
    }

    fn report(self, outcome: Outcome, first: u32, last: u32, begun: Instant) -> RunReport {
        RunReport {
            directory: self.job.directory.clone(),
            outcome,
            resumed_after: self.after,
            last,
            simulated: (last + 1).saturating_sub(first),
            written: self.written,
            bytes: self.bytes,
            substeps: self.prepared.substeps,
            elapsed: begun.elapsed(),
            bodies: self.bodies,
        }
    }
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}
