//! The supports of a body: the contacts that pressed on it in the last step.

use nalgebra::Vector3;

/// The contacts of one component with one collider that pressed on the body in a step, as one contact at their center
/// of pressure. Lengths are in cells, velocities in cells/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Support {
    /// Index of the connected component.
    pub(crate) component: u32,
    /// Index of the collider.
    pub(crate) collider: u32,
    /// Sum of the normal impulses.
    pub(crate) impulse: f64,
    /// Center of pressure, from the body's origin.
    pub(crate) point: [f64; 3],
    /// Mean of the squared distances of the contacts from the center of pressure.
    pub(crate) squared_radius: f64,
    /// Mean normal, a unit vector; zero if the normals cancel each other.
    pub(crate) normal: [f64; 3],
    /// Velocity of the surface of the collider at the center of pressure.
    pub(crate) velocity: [f64; 3],
    /// Angular velocity of the collider in rad/s.
    pub(crate) spin: [f64; 3],
    /// Deflection of the support by rotation, in rad.
    pub(crate) rotation: Deflection,
    /// Deflection of the support by sliding, as a fraction of the size of the body.
    pub(crate) sliding: Deflection,
}

/// The deflection of a support: see `dynamics::elastic_damping`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Deflection {
    pub(crate) vector: [f64; 3],
    /// Greatest length of the vector; 0 for the initial limit.
    pub(crate) limit: f64,
    /// Whether the vector has reached the limit since the motion last reversed.
    pub(crate) is_at_limit: bool,
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
    pub(crate) fn set(&mut self, contacts: impl Iterator<Item = Support>) {
        for Support { impulse, point, squared_radius, normal, velocity, .. } in &mut self.0 {
            (*impulse, *point, *normal, *velocity) = (0.0, [0.0; 3], [0.0; 3], [0.0; 3]);
            *squared_radius = 0.0;
        }
        // Contacts of the same support mostly follow each other.
        let mut last = 0;
        for contact in contacts {
            let is_of = |support: &Support| {
                (support.component, support.collider) == (contact.component, contact.collider)
            };
            if !self.0.get(last).is_some_and(is_of) {
                last = self.0.iter().position(is_of).unwrap_or_else(|| {
                    let Support { component, collider, .. } = contact;
                    self.0.push(Support { component, collider, ..Support::default() });
                    self.0.len() - 1
                });
            }
            self.0[last].add(&contact);
        }
        self.0.retain(|support| support.impulse > 0.0);
        self.0.iter_mut().for_each(Support::normalize);
    }

    /// Moves the centers of pressure by `offset`.
    pub(super) fn shift(&mut self, offset: Vector3<f64>) {
        for support in &mut self.0 {
            support.point = (Vector3::from(support.point) + offset).into();
        }
    }
}

impl Support {
    /// Adds a contact to the sums of impulses, and of points, normals and velocities times the impulses.
    fn add(&mut self, contact: &Self) {
        self.impulse += contact.impulse;
        self.spin = contact.spin;
        self.squared_radius += contact.impulse * Vector3::from(contact.point).norm_squared();
        for c in 0..3 {
            self.point[c] += contact.impulse * contact.point[c];
            self.normal[c] += contact.impulse * contact.normal[c];
            self.velocity[c] += contact.impulse * contact.velocity[c];
        }
    }

    /// Converts the sums to means.
    fn normalize(&mut self) {
        let scale = 1.0 / self.impulse;
        self.point = self.point.map(|sum| sum * scale);
        self.squared_radius =
            (self.squared_radius * scale - Vector3::from(self.point).norm_squared()).max(0.0);
        self.velocity = self.velocity.map(|sum| sum * scale);
        // Normals that cancel each other, all around a ball, have no mean.
        let normal = Vector3::from(self.normal) * scale;
        self.normal = normal.try_normalize(1e-3).unwrap_or_default().into();
    }
}
