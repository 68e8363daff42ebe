//! Fields: accelerations that depend on place, velocity and time, and act on all bodies or on some.
//!
//! | file | contents |
//! |---|---|
//! | `law` | the kinds of fields, and their accelerations |
//! | `accelerations` | the accelerations of the vertices of a body |
//! | `wind` | a wind, with its gusts and eddies |

mod accelerations;
mod law;
mod wind;

pub(super) use accelerations::FieldAccelerations;
pub use law::{Attraction, FieldLaw, Vortex};
pub use wind::Wind;

use nalgebra::{Point3, Vector3};

use self::law::Moment;
use super::selection::{Selection, SelectionError};
use crate::motion::{Curve, CurveKey};
use crate::range::{RangeError, in_range};
use crate::state::Interval;

/// An invalid field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// A number out of range.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// A part of space that is invalid or no shape.
    #[error(transparent)]
    Selection(#[from] SelectionError),
}

/// An acceleration field, which acts in every step on all bodies of a simulation or on some of them.
///
/// ```
/// use supple::{Field, FieldLaw, Wind};
///
/// let wind = Wind { velocity: [4.0, 0.0, 0.0], gust: 0.5, ..Wind::default() };
/// let field = Field { bodies: vec!["flag".to_owned()], ..Field::new(FieldLaw::Wind(wind)) };
/// # assert!(field.validate().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Field {
    /// The acceleration.
    pub law: FieldLaw,
    /// Factor of the acceleration, at least 0: a number or keyframes; default 1.
    pub strength: Curve,
    /// Names of the bodies on which the field acts; empty, the default: all bodies.
    pub bodies: Vec<String>,
    /// The part of space in which the field acts: a shape; `None`, the default: everywhere.
    pub within: Option<Selection>,
}

impl Field {
    /// Creates a field of strength 1 that acts on all bodies everywhere.
    pub fn new(law: FieldLaw) -> Self {
        Self { law, strength: 1.0.into(), bodies: Vec::new(), within: None }
    }

    /// Checks the numbers of the field.
    ///
    /// # Errors
    ///
    /// A number out of range, or a part of space that is no shape or invalid.
    pub fn validate(&self) -> Result<(), FieldError> {
        self.law.validate()?;
        for CurveKey { value, .. } in self.strength.keys() {
            in_range("strength", *value, (0.0..=1e12).contains(value), "at least 0 and at most 1e12")?;
        }
        match &self.within {
            None => Ok(()),
            Some(shape) if shape.is_shape() => Ok(shape.validate()?),
            Some(_) => Err(SelectionError::NoShape.into()),
        }
    }

    /// Returns whether the field acts on a body.
    pub(crate) fn acts_on(&self, body: &str) -> bool {
        self.bodies.is_empty() || self.bodies.iter().any(|name| name == body)
    }

    /// Returns whether the acceleration of a body at rest is the same at all times.
    pub(crate) fn is_steady(&self) -> bool {
        self.strength.constant().is_some() && self.law.is_steady()
    }

    /// Returns the acceleration in a step.
    pub(crate) fn in_step(&self, step: Interval) -> FieldInStep<'_> {
        FieldInStep { field: self, moment: Moment::new(&self.law, self.strength.value(step.start), step) }
    }
}

/// A field in a step.
#[derive(Debug)]
pub(crate) struct FieldInStep<'a> {
    field: &'a Field,
    moment: Moment,
}

impl FieldInStep<'_> {
    /// Returns whether the field has no effect in the step.
    pub(crate) fn is_zero(&self) -> bool {
        self.moment.strength == 0.0
    }

    /// Returns the mean acceleration in the step of a point with a velocity.
    pub(crate) fn acceleration(&self, point: &Point3<f64>, velocity: &Vector3<f64>) -> Vector3<f64> {
        match &self.field.within {
            Some(shape) if shape.distance(point) > 0.0 => Vector3::zeros(),
            _ => self.field.law.acceleration(&self.moment, point, velocity),
        }
    }
}
