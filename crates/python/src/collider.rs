//! Converts colliders between the dataclasses of `supple.colliders` and the core.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};
use supple::{Collider, Key, Shape};

use crate::argument::{conversion_error, number, wrong_type};
use crate::arrays::vector;
use crate::constraint;

/// Reads the `colliders` argument, and returns the Python objects as a tuple.
pub(crate) fn as_tuple<'py>(colliders: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyTuple>> {
    let expected = "a list of Plane, Sphere, Box or Capsule";
    let items =
        colliders.try_iter().map_err(|error| conversion_error(error, colliders, "colliders", expected))?;
    PyTuple::new(colliders.py(), items.collect::<PyResult<Vec<_>>>()?)
}

/// Converts all colliders of a simulation to the core.
pub(crate) fn read_all(colliders: &Bound<'_, PyTuple>) -> PyResult<Vec<Collider>> {
    colliders.iter().enumerate().map(|(index, item)| read(&item, &format!("colliders[{index}]"))).collect()
}

/// Check a collider, and return its fields as plain numbers. Raises ValueError for an invalid field.
#[pyfunction]
pub(crate) fn check_collider<'py>(collider: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    let class = collider.get_type().name()?.to_string();
    let read = read(collider, &class)?;
    read.validate().map_err(|fault| PyValueError::new_err(format!("{class}: {fault}")))?;
    Ok(fields(collider.py(), &read)?.1)
}

/// Converts a collider to the core, without checking ranges.
fn read(collider: &Bound<'_, PyAny>, name: &str) -> PyResult<Collider> {
    static BASE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let base = BASE.import(collider.py(), "supple.colliders", "Collider")?;
    if !collider.is_instance(base)? {
        return Err(wrong_type(collider, name, "a Plane, Sphere, Box or Capsule"));
    }
    let read_vector = |key| vector(&collider.getattr(key)?, key);
    let read_number = |key| number(&collider.getattr(key)?, key);
    // The base class has no shape.
    let Ok(shape) = collider.getattr("shape") else {
        return Err(wrong_type(collider, name, "a Plane, Sphere, Box or Capsule"));
    };
    let shape = match shape.extract::<String>()?.as_str() {
        "plane" => Shape::Plane { point: read_vector("point")?, normal: read_vector("normal")? },
        "sphere" => Shape::Sphere { center: read_vector("center")?, radius: read_number("radius")? },
        "box" => Shape::Box {
            center: read_vector("center")?,
            half_extents: read_vector("half_extents")?,
            rotate: read_vector("rotate")?,
        },
        "capsule" => {
            Shape::Capsule { a: read_vector("a")?, b: read_vector("b")?, radius: read_number("radius")? }
        }
        shape => return Err(PyValueError::new_err(format!("{name} has the unknown shape {shape:?}"))),
    };
    let (friction, restitution) = (read_number("friction")?, read_number("restitution")?);
    let keys = constraint::keys(&collider.getattr("keys")?)?;
    Ok(Collider { shape, friction, restitution, keys })
}

/// Converts a collider to its Python object.
pub(crate) fn to_python<'py>(py: Python<'py>, collider: &Collider) -> PyResult<Bound<'py, PyAny>> {
    let (class, fields) = fields(py, collider)?;
    py.import("supple.colliders")?.getattr(class)?.call((), Some(&fields))
}

/// Returns the name of the Python class of a collider, and its fields.
fn fields<'py>(py: Python<'py>, collider: &Collider) -> PyResult<(&'static str, Bound<'py, PyDict>)> {
    let (class, vectors, radius) = match collider.shape {
        Shape::Plane { point, normal } => ("Plane", vec![("point", point), ("normal", normal)], None),
        Shape::Sphere { center, radius } => ("Sphere", vec![("center", center)], Some(radius)),
        Shape::Box { center, half_extents, rotate } => {
            ("Box", vec![("center", center), ("half_extents", half_extents), ("rotate", rotate)], None)
        }
        Shape::Capsule { a, b, radius } => ("Capsule", vec![("a", a), ("b", b)], Some(radius)),
    };
    let fields = PyDict::new(py);
    for (name, vector) in vectors {
        fields.set_item(name, <(f64, f64, f64)>::from(vector))?;
    }
    if let Some(radius) = radius {
        fields.set_item("radius", radius)?;
    }
    let key =
        |key: &Key| (key.time, <(f64, f64, f64)>::from(key.translate), <(f64, f64, f64)>::from(key.rotate));
    fields.set_item("keys", PyTuple::new(py, collider.keys.iter().map(key))?)?;
    fields.set_item("friction", collider.friction)?;
    fields.set_item("restitution", collider.restitution)?;
    Ok((class, fields))
}
