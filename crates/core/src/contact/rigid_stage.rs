//! The contacts of a rigid body with colliders: impulses and pushes move the whole body.

use nalgebra::{Point3, Vector3};

use super::SKIN;
use super::colliders::Colliders;
use super::constraint::Contact;
use super::finish::ContactMover;
use super::patch::PatchVertices;
use super::samples::SampleCells;
use super::solver::Solver;
use super::stage::Contacts;
use super::vec4::narrow;
use crate::state::{BodyState, Interval, RigidMobility, Twist};

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

impl<B: RigidMover> ContactMover for B {
    fn state(&mut self) -> BodyState<'_> {
        self.body_state()
    }

    fn mobility(&self) -> Option<RigidMobility> {
        Some(RigidMover::mobility(self))
    }

    fn apply_impulses(&mut self, contacts: &mut Contacts, dt: f64) {
        let Contacts { solver, rigid_totals, .. } = contacts;
        solver.rigid_totals(rigid_totals);
        rigid_totals.iter().for_each(|total| self.apply_impulse(*total, dt));
    }

    fn push(&mut self, contacts: &mut Contacts) {
        self.displace(contacts.solver.rigid.change(0));
    }
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
        !during.any(|collider| collider.shape.may_touch(&Point3::from(*center), &half, SKIN))
    }

    /// Sets the mobility of a rigid body, at its present pose.
    pub(crate) fn set_rigid(&mut self, mobility: &RigidMobility) {
        self.rigid = Some(*mobility);
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
            None => {
                let mobility = |row: u32| samples.mobilities[row as usize];
                self.add(contact, vertices.iter().map(|(row, weight)| (row, weight, mobility(row))));
            }
            Some(mobility) => {
                self.add(contact, std::iter::empty());
                self.rigid.link(self.len() - 1, 0, 1.0, narrow(position().coords - mobility.center));
            }
        }
    }
}
