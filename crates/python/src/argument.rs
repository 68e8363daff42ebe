//! Checks arguments: numbers, strings, booleans, paths and keyword arguments. Each error names the argument.

use std::convert::Infallible;
use std::path::PathBuf;

use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::Borrowed;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use supple_io::scene::way_out;

/// An argument that may be missing, as the default of a pyo3 signature. Unlike `Option`, it distinguishes a
/// missing argument from `None`.
pub(crate) struct Given<'py>(pub(crate) Option<Bound<'py, PyAny>>);

impl<'py> FromPyObject<'_, 'py> for Given<'py> {
    type Error = Infallible;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> Result<Self, Infallible> {
        Ok(Self(Some(value.to_owned())))
    }
}

impl<'py> Given<'py> {
    /// Returns the value, converted by `read`, or `None` if the argument is missing.
    pub(crate) fn read<T>(
        &self,
        name: &str,
        read: impl FnOnce(&Bound<'py, PyAny>, &str) -> PyResult<T>,
    ) -> PyResult<Option<T>> {
        self.0.as_ref().map(|value| read(value, name)).transpose()
    }
}

/// Returns whether an error comes from Python code, such as `__array__` or `__index__` of an argument. Such an
/// error has a traceback and is raised unchanged. Errors of a conversion in C have no traceback.
pub(crate) fn is_from_python(error: &PyErr, py: Python<'_>) -> bool {
    error.traceback(py).is_some()
}

/// Reads a real number, finite or not.
pub(crate) fn number(value: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    let py = value.py();
    let is_array = value.cast::<PyUntypedArray>().is_ok_and(|array| array.ndim() > 0);
    if value.is_instance_of::<PyString>() || value.is_instance_of::<PyBool>() || is_array {
        return Err(wrong_type(value, name, "a number"));
    }
    value.extract().map_err(|error: PyErr| match error.is_instance_of::<PyOverflowError>(py) {
        _ if is_from_python(&error, py) => error,
        true => PyValueError::new_err(format!("{name} is too large for a float")),
        false => wrong_type(value, name, "a number"),
    })
}

/// Reads a whole number, at least `minimum`.
pub(crate) fn count(value: &Bound<'_, PyAny>, name: &str, minimum: usize) -> PyResult<usize> {
    count_below(value, name, minimum, 63)
}

/// Reads a whole number, at least `minimum`, that fits into 32 bits.
pub(crate) fn count_u32(value: &Bound<'_, PyAny>, name: &str, minimum: usize) -> PyResult<u32> {
    Ok(count_below(value, name, minimum, 32)? as u32)
}

/// Reads a whole number, at least `minimum` and below 2^`bits`.
fn count_below(value: &Bound<'_, PyAny>, name: &str, minimum: usize, bits: u32) -> PyResult<usize> {
    let py = value.py();
    if value.is_instance_of::<PyBool>() {
        return Err(wrong_type(value, name, "a whole number"));
    }
    let number =
        py.import("operator")?.call_method1("index", (value,)).map_err(|error| {
            match is_from_python(&error, py) {
                true => error,
                false => wrong_type(value, name, "a whole number"),
            }
        })?;
    match number.extract::<u64>() {
        Ok(count) if count >= minimum as u64 && count >> bits == 0 => Ok(count as usize),
        Ok(count) if count < minimum as u64 => Err(out_of_range(&number, name, minimum, "")),
        _ if number.lt(0)? => Err(out_of_range(&number, name, minimum, "")),
        _ => Err(out_of_range(&number, name, minimum, &format!(", and below 2^{bits}"))),
    }
}

/// Returns the `ValueError` that a whole number is below `minimum`, or not below a maximum.
fn out_of_range(value: &Bound<'_, PyAny>, name: &str, minimum: usize, maximum: &str) -> PyErr {
    PyValueError::new_err(format!(
        "{name} = {value} is out of range: it must be a whole number, at least {minimum}{maximum}"
    ))
}

/// Reads a boolean.
pub(crate) fn boolean(value: &Bound<'_, PyAny>, name: &str) -> PyResult<bool> {
    value.extract().map_err(|error| conversion_error(error, value, name, "True or False"))
}

/// Reads a string.
pub(crate) fn text(value: &Bound<'_, PyAny>, name: &str) -> PyResult<String> {
    value.extract().map_err(|error| conversion_error(error, value, name, "a string"))
}

/// Reads a path: a string or an object with `__fspath__`.
pub(crate) fn path(value: &Bound<'_, PyAny>, name: &str) -> PyResult<PathBuf> {
    value.extract().map_err(|error| conversion_error(error, value, name, "a path (str or os.PathLike)"))
}

/// Checks that a value can be called.
pub(crate) fn callable(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Py<PyAny>> {
    match value.is_callable() {
        true => Ok(value.clone().unbind()),
        false => Err(wrong_type(value, name, "callable")),
    }
}

/// Reads a string that must be the name of one of `choices`, and returns the value of this choice.
pub(crate) fn choice<T: Copy>(value: &Bound<'_, PyAny>, name: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let word = text(value, name)?;
    choices.iter().find(|(known, _)| *known == word).map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<String> = choices.iter().map(|(known, _)| format!("{known:?}")).collect();
        PyValueError::new_err(format!("{name} is {word:?}; it must be {}", known.join(" or ")))
    })
}

