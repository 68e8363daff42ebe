//! The supports of a body: the contacts that pressed on it in the last step.

use nalgebra::Vector3;

use super::pressing::{Pressing, PressingContact};

/// The contacts of one component with one collider that pressed on the body in a step. Lengths are in cells from the
/// body's origin, velocities in cells/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Support {
    /// Index of the connected component.
    pub(crate) component: u32,
    /// Index of the collider.
    pub(crate) collider: u32,
    pub(crate) pressing: Pressing,
    /// Velocity of the surface of the collider at the center of pressure.
    pub(crate) velocity: [f64; 3],
    /// Angular velocity of the collider in rad/s.
    pub(crate) spin: [f64; 3],
}

/// A contact of a component with a collider that pressed in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SupportingContact {
    /// Index of the connected component.
    pub(crate) component: u32,
    /// Index of the collider.
    pub(crate) collider: u32,
    pub(crate) contact: PressingContact,
    /// Velocity and angular velocity of the surface of the collider.
    pub(crate) velocity: Vector3<f64>,
    pub(crate) spin: Vector3<f64>,
}

/// The supports of a body.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Supports(Vec<Support>);

impl Supports {
    pub(crate) fn list(&self) -> &[Support] {
        &self.0
    }

    pub(crate) fn list_mut(&mut self) -> &mut [Support] {
        &mut self.0
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Replaces the supports. `contacts` are single contacts, which are combined to one support of each component by
    /// each collider. A support that existed before keeps its deflections.
    pub(crate) fn set(&mut self, contacts: impl Iterator<Item = SupportingContact>) {
        for support in &mut self.0 {
            support.pressing.begin();
            support.velocity = [0.0; 3];
        }
        // Contacts of the same support mostly follow each other.
        let mut last = 0;
        for SupportingContact { component, collider, contact, velocity, spin } in contacts {
            let is_of = |support: &Support| (support.component, support.collider) == (component, collider);
            if !self.0.get(last).is_some_and(is_of) {
                last = self.0.iter().position(is_of).unwrap_or_else(|| {
                    self.0.push(Support { component, collider, ..Support::default() });
                    self.0.len() - 1
                });
            }
            let support = &mut self.0[last];
            support.pressing.add(&contact);
            support.spin = spin.into();
            (0..3).for_each(|c| support.velocity[c] += contact.impulse * velocity[c]);
        }
        self.0.retain(|support| support.pressing.impulse > 0.0);
        for Support { pressing, velocity, .. } in &mut self.0 {
            *velocity = velocity.map(|sum| sum * (1.0 / pressing.impulse));
            pressing.normalize();
        }
    }

    /// Moves the centers of pressure by `offset`.
    pub(super) fn shift(&mut self, offset: Vector3<f64>) {
        for support in &mut self.0 {
            support.pressing.point = (Vector3::from(support.pressing.point) + offset).into();
        }
    }
}
