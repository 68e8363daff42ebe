//! Options of the contact with other bodies.

use crate::error::Error;
use crate::range::Range;

/// Options of the contact with other bodies, and of rolling on colliders. Colliders have
/// [a friction and a restitution of their own](crate::Collider).
#[derive(Clone, Debug, PartialEq)]
pub struct TouchingOptions {
    /// Coulomb friction coefficient, >= 0; default 0.5. The coefficient of two bodies is the geometric mean of theirs.
    pub friction: f64,
    /// Coefficient of restitution, in [0, 1]; default 0. That of two bodies is the greater of theirs.
    pub restitution: f64,
    /// Coefficient of rolling resistance on colliders, >= 0: the greatest distance of the center of pressure of a
    /// contact from its middle, as a fraction of the radius of the contact. `None`, the default: 0.08 times the
    /// damping ratio of the material, or 0.016 with a damping rate above 0.
    pub rolling_resistance: Option<f64>,
    /// Distance outside of the surface at which the body touches, in scene units, from 0 to half of the longest side of
    /// its bounding box; default 0. Bodies rest at the sum of their thicknesses, and on a collider at the sum with
    /// [its thickness](crate::Collider::thickness). Open surfaces keep at least the distance that they keep without it.
    pub thickness: f64,
    /// Whether parts of the body touch each other; `None`, the default:
    /// [the simulation](crate::SimulationBuilder::self_contact) decides.
    pub self_contact: Option<bool>,
    /// Names of bodies that the body does not touch, whichever of the two names the other; default none. A name that no
    /// body has has no effect.
    pub ignored: Vec<String>,
    /// Whether the body touches soft bodies alone, neither colliders nor rigid bodies; default false. For a rigid body
    /// that another program moves, which computes its other contacts: see
    /// [`Body::set_rigid_motion`](crate::Body::set_rigid_motion).
    pub soft_only: bool,
}

impl Default for TouchingOptions {
    fn default() -> Self {
        let (rolling_resistance, self_contact) = (None, None);
        Self {
            friction: 0.5,
            restitution: 0.0,
            rolling_resistance,
            thickness: 0.0,
            self_contact,
            ignored: Vec::new(),
            soft_only: false,
        }
    }
}

impl TouchingOptions {
    /// Checks the ranges.
    pub(super) fn validate(&self) -> Result<(), Error> {
        let &Self { friction, restitution, .. } = self;
        Range::NOT_NEGATIVE.check("friction", friction)?;
        Range::FRACTION.check("restitution", restitution)?;
        let rolling = self.rolling_resistance.unwrap_or(0.0);
        Range::NOT_NEGATIVE.check("rolling_resistance", rolling)?;
        Range::NOT_NEGATIVE.check("thickness", self.thickness)?;
        Ok(())
    }

    /// Checks the thickness of a body with this longest side.
    pub(super) fn check_size(&self, longest_side: f64) -> Result<(), Error> {
        let (thickness, limit) = (self.thickness, 0.5 * longest_side);
        if thickness > limit { Err(Error::Thickness { thickness, limit }) } else { Ok(()) }
    }
}
