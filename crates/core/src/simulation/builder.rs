//! From bodies and numbers to a simulation.

use super::{Clock, Simulation};
use crate::body::Body;
use crate::contact::{Collider, Colliders};
use crate::error::Error;
use crate::parallel::Executor;
use crate::range::in_range;

/// More threads than a simulation can use, and few enough to start.
const MOST_THREADS: usize = 1024;

/// What a [`Simulation`] is built from.
#[derive(Debug)]
pub struct SimulationBuilder {
    bodies: Vec<Body>,
    gravity: [f64; 3],
    dt: f64,
    colliders: Vec<Collider>,
    substeps: u64,
    threads: usize,
}

impl Default for SimulationBuilder {
    fn default() -> Self {
        Self {
            bodies: Vec::new(),
            gravity: [0.0, -9.81, 0.0],
            dt: 1.0 / 60.0,
            colliders: Vec::new(),
            substeps: 1,
            threads: 0,
        }
    }
}

impl SimulationBuilder {
    /// Adds a body.
    #[must_use]
    pub fn body(mut self, body: Body) -> Self {
        self.bodies.push(body);
        self
    }

    /// Gravity in scene units per second squared; default (0, -9.81, 0).
    #[must_use]
    pub fn gravity(mut self, gravity: [f64; 3]) -> Self {
        self.gravity = gravity;
        self
    }

    /// Length of a step in seconds, > 0; default 1/60.
    #[must_use]
    pub fn dt(mut self, dt: f64) -> Self {
        self.dt = dt;
        self
    }

    /// Adds a collider.
    #[must_use]
    pub fn collider(mut self, collider: Collider) -> Self {
        self.colliders.push(collider);
        self
    }

    /// Steps that make a frame, at least 1; default 1. Contacts of all steps since the last frame count in the
    /// volume correction that is shown.
    #[must_use]
    pub fn substeps(mut self, substeps: u64) -> Self {
        self.substeps = substeps;
        self
    }

    /// Threads, at most 1024; 0, the default, takes one for each processor. Without the feature `rayon` there is one.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads;
        self
    }

    /// The simulation, at time zero.
    ///
    /// # Errors
    ///
    /// No body, a number out of its range, a collider that makes no sense.
    pub fn build(self) -> Result<Simulation, Error> {
        let colliders = self.checked_colliders()?;
        if self.bodies.is_empty() {
            return Err(Error::NoBody);
        }
        let mut bodies = self.bodies;
        bodies.iter_mut().for_each(|body| body.meet(&colliders));
        Ok(Simulation {
            bodies,
            gravity: self.gravity.into(),
            clock: Clock::new(self.dt),
            colliders,
            substeps: self.substeps,
            executor: Executor::new(self.threads),
        })
    }

    /// Checks all but the bodies.
    ///
    /// # Errors
    ///
    /// A number out of its range, a collider that makes no sense.
    pub fn validate(&self) -> Result<(), Error> {
        self.checked_colliders().map(drop)
    }

    fn checked_colliders(&self) -> Result<Colliders, Error> {
        check_dt(self.dt)?;
        check_threads(self.threads)?;
        in_range("substeps", self.substeps as f64, self.substeps > 0, "at least 1")?;
        check_gravity(self.gravity)?;
        Ok(Colliders::new(&self.colliders)?)
    }
}

pub(super) fn check_dt(dt: f64) -> Result<(), Error> {
    in_range("dt", dt, (1e-12..=1e6).contains(&dt), "a time in seconds, from 1e-12 to 1e6")?;
    Ok(())
}

pub(super) fn check_gravity(gravity: [f64; 3]) -> Result<(), Error> {
    for g in gravity {
        in_range("gravity", g, g.abs() <= 1e12, "at most 1e12")?;
    }
    Ok(())
}

pub(super) fn check_threads(threads: usize) -> Result<(), Error> {
    in_range("threads", threads as f64, threads <= MOST_THREADS, "at most 1024 (0: all processors)")?;
    Ok(())
}
