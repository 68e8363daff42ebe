//! The second part of the contact stage: applies the impulses, and pushes samples that are still inside a collider out
//! of it.

use super::colliders::Colliders;
use super::constraint::{Contact, SOFT_DEPTH, mean_position};
use super::detection::ContactReport;
use super::jacobi::Tolerance;
use super::solver::Units;
use super::stage::{Contacts, PUSH_LIMIT};
use super::vec4::{Vec4, narrow, wide};
use crate::state::{BodyState, Interval, RigidMobility};

/// Maximum number of push-out rounds in a step. Each round moves the contact point of each patch to the
/// surface of the collider. The samples that remain inside form the patches of the next round.
const PUSH_ROUNDS: usize = 4;

/// A body that contacts move: its lattice vertices one by one, or the whole body if it is rigid.
pub(crate) trait ContactMover {
    /// Returns the positions and velocities of the lattice vertices.
    fn state(&mut self) -> BodyState<'_>;

    /// Returns the mobility of a rigid body at the present pose.
    fn mobility(&self) -> Option<RigidMobility>;

    /// Applies the impulses of the solved problem of a step of `dt` seconds: adds the velocity changes to the
    /// velocities, and the velocity changes times the step to the positions.
    fn apply_impulses(&mut self, contacts: &mut Contacts, dt: f64);

    /// Displaces the body by the solved problem of a push-out.
    fn push(&mut self, contacts: &mut Contacts);
}

impl ContactMover for BodyState<'_> {
    fn state(&mut self) -> BodyState<'_> {
        let Self { positions, compensation, velocities, frame } = self;
        BodyState { positions, compensation: compensation.as_deref_mut(), velocities, frame: *frame }
    }

    fn mobility(&self) -> Option<RigidMobility> {
        None
    }

    fn apply_impulses(&mut self, contacts: &mut Contacts, dt: f64) {
        for (row, change) in contacts.solver.changes() {
            let (slot, change) = (contacts.samples.slots[row as usize], wide(change));
            self.set_position(slot, self.position(slot) + change * dt);
            self.set_velocity(slot, self.velocity(slot) + change);
        }
    }

    fn push(&mut self, contacts: &mut Contacts) {
        let Contacts { samples, solver, touched, displacements, .. } = contacts;
        for (row, displacement) in solver.changes() {
            let slot = samples.slots[row as usize];
            self.set_position(slot, self.position(slot) + wide(displacement));
            add_displacement(&mut displacements[row as usize], displacement, 1.0);
            touched.push(row);
        }
    }
}

impl Contacts {
    /// Solves and applies the contacts that [`detect`](Self::detect) found: the second part of the stage for a body
    /// that touches no other body.
    pub(crate) fn finish_alone(
        &mut self,
        body: &mut impl ContactMover,
        colliders: &Colliders,
        step: Interval,
    ) {
        if !self.pressures.is_empty() {
            self.solver.begin_with(&self.begin, self.slow);
            self.solver.solve(Tolerance::IMPACT);
            body.apply_impulses(self, step.dt);
            self.finish(body, colliders, step);
        }
        self.keep_sides(&body.state(), colliders, step);
    }

    /// Takes the impulses from the problem of an island, which moved the body already, and pushes samples out of
    /// colliders: the second part of the stage in an island. `impulses` and `units`: see [`Solver::set_impulses`].
    ///
    /// [`Solver::set_impulses`]: super::solver::Solver::set_impulses
    pub(super) fn finish_in_island(
        &mut self,
        body: &mut impl ContactMover,
        (colliders, step): (&Colliders, Interval),
        (impulses, units): (&[(f32, Vec4)], Units),
    ) {
        if !self.pressures.is_empty() {
            self.is_on_plane = false;
            self.solver.set_impulses(impulses, units);
            self.finish(body, colliders, step);
        }
        self.keep_sides(&body.state(), colliders, step);
    }

    /// Stores the impulses, and pushes samples out of colliders.
    fn finish(&mut self, body: &mut impl ContactMover, colliders: &Colliders, step: Interval) {
        self.touched.extend(self.solver.changes().map(|(row, _)| row));
        if self.store_impulses(step.dt) > SOFT_DEPTH {
            let deepest = self.push_out(body, colliders, step);
            for pressure in &mut self.pressures {
                pressure.depth = pressure.depth.min(deepest);
            }
        }
        self.touched.sort_unstable();
        self.touched.dedup();
    }

