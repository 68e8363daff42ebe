//! The step: all bodies, then the driven colliders, the clock, and what follows the time.

use super::contact::store_supports;
use super::groups;
use super::world::Simulation;
use crate::body::{Body, StepContext};
use crate::contact::bodies::BodyContactPart;
use crate::parallel::Executor;

impl Simulation {
    /// Advances all bodies by one step of length `dt`: see [the pipeline](crate#the-pipeline).
    ///
    /// A step does not evaluate the displayed surface (volume correction, mesh update): see
    /// [`Simulation::body`] and [`BodyRef::surface`](crate::BodyRef::surface).
    pub fn step(&mut self) {
        self.steps(1);
    }

    /// Advances all bodies by `count` steps of length `dt`.
    pub fn steps(&mut self, count: u64) {
        self.make_steps(count);
        if count > 0 {
            self.end_call();
        }
    }

    /// Advances all bodies by `count` steps that are a part of a call: forces of
    /// [`ForceDuration::Call`](crate::ForceDuration::Call) act on, until [`end_call`](Self::end_call). For programs that
    /// do something else in the course of a call.
    pub fn make_steps(&mut self, count: u64) {
        // Entering the pool takes longer than a step of a body that is a single task (see `parallel`).
        let executor = match &self.bodies[..] {
            [body] if body.is_one_task() => Executor::sequential(),
            _ => self.executor.clone(),
        };
        self.make_steps_on(&executor, count);
    }

    /// Makes the steps of [`make_steps`](Self::make_steps) on the calling thread, with the same bits. For programs that
    /// step many simulations at once.
    pub fn make_sequential_steps(&mut self, count: u64) {
        self.make_steps_on(&Executor::sequential(), count);
    }

    fn make_steps_on(&mut self, executor: &Executor, count: u64) {
        if count > 0 && self.choose_at_next_step {
            self.choose_substeps();
            self.choose_at_next_step = false;
        }
        Body::reserve_workspaces(&mut self.workspaces, &self.bodies, executor.threads());
        executor.enter(|| {
            self.update_pieces();
            for _ in 0..count {
                self.step_bodies(executor);
            }
        });
    }

    /// Ends a call that [made steps](Self::make_steps).
    pub fn end_call(&mut self) {
        self.bodies.iter_mut().for_each(Body::end_call);
    }

    /// Advances all bodies by `count` frames: by that many times the number of steps per frame.
    pub fn advance(&mut self, count: u64) {
        for _ in 0..count {
            // The first step may choose the number of steps.
            self.make_steps(1);
            self.make_steps(self.substeps - 1);
        }
        if count > 0 {
            self.end_call();
        }
    }

    /// Advances the bodies by one step, then the driven colliders and the clock.
    fn step_bodies(&mut self, executor: &Executor) {
        self.colliders.animate(self.clock.interval());
        let greatest_gravity = self.greatest_gravity().norm();
        let Self {
            bodies, contacts, fields, links, pair_supports, groups, colliders, clock, workspaces, ..
        } = self;
        let context = StepContext {
            gravity: self.gravity,
            greatest_gravity,
            interval: clock.interval(),
            is_frame_start: clock.is_frame_start(self.substeps),
            colliders,
            sleep: self.sleep,
            workspaces,
        };
        // Without fields there is too little work for several threads.
        if fields.is_empty() {
            bodies.iter_mut().for_each(|body| body.begin_forces(&[], context.interval));
        } else {
            executor.for_each_mut(bodies, |body| body.begin_forces(fields, context.interval));
        }
        links.apply(bodies, context.interval.dt);
        groups.settle(bodies, &context);
        match contacts {
            None => executor.for_each_mut(bodies, |body| {
                body.advance_step(&context, executor);
                body.finish_step(&context, &BodyContactPart::Alone, executor);
                body.end_step(&context, executor);
            }),
            Some(contacts) => {
                executor.for_each_mut(bodies, |body| body.advance_step(&context, executor));
                Self::finish_bodies(bodies, contacts, &context, executor);
                store_supports(bodies, contacts, pair_supports);
                groups.couple_damping(bodies, pair_supports, context.interval.dt);
                executor.for_each_mut(bodies, |body| body.end_step(&context, executor));
                contacts.record(bodies, (pair_supports, groups.reactions()), context.interval.dt);
            }
        }
        for body in &mut *bodies {
            body.break_joints();
        }
        self.colliders.advance(self.clock.dt());
        self.clock.tick();
        self.forget_restored_contacts();
        self.follow_time();
        self.update_pieces();
    }

    /// Lets pieces that broke or were cut off touch each other.
    pub(super) fn update_pieces(&mut self) {
        if self.bodies.iter_mut().map(Body::take_new_pieces).fold(false, std::ops::BitOr::bitor) {
            groups::update(&mut self.bodies, self.contact, &mut self.contacts);
        }
    }
}
