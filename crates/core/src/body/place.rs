//! Where a body starts: turned, moved, and in motion.

use nalgebra::{UnitQuaternion, Vector3};

use crate::dynamics::euler_degrees;

/// How the model is placed in the world, after its scale; and how it moves at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Degrees about the fixed axes x, then y, then z; default 0.
    pub rotate: [f64; 3],
    /// Scene units; default 0.
    pub translate: [f64; 3],
    /// Scene units per second; default 0.
    pub velocity: [f64; 3],
    /// Radians per second about the centre of mass; default 0.
    pub spin: [f64; 3],
}

impl Placement {
    /// The turn from the model's axes to the world's.
    pub(crate) fn rotation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_matrix(&euler_degrees(self.rotate))
    }

    /// The shift of the model in the world.
    pub(crate) fn translation(&self) -> Vector3<f64> {
        Vector3::from(self.translate)
    }
}
