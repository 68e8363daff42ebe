//! Ranges of numbers, which know how to say themselves.

use std::fmt;

/// The range of a number; infinities and NaN lie in none.
#[derive(Clone, Copy, Debug)]
pub(super) enum Range {
    /// Any number.
    Finite,
    /// Above zero.
    Positive,
    /// Zero or above.
    NotNegative,
    /// Above zero, up to and including one.
    Share,
    /// Zero to one, both included.
    Unit,
    /// Above this.
    Above(f64),
}

impl Range {
    /// Whether the range holds a number.
    pub(super) fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::Share => value > 0.0 && value <= 1.0,
                Self::Unit => (0.0..=1.0).contains(&value),
                Self::Above(low) => value > low,
            }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => write!(f, "a finite number"),
            Self::Positive => write!(f, "a number above 0"),
            Self::NotNegative => write!(f, "a number of at least 0"),
            Self::Share => write!(f, "in (0, 1]"),
            Self::Unit => write!(f, "in [0, 1]"),
            Self::Above(low) => write!(f, "a number above {low}"),
        }
    }
}
