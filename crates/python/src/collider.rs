//! Converts colliders between the dataclasses of `supple.colliders` and the core, and moves the colliders of a
//! simulation.

use std::sync::Arc;

use numpy::PyArray1;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};
use supple::{
    Collider, ColliderFault, ColliderRef, CollisionMesh, Interpolation, Key, MeshAnimation, Scale, Shape,
    Switch, SwitchKey,
};
use supple_io::scene::EnabledTable;

use crate::argument::{choice, conversion_error, number, wrong_type};
use crate::arrays::{self, vector};
use crate::body::{SharedSimulation, scene_key};
use crate::mesh::Mesh;
use crate::rotation::rotate_once;
use crate::{animation, constraint, error, keys, rotation};

/// Reads the `colliders` argument, a list or one collider, and returns the Python objects as a tuple.
pub(crate) fn as_tuple<'py>(colliders: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyTuple>> {
    if is_collider(colliders)? {
        return PyTuple::new(colliders.py(), [colliders]);
    }
    let expected = "a list of Plane, Sphere, Box, Capsule or MeshCollider, or one of them";
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
    let fields = fields(collider.py(), &read)?.1;
    if let Shape::Mesh { .. } = read.shape {
        // Keeps the object, so that colliders share it.
        fields.set_item("mesh", collider.getattr("mesh")?)?;
        let scale = scene_key("scale", &collider.getattr("scale")?)?.scale;
        if let Scale::PerAxis(factors) = scale {
            // The shape has the scaled mesh and frames.
            fields.set_item("scale", <(f64, f64, f64)>::from(factors))?;
            if let Some(animation) = read_mesh(collider, &class)?.animation() {
                fields.set_item("frames", animation::array(collider.py(), animation)?)?;
            }
        }
        fields.set_item("fps", number(&collider.getattr("fps")?, "fps")?)?;
        fields.set_item("start", number(&collider.getattr("start")?, "start")?)?;
    }
    Ok(fields)
}

/// Returns whether an object is an instance of `supple.Collider`.
fn is_collider(object: &Bound<'_, PyAny>) -> PyResult<bool> {
    static BASE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    object.is_instance(BASE.import(object.py(), "supple.colliders", "Collider")?)
}

/// Converts a collider to the core, without checking ranges.
fn read(collider: &Bound<'_, PyAny>, name: &str) -> PyResult<Collider> {
    if !is_collider(collider)? {
        return Err(wrong_type(collider, name, "a Plane, Sphere, Box, Capsule or MeshCollider"));
    }
    let read_vector = |key| vector(&collider.getattr(key)?, key);
    let read_number = |key| number(&collider.getattr(key)?, key);
    // The base class has no shape.
    let Ok(shape) = collider.getattr("shape") else {
        return Err(wrong_type(collider, name, "a Plane, Sphere, Box, Capsule or MeshCollider"));
    };
    let shape = match shape.extract::<String>()?.as_str() {
        "plane" => Shape::Plane { point: read_vector("point")?, normal: read_vector("normal")? },
        "sphere" => Shape::Sphere { center: read_vector("center")?, radius: read_number("radius")? },
        "box" => Shape::Box {
            center: read_vector("center")?,
            half_extents: read_vector("half_extents")?,
            rotate: rotate_once(&collider.getattr("rotate")?, "rotate")?,
        },
        "capsule" => {
            Shape::Capsule { a: read_vector("a")?, b: read_vector("b")?, radius: read_number("radius")? }
        }
        "mesh" => Shape::mesh(
            match collider.getattr("inside")?.is_truthy()? {
                false => read_mesh(collider, name)?,
                true => read_mesh(collider, name)?
                    .inverted()
                    .map_err(|fault| PyValueError::new_err(format!("{name}: {fault}")))?,
            },
            scene_key("scale", &collider.getattr("scale")?)?.scale,
            rotate_once(&collider.getattr("rotate")?, "rotate")?,
            read_vector("translate")?,
        )
        .map_err(|fault| PyValueError::new_err(format!("{name}: {fault}")))?,
        shape => return Err(PyValueError::new_err(format!("{name} has the unknown shape {shape:?}"))),
    };
    let (friction, restitution) = (read_number("friction")?, read_number("restitution")?);
    let keys = constraint::keys(&collider.getattr("keys")?)?;
    let interpolation = choice(&collider.getattr("interpolation")?, "interpolation", &Interpolation::NAMED)?;
    let rolling_resistance = collider.getattr("rolling_resistance")?;
    let rolling_resistance = match rolling_resistance.is_none() {
        true => None,
        false => Some(number(&rolling_resistance, "rolling_resistance")?),
    };
    let thickness = read_number("thickness")?;
    let enabled = enabled(&collider.getattr("enabled")?)?;
    Ok(Collider { shape, friction, restitution, rolling_resistance, thickness, keys, interpolation, enabled })
}

