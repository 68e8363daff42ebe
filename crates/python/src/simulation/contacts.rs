//! Contact between bodies in `supple.Simulation`: settings, the contacts of the last step, bodies by name.

use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{ContactPoint, Touched};
use supple_io::scene::nearest;

use super::Simulation;
use crate::argument;
use crate::arrays::from_vectors;
use crate::body::Body;

/// Fields of the array of contacts, and their types in numpy.
const FIELDS: [(&str, &str); 7] = [
    ("body", "i4"),
    ("other", "i4"),
    ("other_is_collider", "?"),
    ("point", "3f8"),
    ("normal", "3f8"),
    ("depth", "f8"),
    ("force", "3f8"),
];

#[pymethods]
impl Simulation {
    /// Whether bodies touch each other.
    #[getter]
    fn contact(&self, py: Python<'_>) -> PyResult<bool> {
        self.shared.with(py, |simulation| simulation.contact())
    }

    /// Whether parts of a body touch each other, for bodies that do not say so themselves.
    #[getter]
    fn self_contact(&self, py: Python<'_>) -> PyResult<bool> {
        self.shared.with(py, |simulation| simulation.self_contact())
    }

    /// Return the body with a name.
    ///
    /// Raises KeyError if no body or several bodies have this name.
    fn __getitem__<'py>(slf: &Bound<'py, Self>, name: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Body>> {
        let name = argument::text(name, "the name of a body")?;
        let names: Vec<String> = slf.get().shared.with(slf.py(), |simulation| {
            simulation.bodies().iter().map(|body| body.name().to_owned()).collect()
        })?;
        let mut found =
            (0..).zip(&names).filter(|(_, own)| **own == name).map(|(index, _): (usize, _)| index);
        match (found.next(), found.count()) {
            (Some(index), 0) => slf.get().bodies[index].python_object(slf.as_any()),
            (Some(index), more) => Err(PyKeyError::new_err(format!(
                "{} bodies are called {name:?}; use sim.bodies[{index}], ...",
                more + 1
            ))),
            (None, _) => {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let nearest = nearest(&name, &names).unwrap_or_default();
                Err(PyKeyError::new_err(format!(
                    "no body is called {name:?}; the nearest name is {nearest:?}"
                )))
            }
        }
    }

    /// Return the contacts of the last step: a structured array with one entry per contact and these fields.
    ///
    /// body : int32
    ///     Index of the body in bodies; the lesser one of two bodies.
    /// other : int32
    ///     Index of the other body, or of the collider. In self-contact it is the body itself.
    /// other_is_collider : bool
    ///     Whether other is the index of a collider.
    /// point, normal : (3,) float64
    ///     Position, and unit vector from the other towards the body.
    /// depth : float64
    ///     Greatest depth at which the surfaces overlap at the end of the step, in scene units; negative for a gap.
    /// force : (3,) float64
    ///     Force on the body during the step: pressure, friction, and what the damping takes from the contact. The force
    ///     on the other is the opposite.
    ///
    /// Contacts with colliders come first. A body that sleeps has the contacts with which it fell asleep. Empty before
    /// the first step, and in a copy until its first step.
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let contacts = self.shared.with(py, |simulation| simulation.contacts())?;
        let dtype = PyDict::new(py);
        let (names, formats): (Vec<_>, Vec<_>) = FIELDS.into_iter().unzip();
        dtype.set_item("names", names)?;
        dtype.set_item("formats", formats)?;
        let array = py.import("numpy")?.call_method1("empty", (contacts.len(), dtype))?;
        let others: Vec<(i32, bool)> = contacts.iter().map(other).collect();
        let set = |name: &str, column: Bound<'py, PyAny>| array.set_item(name, column);
        let numbers = |values: Vec<i32>| PyArray1::from_vec(py, values).into_any();
        let vectors = |read: fn(&ContactPoint) -> [f64; 3]| {
            from_vectors(py, contacts.iter().map(read).collect()).into_any()
        };
        set("body", numbers(contacts.iter().map(|contact| contact.body as i32).collect()))?;
        set("other", numbers(others.iter().map(|(index, _)| *index).collect()))?;
        let are_colliders: Vec<bool> = others.iter().map(|(_, is_collider)| *is_collider).collect();
        set("other_is_collider", PyArray1::from_vec(py, are_colliders).into_any())?;
        set("point", vectors(|contact| contact.point.into()))?;
        set("normal", vectors(|contact| contact.normal.into()))?;
        let depths: Vec<f64> = contacts.iter().map(|contact| contact.depth).collect();
        set("depth", PyArray1::from_vec(py, depths).into_any())?;
        set("force", vectors(|contact| contact.force.into()))?;
        Ok(array)
    }
}

/// Returns the index of what a body touches, and whether it is a collider.
fn other(contact: &ContactPoint) -> (i32, bool) {
    match contact.other {
        Touched::Body(index) => (index as i32, false),
        Touched::Collider(index) => (index as i32, true),
    }
}
