//! Reads how a `supple.Body` touches other bodies and itself, and defines it as read-only properties.

use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};
use supple::TouchingOptions;

use super::Body;
use crate::argument::{self, Settings, conversion_error, wrong_type};

/// Reads the options from the arguments of `supple.Body`.
pub(super) fn read(settings: &Settings<'_>) -> PyResult<TouchingOptions> {
    let default = TouchingOptions::default();
    Ok(TouchingOptions {
        friction: settings.number("friction")?.unwrap_or(default.friction),
        restitution: settings.number("restitution")?.unwrap_or(default.restitution),
        rolling_resistance: settings.number("rolling_resistance")?,
        self_contact: settings.read("self_contact", argument::boolean)?,
        ignored: settings.read("ignore", names)?.unwrap_or_default(),
    })
}

/// Reads names of bodies.
fn names(value: &Bound<'_, PyAny>, key: &str) -> PyResult<Vec<String>> {
    let expected = "a list of names of bodies";
    // A string is a sequence of strings.
    if value.is_instance_of::<PyString>() {
        return Err(wrong_type(value, key, expected));
    }
    let items = value.try_iter().map_err(|error| conversion_error(error, value, key, expected))?;
    items.enumerate().map(|(index, name)| argument::text(&name?, &format!("{key}[{index}]"))).collect()
}

#[pymethods]
impl Body {
    /// Coulomb friction coefficient at other bodies, >= 0.
    #[getter]
    fn friction(&self, py: Python<'_>) -> PyResult<f64> {
        self.read(py, |body| body.touching().friction)
    }

    /// Coefficient of restitution at other bodies, in [0, 1].
    #[getter]
    fn restitution(&self, py: Python<'_>) -> PyResult<f64> {
        self.read(py, |body| body.touching().restitution)
    }

    /// Coefficient of rolling resistance on colliders, >= 0: the greatest distance of the center of pressure of a contact from its
    /// middle, as a fraction of the radius of the contact. Unless it is set, 0.08 times the damping ratio, or 0.016 with a
    /// damping_rate above 0.
    #[getter]
    fn rolling_resistance(&self, py: Python<'_>) -> PyResult<f64> {
        self.read(py, supple::Body::rolling_resistance)
    }

    /// Whether parts of the body touch each other: bool, or None if the simulation decides.
    #[getter]
    fn self_contact(&self, py: Python<'_>) -> PyResult<Option<bool>> {
        self.read(py, |body| body.touching().self_contact)
    }

    /// Names of bodies that the body does not touch: tuple of str.
    #[getter]
    fn ignore<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.read(py, |body| body.touching().ignored.clone())?)
    }
}