/// Reads whether a collider is enabled: a boolean, or keyframes.
fn enabled(value: &Bound<'_, PyAny>) -> PyResult<Switch> {
    let arguments = [("enabled".to_owned(), value.clone())];
    keys::read::<EnabledTable>(arguments, |key, value| keys::curve(value, key).map(Some))
        .map(|table| table.enabled)
}

/// Returns a switch as the argument that [`enabled`] reads.
fn switch<'py>(py: Python<'py>, switch: &Switch) -> PyResult<Bound<'py, PyAny>> {
    match switch.constant() {
        Some(value) => value.into_bound_py_any(py),
        None => {
            let pairs = switch.keys().iter().map(|&SwitchKey { time, value }| (time, value));
            Ok(PyTuple::new(py, pairs)?.into_any())
        }
    }
}

/// Returns the mesh of a `MeshCollider`. The search tree of a rigid mesh is built once, and stored in the `Mesh`.
fn read_mesh(collider: &Bound<'_, PyAny>, name: &str) -> PyResult<CollisionMesh> {
    let (mesh, frames) = (collider.getattr("mesh")?, collider.getattr("frames")?);
    let Ok(mesh) = mesh.cast::<Mesh>() else { return Err(wrong_type(&mesh, "mesh", "a supple.Mesh")) };
    let fault = |fault| PyValueError::new_err(format!("{name}: {fault}"));
    if frames.is_none() {
        return mesh.get().collision_mesh(mesh.py()).map_err(fault);
    }
    let fps = animation::fps(&collider.getattr("fps")?, &format!("{name}: fps"))?;
    let start = number(&collider.getattr("start")?, "start")?;
    let core = mesh.get().mesh.clone();
    let vertices = core.vertices().len();
    let positions = animation::positions(&frames, "frames", vertices)?;
    MeshAnimation::new(positions, vertices, start, 1.0 / fps)
        .map_err(ColliderFault::from)
        .and_then(|animation| CollisionMesh::animated(core, animation))
        .map_err(fault)
}

/// Converts a collider to its Python object.
pub(crate) fn to_python<'py>(py: Python<'py>, collider: &Collider) -> PyResult<Bound<'py, PyAny>> {
    let (class, fields) = fields(py, collider)?;
    py.import("supple.colliders")?.getattr(class)?.call((), Some(&fields))
}

/// Returns the name of the Python class of a collider, and its fields.
fn fields<'py>(py: Python<'py>, collider: &Collider) -> PyResult<(&'static str, Bound<'py, PyDict>)> {
    let (class, vectors, number) = match collider.shape {
        Shape::Plane { point, normal } => ("Plane", vec![("point", point), ("normal", normal)], None),
        Shape::Sphere { center, radius } => ("Sphere", vec![("center", center)], Some(("radius", radius))),
        Shape::Box { center, half_extents, rotate } => {
            ("Box", vec![("center", center), ("half_extents", half_extents), ("rotate", rotate)], None)
        }
        Shape::Capsule { a, b, radius } => ("Capsule", vec![("a", a), ("b", b)], Some(("radius", radius))),
        Shape::Mesh { scale, rotate, translate, .. } => {
            ("MeshCollider", vec![("rotate", rotate), ("translate", translate)], Some(("scale", scale)))
        }
    };
    let fields = PyDict::new(py);
    if let Shape::Mesh { mesh, .. } = &collider.shape {
        fields.set_item("mesh", Bound::new(py, Mesh::from_collision(py, mesh))?)?;
        fields.set_item("inside", mesh.is_inverted())?;
        if let Some(animation) = mesh.animation() {
            fields.set_item("frames", animation::array(py, animation)?)?;
            fields.set_item("fps", 1.0 / animation.interval())?;
            fields.set_item("start", animation.start())?;
        }
    }
    for (name, vector) in vectors {
        fields.set_item(name, <(f64, f64, f64)>::from(vector))?;
    }
    if let Some((name, number)) = number {
        fields.set_item(name, number)?;
    }
    let key =
        |key: &Key| (key.time, <(f64, f64, f64)>::from(key.translate), <(f64, f64, f64)>::from(key.rotate));
    fields.set_item("keys", PyTuple::new(py, collider.keys.iter().map(key))?)?;
    fields.set_item("interpolation", collider.interpolation.name())?;
    fields.set_item("friction", collider.friction)?;
    fields.set_item("restitution", collider.restitution)?;
    fields.set_item("rolling_resistance", collider.rolling_resistance)?;
    fields.set_item("thickness", collider.thickness)?;
    fields.set_item("enabled", switch(py, &collider.enabled)?)?;
    Ok((class, fields))
}