    /// Stores the impulses of a step of `dt` seconds. Returns a bound of the greatest depth that remains.
    ///
    /// The impulses of a plane move no vertex inwards, and a sample at least as far outwards as the least moved vertex
    /// of its cell that has a weight in it. Elsewhere, samples that turn about the contact point of an impact may be
    /// deeper than it, by its motion at most.
    fn store_impulses(&mut self, dt: f64) -> f64 {
        let Self { solver, pressures, displacements, is_on_plane, .. } = self;
        for (pressure, (impulse, friction)) in pressures.iter_mut().zip(solver.impulses()) {
            pressure.impulse = f64::from(impulse);
            pressure.friction = wide(&friction);
        }
        let mut remaining = 0.0_f64;
        let changes = solver.contacts().map(|(_, change)| change).zip(solver.least_changes());
        for (pressure, (change, least)) in pressures.iter_mut().zip(changes) {
            let (motion, before) = (f64::from(change) * dt, pressure.depth);
            pressure.depth -= motion;
            let bound = if *is_on_plane { before - f64::from(least) * dt } else { motion.abs() };
            remaining = remaining.max(pressure.depth).max(bound);
        }
        for (row, change) in solver.normal_changes() {
            // The displacement plus the velocity change times the step; the two are equal.
            add_displacement(&mut displacements[row as usize], change, 2.0 * dt as f32);
        }
        remaining
    }

    /// Pushes samples that are deeper than [`SOFT_DEPTH`] inside a collider out of it. Changes positions, but not
    /// velocities. Returns the greatest depth of a sample in cells before the last push.
    ///
    /// Few steps need a push-out. The possible causes are a body that was placed inside a collider or is
    /// constrained to be inside it, and a patch that rotated about its contact point.
    fn push_out(&mut self, body: &mut impl ContactMover, colliders: &Colliders, step: Interval) -> f64 {
        let mut deepest = f64::INFINITY;
        for _ in 0..PUSH_ROUNDS {
            self.rigid = body.mobility();
            deepest = self.find_pushes(&body.state(), colliders, step);
            if deepest <= SOFT_DEPTH {
                break;
            }
            self.solver.solve(Tolerance::PUSH);
            body.push(self);
            if deepest > PUSH_LIMIT {
                break;
            }
        }
        deepest
    }

    /// Adds the push-outs of the samples inside colliders to the problem. Returns the greatest depth of a sample in
    /// cells.
    fn find_pushes(&mut self, state: &BodyState<'_>, colliders: &Colliders, step: Interval) -> f64 {
        let Self { samples, detection, solver, leaving, rigid, thickness, .. } = self;
        solver.clear();
        solver.begin_rigid(rigid.as_ref());
        detection.read_moved(state.positions, &samples.slots, leaving);
        let mut report = ContactReport::default();
        for collider in colliders.during(step, state.frame, *thickness) {
            detection.find(&collider, samples, 0.0, &mut report);
            for patch in detection.patches() {
                let vertices = patch.vertices();
                let position = || mean_position(vertices.iter(), &detection.positions);
                let (normal, distance) = match patch.side() {
                    Some(side) => (side.normal, patch.mean_distance()),
                    None => {
                        let position = position();
                        let sdf = collider.shape.signed_distance(&position);
                        (sdf.normal, sdf.distance + samples.offset(patch, &collider.shape, &position))
                    }
                };
                let (normal, target) = (narrow(normal), (-distance).min(PUSH_LIMIT) as f32);
                let contact = Contact { normal, target, approach: target, ..Contact::default() };
                solver.add_patch(contact, (&vertices, position), samples, rigid.as_ref());
            }
        }
        report.deepest
    }

    /// Stores on which side of the colliders the samples are at the end of a step.
    fn keep_sides(&mut self, state: &BodyState<'_>, colliders: &Colliders, step: Interval) {
        let Self { samples, detection, leaving, thickness, .. } = self;
        let during = colliders.during(step, state.frame, *thickness);
        detection.keep_sides(state.positions, (samples, leaving), during);
    }
}

/// Adds `vector * scale` to a contact displacement.
fn add_displacement(displacement: &mut [f32; 3], vector: &Vec4, scale: f32) {
    for (sum, component) in displacement.iter_mut().zip(vector) {
        *sum += component * scale;
    }
}
