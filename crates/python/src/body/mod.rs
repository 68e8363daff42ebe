//! Defines `supple.Body`: a soft body, outside or in a simulation.

/// Defines read-only properties of `supple.Body`, each by a function that reads it.
macro_rules! properties {
    ($($(#[$doc:meta])* $name:ident: $value:ty = $read:expr;)*) => {
        #[pymethods]
        impl Body {$(
            $(#[$doc])*
            #[getter]
            fn $name(&self, py: Python<'_>) -> PyResult<$value> {
                self.read(py, $read)
            }
        )*}
    };
}

mod build;
mod class;
mod fields;
mod follow;
mod force_field;
mod forces;
mod fracture;
mod hold;
mod holds;
mod material;
mod plastic;
mod quantities;
mod shapes;
mod storage;
mod touching;
mod values;
mod zones;

pub(crate) use build::{body_keys, half_width, keys_of, scene_key};
pub(crate) use class::Body;
pub(crate) use follow::{Arrays, Restored};
pub(crate) use force_field::ForceField;
pub(crate) use forces::add_fields;
pub(crate) use hold::Hold;
pub(crate) use storage::{APART, LONG, SharedBody, SharedSimulation, Storage};
pub(crate) use values::mesh_size;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{PyTraverseError, PyVisit};
use supple::BodySnapshot;
use supple_io::counted;

use crate::argument::Settings;
use crate::error;
use crate::lattice::Lattice;
use crate::mesh::Mesh;
use crate::pickle::{self, decode, encode};
use crate::rotation::rotate_once;

#[pymethods]
impl Body {
    #[new]
    #[pyo3(
        signature = (shape, **settings),
        text_signature = "(shape, *, name='body', object=None, scale=1.0, refine='off', rotate=(0, 0, 0), translate=(0, 0, 0), rigid=False, lattice_vertices=1000, cell_size=None, join=True, material='flesh', youngs_modulus=None, half_width=None, stiffness_radius=None, stiffness=None, frequency=None, accuracy='balanced', poisson_ratio=None, inflate=1.0, damping_ratio=None, damping_rate=None, region_damping=0.0, region_damping_rate=None, density=1000.0, plastic=None, fracture=None, volume='auto', skin='linear', friction=0.5, restitution=0.0, rolling_resistance=None, thickness=0.0, ignore=(), self_contact=None, velocity=(0, 0, 0), spin=(0, 0, 0), memory_limit=None)"
    )]
    fn new(shape: &Bound<'_, PyAny>, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let py = shape.py();
        let keys = body_keys();
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let (shape, body) =
            build::body(shape, &Settings::from_call(settings, "Body()", &keys, &build::OPTIONAL)?)?;
        let settings = match settings {
            Some(given) => py.import("copy")?.call_method1("deepcopy", (given,))?.cast_into()?,
            None => PyDict::new(py),
        };
        // A pickle does not need the library of the rotation.
        if let Some(rotate) = settings.get_item("rotate")? {
            settings.set_item("rotate", rotate_once(&rotate, "rotate")?)?;
        }
        // The mesh contains only the faces of the object, so a pickle does not need the name of the object.
        if settings.contains("object")? {
            settings.del_item("object")?;
        }
        Ok(Self::alone(body, (shape, settings)))
    }

    /// Name of the body, used in reports and file names.
    #[getter]
    fn name(&self, py: Python<'_>) -> PyResult<String> {
        self.read(py, |body| body.name().to_owned())
    }

    /// Mesh in the model's frame, at rest: after scale, before rotate and translate. None for a bare lattice. Of a
    /// broken body, the mesh of its pieces.
    #[getter]
    pub(super) fn mesh<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, Mesh>>> {
        self.shapes.mesh(py, &**self)
    }

    /// Lattice in the model's frame: after scale, before rotate and translate. Of a broken body, the lattice of its
    /// pieces.
    #[getter]
    fn lattice<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Lattice>> {
        self.shapes.lattice(py, &**self)
    }

    /// Simulation of the body, which the body keeps alive. None outside a simulation.
    #[getter]
    fn simulation<'py>(&self, py: Python<'py>) -> Option<&Bound<'py, PyAny>> {
        self.simulation.get().map(|simulation| simulation.bind(py))
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
                |mesh| format!("mesh of {}", counted(mesh.vertices().len(), "vertex")),
            );
            format!(
                "<supple.Body {:?}: {} lattice vertices, {} of {:.4}, half-width {}, {mesh}, {:.1} MB>",
                body.name(),
                lattice.len(),
                counted(lattice.cells().len(), "cell"),
                lattice.cell_size(),
                body.half_width(),
                body.memory() as f64 / 1e6
            )
        })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        // The simulation shows the fields of its bodies.
        match self.simulation.get() {
            Some(simulation) => visit.call(simulation),
            None if self.is_in_simulation() => Ok(()),
            None => self.fields.visit(&visit),
        }
    }

    fn __clear__(&self) {
        self.fields.clear();
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let class = py.get_type::<Self>();
        // A body in a simulation is pickled as the simulation and the index of the body in it.
        if let (Some(simulation), Some(index)) = (slf.get().simulation(py), slf.get().index(py)?) {
            return (class.getattr("_of")?, (simulation, encode(py, &index)?)).into_pyobject(py);
        }
        let snapshot = slf.get().read(py, supple::Body::snapshot)?;
        let (shape, settings) = slf.get().build_arguments(py);
        let fields = slf.get().field_arguments(py)?;
        let follows = Arrays::default().of(py, slf.get())?;
        let arguments = pickle::dumps((settings, fields, follows).into_pyobject(py)?.as_any())?;
        let data = (pickle::shape_checksum(&shape)?, arguments, snapshot);
        (class.getattr("_restore")?, (shape, encode(py, &data)?)).into_pyobject(py)
    }

    /// Return the body with the given index in a simulation. Pickles call this function.
    #[staticmethod]
    fn _of<'py>(simulation: &Bound<'py, PyAny>, index: &[u8]) -> PyResult<Bound<'py, PyAny>> {
        let index: usize = decode(simulation.py(), index)?;
        simulation.getattr("bodies")?.get_item(index)
    }

    /// Build a body and restore its state. Pickles call this function.
    #[staticmethod]
    fn _restore<'py>(shape: &Bound<'py, PyAny>, data: &[u8]) -> PyResult<Bound<'py, Self>> {
        let py = shape.py();
        let (checksum, arguments, snapshot): (_, Vec<u8>, BodySnapshot) = decode(py, data)?;
        pickle::check_shape(shape, checksum)?;
        let (settings, fields, follows): (Bound<'py, PyDict>, _, _) =
            pickle::loads(py, &arguments)?.extract()?;
        let body = Bound::new(py, Self::new(shape, Some(&settings))?)?;
        Restored::default().add(&body, follows)?;
        body.get().with(py, |body| body.restore(&snapshot))?.map_err(error::from_core)?;
        add_fields(&body, fields)?;
        Ok(body)
    }
}
