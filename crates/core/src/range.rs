//! Range checks of user-supplied numbers.

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
