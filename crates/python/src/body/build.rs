//! From keyword arguments to a body.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{
    BodyBuilder, Damping, FieldKind, Material, Placement, Preservation, RegionSize, Stiffness, VolumeOptions,
    VolumeScope,
};
use supple_io::scene::{ALTERNATIVES, BodyData};

use crate::argument::{self, wrong_type};
use crate::error;
use crate::lattice::Lattice;
use crate::mesh::mesh_like;
use crate::settings::Settings;

/// The keyword arguments: the keys of a scene's `[[body]]`, but for its file and what methods add; and the memory limit.
#[pyfunction]
pub(crate) fn body_keys() -> Vec<String> {
    let keys = supple_io::scene::body_keys().into_iter();
    let of_scene = keys.filter(|key| !["mesh", "pin", "handle"].contains(&key.as_str()));
    of_scene.chain(["memory_limit".to_owned()]).collect()
}

/// Those that may be `None`: not asked for, or said in another way.
pub(super) const OPTIONAL: [&str; 10] = {
    let [[a, b], [c, d], [e, f], [g, h]] = ALTERNATIVES;
    [a, b, c, d, e, f, g, h, "object", "memory_limit"]
};

/// Arguments about the lattice of a mesh, which a lattice does not need any more.
const OF_MESH: [&str; 5] = ["object", "lattice_vertices", "cell_size", "join", "memory_limit"];

/// The mesh or lattice as an object of ours, and the body.
pub(super) fn body<'py>(
    shape: &Bound<'py, PyAny>,
    settings: &Settings<'py>,
) -> PyResult<(Bound<'py, PyAny>, supple::Body)> {
    let py = shape.py();
    for [one, other] in ALTERNATIVES {
        settings.exclusive(one, other)?;
    }
    let (shape, builder) = builder(shape, settings)?;
    let default = BodyData::default();
    let builder = builder
        .name(settings.text("name")?.unwrap_or_else(|| "body".to_owned()))
        .scale(settings.number("scale")?.unwrap_or(default.scale))
        .material(material(settings)?)
        .placement(placement(settings)?)
        .volume(settings.get("volume")?.map(|v| read_volume(&v)).transpose()?.unwrap_or_default());
    let body = py.detach(|| builder.build()).map_err(error::of)?;
    Ok((shape, body))
}

fn builder<'py>(
    shape: &Bound<'py, PyAny>,
    settings: &Settings<'py>,
) -> PyResult<(Bound<'py, PyAny>, BodyBuilder)> {
    if let Ok(lattice) = shape.cast::<Lattice>() {
        for key in OF_MESH {
            if settings.get(key)?.is_some() {
                let message = format!("{key} is for a mesh; a Lattice is as it is");
                return Err(PyValueError::new_err(message));
            }
        }
        let builder = supple::Body::from_lattice(lattice.get().lattice.clone());
        return Ok((lattice.clone().into_any(), builder));
    }
    let mesh = mesh_like(shape, "shape", settings.text("object")?)?;
    let mut builder = supple::Body::builder(mesh.get().mesh.clone());
    if let Some(vertices) = settings.count("lattice_vertices", 8)? {
        builder = builder.lattice_vertices(vertices);
    }
    if let Some(cell_size) = settings.number("cell_size")? {
        builder = builder.cell_size(cell_size);
    }
    if let Some(join) = settings.boolean("join")? {
        builder = builder.join(join);
    }
    if let Some(bytes) = settings.count("memory_limit", 0)? {
        builder = builder.memory_limit(bytes as u64);
    }
    Ok((mesh.into_any(), builder))
}

fn material(settings: &Settings<'_>) -> PyResult<Material> {
    let mut material = Material::default();
    if let Some(cells) = settings.count("half_width", 1)? {
        material.region_size = RegionSize::Cells(cells);
    }
    if let Some(radius) = settings.number("stiffness_radius")? {
        material.region_size = RegionSize::Radius(radius);
    }
    if let Some(alpha) = settings.number("stiffness")? {
        material.stiffness = Stiffness::PerStep(alpha);
    }
    if let Some(hertz) = settings.number("frequency")? {
        material.stiffness = Stiffness::Frequency(hertz);
    }
    if let Some(share) = settings.number("damping")? {
        material.damping = Damping::PerStep(share);
    }
    if let Some(rate) = settings.number("damping_rate")? {
        material.damping = Damping::Rate(rate);
    }
    if let Some(density) = settings.number("density")? {
        material.density = density;
    }
    Ok(material)
}

fn placement(settings: &Settings<'_>) -> PyResult<Placement> {
    Ok(Placement {
        rotate: settings.vector("rotate")?.unwrap_or_default(),
        translate: settings.vector("translate")?.unwrap_or_default(),
        velocity: settings.vector("velocity")?.unwrap_or_default(),
        spin: settings.vector("spin")?.unwrap_or_default(),
    })
}

/// A word for the measure, or a dict with the measure and more.
pub(super) fn read_volume(value: &Bound<'_, PyAny>) -> PyResult<VolumeOptions> {
    if value.extract::<String>().is_ok() {
        return argument::choice(value, "volume", &Preservation::NAMED).map(VolumeOptions::from);
    }
    let dict = value
        .cast::<PyDict>()
        .map_err(|_| wrong_type(value, "volume", "a string (\"off\" for none) or a dict"))?;
    let settings = Settings::of_dict(dict, "volume", &["measure", "scope", "field", "max_correction"])?;
    let mut options = VolumeOptions::default();
    if let Some(measure) = settings.get("measure")? {
        options.measure = argument::choice(&measure, "volume measure", &Preservation::NAMED)?;
    }
    if let Some(scope) = settings.get("scope")? {
        options.scope = argument::choice(&scope, "volume scope", &VolumeScope::NAMED)?;
    }
    if let Some(field) = settings.get("field")? {
        options.field = argument::choice(&field, "volume field", &FieldKind::NAMED)?;
    }
    if let Some(cap) = settings.number("max_correction")? {
        options.max_correction = cap;
    }
    Ok(options)
}

/// Volume options as the dict that makes them.
pub(crate) fn volume_settings<'py>(py: Python<'py>, options: &VolumeOptions) -> PyResult<Bound<'py, PyDict>> {
    let VolumeOptions { measure, scope, field, max_correction } = *options;
    let settings = PyDict::new(py);
    settings.set_item("measure", measure.name())?;
    settings.set_item("scope", scope.name())?;
    settings.set_item("field", field.name())?;
    settings.set_item("max_correction", max_correction)?;
    Ok(settings)
}
