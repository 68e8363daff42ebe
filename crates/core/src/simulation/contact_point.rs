//! A contact of the last step.

use nalgebra::{Point3, Vector3};

/// The body or collider that a body touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Touched {
    /// The body with this index; the body itself in self-contact.
    Body(usize),
    /// The collider with this index.
    Collider(usize),
}

/// A contact of the last step, in scene units. The surface samples of a body that are near the same lattice vertex, or
/// the same point of a grid of half the cell size between two bodies, are one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "SavedContact", from = "SavedContact"))]
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

/// A contact as numbers.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct SavedContact {
    body: usize,
    other: Touched,
    depth: f64,
    vectors: [[f64; 3]; 3],
}

#[cfg(feature = "serde")]
impl From<ContactPoint> for SavedContact {
    fn from(contact: ContactPoint) -> Self {
        let ContactPoint { body, other, point, normal, depth, force } = contact;
        Self { body, other, depth, vectors: [point.coords, normal, force].map(Into::into) }
    }
}

#[cfg(feature = "serde")]
impl From<SavedContact> for ContactPoint {
    fn from(SavedContact { body, other, depth, vectors }: SavedContact) -> Self {
        let [point, normal, force] = vectors.map(Vector3::from);
        Self { body, other, point: point.into(), normal, depth, force }
    }
}
