//! Defines the initial position, orientation and velocity of a body.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::motion::euler_degrees;
use crate::range::{RangeError, in_range};

/// Placement of the scaled model in the world, and its initial velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Euler angles in degrees about the fixed axes x, then y, then z; default 0.
    pub rotate: [f64; 3],
    /// Translation in scene units; default 0.
    pub translate: [f64; 3],
    /// Velocity in scene units per second; default 0.
    pub velocity: [f64; 3],
    /// Angular velocity in radians per second about the center of mass; default 0.
    pub spin: [f64; 3],
}

impl Placement {
    /// Returns the rotation from the model's axes to the world axes.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_matrix(&euler_degrees(self.rotate))
    }

    /// Returns the rigid transformation from the model's frame to world space.
    pub fn isometry(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Vector3::from(self.translate).into(), self.rotation())
    }

    /// Checks that each component of the translation and the velocity has a magnitude of at most `limit`, and
    /// each component of the spin a magnitude of at most 1e12 rad/s.
    pub(crate) fn check_limit(&self, limit: f64) -> Result<(), RangeError> {
        let Self { translate, velocity, spin, .. } = *self;
        for (name, values) in [("translate", translate), ("velocity", velocity), ("spin", spin)] {
            let limit = if name == "spin" { 1e12 } else { limit };
            for value in values {
                in_range(name, value, value.abs() <= limit, "at most 1e15 cells (spin: 1e12 rad/s)")?;
            }
        }
        Ok(())
    }

    /// Checks that all values are finite.
    ///
    /// # Errors
    ///
    /// If a value is not finite.
    pub fn validate(&self) -> Result<(), RangeError> {
        let Self { rotate, translate, velocity, spin } = *self;
        let named = [("rotate", rotate), ("translate", translate), ("velocity", velocity), ("spin", spin)];
        for (name, value) in named.into_iter().flat_map(|(name, values)| values.map(|value| (name, value))) {
            in_range(name, value, true, "finite")?;
        }
        Ok(())
    }
}