/// Returns copies of colliders that can move the colliders of a simulation while the simulation has the given
/// [generation](SharedSimulation::generation) of colliders.
pub(crate) fn attach<'py>(
    colliders: &Bound<'py, PyTuple>,
    simulation: &Arc<SharedSimulation>,
    generation: u64,
) -> PyResult<Bound<'py, PyTuple>> {
    let attached = colliders.iter().enumerate().map(|(index, collider)| {
        let motion = ColliderMotion { simulation: simulation.clone(), index, generation };
        collider.call_method1("_attached", (motion,))
    });
    PyTuple::new(colliders.py(), attached.collect::<PyResult<Vec<_>>>()?)
}

/// The motion of a collider of a simulation. The methods of supple.Collider call its methods.
#[pyclass(frozen, module = "supple._core")]
pub(crate) struct ColliderMotion {
    simulation: Arc<SharedSimulation>,
    index: usize,
    /// See [`SharedSimulation::generation`].
    generation: u64,
}

impl ColliderMotion {
    /// Calls `work` with the simulation, without the GIL.
    ///
    /// # Errors
    ///
    /// `RuntimeError` if the colliders of the simulation were replaced.
    fn with<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut supple::Simulation) -> R + Send,
    ) -> PyResult<R> {
        let result = self.simulation.with(py, |simulation| {
            (self.simulation.generation() == self.generation).then(|| work(simulation))
        })?;
        result.ok_or_else(|| {
            PyRuntimeError::new_err(format!(
                "this collider was replaced when sim.colliders was set; use sim.colliders[{}] again",
                self.index
            ))
        })
    }

    /// Reads a vector of the collider: (3,) float64, read-only.
    fn vector<'py>(
        &self,
        py: Python<'py>,
        read: impl FnOnce(ColliderRef<'_>) -> [f64; 3] + Send,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let vector = self.with(py, |simulation| read(simulation.collider(self.index)))?;
        Ok(arrays::frozen(PyArray1::from_slice(py, &vector)))
    }
}

#[pymethods]
impl ColliderMotion {
    /// See supple.Collider.move_to.
    fn move_to(
        &self,
        py: Python<'_>,
        translate: &Bound<'_, PyAny>,
        rotate: &Bound<'_, PyAny>,
        duration: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let near = self.with(py, |simulation| simulation.collider(self.index).rotation())?;
        let (translate, rotate) =
            (vector(translate, "translate")?, rotation::rotate(rotate, "rotate", near)?);
        let duration = if duration.is_none() { None } else { Some(number(duration, "duration")?) };
        let moved = self.with(py, |simulation| {
            let mut collider = simulation.collider_mut(self.index);
            match duration {
                Some(seconds) => collider.move_to_in(translate, rotate, seconds),
                None => collider.move_to(translate, rotate),
            }
        })?;
        moved.map_err(error::from_core)
    }

    /// Enable or disable the collider: True, False or keyframes. Return the value that Collider.enabled has then.
    fn set_enabled<'py>(&self, py: Python<'py>, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let enabled = enabled(value)?;
        let set = enabled.clone();
        self.with(py, |simulation| simulation.collider_mut(self.index).set_enabled(set))?;
        switch(py, &enabled)
    }

    /// See supple.Collider.is_enabled.
    #[getter]
    fn is_enabled(&self, py: Python<'_>) -> PyResult<bool> {
        self.with(py, |simulation| simulation.collider(self.index).is_enabled())
    }

    /// See supple.Collider.translation.
    #[getter]
    fn translation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.vector(py, |collider| collider.translation())
    }

    /// See supple.Collider.rotation.
    #[getter]
    fn rotation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.vector(py, |collider| collider.rotation())
    }

    /// See supple.Collider.velocity.
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.vector(py, |collider| collider.velocity())
    }

    /// See supple.Collider.force.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.vector(py, |collider| collider.force())
    }

    /// See supple.Collider.spin.
    #[getter]
    fn spin<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.vector(py, |collider| collider.spin())
    }
}
