//! Changes and checks the settings of a simulation.

use nalgebra::Vector3;

use super::contact_point::Touched;
use super::substeps::{self, Substeps};
use super::world::Simulation;
use crate::body::Body;
use crate::contact::{Collider, Colliders};
use crate::dynamics::Field;
use crate::error::Error;
use crate::matching::Workspaces;
use crate::motion::Curve;
use crate::parallel::Executor;
use crate::range::in_range;

/// Maximum number of threads: more than a simulation can use, and few enough for the system to start.
const MAX_THREADS: usize = 1024;

impl Simulation {
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
        self.follow_time();
        self.wake();
        Ok(())
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
    pub(super) fn choose_substeps(&mut self) {
        let gravity = self.greatest_gravity();
        let Self { bodies, contacts, colliders, .. } = self;
        let Some(fps) = self.fps else { return };
        let chosen = substeps::choose(bodies, (contacts.as_ref(), colliders), gravity, fps);
        let dt = 1.0 / (fps * f64::from(chosen.steps));
        (self.chosen, self.substeps) = (Some(chosen), u64::from(chosen.steps));
        self.clock.begin_frame();
        if dt != self.clock.dt() {
            self.clock.set_dt(dt);
        }
        self.bodies.iter_mut().for_each(|body| body.fix_elasticity(gravity.norm(), dt));
    }

    /// Replaces the fields, from the next step on.
    ///
    /// # Errors
    ///
    /// A number out of range, or a field of a body that does not exist. The fields are then unchanged.
    pub fn set_fields(&mut self, fields: Vec<Field>) -> Result<(), Error> {
        check_fields(&fields, &self.bodies)?;
        self.fields = fields;
        self.wake();
        Ok(())
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
        self.colliders.set_time(self.clock.time());
        self.restored_contacts.retain(|contact| matches!(contact.other, Touched::Body(_)));
        for body in &mut self.bodies {
            body.update_contact_stage(&self.colliders);
            body.search_escapes();
            body.forget_contact_forces();
        }
        self.wake();
        Ok(())
    }

    /// Sets gravity in scene units per second squared, from the next step on: a vector, or a [`Curve`] of vectors over
    /// the time of the simulation.
    ///
    /// # Errors
    ///
    /// A component that is not finite or exceeds 1e12 in magnitude.
    pub fn set_gravity(&mut self, gravity: impl Into<Curve<[f64; 3]>>) -> Result<(), Error> {
        let gravity = gravity.into();
        check_gravity(&gravity)?;
        self.gravity = gravity.value(self.clock.time()).into();
        self.gravity_curve = gravity;
        self.wake();
        Ok(())
    }

    /// Sets whether bodies at rest fall asleep: they are then not stepped until something moves them. See
    /// [`Body::is_asleep`].
    pub fn set_sleep(&mut self, sleep: bool) {
        self.sleep = sleep;
    }

    /// Sets what follows the time at the beginning of a step to the current time: gravity, and which colliders are
    /// enabled. Bodies wake up to changes.
    pub(super) fn follow_time(&mut self) {
        if self.gravity_curve.keys().len() > 1 {
            let gravity = Vector3::from(self.gravity_curve.value(self.clock.time()));
            if gravity != self.gravity {
                self.gravity = gravity;
                self.wake();
            }
        }
        self.switch_colliders();
    }

    /// Returns the greatest gravity of a keyframe.
    pub(super) fn greatest_gravity(&self) -> Vector3<f64> {
        self.gravity_curve.longest().into()
    }

    /// Enables and disables the colliders by their keyframes for the current time. Bodies follow.
    pub(super) fn switch_colliders(&mut self) {
        let Self { bodies, colliders, clock, gravity, .. } = self;
        let time = clock.time();
        if colliders.any_switches(time) {
            bodies.iter_mut().for_each(|body| body.follow_switches(colliders, time, *gravity));
            colliders.switch(time);
        }
    }

    /// Wakes all bodies up.
    pub(super) fn wake(&mut self) {
        self.bodies.iter_mut().for_each(Body::wake);
    }
}

/// Checks the number of steps per frame.
pub(super) fn check_substeps(substeps: Substeps, fps: Option<f64>) -> Result<(), Error> {
    match substeps {
        Substeps::Fixed(steps) => {
            in_range("substeps", f64::from(steps), steps > 0, "at least 1")?;
        }
        Substeps::Auto if fps.is_none() => return Err(Error::AutoSubstepsWithoutFps),
        Substeps::Auto => {}
    }
    Ok(())
}

/// Checks the length of a step.
pub(super) fn check_dt(dt: f64) -> Result<(), Error> {
    in_range("dt", dt, (1e-12..=1e6).contains(&dt), "a time in seconds, from 1e-12 to 1e6")?;
    Ok(())
}

/// Checks fields of some bodies.
pub(super) fn check_fields(fields: &[Field], bodies: &[Body]) -> Result<(), Error> {
    for field in fields {
        field.validate()?;
        field.bodies.iter().try_for_each(|name| Body::index_of(bodies, "field", name).map(drop))?;
    }
    Ok(())
}

/// Checks gravity.
pub(super) fn check_gravity(gravity: &Curve<[f64; 3]>) -> Result<(), Error> {
    for g in gravity.keys().iter().flat_map(|key| key.value) {
        in_range("gravity", g, g.abs() <= 1e12, "at most 1e12")?;
    }
    Ok(())
}

/// Checks the number of threads.
pub(super) fn check_threads(threads: usize) -> Result<(), Error> {
    in_range("threads", threads as f64, threads <= MAX_THREADS, "at most 1024 (0: all processors)")?;
    Ok(())
}
