//! `supple.Body`: a soft body, alone or in a simulation.

mod build;
mod holds;
mod storage;
mod values;

pub(crate) use build::{body_keys, volume_settings};
pub(crate) use holds::Hold;
pub(crate) use storage::{Storage, World};

use std::sync::Mutex;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use supple::BodySnapshot;

use crate::argument::Settings;
use crate::error;
use crate::forked::Owner;
use crate::lattice::Lattice;
use crate::mesh::Mesh;

/// A soft body: a lattice, what it is made of, and the mesh that is displayed.
///
/// shape : Mesh, Lattice, path of an OBJ file, or anything with vertices and faces (trimesh.Trimesh)
///     A Lattice is a body without a mesh to show.
/// name : str, default "body"
/// object : str
///     With a path: only the `o` or `g` of this name.
/// scale, rotate, translate : float; (3,) degrees about the fixed axes x, then y, then z; (3,) length
///     Where the model is placed, in this order. Default 1, 0, 0.
/// lattice_vertices : int, default 1000; or cell_size : float
///     How fine the lattice of a mesh is: a wished number of vertices, at least 8, or the edge of a cell, > 0.
/// join : bool, default True
///     Parts of a mesh that float apart ride along.
/// memory_limit : int, default half of the machine's memory
///     Bytes that the body may take; LatticeError if it would take more.
/// half_width : int, default 2; or stiffness_radius : float
///     Of the regions: in cells, at least 1, or as a length, > 0. Larger is stiffer.
/// stiffness : float, default 1; or frequency : float
///     alpha per step, in (0, 1], or the frequency of a vertex about its goal in Hz, > 0.
/// region_damping : float, default 0; or region_damping_rate : float
///     Region damping: the share per step, in [0, 1], or a rate in 1/s, >= 0.
/// density : float, default 1000
///     Mass per volume, > 0.
/// volume : str or dict, default "auto"
///     "off", or the measure that is kept: "auto", "mesh", "cells" or "lattice"; or a dict with measure, scope
///     ("global" or "regional": where the volume was lost), field (the way in which the correction moves: "surface",
///     "cells" or "paper") and max_correction (>= 0, as a share of the body's thickness).
/// velocity, spin : (3,) length/s; (3,) rad/s about the center of mass
///     At the start. Default 0.
///
/// Arrays that are "one per vertex" have the order of lattice.indices. A body belongs to at most one Simulation, and
/// stays live in it. Raises ValueError for a value out of range, MeshError and LatticeError for what cannot be built,
/// TypeError for a wrong type.
#[pyclass(frozen, module = "supple", weakref)]
pub(crate) struct Body {
    storage: Mutex<Storage>,
    /// Locked by whoever has locked the storage or the world.
    display: Mutex<supple::Display>,
    owner: Owner,
    /// What the body was made of: a `Mesh` or a `Lattice`.
    shape: Py<PyAny>,
    /// A copy of the keyword arguments, for pickles.
    settings: Py<PyDict>,
    mesh: PyOnceLock<Option<Py<Mesh>>>,
    lattice: PyOnceLock<Py<Lattice>>,
}

impl Body {
    /// A body that lives here, and how it was made.
    pub(crate) fn of(storage: Storage, (shape, settings): Recipe<'_>) -> Self {
        Self {
            storage: Mutex::new(storage),
            display: Mutex::default(),
            owner: Owner::new(),
            shape: shape.unbind(),
            settings: settings.unbind(),
            mesh: PyOnceLock::new(),
            lattice: PyOnceLock::new(),
        }
    }

    /// How the body was made.
    pub(crate) fn recipe<'py>(&self, py: Python<'py>) -> Recipe<'py> {
        (self.shape.bind(py).clone(), self.settings.bind(py).clone())
    }
}

/// How a body is made anew: its shape and its keyword arguments.
pub(crate) type Recipe<'py> = (Bound<'py, PyAny>, Bound<'py, PyDict>);

