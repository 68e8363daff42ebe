//! The step: all bodies, then the driven colliders, the clock, and what follows the time.

use super::contact::store_supports;
use super::groups;
use super::world::Simulation;
use crate::body::{Body, StepContext};
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
        if count > 0 {
            self.choose_due_substeps();
        }
        Body::reserve_workspaces(&mut self.workspaces, &self.bodies, executor.threads());
        executor.enter(|| {
            self.update_pieces();
            if self.need_no_other_body() {
                self.step_each_body(count, executor);
            } else {
                (0..count).for_each(|_| self.step_bodies(executor));
            }
        });
    }

    /// Chooses the number of steps per frame if the next step has to.
    fn choose_due_substeps(&mut self) {
        if std::mem::take(&mut self.choose_at_next_step) {
            self.choose_substeps();
        }
    }

    /// Ends a call that [made steps](Self::make_steps).
    pub fn end_call(&mut self) {
        self.bodies.iter_mut().for_each(Body::end_call);
    }

    /// Advances all bodies by `count` frames: by that many times the number of steps per frame.
    pub fn advance(&mut self, count: u64) {
        for _ in 0..count {
            self.choose_due_substeps();
            self.make_steps(self.substeps);
        }
        if count > 0 {
            self.end_call();
        }
    }

    /// Returns whether there are several bodies, and none has to wait for another one in a step: none can touch another
    /// one or itself or break, there are no links, and neither gravity nor what colliders are there changes from step to
    /// step. Many steps in a call are then faster than in several calls, because each body makes all of them before the
    /// next one.
    pub fn bodies_are_apart(&self) -> bool {
        self.bodies.len() > 1 && self.need_no_other_body()
    }

    fn need_no_other_body(&self) -> bool {
        self.contacts.is_none()
            && self.links.is_empty()
            && self.restored_contacts.is_empty()
            && self.gravity_curve.keys().len() <= 1
            && self.colliders.need_no_update()
            && !self.bodies.iter().any(Body::is_armed)
    }

    /// Advances each body by `count` steps before the next one, which is faster than each step for all bodies: a small
    /// body stays in the cache of its processor. The results are the same if the bodies
    /// [need none of the others](Self::need_no_other_body).
    fn step_each_body(&mut self, count: u64, executor: &Executor) {
        let greatest_gravity = self.greatest_gravity().norm();
        let Self { bodies, fields, colliders, clock, workspaces, gravity, sleep, substeps, .. } = self;
        debug_assert!(bodies.iter().all(|body| body.touches().is_empty()), "bodies sleep together");
        executor.for_each_mut(bodies, |body| {
            let mut clock = *clock;
            for _ in 0..count {
                let context = StepContext {
                    gravity: *gravity,
                    greatest_gravity,
                    interval: clock.interval(),
                    is_frame_start: clock.is_frame_start(*substeps),
                    colliders,
                    sleep: *sleep,
                    workspaces,
                };
                body.begin_forces(fields, context.interval);
                body.follow(body.rest_vote(&context));
                body.step_alone(&context, executor);
                clock.tick(1);
            }
        });
        clock.tick(count);
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
            None => executor.for_each_mut(bodies, |body| body.step_alone(&context, executor)),
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
        self.clock.tick(1);
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
