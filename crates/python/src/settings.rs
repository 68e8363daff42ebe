//! Keyword arguments by the names that scenes have for them.

use std::path::PathBuf;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::{argument, arrays};

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
        let settings = Self { given: given.cloned(), optional };
        match settings.unknown(known)? {
            None => Ok(settings),
            Some((key, nearest)) => Err(PyTypeError::new_err(format!(
                "{function} has no argument {key:?}; the nearest one is {nearest:?}"
            ))),
        }
    }

    /// The entries of the dict that the argument `name` is.
    ///
    /// # Errors
    ///
    /// `ValueError` for a key that is not one of `known`, with the nearest that is.
    pub(crate) fn of_dict(given: &Bound<'py, PyDict>, name: &str, known: &[&str]) -> PyResult<Self> {
        let settings = Self { given: Some(given.clone()), optional: &[] };
        match settings.unknown(known)? {
            None => Ok(settings),
            Some((key, nearest)) => Err(PyValueError::new_err(format!(
                "{name} has no key {key:?}; the nearest one is {nearest:?}"
            ))),
        }
    }

    /// The first name that is not a known one, and the known one nearest to it.
    fn unknown<'a>(&self, known: &[&'a str]) -> PyResult<Option<(String, &'a str)>> {
        for key in self.given.iter().flat_map(|given| given.keys()) {
            let key = key.str()?.to_string();
            if !known.contains(&key.as_str()) {
                let nearest = supple_io::scene::nearest(&key, known).unwrap_or_default();
                return Ok(Some((key, nearest)));
            }
        }
        Ok(None)
    }

    /// What was given under a name.
    pub(crate) fn get(&self, key: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let value = self.given.as_ref().map(|given| given.get_item(key)).transpose()?.flatten();
        Ok(value.filter(|value| !(value.is_none() && self.optional.contains(&key))))
    }

    /// A number, finite or not.
    pub(crate) fn number(&self, key: &str) -> PyResult<Option<f64>> {
        self.get(key)?.map(|value| argument::number(&value, key)).transpose()
    }

    /// A whole number of at least `least`.
    pub(crate) fn count(&self, key: &str, least: usize) -> PyResult<Option<usize>> {
        self.get(key)?.map(|value| argument::count(&value, key, least)).transpose()
    }

    /// A whole number of at least `least` that 32 bits hold.
    pub(crate) fn count_u32(&self, key: &str, least: usize) -> PyResult<Option<u32>> {
        let narrow = |count: usize| {
            u32::try_from(count).map_err(|_| PyValueError::new_err(format!("{key} = {count} is too large")))
        };
        self.count(key, least)?.map(narrow).transpose()
    }

    /// A path.
    pub(crate) fn path(&self, key: &str) -> PyResult<Option<PathBuf>> {
        self.get(key)?.map(|value| argument::path(&value, key)).transpose()
    }

    /// Three finite numbers.
    pub(crate) fn vector(&self, key: &str) -> PyResult<Option<[f64; 3]>> {
        self.get(key)?.map(|value| arrays::vector(&value, key)).transpose()
    }

    /// True or false.
    pub(crate) fn boolean(&self, key: &str) -> PyResult<Option<bool>> {
        self.get(key)?.map(|value| argument::boolean(&value, key)).transpose()
    }

    /// A word.
    pub(crate) fn text(&self, key: &str) -> PyResult<Option<String>> {
        self.get(key)?.map(|value| argument::text(&value, key)).transpose()
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
