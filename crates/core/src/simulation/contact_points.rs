//! Reports the contacts of the last step.

use nalgebra::{Point3, Vector3};

use super::world::Simulation;

/// The body or collider that a body touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Touched {
    /// The body with this index; the body itself in self-contact.
    Body(usize),
    /// The collider with this index.
    Collider(usize),
}

/// A contact of the last step, in scene units. The surface samples of a body that are near the same lattice vertex, or
/// the same point of a grid of half the cell size between two bodies, are one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactPoint {
    /// Index of the body; the lesser one of two bodies.
    pub body: usize,
    /// The other body or the collider.
    pub other: Touched,
    /// Position of the contact: on the surface of the body, or with a thickness in front of it, where the layers around
    /// both surfaces meet.
    pub point: Point3<f64>,
    /// Unit normal, from the other towards the body.
    pub normal: Vector3<f64>,
    /// Greatest depth at which the surfaces, or the layers around them, overlap at the end of the step, if all of the
    /// contact moved like its point; negative for a gap.
    pub depth: f64,
    /// Force on the body during the step: pressure, friction, and what the elastic damping takes from the contact.
    pub force: Vector3<f64>,
}

impl Simulation {
    /// Returns the contacts of the last step: those with colliders, by body, then those between bodies. A sleeping body
    /// has the contacts with which it fell asleep. Empty after [`restore`](Self::restore).
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
        with_colliders.chain(between).collect()
    }
}
