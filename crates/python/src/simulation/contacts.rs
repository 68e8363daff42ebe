//! Contact between bodies in `supple.Simulation`: settings, the contacts of the last step, bodies by name.

use numpy::PyArray1;
use pyo3::exceptions::{PyIndexError, PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use supple::{ContactPoint, Touched};
use supple_io::scene::nearest;

use super::Simulation;
use crate::argument::{self, type_name};
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

    /// Return the contacts of the last step: a structured array with one entry per contact and the fields below.
    ///
    /// body : str, int or Body, optional
    ///     Only contacts of this body, given by name, index or itself: with bodies, also as the other one, and with
    ///     colliders.
    /// collider : int or collider, optional
    ///     Only contacts with this collider of colliders, given by index or itself.
    ///
    /// Fields:
    ///
    /// body : int32
    ///     Index of the body in bodies; the lesser one of two bodies.
    /// other : int32
    ///     Index of the other body, or of the collider. In self-contact it is the body itself.
    /// other_is_collider : bool
    ///     Whether other is the index of a collider.
    /// point, normal : (3,) float64
    ///     Position, and unit vector from the other towards the body. With a thickness, contacts act where the layers
    ///     around both surfaces meet.
    /// depth : float64
    ///     Greatest depth at which the surfaces overlap at the end of the step, in scene units; negative for a gap. The
    ///     thicknesses count as part of the bodies and colliders.
    /// force : (3,) float64
    ///     Force on the body during the step: pressure, friction, and what the damping takes from the contact. The force
    ///     on the other is the opposite.
    ///
    /// Contacts with colliders come first. A body that sleeps has the contacts with which it fell asleep. Empty before
    /// the first step, and in a copy until its first step. Raises KeyError for an unknown name, IndexError for an index that
    /// does not exist, and ValueError for a body or a collider of another simulation.
    #[pyo3(signature = (body=None, collider=None))]
    fn contacts<'py>(
        slf: &Bound<'py, Self>,
        body: Option<&Bound<'py, PyAny>>,
        collider: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let body = body.map(|body| Self::body_index(slf, body)).transpose()?;
        let collider = collider.map(|collider| Self::collider_index(slf, collider)).transpose()?;
        let mut contacts = slf.get().shared.with(py, |simulation| simulation.contacts())?;
        contacts.retain(|contact| {
            let is_of_body = |body| contact.body == body || contact.other == Touched::Body(body);
            let is_of_collider = |collider| contact.other == Touched::Collider(collider);
            body.is_none_or(is_of_body) && collider.is_none_or(is_of_collider)
        });
        let array = structured(py, &FIELDS, contacts.len())?;
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

impl Simulation {
    /// Returns the index of a body, given by its name, index or itself.
    fn body_index(slf: &Bound<'_, Self>, body: &Bound<'_, PyAny>) -> PyResult<usize> {
        if body.is_instance_of::<PyString>() {
            let body = Self::__getitem__(slf, body)?.into_any();
            return place_of(&body, &slf.getattr("bodies")?, "body", "bodies");
        }
        place_of(body, &slf.getattr("bodies")?, "body", "bodies")
    }

    /// Returns the index of a collider, given by its index or itself.
    fn collider_index(slf: &Bound<'_, Self>, collider: &Bound<'_, PyAny>) -> PyResult<usize> {
        place_of(collider, &slf.getattr("colliders")?, "collider", "colliders")
    }
}

/// Returns a new structured array of `count` entries with fields of given types.
pub(super) fn structured<'py>(
    py: Python<'py>,
    fields: &[(&str, &str)],
    count: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let dtype = PyDict::new(py);
    let (names, formats): (Vec<_>, Vec<_>) = fields.iter().copied().unzip();
    dtype.set_item("names", names)?;
    dtype.set_item("formats", formats)?;
    py.import("numpy")?.call_method1("empty", (count, dtype))
}

/// Returns the place of an item in a tuple: the item itself, or its index.
fn place_of(item: &Bound<'_, PyAny>, items: &Bound<'_, PyAny>, name: &str, list: &str) -> PyResult<usize> {
    let count = items.len()?;
    if is_index(item) {
        let index = argument::count(item, name, 0)?;
        return match index < count {
            true => Ok(index),
            false => Err(PyIndexError::new_err(format!(
                "{name} is {index}, and the simulation has {count} {list}; it must be less than {count}"
            ))),
        };
    }
    for (index, own) in items.try_iter()?.enumerate() {
        if own?.is(item) {
            return Ok(index);
        }
    }
    let found = type_name(item);
    Err(match item.get_type().module().is_ok_and(|module| module.to_string().starts_with("supple")) {
        true => PyValueError::new_err(format!(
            "{name} is a {found} that is not in sim.{list}; take it from there"
        )),
        false => {
            PyTypeError::new_err(format!("{name} must be an item of sim.{list} or its index, not {found}"))
        }
    })
}

/// Returns whether a Python object is a whole number, and not a boolean.
fn is_index(item: &Bound<'_, PyAny>) -> bool {
    !item.is_instance_of::<PyBool>() && item.hasattr("__index__").unwrap_or(false)
}

/// Returns the index of what a body touches, and whether it is a collider.
fn other(contact: &ContactPoint) -> (i32, bool) {
    match contact.other {
        Touched::Body(index) => (index as i32, false),
        Touched::Collider(index) => (index as i32, true),
    }
}
