//! Single arguments: numbers, words, truth values, each named in its error.

use std::path::PathBuf;

use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyString};

/// A real number, finite or not.
pub(crate) fn number(value: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    if value.is_instance_of::<PyString>() || value.is_instance_of::<PyBool>() {
        return Err(wrong_type(value, name, "a number"));
    }
    value.extract().map_err(|error: PyErr| match error.is_instance_of::<PyOverflowError>(value.py()) {
        true => PyValueError::new_err(format!("{name} is too large for a number")),
        false => wrong_type(value, name, "a number"),
    })
}

/// A whole number of at least `least`.
pub(crate) fn count(value: &Bound<'_, PyAny>, name: &str, least: usize) -> PyResult<usize> {
    if value.is_instance_of::<PyBool>() || !value.hasattr("__index__")? {
        return Err(wrong_type(value, name, "a whole number"));
    }
    match value.extract::<i64>() {
        Ok(count) if count >= 0 && count as usize >= least => Ok(count as usize),
        _ => Err(PyValueError::new_err(format!(
            "{name} = {value} is out of range: it must be a whole number, at least {least}"
        ))),
    }
}

/// True or false.
pub(crate) fn boolean(value: &Bound<'_, PyAny>, name: &str) -> PyResult<bool> {
    value.extract().map_err(|_| wrong_type(value, name, "True or False"))
}

/// A word or a text.
pub(crate) fn text(value: &Bound<'_, PyAny>, name: &str) -> PyResult<String> {
    value.extract().map_err(|_| wrong_type(value, name, "a string"))
}

/// A path: a string or anything with `__fspath__`.
pub(crate) fn path(value: &Bound<'_, PyAny>, name: &str) -> PyResult<PathBuf> {
    value.extract().map_err(|_| wrong_type(value, name, "a path (str or os.PathLike)"))
}

/// One of a few words.
pub(crate) fn choice<T: Copy>(value: &Bound<'_, PyAny>, name: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let word = text(value, name)?;
    choices.iter().find(|(known, _)| *known == word).map(|(_, meaning)| *meaning).ok_or_else(|| {
        let known: Vec<String> = choices.iter().map(|(known, _)| format!("{known:?}")).collect();
        PyValueError::new_err(format!("{name} is {word:?}; it must be {}", known.join(" or ")))
    })
}

/// "must be ..., not ...".
pub(crate) fn wrong_type(value: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyErr {
    let found = match value.is_none() {
        true => "None".to_owned(),
        false => value.get_type().qualname().map_or_else(|_| "another type".to_owned(), |n| n.to_string()),
    };
    PyTypeError::new_err(format!("{name} must be {expected}, not {found}"))
}
