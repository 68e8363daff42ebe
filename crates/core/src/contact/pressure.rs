//! A contact of a body with a collider in the last step.

use nalgebra::Vector3;

use crate::state::{ContactForce, ContactKey, PressingContact, SupportingContact};

/// A contact of the last step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pressure {
    /// Index of the collider.
    pub(crate) collider: u32,
    /// Nearest lattice vertex of the contact.
    pub(crate) vertex: u32,
    /// Normal impulse, 0 if the contact does not press on the body.
    pub(crate) impulse: f64,
    /// Factor of the coefficient of friction: see `Contacts::set_friction_factors`.
    pub(super) friction_factor: f64,
    /// Friction impulse, in the unit of `impulse`: a full cell's mass times cells/s.
    pub(crate) friction: Vector3<f64>,
    /// Greatest depth of a sample at the end of the step in cells, negative outside: if every sample of the contact
    /// moved like the contact point.
    pub(crate) depth: f64,
    /// Contact point, in cells from the body's origin.
    pub(crate) point: Vector3<f64>,
    /// Normal of the collider, a unit vector.
    pub(crate) normal: Vector3<f64>,
    /// Velocity of the surface of the collider, in cells/s.
    pub(super) velocity: Vector3<f64>,
    /// Angular velocity of the collider in rad/s.
    pub(super) spin: Vector3<f64>,
}

impl Pressure {
    /// Returns the key of the contact, by which the next step finds it.
    pub(super) fn key(&self) -> ContactKey {
        ContactKey::Collider { collider: self.collider, vertex: self.vertex }
    }

    /// Returns the force of the contact. `unit`: the unit of `impulse` over the length of the step, in scene units.
    pub(crate) fn force(&self, unit: f64) -> ContactForce {
        let &Self { normal, impulse, friction, .. } = self;
        ContactForce { key: self.key(), force: ((normal * impulse + friction) * unit).into() }
    }

    /// Returns the contact as a support of a component.
    pub(crate) fn support_of(&self, component: u32) -> SupportingContact {
        let Self { collider, impulse, friction_factor, point, normal, velocity, spin, friction, .. } = *self;
        let contact = PressingContact { impulse, friction_factor, friction, point, normal };
        SupportingContact { component, collider, contact, velocity, spin }
    }
}
