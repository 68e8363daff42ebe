//! Where a body starts, and how it moves there.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::angles::euler_degrees;
use crate::range::{RangeError, in_range};

/// How the model is placed in the world, after its scale; and how it moves at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Degrees about the fixed axes x, then y, then z; default 0.
    pub rotate: [f64; 3],
    /// Scene units; default 0.
    pub translate: [f64; 3],
    /// Scene units per second; default 0.
    pub velocity: [f64; 3],
    /// Radians per second about the center of mass; default 0.
    pub spin: [f64; 3],
}

impl Placement {
    /// The rotation from the model's axes to the world's.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_matrix(&euler_degrees(self.rotate))
    }

    /// From the model's frame to the world.
    pub fn isometry(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Vector3::from(self.translate).into(), self.rotation())
    }

    /// Checks that lengths and speeds are at most `limit`, and the spin at most 1e12 rad/s.
    pub(crate) fn within(&self, limit: f64) -> Result<(), RangeError> {
        let Self { translate, velocity, spin, .. } = *self;
        for (name, values) in [("translate", translate), ("velocity", velocity), ("spin", spin)] {
            let limit = if name == "spin" { 1e12 } else { limit };
            for value in values {
                in_range(name, value, value.abs() <= limit, "at most 1e15 cells (spin: 1e12 rad/s)")?;
            }
        }
        Ok(())
    }

    /// Checks that all numbers are finite.
    ///
    /// # Errors
    ///
    /// A number that is not finite.
    pub fn validate(&self) -> Result<(), RangeError> {
        let Self { rotate, translate, velocity, spin } = *self;
        let named = [("rotate", rotate), ("translate", translate), ("velocity", velocity), ("spin", spin)];
        for (name, value) in named.into_iter().flat_map(|(name, values)| values.map(|value| (name, value))) {
            in_range(name, value, true, "finite")?;
        }
        Ok(())
    }
}
