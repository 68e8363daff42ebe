//! Bodies and time.

mod clock;
#[cfg(feature = "scene")]
mod state;

#[cfg(feature = "scene")]
pub use state::SimulationState;

use nalgebra::Vector3;

use crate::body::{Body, World, in_range};
use crate::dynamics::{Collider, Colliders};
use crate::error::Error;
use crate::parallel::Executor;
use crate::plan::Plan;
use clock::Clock;

/// More threads than any machine makes use of here, and fewer than one chokes on.
const MOST_THREADS: usize = 1024;

/// Bodies that move through time, each by itself, among colliders. Contact between bodies is not simulated.
///
/// The result has the same bits for any number of threads.
#[derive(Debug)]
pub struct Simulation {
    bodies: Vec<Body>,
    gravity: Vector3<f64>,
    clock: Clock,
    colliders: Option<Colliders>,
    substeps: u64,
    executor: Executor,
}

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
        let colliders = self.validate()?;
        if self.bodies.is_empty() {
            return Err(Error::NoBody);
        }
        let mut bodies = self.bodies;
        bodies.iter_mut().for_each(|body| body.meet(colliders.is_some(), self.dt));
        Ok(Simulation {
            bodies,
            gravity: self.gravity.into(),
            clock: Clock::new(self.dt),
            colliders,
            substeps: self.substeps,
            executor: Executor::new(self.threads),
        })
    }

    /// Whether [`SimulationBuilder::build`] will have nothing to object to but a lack of bodies; what bodies will
    /// meet.
    ///
    /// # Errors
    ///
    /// A number out of its range, a collider that makes no sense.
    pub fn validate(&self) -> Result<Option<Colliders>, Error> {
        check_dt(self.dt)?;
        in_range("substeps", self.substeps as f64, self.substeps > 0, "at least 1")?;
        let threads = self.threads;
        in_range("threads", threads as f64, threads <= MOST_THREADS, "at most 1024 (0: all processors)")?;
        check_gravity(self.gravity)?;
        Ok(Colliders::new(&self.colliders)?)
    }
}

impl Simulation {
    /// A simulation of nothing yet.
    pub fn builder() -> SimulationBuilder {
        SimulationBuilder::default()
    }

    /// One step of length `dt`.
    pub fn step(&mut self) {
        self.steps(1);
    }

    /// `count` steps of length `dt`.
    pub fn steps(&mut self, count: u64) {
        let executor = self.executor.clone();
        executor.enter(|| {
            for _ in 0..count {
                self.step_bodies(&executor);
            }
        });
    }

    fn step_bodies(&mut self, executor: &Executor) {
        let world = World {
            gravity: self.gravity,
            interval: self.clock.interval(),
            colliders: self.colliders.as_ref(),
            opens_frame: self.clock.steps().is_multiple_of(self.substeps),
        };
        executor.each(&mut self.bodies, |body| body.step(&world, executor));
        self.clock.tick();
    }

    /// What is done in a step and in a look.
    pub fn plan(&self) -> Plan {
        let bodies = self.bodies.iter().map(Body::plan).collect();
        Plan { dt: self.dt(), substeps: self.substeps, threads: self.threads(), bodies }
    }

    /// Length of a step in seconds.
    pub fn dt(&self) -> f64 {
        self.clock.dt()
    }

    /// Sets the length of a step in seconds, > 0, from the next step on. Time stays.
    ///
    /// # Errors
    ///
    /// A number out of its range.
    pub fn set_dt(&mut self, dt: f64) -> Result<(), Error> {
        check_dt(dt)?;
        self.clock.set_dt(dt);
        self.bodies.iter_mut().for_each(|body| body.set_dt(dt));
        Ok(())
    }

    /// Time in seconds: steps x dt, never a running sum, since dt or time were set last.
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Sets the time in seconds: pins, handles and moving colliders go by it.
    ///
    /// # Errors
    ///
    /// A number that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<(), Error> {
        in_range("time", time, true, "finite")?;
        self.clock.set_time(time);
        Ok(())
    }

    /// Steps so far.
    pub fn step_count(&self) -> u64 {
        self.clock.steps()
    }

    /// Steps that make a frame.
    pub fn substeps(&self) -> u64 {
        self.substeps
    }

    /// Threads that work.
    pub fn threads(&self) -> usize {
        self.executor.threads()
    }

    /// Sets the threads; 0 takes one for each processor. The results have the same bits for any number.
    pub fn set_threads(&mut self, threads: usize) {
        self.executor = Executor::new(threads);
    }

    /// Forgets the threads, as a process must that was forked: they are not in it. Works alone from then on.
    pub fn abandon_threads(&mut self) {
        // To let them go would mean to wake them.
        std::mem::forget(std::mem::take(&mut self.executor));
    }

    /// Sets the colliders, from the next step on.
    ///
    /// # Errors
    ///
    /// A collider that makes no sense; nothing is changed then.
    pub fn set_colliders(&mut self, colliders: &[Collider]) -> Result<(), Error> {
        self.colliders = Colliders::new(colliders)?;
        let (any, dt) = (self.colliders.is_some(), self.dt());
        self.bodies.iter_mut().for_each(|body| body.meet(any, dt));
        Ok(())
    }

    /// Gravity in scene units per second squared.
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity.into()
    }

    /// Sets gravity, from the next step on.
    ///
    /// # Errors
    ///
    /// A number that is not finite.
    pub fn set_gravity(&mut self, gravity: [f64; 3]) -> Result<(), Error> {
        check_gravity(gravity)?;
        self.gravity = gravity.into();
        Ok(())
    }

    /// The bodies, in the order in which they were added.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The bodies, to change.
    pub fn bodies_mut(&mut self) -> &mut [Body] {
        &mut self.bodies
    }

    /// One body.
    ///
    /// # Panics
    ///
    /// If there are not so many.
    pub fn body(&self, index: usize) -> &Body {
        &self.bodies[index]
    }

    /// One body, to change.
    ///
    /// # Panics
    ///
    /// If there are not so many.
    pub fn body_mut(&mut self, index: usize) -> &mut Body {
        &mut self.bodies[index]
    }
}

fn check_dt(dt: f64) -> Result<(), Error> {
    in_range("dt", dt, dt > 0.0, "a time in seconds, > 0")?;
    Ok(())
}

fn check_gravity(gravity: [f64; 3]) -> Result<(), Error> {
    for g in gravity {
        in_range("gravity", g, true, "finite")?;
    }
    Ok(())
}
