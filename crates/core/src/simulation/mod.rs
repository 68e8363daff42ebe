//! The simulation: bodies, colliders and time. [`Simulation::step`] advances the bodies and the time.

mod builder;
mod clock;
mod collider;
mod contact;
mod contact_points;
mod load;
mod state;
mod substeps;

pub use builder::SimulationBuilder;
pub use collider::{ColliderMut, ColliderRef};
pub use contact_points::{ContactPoint, Touched};
pub use state::SimulationState;
pub use substeps::{ChosenSubsteps, StepReason, Substeps};

use nalgebra::Vector3;

use crate::body::{Body, BodyContactPart, BodyRef, DisplayContext, NearBodies, StepContext};
use crate::contact::bodies::BodyContacts;
use crate::contact::{Collider, Colliders};
use crate::error::Error;
use crate::matching::Workspaces;
use crate::parallel::Executor;
use crate::plan::Plan;
use crate::range::in_range;
use crate::state::PairSupports;
use builder::{check_dt, check_gravity, check_substeps, check_threads};
use clock::Clock;
use contact::{ContactSettings, Groups};

/// Simulates bodies that touch each other and colliders.
///
/// Results are bit-identical for any number of threads.
#[derive(Debug)]
pub struct Simulation {
    bodies: Vec<Body>,
    gravity: Vector3<f64>,
    clock: Clock,
    colliders: Colliders,
    /// The contacts between bodies, if bodies can touch.
    contacts: Option<BodyContacts>,
    contact: ContactSettings,
    pair_supports: PairSupports,
    groups: Groups,
    /// Frames per second, if they were given in place of the step length.
    fps: Option<f64>,
    /// Number of steps per frame.
    substeps: u64,
    /// The last choice of the number of steps per frame, if it is automatic.
    chosen: Option<ChosenSubsteps>,
    /// Whether the next step chooses the number of steps per frame.
    choose_at_next_step: bool,
    sleep: bool,
    workspaces: Workspaces,
    executor: Executor,
}

impl Simulation {
    /// Creates a builder without bodies.
    pub fn builder() -> SimulationBuilder {
        SimulationBuilder::default()
    }

    /// Advances all bodies by one step of length `dt`: see [the pipeline](crate#the-pipeline).
    ///
    /// A step does not evaluate the displayed surface (volume correction, mesh update): see
    /// [`Simulation::body`] and [`BodyRef::surface`].
    pub fn step(&mut self) {
        self.steps(1);
    }

    /// Advances all bodies by `count` steps of length `dt`.
    pub fn steps(&mut self, count: u64) {
        if count > 0 && self.choose_at_next_step {
            self.choose_substeps();
            self.choose_at_next_step = false;
        }
        // Entering the pool takes longer than a step of a body that is a single task (see `parallel`).
        let executor = match &self.bodies[..] {
            [body] if body.is_one_task() => Executor::sequential(),
            _ => self.executor.clone(),
        };
        Body::reserve_workspaces(&mut self.workspaces, &self.bodies, executor.threads());
        executor.enter(|| {
            self.update_pieces();
            for _ in 0..count {
                self.step_bodies(&executor);
            }
        });
    }

    /// Advances the bodies by one step, then the driven colliders and the clock.
    fn step_bodies(&mut self, executor: &Executor) {
        self.colliders.animate(self.clock.interval());
        let Self { bodies, contacts, pair_supports, groups, colliders, clock, workspaces, .. } = self;
        let context = StepContext {
            gravity: self.gravity,
            interval: clock.interval(),
            is_frame_start: clock.is_frame_start(self.substeps),
            colliders,
            sleep: self.sleep,
            workspaces,
        };
        groups.settle(bodies, &context);
        match contacts {
            None => executor.for_each_mut(bodies, |body| {
                body.begin_step(&context, executor);
                body.advance_step(&context, executor);
                body.finish_step(&context, &BodyContactPart::Alone, executor);
            }),
            Some(contacts) => {
                if pair_supports.list().is_empty() {
                    executor.for_each_mut(bodies, |body| {
                        body.begin_step(&context, executor);
                        body.advance_step(&context, executor);
                    });
                } else {
                    executor.for_each_mut(bodies, |body| body.begin_step(&context, executor));
                    groups.couple_damping(bodies, pair_supports, context.interval.dt);
                    executor.for_each_mut(bodies, |body| body.advance_step(&context, executor));
                }
                Self::finish_bodies(bodies, (contacts, pair_supports), &context, executor);
            }
        }
        for body in &mut *bodies {
            body.break_joints();
        }
        self.colliders.advance(self.clock.dt());
        self.clock.tick();
        self.update_pieces();
    }

