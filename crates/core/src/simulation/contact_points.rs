//! Reports the contacts of the last step.

use super::contact_point::{ContactPoint, Touched};
use super::world::Simulation;

impl Simulation {
    /// Returns the contacts of the last step: those with colliders, by body, then those between bodies. A sleeping body
    /// has the contacts with which it fell asleep. After [`restore`](Self::restore) they are those of the state.
    pub fn contacts(&self) -> Vec<ContactPoint> {
        let dt = self.dt();
        let with_colliders = self.bodies.iter().enumerate().flat_map(|(index, body)| {
            let frame = body.frame();
            let layer = body.touching().thickness / frame.cell_size;
            body.collider_contacts(dt).into_iter().map(move |(pressure, force)| ContactPoint {
                body: index,
                other: Touched::Collider(pressure.collider as usize),
                point: frame.to_world(pressure.point - pressure.normal * layer),
                normal: pressure.normal,
                depth: pressure.depth * frame.cell_size,
                force,
            })
        });
        let records = self.contacts.iter().flat_map(|contacts| contacts.records());
        let between = records.map(|(pair, force)| {
            let [body, other] = pair.bodies.map(|body| body as usize);
            // The normal and the force refer to the lesser body.
            let (body, other, sign) = if body <= other { (body, other, 1.0) } else { (other, body, -1.0) };
            ContactPoint {
                body,
                other: Touched::Body(other),
                point: pair.point,
                normal: pair.normal * sign,
                depth: pair.depth,
                force: force * sign,
            }
        });
        let mut contacts = self.restored_contacts.clone();
        contacts.extend(with_colliders.chain(between));
        if !self.restored_contacts.is_empty() {
            contacts.sort_by_key(|contact| match contact.other {
                Touched::Collider(_) => (0, contact.body),
                Touched::Body(_) => (1, 0),
            });
        }
        contacts
    }

    /// Removes the restored contacts of bodies that are awake.
    pub(super) fn forget_restored_contacts(&mut self) {
        let Self { restored_contacts, bodies, .. } = self;
        restored_contacts.retain(|contact| match contact.other {
            Touched::Body(other) => bodies[contact.body].is_asleep() && bodies[other].is_asleep(),
            Touched::Collider(_) => bodies[contact.body].is_asleep(),
        });
    }

    /// Removes the restored contacts of a body, which is no longer there.
    pub(super) fn remove_restored_contacts(&mut self, removed: usize) {
        self.restored_contacts.retain_mut(|contact| {
            let lower = |index: &mut usize| {
                let is_other = *index != removed;
                *index -= usize::from(*index > removed);
                is_other
            };
            let touches_other = match &mut contact.other {
                Touched::Body(other) => lower(other),
                Touched::Collider(_) => true,
            };
            lower(&mut contact.body) && touches_other
        });
    }

    /// Returns whether the bodies and the collider of a contact exist.
    pub(super) fn has_touched(&self, contact: &ContactPoint) -> bool {
        contact.body < self.bodies.len()
            && match contact.other {
                Touched::Body(other) => other < self.bodies.len(),
                Touched::Collider(other) => other < self.colliders.len(),
            }
    }
}
