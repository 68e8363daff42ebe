//! The settings of a new body for contact.

use super::builder::{BodyBuilder, keyed};
use super::touching::TouchingOptions;
use crate::motion::Curve;

impl BodyBuilder {
    /// Sets how the body touches other bodies: friction, restitution, thickness, self-contact and the bodies that it
    /// does not touch.
    pub fn touching(mut self, touching: TouchingOptions) -> Self {
        (self.touching, self.keyed.friction) = (touching, None);
        self
    }

    /// Sets the Coulomb friction coefficient of the body at other bodies, >= 0, a number or keyframes; default 0.5. The
    /// coefficient of two bodies is the geometric mean of theirs. At a collider, that of the collider holds.
    pub fn friction(mut self, friction: impl Into<Curve>) -> Self {
        (self.touching.friction, self.keyed.friction) = keyed(friction);
        self
    }

    /// Sets the coefficient of restitution of the body at other bodies, in [0, 1]; default 0. That of two bodies is the
    /// greater of theirs. At a collider, that of the collider holds.
    pub fn restitution(mut self, restitution: f64) -> Self {
        self.touching.restitution = restitution;
        self
    }

    /// Sets the coefficient of rolling resistance on colliders, >= 0: see [`TouchingOptions::rolling_resistance`].
    pub fn rolling_resistance(mut self, coefficient: f64) -> Self {
        self.touching.rolling_resistance = Some(coefficient);
        self
    }

    /// Sets the distance outside of the surface at which the body touches, in scene units: see
    /// [`TouchingOptions::thickness`]; default 0.
    pub fn thickness(mut self, thickness: f64) -> Self {
        self.touching.thickness = thickness;
        self
    }

    /// Sets whether parts of the body touch each other. By default the
    /// [simulation](crate::SimulationBuilder::self_contact) decides.
    pub fn self_contact(mut self, enabled: bool) -> Self {
        self.touching.self_contact = Some(enabled);
        self
    }

    /// Adds the name of a body that this one does not touch, whichever of the two names the other.
    pub fn ignore(mut self, name: impl Into<String>) -> Self {
        self.touching.ignored.push(name.into());
        self
    }
}
