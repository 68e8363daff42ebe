//! Colliders: shapes with friction and restitution, at rest or in motion.

use thiserror::Error;

use super::Shape;
use crate::dynamics::{Key, MotionError, direction};

/// Something that bodies cannot enter.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// What it is.
    pub shape: Shape,
    /// Coulomb coefficient, >= 0: greatest tangential over normal impulse. Default 0.5; 0 slides freely.
    pub friction: f64,
    /// Speed after over speed before an impact, [0, 1]. Default 0: no bounce. At 1 the surface leaves as fast as it came;
    /// what the body keeps of its height is less, since it vibrates after the impact. Impacts slower than two steps of
    /// free fall do not bounce.
    pub restitution: f64,
    /// Motion of the shape about its centre. Default: none, it rests.
    pub keys: Vec<Key>,
}

/// Why a collider cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ColliderError {
    /// A number is NaN or infinite.
    #[error("collider {collider}: {name} is {value}; it must be finite")]
    NotFinite {
        /// Index of the collider, from 0.
        collider: usize,
        /// Which number.
        name: &'static str,
        /// The number.
        value: f64,
    },
    /// A length must be positive.
    #[error("collider {collider}: {name} is {value}; it must be greater than 0")]
    NotPositive {
        /// Index of the collider, from 0.
        collider: usize,
        /// `radius` or `half_extents`.
        name: &'static str,
        /// The number.
        value: f64,
    },
    /// A plane without direction.
    #[error("collider {collider}: the plane's normal is zero; give the direction of the free side")]
    ZeroNormal {
        /// Index of the collider, from 0.
        collider: usize,
    },
    /// Friction is negative.
    #[error("collider {collider}: friction is {value}; its range is 0 and above")]
    Friction {
        /// Index of the collider, from 0.
        collider: usize,
        /// The number.
        value: f64,
    },
    /// Restitution is out of range.
    #[error("collider {collider}: restitution is {value}; its range is 0 to 1")]
    Restitution {
        /// Index of the collider, from 0.
        collider: usize,
        /// The number.
        value: f64,
    },
    /// The keys are no motion.
    #[error("collider {collider}: {source}")]
    Motion {
        /// Index of the collider, from 0.
        collider: usize,
        /// What is wrong with them.
        source: MotionError,
    },
}

impl Collider {
    /// A collider at rest with the default friction and restitution.
    pub fn new(shape: Shape) -> Self {
        Self { shape, friction: 0.5, restitution: 0.0, keys: Vec::new() }
    }

    /// The half space below the plane through `point` whose free side `normal` points to.
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self::new(Shape::Plane { point, normal })
    }

    /// A ball.
    pub fn sphere(center: [f64; 3], radius: f64) -> Self {
        Self::new(Shape::Sphere { center, radius })
    }

    /// A box, turned by Euler angles in degrees.
    pub fn cuboid(center: [f64; 3], half_extents: [f64; 3], rotate: [f64; 3]) -> Self {
        Self::new(Shape::Box { center, half_extents, rotate })
    }

    /// A capsule about the segment from `a` to `b`.
    pub fn capsule(a: [f64; 3], b: [f64; 3], radius: f64) -> Self {
        Self::new(Shape::Capsule { a, b, radius })
    }

    pub(super) fn validate(&self, collider: usize) -> Result<(), ColliderError> {
        let finite = |name, values: &[f64]| match values.iter().find(|v| !v.is_finite()) {
            Some(&value) => Err(ColliderError::NotFinite { collider, name, value }),
            None => Ok(()),
        };
        let positive = |name, values: &[f64]| match values.iter().find(|&&v| v <= 0.0) {
            Some(&value) => Err(ColliderError::NotPositive { collider, name, value }),
            None => Ok(()),
        };
        match &self.shape {
            Shape::Plane { point, normal } => {
                finite("point", point)?;
                finite("normal", normal)?;
                direction(*normal).ok_or(ColliderError::ZeroNormal { collider })?;
            }
            Shape::Sphere { center, radius } => {
                finite("center", center)?;
                finite("radius", &[*radius])?;
                positive("radius", &[*radius])?;
            }
            Shape::Box { center, half_extents, rotate } => {
                finite("center", center)?;
                finite("half_extents", half_extents)?;
                finite("rotate", rotate)?;
                positive("half_extents", half_extents)?;
            }
            Shape::Capsule { a, b, radius } => {
                finite("a", a)?;
                finite("b", b)?;
                finite("radius", &[*radius])?;
                positive("radius", &[*radius])?;
            }
        }
        finite("friction", &[self.friction])?;
        finite("restitution", &[self.restitution])?;
        if self.friction < 0.0 {
            return Err(ColliderError::Friction { collider, value: self.friction });
        }
        if !(0.0..=1.0).contains(&self.restitution) {
            return Err(ColliderError::Restitution { collider, value: self.restitution });
        }
        Ok(())
    }
}
