//! Numbers that users give, and their ranges.

/// A number out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {} is out of range: it must be {range}", short(*.value))]
pub struct RangeError {
    /// The name of the number, as in a scene file.
    pub name: &'static str,
    /// What was given.
    pub value: f64,
    /// What is taken.
    pub range: &'static str,
}

/// A number as a person would write it.
fn short(value: f64) -> String {
    if value.abs() >= 1e15 { format!("{value:e}") } else { value.to_string() }
}

/// `value`, if it is finite and `inside`.
pub(crate) fn in_range(
    name: &'static str,
    value: f64,
    inside: bool,
    range: &'static str,
) -> Result<f64, RangeError> {
    if value.is_finite() && inside { Ok(value) } else { Err(RangeError { name, value, range }) }
}