#[pymethods]
impl Body {
    #[new]
    #[pyo3(
        signature = (shape, **settings),
        text_signature = "(shape, *, name='body', object=None, scale=1.0, rotate=(0, 0, 0), translate=(0, 0, 0), lattice_vertices=1000, cell_size=None, join=True, half_width=2, stiffness_radius=None, stiffness=1.0, frequency=None, region_damping=0.0, region_damping_rate=None, density=1000.0, volume='auto', velocity=(0, 0, 0), spin=(0, 0, 0), memory_limit=None)"
    )]
    fn new(shape: &Bound<'_, PyAny>, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let py = shape.py();
        let keys = body_keys();
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let (shape, body) =
            build::body(shape, &Settings::of_call(settings, "Body()", &keys, &build::OPTIONAL)?)?;
        let settings = match settings {
            Some(given) => py.import("copy")?.call_method1("deepcopy", (given,))?.cast_into()?,
            None => PyDict::new(py),
        };
        // It has been read; the mesh knows it by its faces.
        if settings.contains("object")? {
            settings.del_item("object")?;
        }
        Ok(Self::of(Storage::Alone(Box::new(body)), (shape, settings)))
    }

    /// The name, as in reports and file names.
    #[getter]
    fn name(&self, py: Python<'_>) -> PyResult<String> {
        self.read(py, |body| body.name().to_owned())
    }

    /// The mesh in the model's frame: after scale, before rotate and translate. None for a bare lattice.
    #[getter]
    fn mesh<'py>(&self, py: Python<'py>) -> PyResult<Option<&Bound<'py, Mesh>>> {
        let mesh = self.mesh.get_or_try_init(py, || -> PyResult<_> {
            let mesh = self.read(py, |body| body.mesh().cloned())?;
            mesh.map(|mesh| Py::new(py, Mesh::from_core(mesh))).transpose()
        })?;
        Ok(mesh.as_ref().map(|mesh| mesh.bind(py)))
    }

    /// The lattice in the model's frame: after scale, before rotate and translate.
    #[getter]
    fn lattice<'py>(&self, py: Python<'py>) -> PyResult<&Bound<'py, Lattice>> {
        let lattice = self.lattice.get_or_try_init(py, || -> PyResult<_> {
            let lattice = self.read(py, |body| body.lattice().clone())?;
            Py::new(py, Lattice::from_core(lattice))
        })?;
        Ok(lattice.bind(py))
    }

    /// The simulation that the body lives in; None for a body by itself, or if nobody holds the Simulation any more.
    #[getter]
    fn simulation<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(self.world(py)?.and_then(|(world, _)| world.python(py)))
    }

    /// Number of lattice vertices.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, |body| body.lattice().len())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        self.read(py, |body| {
            let lattice = body.lattice();
            let mesh = body.mesh().map_or_else(
                || "no mesh".to_owned(),
                |mesh| format!("mesh of {} vertices", mesh.vertices().len()),
            );
            format!(
                "<supple.Body {:?}: {} lattice vertices, {} cells of {:.4}, half-width {}, {mesh}, {:.1} MB>",
                body.name(),
                lattice.len(),
                lattice.cells().len(),
                lattice.cell_size(),
                body.half_width(),
                body.memory() as f64 / 1e6
            )
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let class = py.get_type::<Self>();
        // A body of a living simulation goes where that goes, as one of its bodies.
        if let Some((world, index)) = slf.get().world(py)?
            && let Some(simulation) = world.python(py)
        {
            return (class.getattr("_of")?, (simulation, index)).into_pyobject(py);
        }
        let snapshot = slf.get().read(py, supple::Body::snapshot)?;
        let state = PyBytes::new(py, &encode(&snapshot)?);
        let (shape, settings) = slf.get().recipe(py);
        (class.getattr("_restore")?, (shape, settings, state)).into_pyobject(py)
    }

    /// The body of a simulation that has this index.
    #[staticmethod]
    fn _of<'py>(simulation: &Bound<'py, PyAny>, index: usize) -> PyResult<Bound<'py, PyAny>> {
        simulation.getattr("bodies")?.get_item(index)
    }

    /// A body made anew, in the state that another was in.
    #[staticmethod]
    fn _restore(
        py: Python<'_>,
        shape: &Bound<'_, PyAny>,
        settings: &Bound<'_, PyDict>,
        state: &[u8],
    ) -> PyResult<Self> {
        let snapshot: BodySnapshot = decode(state)?;
        let body = Self::new(shape, Some(settings))?;
        body.with(py, |body| body.restore(&snapshot))?.map_err(error::of)?;
        Ok(body)
    }
}

/// The bytes of a state.
pub(crate) fn encode(state: &impl serde::Serialize) -> PyResult<Vec<u8>> {
    postcard::to_stdvec(state).map_err(error::value)
}

/// The state of bytes that `encode` made.
pub(crate) fn decode<T: serde::de::DeserializeOwned>(bytes: &[u8]) -> PyResult<T> {
    postcard::from_bytes(bytes).map_err(|error| {
        PyValueError::new_err(format!("the pickle is not of this version of supple: {error}"))
    })
}
