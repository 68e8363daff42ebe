//! f32 and f64 alike.

use std::ops::{Add, Mul, Sub};

use nalgebra::Scalar;

/// A floating-point number.
pub(super) trait Number:
    Scalar + Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// What it is called.
    const NAME: &'static str;

    /// The nearest one.
    fn of(value: f64) -> Self;

    /// The same number in f64.
    fn wide(self) -> f64;
}

impl Number for f32 {
    const NAME: &'static str = "f32";

    fn of(value: f64) -> Self {
        value as Self
    }

    fn wide(self) -> f64 {
        self.into()
    }
}

impl Number for f64 {
    const NAME: &'static str = "f64";

    fn of(value: f64) -> Self {
        value
    }

    fn wide(self) -> f64 {
        self
    }
}
