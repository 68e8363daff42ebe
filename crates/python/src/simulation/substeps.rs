//! Reads the number of steps per frame.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use supple::Substeps;

use crate::argument;

/// The name of [`Substeps::Auto`] in Python.
pub(super) const AUTO: &str = "auto";

/// Reads a number of steps per frame, or "auto".
pub(super) fn substeps(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Substeps> {
    let Ok(word) = value.cast::<PyString>() else {
        return argument::count_u32(value, name, 1).map(Substeps::Fixed);
    };
    match word.to_str()? {
        AUTO => Ok(Substeps::Auto),
        other => Err(PyValueError::new_err(format!(
            "{name} is {other:?}; it must be \"auto\" or a whole number, at least 1"
        ))),
    }
}
