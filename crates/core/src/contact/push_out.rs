//! Pushes samples that are still inside a collider out of it.

use super::colliders::Colliders;
use super::constraint::{Contact, SOFT_DEPTH, mean_position};
use super::detection::ContactReport;
use super::solver::Tolerance;
use super::stage::{Contacts, PUSH_LIMIT, add_displacement};
use super::vec4::{narrow, wide};
use crate::state::{BodyState, Interval};

/// Maximum number of push-out rounds in a step. Each round moves the contact point of each patch to the
/// surface of the collider. The samples that remain inside form the patches of the next round.
pub(super) const PUSH_ROUNDS: usize = 4;

impl Contacts {
    /// Pushes samples that are deeper than [`SOFT_DEPTH`] inside a collider out of it. Changes positions, but not
    /// velocities. Returns the greatest depth of a sample in cells before the last push.
    ///
    /// Few steps need a push-out. The possible causes are a body that was placed inside a collider or is
    /// constrained to be inside it, and a patch that rotated about its contact point.
    pub(super) fn push_out(
        &mut self,
        state: &mut BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
    ) -> f64 {
        let mut deepest = f64::INFINITY;
        for _ in 0..PUSH_ROUNDS {
            deepest = self.find_pushes(state, colliders, step);
            if deepest <= SOFT_DEPTH {
                break;
            }
            let Self { samples, solver, touched, displacements, .. } = self;
            solver.solve(Tolerance::PUSH);
            for (row, displacement) in solver.changes() {
                let slot = samples.slots[row as usize];
                state.set_position(slot, state.position(slot) + wide(displacement));
                add_displacement(&mut displacements[row as usize], displacement, 1.0);
                touched.push(row);
            }
            if deepest > PUSH_LIMIT {
                break;
            }
        }
        deepest
    }
    /// Adds the push-outs of the samples inside colliders to the problem. Returns the greatest depth of a sample in cells.
    pub(super) fn find_pushes(
        &mut self,
        state: &BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
    ) -> f64 {
        let Self { samples, detection, solver, leaving, rigid, thickness, .. } = self;
        solver.clear();
        solver.begin_rigid(rigid.as_ref());
        detection.read(state.positions, &samples.slots, leaving);
        detection.update_paths();
        let mut report = ContactReport::default();
        for (index, collider) in colliders.during(step, state.frame, *thickness) {
            detection.find(index, &collider, samples, 0.0, &mut report);
            for patch in detection.patches() {
                let vertices = patch.vertices();
                let position = || mean_position(vertices.iter(), detection.positions());
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
}
