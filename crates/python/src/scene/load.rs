//! A scene as a live simulation.

use std::sync::{Arc, Mutex};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use supple::{Damping, RegionSize, Resolution, Stiffness};
use supple_io::run::{Input, prepare};
use supple_io::scene::{BodyData, Scene};

use super::{of_run, open};
use crate::body::{Body, World, volume_settings};
use crate::collider;
use crate::mesh::Mesh;
use crate::simulation::Simulation;

/// The simulation of a scene file, at time zero; `overrides` are `KEY=VALUE`.
#[pyfunction]
pub(crate) fn load_scene<'py>(
    py: Python<'py>,
    path: &Bound<'py, PyAny>,
    overrides: Vec<String>,
) -> PyResult<Bound<'py, Simulation>> {
    let scene = open(path, &overrides)?;
    let prepared = py.detach(|| prepare(&scene)).map_err(of_run)?;
    live(py, &scene, &prepared.inputs, Arc::new(Mutex::new(prepared.simulation)))
}

/// The Python object of the simulation of a scene.
pub(super) fn live<'py>(
    py: Python<'py>,
    scene: &Scene,
    inputs: &[Input],
    simulation: Arc<Mutex<supple::Simulation>>,
) -> PyResult<Bound<'py, Simulation>> {
    let world = Arc::new(World::new(simulation, scene.simulation.threads));
    let mut bodies = Vec::with_capacity(scene.bodies.len());
    for (index, (data, input)) in scene.bodies.iter().zip(inputs).enumerate() {
        bodies.push(body(py, data, input, &world, index)?);
    }
    let colliders = scene.colliders.iter().map(|collider| collider::to_python(py, collider));
    let colliders = PyTuple::new(py, colliders.collect::<PyResult<Vec<_>>>()?)?;
    let simulation = Bound::new(py, Simulation::of(world, bodies, &colliders))?;
    simulation.get().introduce(&simulation)?;
    Ok(simulation)
}

fn body(
    py: Python<'_>,
    data: &BodyData,
    input: &Input,
    world: &Arc<World>,
    index: usize,
) -> PyResult<Py<Body>> {
    let shape = Bound::new(py, Mesh::from_core(input.part.mesh().clone()))?.into_any().unbind();
    Py::new(py, Body::of_scene(shape, settings(py, data)?.unbind(), world.clone(), index))
}

/// A body's keys as keyword arguments.
fn settings<'py>(py: Python<'py>, data: &BodyData) -> PyResult<Bound<'py, PyDict>> {
    let settings = PyDict::new(py);
    settings.set_item("name", &data.name)?;
    settings.set_item("scale", data.scale)?;
    settings.set_item("rotate", data.placement.rotate)?;
    settings.set_item("translate", data.placement.translate)?;
    settings.set_item("velocity", data.placement.velocity)?;
    settings.set_item("spin", data.placement.spin)?;
    settings.set_item("join", data.join)?;
    match data.resolution {
        Resolution::Vertices(vertices) => settings.set_item("lattice_vertices", vertices)?,
        Resolution::CellSize(cell_size) => settings.set_item("cell_size", cell_size)?,
    }
    match data.material.region_size {
        RegionSize::Cells(cells) => settings.set_item("half_width", cells)?,
        RegionSize::Radius(radius) => settings.set_item("stiffness_radius", radius)?,
    }
    match data.material.stiffness {
        Stiffness::PerStep(alpha) => settings.set_item("stiffness", alpha)?,
        Stiffness::Frequency(hertz) => settings.set_item("frequency", hertz)?,
    }
    match data.material.damping {
        Damping::PerStep(share) => settings.set_item("damping", share)?,
        Damping::Rate(rate) => settings.set_item("damping_rate", rate)?,
    }
    settings.set_item("density", data.material.density)?;
    settings.set_item("volume", volume_settings(py, &data.volume)?)?;
    Ok(settings)
}
