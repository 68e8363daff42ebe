//! The contacts of a rigid body with colliders: impulses and pushes move the whole body.

use super::SKIN;
use super::colliders::Colliders;
use super::constraint::{Contact, SOFT_DEPTH};
use super::patch::PatchVertices;
use super::push_out::PUSH_ROUNDS;
use super::samples::SampleCells;
use super::solver::{Solver, Tolerance, Units};
use super::stage::{Contacts, PUSH_LIMIT};
use super::vec4::{Vec4, narrow};
use crate::state::{BodyState, Interval, RigidMobility, Twist};
use nalgebra::{Point3, Vector3};

/// A rigid body that contacts move. Its lattice vertices follow at once.
pub(crate) trait RigidMover {
    /// Returns the positions and velocities of the lattice vertices.
    fn body_state(&mut self) -> BodyState<'_>;

    /// Returns the mobility at the present pose.
    fn mobility(&self) -> RigidMobility;

    /// Applies an impulse of a step of `dt` seconds, and displaces the body by the change of its motion times `dt`.
    fn apply_impulse(&mut self, impulse: Twist, dt: f64);

    /// Displaces the body.
    fn displace(&mut self, displacement: Twist);
}

impl Contacts {
    /// Returns true only if the body is rigid, and all colliders are planes that are not near the sphere around its center
    /// of mass which contains its lattice vertices.
    pub(super) fn is_away_from_planes(
        &self,
        state: &BodyState<'_>,
        colliders: &Colliders,
        step: Interval,
    ) -> bool {
        let Some(RigidMobility { center, bounding_radius, .. }) = &self.rigid else { return false };
        if self.samples.stencils().is_some() || colliders.any_needs_paths() {
            return false;
        }
        // Positions are rounded to f32.
        let half = Vector3::repeat(1.001 * bounding_radius + 1e-6 * center.amax());
        let mut during = colliders.during(step, state.frame, self.thickness);
        !during.any(|(_, collider)| collider.shape.may_touch(&Point3::from(*center), &half, SKIN))
    }

    /// Sets the mobility of a rigid body, at its present pose. `None` if the body is not rigid.
    pub(crate) fn set_rigid(&mut self, mobility: Option<&RigidMobility>) {
        self.rigid = mobility.copied();
    }

    /// Solves and applies the contacts of a rigid body that touches no other body, as
    /// [`finish_alone`](Self::finish_alone).
    pub(crate) fn finish_alone_rigidly(
        &mut self,
        body: &mut impl RigidMover,
        colliders: &Colliders,
        step: Interval,
    ) {
        if !self.pressures.is_empty() {
            self.solver.begin_with(&self.begin, self.slow);
            self.solver.solve(Tolerance::IMPACT);
            self.solver.rigid_totals(&mut self.rigid_totals);
            self.rigid_totals.iter().for_each(|total| body.apply_impulse(*total, step.dt));
            self.finish_rigidly(body, colliders, step);
        }
        self.keep_sides(&body.body_state(), colliders, step);
    }

    /// Takes the impulses from the problem of an island, which moved the body already, as
    /// [`finish_in_island`](Self::finish_in_island).
    pub(super) fn finish_rigidly_in_island(
        &mut self,
        body: &mut impl RigidMover,
        (colliders, step): (&Colliders, Interval),
        (impulses, units): (&[(f32, Vec4)], Units),
    ) {
        if !self.pressures.is_empty() {
            self.solver.set_impulses(impulses, units);
            self.finish_rigidly(body, colliders, step);
        }
        self.keep_sides(&body.body_state(), colliders, step);
    }

    fn finish_rigidly(&mut self, body: &mut impl RigidMover, colliders: &Colliders, step: Interval) {
        if self.store_impulses(step.dt) > SOFT_DEPTH {
            let deepest = self.push_out_rigidly(body, colliders, step);
            self.limit_depths(deepest);
        }
    }

    /// Pushes the body out of colliders: see `push_out`.
    fn push_out_rigidly(&mut self, body: &mut impl RigidMover, colliders: &Colliders, step: Interval) -> f64 {
        let mut deepest = f64::INFINITY;
        for _ in 0..PUSH_ROUNDS {
            self.set_rigid(Some(&body.mobility()));
            deepest = self.find_pushes(&body.body_state(), colliders, step);
            if deepest <= SOFT_DEPTH {
                break;
            }
            self.solver.solve(Tolerance::PUSH);
            body.displace(self.solver.rigid.change(0));
            if deepest > PUSH_LIMIT {
                break;
            }
        }
        deepest
    }
}

impl Solver {
    /// Adds the rigid body of a body's own problem, which is empty.
    pub(super) fn begin_rigid(&mut self, rigid: Option<&RigidMobility>) {
        if let Some(mobility) = rigid {
            self.rigid.add(mobility, 1.0, 1.0);
        }
    }

    /// Adds the contact of a patch: with its vertices, or with the rigid body at the place that `position` returns.
    pub(super) fn add_patch(
        &mut self,
        contact: Contact,
        (vertices, position): (&PatchVertices, impl FnOnce() -> Point3<f64>),
        samples: &SampleCells,
        rigid: Option<&RigidMobility>,
    ) {
        match rigid {
            None => self.add(contact, samples.links(vertices)),
            Some(mobility) => {
                self.add(contact, std::iter::empty());
                self.rigid.link(self.len() - 1, 0, 1.0, narrow(position().coords - mobility.center));
            }
        }
    }
}
