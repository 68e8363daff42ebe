//! Colliders: the dataclasses of `supple.colliders` as the core has them.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use supple::dynamics::Colliders;
use supple::{Collider, Shape};

use crate::argument::{number, wrong_type};
use crate::arrays::vector;
use crate::keys;

/// The colliders of a simulation.
pub(crate) fn read_all(colliders: &Bound<'_, PyAny>) -> PyResult<Vec<Collider>> {
    let items = colliders
        .try_iter()
        .map_err(|_| wrong_type(colliders, "colliders", "a list of Plane, Sphere, Box or Capsule"))?;
    items.enumerate().map(|(index, item)| read(&item?, &format!("colliders[{index}]"))).collect()
}

/// Refuses a collider whose numbers make no sense.
#[pyfunction]
pub(crate) fn check_collider(collider: &Bound<'_, PyAny>) -> PyResult<()> {
    let class = collider.get_type().name()?.to_string();
    Colliders::new(&[read(collider, &class)?]).map(drop).map_err(|error| {
        // The core counts the colliders of a scene; this one is alone.
        let message = error.to_string();
        PyValueError::new_err(format!("{class}: {}", message.trim_start_matches("collider 0: ")))
    })
}

fn read(collider: &Bound<'_, PyAny>, name: &str) -> PyResult<Collider> {
    static BASE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let base = BASE.import(collider.py(), "supple.colliders", "Collider")?;
    if !collider.is_instance(base)? {
        return Err(wrong_type(collider, name, "a Plane, Sphere, Box or Capsule"));
    }
    let place = |key: &str| vector(&collider.getattr(key)?, key);
    let length = |key: &str| number(&collider.getattr(key)?, key);
    let shape = match collider.getattr("shape")?.extract::<String>()?.as_str() {
        "plane" => Shape::Plane { point: place("point")?, normal: place("normal")? },
        "sphere" => Shape::Sphere { center: place("center")?, radius: length("radius")? },
        "box" => Shape::Box {
            center: place("center")?,
            half_extents: place("half_extents")?,
            rotate: place("rotate")?,
        },
        "capsule" => Shape::Capsule { a: place("a")?, b: place("b")?, radius: length("radius")? },
        shape => return Err(PyValueError::new_err(format!("{name} has the unknown shape {shape:?}"))),
    };
    let (friction, restitution) = (length("friction")?, length("restitution")?);
    let keys = keys::read(&collider.getattr("keys")?)?;
    Ok(Collider { shape, friction, restitution, keys })
}
