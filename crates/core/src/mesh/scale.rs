//! The factors by which a model is scaled.

use nalgebra::{Point3, Vector3};

/// Factors by which a model is scaled about its origin, before it is rotated and moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// One factor for all axes, finite and above 0.
    Uniform(f64),
    /// A factor for each axis of the model, finite and not 0. A negative factor mirrors the model at a plane.
    PerAxis([f64; 3]),
}

impl Scale {
    /// Returns the factors of the three axes.
    pub fn factors(self) -> [f64; 3] {
        match self {
            Self::Uniform(factor) => [factor; 3],
            Self::PerAxis(factors) => factors,
        }
    }

    /// Returns whether the model is mirrored: an odd number of factors is negative.
    pub fn is_mirror(self) -> bool {
        self.factors().iter().filter(|factor| **factor < 0.0).count() % 2 == 1
    }

    /// Returns the factor of a length of unknown direction: the cube root of the factor of volumes.
    pub fn of_lengths(self) -> f64 {
        match self {
            Self::Uniform(factor) => factor,
            Self::PerAxis([x, y, z]) => libm::cbrt(x.abs()) * libm::cbrt(y.abs()) * libm::cbrt(z.abs()),
        }
    }

    /// Returns the greatest magnitude of a factor.
    pub fn greatest(self) -> f64 {
        self.factors().iter().fold(0.0, |greatest, factor| factor.abs().max(greatest))
    }

    /// Returns a point of the model after it was scaled.
    pub fn apply(self, point: &Point3<f64>) -> Point3<f64> {
        match self {
            Self::Uniform(factor) => point * factor,
            Self::PerAxis(factors) => Point3::from(point.coords.component_mul(&Vector3::from(factors))),
        }
    }

    /// Returns the direction of a normal of the model after it was scaled, not of unit length: factors divide normals.
    /// Of a mirrored model the normal still points outward.
    pub fn apply_to_normal(self, normal: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Uniform(_) => *normal,
            Self::PerAxis(factors) => normal.component_div(&Vector3::from(factors)) * self.of_lengths(),
        }
    }

    /// Returns whether the factors are in their ranges.
    pub fn is_valid(self) -> bool {
        match self {
            Self::Uniform(factor) => factor.is_finite() && factor > 0.0,
            Self::PerAxis(factors) => factors.iter().all(|factor| factor.is_finite() && *factor != 0.0),
        }
    }
}

impl Default for Scale {
    fn default() -> Self {
        Self::Uniform(1.0)
    }
}

impl From<f64> for Scale {
    fn from(factor: f64) -> Self {
        Self::Uniform(factor)
    }
}

impl From<[f64; 3]> for Scale {
    fn from(factors: [f64; 3]) -> Self {
        Self::PerAxis(factors)
    }
}

impl std::fmt::Display for Scale {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Uniform(factor) => write!(f, "{factor}"),
            Self::PerAxis([x, y, z]) => write!(f, "[{x}, {y}, {z}]"),
        }
    }
}
