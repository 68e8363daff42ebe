//! Arguments: numbers, words, truth values, each named in its error; and keyword arguments by the names that scenes have
//! for them.

use std::path::PathBuf;

use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use supple_io::scene::nearest;

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

/// Keyword arguments, or the entries of a dict that is one. One that is absent leaves its default; so does `None`, where
/// `None` is taken.
pub(crate) struct Settings<'py> {
    given: Option<Bound<'py, PyDict>>,
    /// Those that may be `None`.
    optional: &'static [&'static str],
}

impl<'py> Settings<'py> {
    /// The arguments of a call to `function`, of which those in `optional` may be `None`.
    ///
    /// # Errors
    ///
    /// `TypeError` for a name that is not one of `known`, with the nearest that is.
    pub(crate) fn of_call(
        given: Option<&Bound<'py, PyDict>>,
        function: &str,
        known: &[&str],
        optional: &'static [&'static str],
    ) -> PyResult<Self> {
        let wrong = |key| PyTypeError::new_err(format!("{function} has no argument {key}"));
        Self::new(given.cloned(), known, optional, wrong)
    }

    /// The entries of the dict that the argument `name` is.
    ///
    /// # Errors
    ///
    /// `ValueError` for a key that is not one of `known`, with the nearest that is.
    pub(crate) fn of_dict(given: &Bound<'py, PyDict>, name: &str, known: &[&str]) -> PyResult<Self> {
        let wrong = |key| PyValueError::new_err(format!("{name} has no key {key}"));
        Self::new(Some(given.clone()), known, &[], wrong)
    }

    fn new(
        given: Option<Bound<'py, PyDict>>,
        known: &[&str],
        optional: &'static [&'static str],
        wrong: impl Fn(String) -> PyErr,
    ) -> PyResult<Self> {
        for key in given.iter().flat_map(|given| given.keys()) {
            let key = key.str()?.to_string();
            if !known.contains(&key.as_str()) {
                let nearest = nearest(&key, known).unwrap_or_default();
                return Err(wrong(format!("{key:?}; the nearest one is {nearest:?}")));
            }
        }
        Ok(Self { given, optional })
    }

    /// What was given under a name.
    pub(crate) fn get(&self, key: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = self.given.as_ref().map(|given| given.get_item(key)).transpose()?.flatten();
        Ok(value.filter(|value| !(value.is_none() && self.optional.contains(&key))))
    }

    /// What was given under a name, as `read` reads it.
    pub(crate) fn read<T>(
        &self,
        key: &str,
        read: impl FnOnce(&Bound<'py, PyAny>, &str) -> PyResult<T>,
    ) -> PyResult<Option<T>> {
        self.get(key)?.map(|value| read(&value, key)).transpose()
    }

    /// A number, finite or not.
    pub(crate) fn number(&self, key: &str) -> PyResult<Option<f64>> {
        self.read(key, number)
    }

    /// A whole number of at least `least`.
    pub(crate) fn count(&self, key: &str, least: usize) -> PyResult<Option<usize>> {
        self.read(key, |value, key| count(value, key, least))
    }

    /// A whole number of at least `least` that 32 bits hold.
    pub(crate) fn count_u32(&self, key: &str, least: usize) -> PyResult<Option<u32>> {
        let narrow = |count: usize| {
            u32::try_from(count).map_err(|_| PyValueError::new_err(format!("{key} = {count} is too large")))
        };
        self.count(key, least)?.map(narrow).transpose()
    }

    /// Refuses two ways to say one thing.
    pub(crate) fn exclusive(&self, one: &str, other: &str) -> PyResult<()> {
        if self.get(one)?.is_some() && self.get(other)?.is_some() {
            return Err(PyValueError::new_err(format!(
                "{one} and {other} say the same thing in two ways; leave one of them out"
            )));
        }
        Ok(())
    }
}