/// Returns an error from Python code unchanged, such as one of `__fspath__`, and otherwise [`wrong_type`].
pub(crate) fn conversion_error(error: PyErr, value: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyErr {
    if is_from_python(&error, value.py()) { error } else { wrong_type(value, name, expected) }
}

/// Returns the `TypeError` "{name} must be {expected}, not {type of value}".
pub(crate) fn wrong_type(value: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyErr {
    PyTypeError::new_err(format!("{name} must be {expected}, not {}", type_name(value)))
}

/// Returns the name of the type of a value; "None" for None.
pub(crate) fn type_name(value: &Bound<'_, PyAny>) -> String {
    match value.get_type().qualname() {
        _ if value.is_none() => "None".to_owned(),
        Ok(name) => owned(&name),
        Err(_) => "another type".to_owned(),
    }
}

/// Copies a string. Unlike `to_string`, it runs no signal handler, whose `KeyboardInterrupt` would be lost.
pub(crate) fn owned(text: &Bound<'_, PyString>) -> String {
    text.to_string_lossy().into_owned()
}

/// Keyword arguments of a call, or the entries of a dict argument. A missing argument has its default value.
/// An argument in `optional` that is `None` counts as missing.
pub(crate) struct Settings<'py> {
    given: Option<Bound<'py, PyDict>>,
    /// Names of the arguments that may be `None`.
    optional: &'static [&'static str],
}

impl<'py> Settings<'py> {
    /// Wraps the arguments of a call to `function`. The arguments in `optional` may be `None`.
    ///
    /// # Errors
    ///
    /// `TypeError` for a name that is not in `known`, with the nearest known name.
    pub(crate) fn from_call(
        given: Option<&Bound<'py, PyDict>>,
        function: &str,
        known: &[&str],
        optional: &'static [&'static str],
    ) -> PyResult<Self> {
        let error = |key| PyTypeError::new_err(format!("{function} has no argument {key}"));
        Self::new(given.cloned(), known, optional, error)
    }

    /// Wraps the entries of the dict that was passed as the argument `name`.
    ///
    /// # Errors
    ///
    /// `ValueError` for a key that is not in `known`, with the nearest known key.
    pub(crate) fn from_dict(given: &Bound<'py, PyDict>, name: &str, known: &[&str]) -> PyResult<Self> {
        let error = |key| PyValueError::new_err(format!("{name} has no key {key}"));
        Self::new(Some(given.clone()), known, &[], error)
    }

    /// Wraps arguments. `error` creates the error for an unknown name from "{name}; {what to write in its place}".
    fn new(
        given: Option<Bound<'py, PyDict>>,
        known: &[&str],
        optional: &'static [&'static str],
        error: impl Fn(String) -> PyErr,
    ) -> PyResult<Self> {
        for key in given.iter().flat_map(|given| given.keys()) {
            let key = owned(&key.str()?);
            if !known.contains(&key.as_str()) {
                let way_out = way_out(&key, known, |name| format!("{name:?}"));
                return Err(error(format!("{key:?}; {way_out}")));
            }
        }
        Ok(Self { given, optional })
    }

    /// Returns the names and the values of the arguments that are given.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (String, Bound<'py, PyAny>)> {
        let entries = self.given.iter().flat_map(|given| given.iter());
        let entries = entries.filter_map(|(key, value)| Some((owned(key.cast::<PyString>().ok()?), value)));
        entries.filter(|(key, value)| !(value.is_none() && self.optional.contains(&key.as_str())))
    }

    /// Returns the value of an argument, or `None` if it is missing.
    pub(crate) fn get(&self, key: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = self.given.as_ref().map(|given| given.get_item(key)).transpose()?.flatten();
        Ok(value.filter(|value| !(value.is_none() && self.optional.contains(&key))))
    }

    /// Returns the value of an argument, converted by `read`, or `None` if it is missing.
    pub(crate) fn read<T>(
        &self,
        key: &str,
        read: impl FnOnce(&Bound<'py, PyAny>, &str) -> PyResult<T>,
    ) -> PyResult<Option<T>> {
        self.get(key)?.map(|value| read(&value, key)).transpose()
    }

    /// Returns a number, finite or not.
    pub(crate) fn number(&self, key: &str) -> PyResult<Option<f64>> {
        self.read(key, number)
    }

    /// Returns a whole number, at least `minimum`.
    pub(crate) fn count(&self, key: &str, minimum: usize) -> PyResult<Option<usize>> {
        self.read(key, |value, key| count(value, key, minimum))
    }

    /// Returns a whole number, at least `minimum`, that fits into 32 bits.
    pub(crate) fn count_u32(&self, key: &str, minimum: usize) -> PyResult<Option<u32>> {
        self.read(key, |value, key| count_u32(value, key, minimum))
    }

    /// Checks that at most one of two alternative arguments is given.
    pub(crate) fn exclusive(&self, first: &str, second: &str) -> PyResult<()> {
        if self.get(first)?.is_some() && self.get(second)?.is_some() {
            return Err(PyValueError::new_err(format!(
                "{first} and {second} are mutually exclusive; pass only one of them"
            )));
        }
        Ok(())
    }
}
