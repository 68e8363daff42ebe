//! Builds a body from the arguments of `supple.Body`.

use std::sync::LazyLock;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use supple::{BodyBuilder, Elasticity, HalfWidth, RegionSize};
use supple_io::scene::{BodyData, Value, optional_keys};

use crate::argument::{self, Settings, wrong_type};
use crate::arrays::vector;
use crate::interrupt::interruptible;
use crate::lattice::Lattice;
use crate::mesh::mesh_like;
use crate::rotation::rotate_once;
use crate::{error, keys};

/// Return the names of the keyword arguments of Body, or the keys of a table of `[[body]]` in a scene: "fracture" or
/// "plastic".
///
/// They are memory_limit, and the keys of `[[body]]` in a scene except mesh, zone, pin and handle.
#[pyfunction(name = "body_keys", signature = (table=None))]
pub(crate) fn keys_of(table: Option<&str>) -> Vec<String> {
    table.map_or_else(body_keys, supple_io::scene::table_keys)
}

/// Returns the names of the keyword arguments of `supple.Body`.
pub(crate) fn body_keys() -> Vec<String> {
    let keys = supple_io::scene::body_keys().into_iter();
    let scene_keys = keys.filter(|key| !["mesh", "zone", "pin", "handle"].contains(&key.as_str()));
    scene_keys.chain(["memory_limit".to_owned()]).collect()
}

/// Keyword arguments that may be `None`: those without a default value, and mutually exclusive alternatives.
pub(super) static OPTIONAL: LazyLock<Vec<&str>> =
    LazyLock::new(|| optional_keys().into_iter().chain(["memory_limit"]).collect());

/// Keyword arguments for building the lattice of a mesh. With a `Lattice`, each of them is an error.
const MESH_ONLY: [&str; 5] = ["object", "lattice_vertices", "cell_size", "join", "memory_limit"];

/// Builds a body. Returns the shape that the body was built from, as a `Mesh` or a `Lattice`, and the body.
pub(super) fn body<'py>(
    shape: &Bound<'py, PyAny>,
    settings: &Settings<'py>,
) -> PyResult<(Bound<'py, PyAny>, supple::Body)> {
    let py = shape.py();
    let data: BodyData = keys::read(settings.iter(), scene_value)?;
    let (shape, builder) = builder(shape, settings)?;
    let name = settings.read("name", argument::text)?.unwrap_or_else(|| "body".to_owned());
    let builder = data.apply(builder).name(name);
    let body = interruptible(py, move || builder.build())?.map_err(error::from_core)?;
    Ok((shape, body))
}

/// Creates the builder with its lattice, or with its mesh and the options of the lattice. Returns the shape
/// as [`body`] does.
fn builder<'py>(
    shape: &Bound<'py, PyAny>,
    settings: &Settings<'py>,
) -> PyResult<(Bound<'py, PyAny>, BodyBuilder)> {
    if let Ok(lattice) = shape.cast::<Lattice>() {
        for key in MESH_ONLY {
            if settings.get(key)?.is_some() {
                return Err(PyValueError::new_err(format!(
                    "{key} is for a mesh and has no effect on a Lattice; leave it out"
                )));
            }
        }
        if !lattice.get().lattice.broken_joints().is_empty() {
            let message = "shape is the lattice of a broken body; copy the body with copy.deepcopy() instead";
            return Err(PyValueError::new_err(message));
        }
        let builder = supple::Body::from_lattice(lattice.get().lattice.clone());
        return Ok((lattice.clone().into_any(), builder));
    }
    let mesh = mesh_like(shape, "shape", settings.read("object", argument::text)?)?;
    let builder = supple::Body::builder(mesh.get().mesh.clone());
    let memory_limit = settings.count("memory_limit", 0)?.map(|bytes| bytes as u64);
    let builder = builder.memory_limit(memory_limit.unwrap_or_else(supple_io::memory_limit));
    Ok((mesh.into_any(), builder))
}

/// Reads one argument that is a key of a scene. The other keys of the body have their defaults.
pub(crate) fn scene_key(key: &str, value: &Bound<'_, PyAny>) -> PyResult<BodyData> {
    keys::read([(key.to_owned(), value.clone())], scene_value)
}

/// Reads the half-width of regions in cells.
pub(crate) fn half_width(value: &Bound<'_, PyAny>) -> PyResult<HalfWidth> {
    match scene_key("half_width", value)?.material.elasticity {
        Elasticity::Regions { size: RegionSize::Cells(cells), .. } => Ok(cells),
        _ => Err(wrong_type(value, "half_width", "a number of cells")),
    }
}

/// Converts an argument to the value of a key of a scene; `None` if a scene has no such key or value.
fn scene_value(key: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<Value>> {
    let is_dict = value.is_instance_of::<PyDict>();
    match key {
        // The name of a body in a scene names files.
        "name" | "object" | "memory_limit" => Ok(None),
        "rotate" => Ok(Some(keys::vector(rotate_once(value, key)?))),
        "translate" | "velocity" | "spin" => Ok(Some(keys::vector(vector(value, key)?))),
        "inflate" | "youngs_modulus" | "poisson_ratio" | "damping_ratio" | "friction" if !value.is_none() => {
            keys::curve(value, key).map(Some)
        }
        "plastic" | "fracture" if value.is_none() => Ok(None),
        "plastic" if value.is_instance_of::<PyBool>() => match value.is_truthy()? {
            true => keys::value(&PyDict::new(value.py()), key).map(Some),
            false => Ok(None),
        },
        "plastic" if !is_dict => {
            Err(wrong_type(value, key, "a dict like {\"yield\": 0.05}, True for its default values, or None"))
        }
        "fracture" if !is_dict => Err(wrong_type(value, key, "a dict like {\"strain\": 0.1}, or None")),
        _ => keys::value(value, key).map(Some),
    }
}