    /// Lets pieces that broke or were cut off touch each other.
    fn update_pieces(&mut self) {
        if self.bodies.iter_mut().map(Body::take_new_pieces).fold(false, std::ops::BitOr::bitor) {
            contact::update(&mut self.bodies, self.contact, &mut self.contacts);
        }
    }

    /// Returns the stages of a step and of the evaluation of the displayed surface, with their memory.
    pub fn plan(&self) -> Plan {
        let bodies = self.bodies.iter().map(Body::plan).collect();
        Plan {
            dt: self.dt(),
            substeps: self.substeps,
            threads: self.threads(),
            bodies,
            contact_bytes: self.contacts.as_ref().map(BodyContacts::bytes),
            window_sum_bytes: self.workspaces.bytes(),
        }
    }

    /// Returns the length of a step in seconds.
    pub fn dt(&self) -> f64 {
        self.clock.dt()
    }

    /// Sets the length of a step in seconds, from 1e-12 to 1e6, from the next step on. The time stays the
    /// same.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_dt(&mut self, dt: f64) -> Result<(), Error> {
        check_dt(dt)?;
        self.clock.set_dt(dt);
        self.wake();
        Ok(())
    }

    /// Returns the time in seconds. It is computed as the time at which `dt` or the time was last set, plus
    /// the number of steps since then times `dt`, so that rounding does not accumulate.
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Sets the time in seconds. The time windows of pins and handles and the keyframes of handles and
    /// colliders refer to this time. The motion of driven colliders does not.
    ///
    /// # Errors
    ///
    /// A number that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<(), Error> {
        in_range("time", time, true, "finite")?;
        self.clock.set_time(time);
        self.colliders.animate_to(time);
        self.wake();
        Ok(())
    }

    /// Returns the number of steps so far.
    pub fn step_count(&self) -> u64 {
        self.clock.steps()
    }

    /// Advances all bodies by `count` frames: by that many times the number of steps per frame.
    pub fn advance(&mut self, count: u64) {
        for _ in 0..count {
            // The first step may choose the number of steps.
            self.steps(1);
            self.steps(self.substeps - 1);
        }
    }

    /// Returns the number of steps per frame. If it is automatic, it may change until the first step, because bodies
    /// can get handles.
    pub fn substeps(&self) -> u64 {
        self.substeps
    }

    /// Returns whether the number of steps per frame is automatic: as it was last set.
    pub fn has_automatic_substeps(&self) -> bool {
        self.chosen.is_some() || self.choose_at_next_step
    }

    /// Returns why the number of steps per frame was chosen, or `None` if it is fixed.
    pub fn chosen_substeps(&self) -> Option<ChosenSubsteps> {
        self.chosen
    }

    /// Returns the number of frames per second, or `None` if the step length was given.
    pub fn fps(&self) -> Option<f64> {
        self.fps
    }

    /// Sets the number of steps per frame, from the next step on, which begins a frame. The step length is then
    /// 1/(fps x steps) if the frames per second were given; otherwise it stays the same. Neither Young's modulus nor
    /// the regions of a body change.
    ///
    /// # Errors
    ///
    /// Zero steps, a step length out of range, or an automatic number without frames per second.
    pub fn set_substeps(&mut self, substeps: Substeps) -> Result<(), Error> {
        check_substeps(substeps, self.fps)?;
        match substeps {
            Substeps::Fixed(steps) => {
                if let Some(fps) = self.fps {
                    self.set_dt(1.0 / (fps * f64::from(steps)))?;
                }
                self.substeps = u64::from(steps);
                self.clock.begin_frame();
                self.chosen = None;
                self.choose_at_next_step = false;
            }
            // Positions and motions may have changed, so that bodies may need other steps.
            Substeps::Auto => self.choose_at_next_step = true,
        }
        Ok(())
    }

    /// Chooses the number of steps per frame, and fixes Young's moduli and regions for the step length that follows.
    fn choose_substeps(&mut self) {
        let Self { bodies, contacts, colliders, gravity, .. } = self;
        let Some(fps) = self.fps else { return };
        let chosen = substeps::choose(bodies, (contacts.as_ref(), colliders), *gravity, fps);
        let dt = 1.0 / (fps * f64::from(chosen.steps));
        (self.chosen, self.substeps) = (Some(chosen), u64::from(chosen.steps));
        self.clock.begin_frame();
        if dt != self.clock.dt() {
            self.clock.set_dt(dt);
        }
        self.bodies.iter_mut().for_each(|body| body.fix_elasticity(self.gravity.norm(), dt));
    }

    /// Returns the executor that runs the steps and evaluates displayed surfaces.
    pub fn executor(&self) -> &Executor {
        &self.executor
    }

    /// Returns the number of threads.
    pub fn threads(&self) -> usize {
        self.executor.threads()
    }

    /// Sets the number of threads, at most 1024; 0 means one per processor. Results are bit-identical for any
    /// number of threads.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_threads(&mut self, threads: usize) -> Result<(), Error> {
        check_threads(threads)?;
        self.executor = Executor::new(threads);
        self.workspaces = Workspaces::default();
        Ok(())
    }

    /// Abandons the thread pool, whose threads do not exist in a forked process. Later steps run on the
    /// calling thread.
    pub fn abandon_threads(&mut self) {
        // Dropping the pool would wait for its threads.
        self.executor.abandon();
    }

    /// Replaces all colliders, from the next step and the next evaluation of a displayed surface on. The new
    /// colliders are not driven. Contacts see no velocity if a collider is thereby in another place; to move a
    /// collider, use [`collider_mut`](Self::collider_mut).
    ///
    /// # Errors
    ///
    /// An invalid collider. The colliders are then unchanged.
    pub fn set_colliders(&mut self, colliders: &[Collider]) -> Result<(), Error> {
        self.colliders = Colliders::new(colliders)?;
        self.colliders.animate_to(self.clock.time());
        for body in &mut self.bodies {
            body.update_contact_stage(&self.colliders);
            body.search_ways_out();
            body.forget_contact_forces();
        }
        self.wake();
        Ok(())
    }

    /// Returns the number of colliders.
    pub fn collider_count(&self) -> usize {
        self.colliders.len()
    }

    /// Returns a collider: its description, current pose and velocity.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a collider.
    pub fn collider(&self, index: usize) -> ColliderRef<'_> {
        ColliderRef::new(&self.colliders, index, self.clock.interval())
    }

    /// Returns a collider to drive it: [`ColliderMut::move_to`].
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a collider.
    pub fn collider_mut(&mut self, index: usize) -> ColliderMut<'_> {
        ColliderMut::new(&mut self.colliders, index, &self.clock)
    }

    /// Returns gravity in scene units per second squared.
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity.into()
    }

    /// Sets gravity in scene units per second squared, from the next step on.
    ///
    /// # Errors
    ///
    /// A component that is not finite or exceeds 1e12 in magnitude.
    pub fn set_gravity(&mut self, gravity: [f64; 3]) -> Result<(), Error> {
        check_gravity(gravity)?;
        self.gravity = gravity.into();
        self.wake();
        Ok(())
    }

    /// Returns whether bodies at rest fall asleep.
    pub fn sleep(&self) -> bool {
        self.sleep
    }

    /// Sets whether bodies at rest fall asleep: they are then not stepped until something moves them. See
    /// [`Body::is_asleep`].
    pub fn set_sleep(&mut self, sleep: bool) {
        self.sleep = sleep;
    }

    /// Returns whether bodies touch each other, as it was set: [`SimulationBuilder::contact`].
    pub fn contact(&self) -> bool {
        self.contact.between
    }

    /// Returns whether bodies touch themselves that do not say so themselves, as it was set:
    /// [`SimulationBuilder::self_contact`].
    pub fn self_contact(&self) -> bool {
        self.contact.with_itself
    }

    /// Wakes all bodies up.
    fn wake(&mut self) {
        self.bodies.iter_mut().for_each(Body::wake);
    }

    /// Returns the bodies, in the order in which they were added. To evaluate the displayed surface of a
    /// body, use [`Simulation::body`].
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the bodies for modification.
    pub fn bodies_mut(&mut self) -> &mut [Body] {
        &mut self.bodies
    }

    /// Returns a reference to a body, with the data of the simulation that evaluating the displayed surface
    /// needs.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a body.
    pub fn body(&self, index: usize) -> BodyRef<'_> {
        let Self { bodies, contacts, colliders, executor, gravity, .. } = self;
        let near = contacts.as_ref().map(|contacts| NearBodies { bodies, index: index as u32, contacts });
        let (time, dt, gravity) = (self.time(), self.dt(), *gravity);
        BodyRef::new(&bodies[index], DisplayContext { colliders, time, dt, gravity, executor, near })
    }

    /// Returns a body for modification.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a body.
    pub fn body_mut(&mut self, index: usize) -> &mut Body {
        &mut self.bodies[index]
    }
}
