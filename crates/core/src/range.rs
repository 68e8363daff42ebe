//! The ranges of user-supplied numbers, and their checks.

use std::ops::RangeInclusive;

/// Least to greatest ratio of the rest volume.
pub(crate) const RATIOS: RangeInclusive<f64> = 0.1..=10.0;

/// A range of finite numbers. The constants are the ranges of the numbers that scenes, Python and Rust have in common,
/// except of counts.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    is_inside: fn(f64) -> bool,
    text: &'static str,
}

impl Range {
    /// A finite number.
    pub const FINITE: Self = Self::new(|_| true, "a finite number");
    /// A number above 0.
    pub const POSITIVE: Self = Self::new(|x| x > 0.0, "a number above 0");
    /// A number of at least 0.
    pub const NOT_NEGATIVE: Self = Self::new(|x| x >= 0.0, "a number of at least 0");
    /// A fraction: in [0, 1].
    pub const FRACTION: Self = Self::new(|x| (0.0..=1.0).contains(&x), "in [0, 1]");
    /// A fraction that is not 0: in (0, 1].
    pub const POSITIVE_FRACTION: Self = Self::new(|x| x > 0.0 && x <= 1.0, "in (0, 1]");
    /// A length above 0.
    pub const LENGTH: Self = Self::new(|x| x > 0.0, "a length > 0");
    /// Young's modulus.
    pub const YOUNGS_MODULUS: Self = Self::new(|x| x > 0.0, "a force per area > 0");
    /// Poisson's ratio. Above 0.47 steps would become very short without a visible gain.
    pub const POISSON_RATIO: Self = Self::new(|x| (0.0..=0.47).contains(&x), "in [0, 0.47]");
    /// Half-width of the regions, in cells.
    pub const HALF_WIDTH: Self = Self::new(
        |x| x == 0.5 || (x >= 1.0 && x.fract() == 0.0),
        "0.5 or a whole number of cells, at least 1",
    );
    /// A frequency.
    pub const FREQUENCY: Self = Self::new(|x| x > 0.0, "a frequency in Hz, > 0");
    /// Number of frames per second.
    pub const FPS: Self = Self::new(|x| x > 0.0, "frames per second, > 0");
    /// Rate of damping.
    pub const RATE: Self = Self::new(|x| x >= 0.0, "a rate in 1/s, >= 0");
    /// Rate of plastic creep.
    pub const CREEP: Self = Self::new(|x| x > 0.0, "a rate in 1/s, > 0");
    /// Greatest plastic strain.
    pub const PLASTIC_STRAIN: Self = Self::new(|x| x > 0.0 && x <= 2.0, "in (0, 2]");
    /// Factor of the stiffness.
    pub const STIFFNESS_FACTOR: Self = Self::new(|x| x > 0.0 && x <= 100.0, "in (0, 100]");
    /// Ratio of the rest volume to that of the mesh.
    pub const INFLATION: Self = Self::new(|x| RATIOS.contains(&x), "in [0.1, 10]");
    /// Simulated seconds per second of frames.
    pub const TIME_SCALE: Self = Self::new(|x| x > 0.0 && x <= 10.0, "in (0, 10]");
    /// Time that is simulated before frame 0.
    pub const PREROLL: Self = Self::new(|x| (0.0..=1e6).contains(&x), "a time in seconds, in [0, 1e6]");
    /// Angle between neighboring cells at which a body breaks.
    pub const BREAK_ANGLE: Self = Self::new(|x| x > 0.0 && x <= 180.0, "in (0, 180] degrees");
    /// Relative variation of the strength.
    pub const NOISE: Self = Self::new(|x| (0.0..=0.5).contains(&x), "in [0, 0.5]");

    const fn new(is_inside: fn(f64) -> bool, text: &'static str) -> Self {
        Self { is_inside, text }
    }

    /// Returns whether a number is finite and in the range.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite() && (self.is_inside)(value)
    }

    /// Returns the description of the range, as in "it must be {text}".
    pub fn text(self) -> &'static str {
        self.text
    }

    /// Returns `value` if it is in the range; otherwise a [`RangeError`].
    pub(crate) fn check(self, name: &'static str, value: f64) -> Result<f64, RangeError> {
        in_range(name, value, self.contains(value), self.text)
    }
}

/// A number out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {} is out of range: it must be {range}", format_value(*.value))]
pub struct RangeError {
    /// Name of the number, as in a scene file.
    pub name: &'static str,
    /// The value that was passed.
    pub value: f64,
    /// Description of the valid range.
    pub range: &'static str,
}

/// Formats a number, with an exponent if its magnitude is at least 1e15.
fn format_value(value: f64) -> String {
    if value.abs() >= 1e15 { format!("{value:e}") } else { value.to_string() }
}

/// Returns `value` if it is finite and `valid` is true; otherwise a [`RangeError`].
pub(crate) fn in_range(
    name: &'static str,
    value: f64,
    valid: bool,
    range: &'static str,
) -> Result<f64, RangeError> {
    if value.is_finite() && valid { Ok(value) } else { Err(RangeError { name, value, range }) }
}
