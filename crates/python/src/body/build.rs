//! Builds a body from the arguments of `supple.Body`.

use std::sync::LazyLock;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use supple::{BodyBuilder, FieldKind, Placement, Preservation, Refine, SkinKind, VolumeOptions, VolumeScope};
use supple_io::scene::{exclusive_keys, optional_keys};

use super::fracture::read_fracture;
use super::{material, touching};
use crate::argument::{self, Settings, wrong_type};
use crate::arrays::{scale, vector};
use crate::constraint::curve;
use crate::error;
use crate::interrupt::interruptible;
use crate::lattice::{Lattice, resolution};
use crate::mesh::mesh_like;
use crate::rotation::rotate_once;

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
    for first in body_keys() {
        for second in exclusive_keys(&first) {
            settings.exclusive(&first, second)?;
        }
    }
    let (shape, builder) = builder(shape, settings)?;
    let skin = settings.read("skin", |value, name| argument::choice(value, name, &SkinKind::NAMED))?;
    let refine = settings.read("refine", |value, name| argument::choice(value, name, &Refine::NAMED))?;
    let builder = builder
        .name(settings.read("name", argument::text)?.unwrap_or_else(|| "body".to_owned()))
        .scale(settings.read("scale", scale)?.unwrap_or_default())
        .material(material::read(settings)?)
        .inflate(settings.read("inflate", curve)?.unwrap_or_else(|| 1.0.into()))
        .placement(placement(settings)?)
        .volume(settings.read("volume", |volume, _| read_volume(volume))?.unwrap_or_default())
        .skin(skin.unwrap_or_default())
        .refine(refine.unwrap_or_default())
        .touching(touching::read(settings)?);
    let builder = match settings.read("fracture", read_fracture)?.flatten() {
        Some(fracture) => builder.fracture(fracture),
        None => builder,
    };
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
    let mut builder = supple::Body::builder(mesh.get().mesh.clone());
    if let Some(resolution) = resolution(settings, "lattice_vertices")? {
        builder = builder.resolution(resolution);
    }
    if let Some(join) = settings.read("join", argument::boolean)? {
        builder = builder.join(join);
    }
    let memory_limit = settings.count("memory_limit", 0)?.map(|bytes| bytes as u64);
    let builder = builder.memory_limit(memory_limit.unwrap_or_else(supple_io::memory_limit));
    Ok((mesh.into_any(), builder))
}

/// Reads the placement and the initial velocities.
fn placement(settings: &Settings<'_>) -> PyResult<Placement> {
    let vector = |key| Ok::<_, PyErr>(settings.read(key, vector)?.unwrap_or_default());
    Ok(Placement {
        rotate: settings.read("rotate", rotate_once)?.unwrap_or_default(),
        translate: vector("translate")?,
        velocity: vector("velocity")?,
        spin: vector("spin")?,
    })
}

/// Reads volume options: the name of a measure, "off", or a dict.
pub(super) fn read_volume(value: &Bound<'_, PyAny>) -> PyResult<VolumeOptions> {
    if value.extract::<String>().is_ok() {
        return argument::choice(value, "volume", &Preservation::NAMED).map(VolumeOptions::from);
    }
    let dict = value
        .cast::<PyDict>()
        .map_err(|_| wrong_type(value, "volume", "a string (\"off\" for no correction) or a dict"))?;
    let settings = Settings::from_dict(dict, "volume", &["measure", "scope", "field", "max_correction"])?;
    let default = VolumeOptions::default();
    let measure =
        settings.read("measure", |v, _| argument::choice(v, "volume measure", &Preservation::NAMED))?;
    let scope = settings.read("scope", |v, _| argument::choice(v, "volume scope", &VolumeScope::NAMED))?;
    let field = settings.read("field", |v, _| argument::choice(v, "volume field", &FieldKind::NAMED))?;
    Ok(VolumeOptions {
        measure: measure.unwrap_or(default.measure),
        scope: scope.unwrap_or(default.scope),
        field: field.unwrap_or(default.field),
        max_correction: settings.number("max_correction")?.unwrap_or(default.max_correction),
    })
}

/// Converts volume options to the equivalent dict.
pub(crate) fn volume_settings<'py>(py: Python<'py>, options: &VolumeOptions) -> PyResult<Bound<'py, PyDict>> {
    let VolumeOptions { measure, scope, field, max_correction } = *options;
    let names = [("measure", measure.name()), ("scope", scope.name()), ("field", field.name())];
    let settings = names.into_py_dict(py)?;
    settings.set_item("max_correction", max_correction)?;
    Ok(settings)
}
