//! The simulation: bodies, colliders and time.

mod builder;
mod clock;
mod state;

pub use builder::SimulationBuilder;
pub use state::SimulationState;

use nalgebra::Vector3;

use crate::body::{Body, BodyRef, Scene, World};
use crate::contact::{Collider, Colliders};
use crate::error::Error;
use crate::parallel::Executor;
use crate::plan::Plan;
use crate::range::in_range;
use builder::{check_dt, check_gravity, check_threads};
use clock::Clock;

/// Bodies among colliders, and time. Contact between bodies is not simulated.
///
/// The result has the same bits for any number of threads.
#[derive(Debug)]
pub struct Simulation {
    bodies: Vec<Body>,
    gravity: Vector3<f64>,
    clock: Clock,
    colliders: Colliders,
    substeps: u64,
    executor: Executor,
}

impl Simulation {
    /// A builder without bodies.
    pub fn builder() -> SimulationBuilder {
        SimulationBuilder::default()
    }

    /// One step of length `dt`.
    pub fn step(&mut self) {
        self.steps(1);
    }

    /// `count` steps of length `dt`.
    pub fn steps(&mut self, count: u64) {
        // To enter a pool takes longer than a step of a body that is one task.
        let executor = match &self.bodies[..] {
            [body] if body.is_one_task() => Executor::sequential(),
            _ => self.executor.clone(),
        };
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
            opens_frame: self.clock.steps().is_multiple_of(self.substeps),
            colliders: &self.colliders,
        };
        executor.each(&mut self.bodies, |body| body.step(&world, executor));
        self.clock.tick();
    }

    /// The stages of a step and of a display.
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

    /// The threads that steps and displays run on.
    pub fn executor(&self) -> &Executor {
        &self.executor
    }

    /// The number of threads.
    pub fn threads(&self) -> usize {
        self.executor.threads()
    }

    /// Sets the threads, at most 1024; 0 takes one for each processor. The results have the same bits for any number.
    ///
    /// # Errors
    ///
    /// A number out of its range.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), Error> {
        check_threads(threads)?;
        self.executor = Executor::new(threads);
        Ok(())
    }

    /// Abandons the threads: in a forked process they do not exist. Steps run on the calling thread from then on.
    pub fn abandon_threads(&mut self) {
        // To drop the pool would wait for its threads.
        self.executor.abandon();
    }

    /// Sets the colliders, from the next step on.
    ///
    /// # Errors
    ///
    /// A collider that makes no sense; nothing is changed then.
    pub fn set_colliders(&mut self, colliders: &[Collider]) -> Result<(), Error> {
        self.colliders = Colliders::new(colliders)?;
        self.bodies.iter_mut().for_each(|body| body.meet(&self.colliders));
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

    /// The bodies, in the order in which they were added. [`Simulation::body`] gives one to show.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The bodies, to change.
    pub fn bodies_mut(&mut self) -> &mut [Body] {
        &mut self.bodies
    }

    /// One body, with what is needed to show it.
    ///
    /// # Panics
    ///
    /// If there is no body of this index.
    pub fn body(&self, index: usize) -> BodyRef<'_> {
        BodyRef::new(&self.bodies[index], self.scene())
    }

    fn scene(&self) -> Scene<'_> {
        let Self { colliders, executor, .. } = self;
        Scene { colliders, time: self.time(), dt: self.dt(), executor }
    }

    /// One body, to change.
    ///
    /// # Panics
    ///
    /// If there is no body of this index.
    pub fn body_mut(&mut self, index: usize) -> &mut Body {
        &mut self.bodies[index]
    }
}
