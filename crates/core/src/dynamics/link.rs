//! Links: glue or springs between parts of two bodies, or between a part of a body and the world.

use super::selection::{Selection, SelectionError};
use crate::range::{Range, RangeError};

/// An invalid link.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// A number out of range.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// An invalid or empty part.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// A link of a body with itself.
    #[error("a link joins the body {body:?} to itself; give another body, or none for the world")]
    ToItself {
        /// Name of the body.
        body: String,
    },
    /// Glue over a distance.
    #[error(
        "the part of {body:?} that is glued to {other:?} is up to {cells:.1} cells away from it; glue parts that touch, or \
         give a stiffness, for springs"
    )]
    TooLong {
        /// Name of the body.
        body: String,
        /// Name of the other body.
        other: String,
        /// The greatest distance, in cells of the other body.
        cells: f64,
    },
}

/// Joins a part of a body to another body or to the world.
///
/// ```
/// use supple::{Link, Selection};
///
/// // The hat is glued to the head where it is inside the ball, until 50 N tear it off.
/// let part = Selection::Sphere { center: [0.0, 2.0, 0.0], radius: 0.5 };
/// let link = Link { other: Some("head".to_owned()), break_force: Some(50.0), ..Link::new("hat", part) };
/// # assert!(link.validate().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name of the body.
    pub body: String,
    /// The part of the body that is joined, at frame 0. Each of its lattice vertices is tied to the other body.
    pub selection: Selection,
    /// Name of the other body; `None`, the default: the world, in which the part stays where it is at frame 0.
    pub other: Option<String>,
    /// Stiffness of the whole link, above 0, in force per length: each vertex is on a spring to the nearest point of the
    /// other body at frame 0, whose rest length is their distance then. `None`, the default: glue, which keeps each
    /// vertex at its place on the other body.
    pub stiffness: Option<f64>,
    /// Damping ratio of the springs, in [0, 1]; default 0.2. Glue has none.
    pub damping_ratio: f64,
    /// The force, above 0, at which the link breaks for good; `None`, the default: it does not break.
    pub break_force: Option<f64>,
}

impl Link {
    /// Creates glue between a part of a body and the world, which does not break.
    pub fn new(body: impl Into<String>, selection: Selection) -> Self {
        Self {
            body: body.into(),
            selection,
            other: None,
            stiffness: None,
            damping_ratio: 0.2,
            break_force: None,
        }
    }

    /// Checks the numbers and the selection.
    ///
    /// # Errors
    ///
    /// A number out of range, an invalid selection, or a link of a body with itself.
    pub fn validate(&self) -> Result<(), LinkError> {
        self.selection.validate()?;
        for (name, value) in [("stiffness", self.stiffness), ("break", self.break_force)] {
            value.map(|value| Range::POSITIVE.check(name, value)).transpose()?;
        }
        Range::FRACTION.check("damping_ratio", self.damping_ratio)?;
        if self.other.as_ref() == Some(&self.body) {
            return Err(LinkError::ToItself { body: self.body.clone() });
        }
        Ok(())
    }
}
