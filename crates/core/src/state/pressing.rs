//! Contacts that pressed in a step, as one contact at their center of pressure.

use nalgebra::Vector3;

/// The contacts of two sides that pressed on each other in a step, as one contact at their center of pressure, in the
/// units of its owner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pressing {
    /// Sum of the normal impulses.
    pub(crate) impulse: f64,
    /// Sum of the normal impulses times the factors of friction.
    pub(crate) grip: f64,
    /// Sum of the friction impulses.
    pub(crate) friction: [f64; 3],
    /// Center of pressure.
    pub(crate) point: [f64; 3],
    /// Mean of the squared distances of the contacts from the center of pressure.
    pub(crate) squared_radius: f64,
    /// Mean normal, a unit vector; zero if the normals cancel each other.
    pub(crate) normal: [f64; 3],
    /// Part of the normal impulses that acts along the mean normal, from 0 to 1.
    pub(crate) aligned: f64,
    /// Deflection by rotation, in rad.
    pub(crate) rotation: Deflection,
    /// Deflection by sliding, as a fraction of the size of the smaller side.
    pub(crate) sliding: Deflection,
}

/// A deflection: see `dynamics::elastic_damping`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Deflection {
    pub(crate) vector: [f64; 3],
    /// Greatest length of the vector; 0 for the initial limit.
    pub(crate) limit: f64,
    /// Whether the vector has reached the limit since the motion last reversed.
    pub(crate) is_at_limit: bool,
}

/// A contact that pressed in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PressingContact {
    /// Normal impulse, > 0.
    pub(crate) impulse: f64,
    /// Factor of the coefficient of friction.
    pub(crate) friction_factor: f64,
    pub(crate) friction: Vector3<f64>,
    pub(crate) point: Vector3<f64>,
    /// A unit vector.
    pub(crate) normal: Vector3<f64>,
}

impl Pressing {
    /// Begins the sums of a step. Only the deflections of the step before remain.
    pub(super) fn begin(&mut self) {
        let Self { rotation, sliding, .. } = *self;
        *self = Self { rotation, sliding, ..Self::default() };
    }

    /// Adds a contact to the sums of impulses, and of points and normals times the impulses.
    pub(super) fn add(&mut self, contact: &PressingContact) {
        let &PressingContact { impulse, friction_factor, friction, point, normal } = contact;
        self.impulse += impulse;
        self.grip += impulse * friction_factor;
        self.squared_radius += impulse * point.norm_squared();
        for c in 0..3 {
            self.friction[c] += friction[c];
            self.point[c] += impulse * point[c];
            self.normal[c] += impulse * normal[c];
        }
    }

    /// Converts the sums to means.
    pub(super) fn normalize(&mut self) {
        let scale = 1.0 / self.impulse;
        self.point = self.point.map(|sum| sum * scale);
        self.squared_radius =
            (self.squared_radius * scale - Vector3::from(self.point).norm_squared()).max(0.0);
        // Normals that cancel each other, all around a ball, have no mean.
        let normal = Vector3::from(self.normal) * scale;
        self.normal = normal.try_normalize(1e-3).unwrap_or_default().into();
        self.aligned = normal.norm();
    }

    /// Returns whether all numbers are finite.
    pub(super) fn is_valid(&self) -> bool {
        let vectors = self.point.iter().chain(&self.normal).chain(&self.friction);
        vectors.chain([&self.impulse, &self.grip, &self.squared_radius, &self.aligned]).all(|x| x.is_finite())
    }

    /// Returns the radius of the contact. `cell_size`: lattices resolve no smaller radius than half of it.
    pub(crate) fn radius(&self, cell_size: f64) -> f64 {
        (self.squared_radius + 0.25 * cell_size * cell_size).sqrt()
    }
}
