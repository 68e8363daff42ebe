//! Defines `supple.Simulation`: bodies, colliders and time.
//!
//! | file | contents |
//! |---|---|
//! | `build` | moves bodies into a simulation |
//! | `bodies` | the bodies as a collection; `reset` |
//! | `many` | steps of many simulations at once |
//! | `cautions` | warnings, such as of bodies that overlap |
//! | `fields` | acceleration fields, such as wind |
//! | `contacts` | the contacts of the last step |
//! | `links` | links between bodies |
//! | `recording` | records frames into a USD stage or a page |
//! | `saved` | saves and restores the state |
//! | `substeps` | reads the number of steps per frame |
//! | `steps` | steps and frames: `step`, `advance`, `fps`, `substeps`; warns about materials out of reach |
//! | `tables` | reads fields and links: lists of dicts with the keys of scenes |
//! | `surfaces` | evaluates the displayed surfaces of all bodies |

mod bodies;
mod build;
mod cautions;
mod contacts;
mod fields;
mod links;
mod many;
mod queries;
mod recording;
mod saved;
mod steps;
mod substeps;
mod surfaces;
mod tables;

pub(crate) use cautions::warn;
pub(crate) use many::step_all;
pub(crate) use recording::{Recording, film};

use std::sync::{Arc, Mutex, PoisonError};

use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use pyo3::{PyTraverseError, PyVisit};
use supple::{SimulationState, Substeps};
use supple_io::run::Caution;
use supple_io::scene::SimulationData;

use crate::argument::{self, Settings};
use crate::body::{Arrays, Body, Restored, SharedBody, SharedSimulation, add_fields};
use crate::pickle::{self, decode, encode};
use crate::{collider, error, keys};

/// Keyword arguments of `supple.Simulation`.
const KEYS: [&str; 11] = [
    "dt",
    "fps",
    "substeps",
    "gravity",
    "colliders",
    "fields",
    "links",
    "threads",
    "contact",
    "self_contact",
    "sleep",
];

/// Keyword arguments that may be `None`.
const OPTIONAL: [&str; 3] = ["dt", "fps", "substeps"];

/// A simulation of bodies that touch colliders and each other.
///
/// bodies : list of Body, or one Body
///     The bodies move into this simulation and stay usable. A body belongs to at most one simulation.
/// dt : float, default 1/60; or fps : float
///     Length of a step in seconds, from 1e-12 to 1e6, or number of frames per second, > 0. With fps, dt is
///     1 / (fps x steps per frame).
/// substeps : int or "auto", default "auto" with fps, otherwise 1
///     Number of steps per frame, at least 1. "auto" needs fps: the least number, at most 1000, with which bodies
///     reach their material and fast motions are resolved. It is chosen at the first step and then stays the same. The
///     volume correction of the displayed surface uses the contacts and external forces of all steps since the
///     frame began.
/// gravity : (3,) float, or keyframes, default (0, -9.81, 0)
///     In scene units per second squared, each component at most 1e12 in magnitude. Keyframes are a list of
///     (time, value), or a dict with keys and interpolation, as for inflate of Body. Where a material or a number of
///     steps depends on gravity, the greatest one counts.
/// colliders : list of Plane, Sphere, Box, Capsule, MeshCollider, or one of them
///     Default: no colliders.
/// fields : list of dict, or one dict
///     Wind, drag and other accelerations, with the keys of [[field]] in a scene. Default: no fields.
/// links : list of dict, or one dict
///     Glue and springs between bodies, with the keys of [[link]] in a scene. Default: no links.
/// threads : int, default 0
///     Number of threads, at most 1024; 0 means one per processor. Results are bit-identical for any number
///     of threads.
/// contact : bool, default True
///     Whether bodies touch each other. Pairs can be left out by Body(ignore=...).
/// self_contact : bool, default False
///     Whether parts of a body touch each other, for bodies that do not say so themselves.
/// sleep : bool, default True
///     Whether bodies at rest fall asleep: they are then not stepped until something moves them.
///
/// sim["name"] is the body with this name, `"name" in sim` says whether there is one; len(sim) is the number of bodies, and
/// iteration gives them. Bodies that overlap at the start are pushed apart by the first steps, and
/// supple.ContactWarning names them.
///
/// If steps are too long for the material of a body, the body is softer, and the first step warns with
/// supple.MaterialWarning.
///
/// Raises ValueError for a number out of range or a body that belongs to another simulation.
#[pyclass(frozen, module = "supple", weakref)]
pub(crate) struct Simulation {
    shared: Arc<SharedSimulation>,
    bodies: Vec<Arc<SharedBody>>,
    /// The colliders as Python objects, and their [generation](SharedSimulation::generation).
    colliders: Mutex<(u64, Py<PyTuple>)>,
}

impl Simulation {
    pub(crate) fn from_parts(
        shared: Arc<SharedSimulation>,
        bodies: Vec<Arc<SharedBody>>,
        colliders: &Bound<'_, PyTuple>,
    ) -> PyResult<Self> {
        let generation = shared.generation();
        let colliders = collider::attach(colliders, &shared, generation)?.unbind();
        bodies.iter().for_each(|body| body.enter_simulation());
        Ok(Self { shared, bodies, colliders: Mutex::new((generation, colliders)) })
    }

    /// Builds a simulation from the arguments of `supple.Simulation`.
    fn build(bodies: &Bound<'_, PyAny>, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let settings = Settings::from_call(settings, "Simulation()", &KEYS, &OPTIONAL)?;
        settings.exclusive("dt", "fps")?;
        let data: SimulationData = keys::read(settings.iter(), |key, value| match key {
            "dt" | "substeps" | "colliders" | "fields" | "links" => Ok(None),
            "gravity" => keys::keyed_vector(value, key).map(Some),
            _ => keys::value(value, key).map(Some),
        })?;
        let mut builder = data.apply(supple::Simulation::builder());
        if let Some(dt) = settings.number("dt")? {
            builder = builder.dt(dt);
        }
        if settings.get("fps")?.is_some() {
            builder = builder.fps(data.fps).substeps(Substeps::Auto);
        }
        if let Some(substeps) = settings.read("substeps", substeps::substeps)? {
            builder = builder.substeps(substeps);
        }
        let colliders = settings.read("colliders", |colliders, _| collider::as_tuple(colliders))?;
        let colliders = colliders.unwrap_or_else(|| PyTuple::empty(bodies.py()));
        builder = collider::read_all(&colliders)?.into_iter().fold(builder, |b, c| b.collider(c));
        let fields = settings.read("fields", |fields, _| tables::read_fields(fields))?.unwrap_or_default();
        let links = settings.read("links", |links, _| tables::read_links(links))?.unwrap_or_default();
        let (shared, bodies) = build::simulation(bodies, (builder, fields, links), data.threads)?;
        Self::from_parts(shared, bodies, &colliders)
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(
        signature = (bodies, **settings),
        text_signature = "(bodies, *, dt=0.016666666666666666, fps=None, substeps=None, gravity=(0, -9.81, 0), colliders=(), fields=(), links=(), threads=0, contact=True, self_contact=False, sleep=True)"
    )]
    fn new(bodies: &Bound<'_, PyAny>, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let simulation = Self::build(bodies, settings)?;
        let py = bodies.py();
        let cautions = simulation.shared.with_long(py, |simulation, _| Caution::all(simulation))?;
        warn(py, &cautions, 1)?;
        Ok(simulation)
    }

    #[pyo3(signature = (*_args, **_settings))]
    fn __init__(slf: &Bound<'_, Self>, _args: &Bound<'_, PyTuple>, _settings: Option<&Bound<'_, PyDict>>) {
        slf.get().bodies.iter().for_each(|body| body.attach(slf.as_any()));
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.bodies.iter().try_for_each(|body| body.fields.visit(&visit))
    }

    fn __clear__(&self) {
        self.bodies.iter().for_each(|body| body.fields.clear());
    }

    /// Bodies, in the given order: tuple of Body.
    #[getter]
    fn bodies<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let bodies = slf.get().bodies.iter().map(|body| body.python_object(slf.as_any()));
        PyTuple::new(slf.py(), bodies.collect::<PyResult<Vec<_>>>()?)
    }

    /// Time in seconds. Settable.
    ///
    /// The time windows of pins and handles and the keyframes of handles and colliders refer to this time. The
    /// motion of Collider.move_to does not.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.shared.with(py, |simulation| simulation.time())
    }

    #[setter]
    fn set_time(&self, py: Python<'_>, time: &Bound<'_, PyAny>) -> PyResult<()> {
        let time = argument::number(time, "time")?;
        self.shared.with(py, |simulation| simulation.set_time(time))?.map_err(error::from_core)
    }

    /// Gravity in force, that of the current time, in scene units per second squared: (3,) float64. Settable, to a vector or
    /// keyframes.
    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_slice(py, &self.shared.with(py, |simulation| simulation.gravity())?))
    }

    #[setter]
    fn set_gravity(&self, py: Python<'_>, gravity: &Bound<'_, PyAny>) -> PyResult<()> {
        let given = [("gravity".to_owned(), gravity.clone())];
        let data: SimulationData = keys::read(given, |key, value| keys::keyed_vector(value, key).map(Some))?;
        self.shared.with(py, |simulation| simulation.set_gravity(data.gravity))?.map_err(error::from_core)
    }

    /// Colliders: tuple of Plane, Sphere, Box, Capsule, MeshCollider. Move one with colliders[i].move_to(translate,
    /// rotate).
    ///
    /// The colliders are copies of those that were given, equal to them, and have a pose and a velocity.
    /// Settable, to a list or one collider; effective from the next step on. Setting replaces all colliders:
    /// the new ones have their given poses, and the motion of the old ones ends.
    #[getter]
    fn colliders(&self, py: Python<'_>) -> Py<PyTuple> {
        self.colliders.lock().unwrap_or_else(PoisonError::into_inner).1.clone_ref(py)
    }

    #[setter]
    fn set_colliders(&self, py: Python<'_>, colliders: &Bound<'_, PyAny>) -> PyResult<()> {
        let colliders = collider::as_tuple(colliders)?;
        let converted = collider::read_all(&colliders)?;
        let generation = self.shared.set_colliders(py, &converted)?;
        let attached = collider::attach(&colliders, &self.shared, generation)?;
        let mut current = self.colliders.lock().unwrap_or_else(PoisonError::into_inner);
        // Another thread may have set later colliders in the meantime.
        if generation > current.0 {
            *current = (generation, attached.unbind());
        }
        Ok(())
    }

    /// Return a text that lists the stages of a step and of the evaluation of the displayed surface, with
    /// their parameters and memory.
    fn plan(&self, py: Python<'_>) -> PyResult<String> {
        self.shared.with(py, |simulation| simulation.plan().to_string())
    }

    /// Whether bodies at rest fall asleep. Settable.
    #[getter]
    fn sleep(&self, py: Python<'_>) -> PyResult<bool> {
        self.shared.with(py, |simulation| simulation.sleep())
    }

    #[setter]
    fn set_sleep(&self, py: Python<'_>, sleep: &Bound<'_, PyAny>) -> PyResult<()> {
        let sleep = argument::boolean(sleep, "sleep")?;
        self.shared.with(py, |simulation| simulation.set_sleep(sleep))
    }

    /// Number of threads.
    #[getter]
    fn threads(&self, py: Python<'_>) -> PyResult<usize> {
        self.shared.with(py, |simulation| simulation.threads())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        self.shared.with(py, |simulation| {
            let bodies = simulation.bodies();
            let vertices: usize = bodies.iter().map(|body| body.lattice().len()).sum();
            let megabytes = bodies.iter().map(supple::Body::memory).sum::<usize>() as f64 / 1e6;
            format!(
                "<supple.Simulation: {} of {vertices} lattice vertices, time {:.4} s, dt {:.6} s, {}, {megabytes:.1} MB>",
                counted(bodies.len(), "body", "bodies"),
                simulation.time(),
                simulation.dt(),
                counted(simulation.threads(), "thread", "threads"),
            )
        })
    }

    /// Return a picture and a table for notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("supple.notebook")?.call_method1("picture_html", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, this) = (slf.py(), slf.get());
        let (shapes, bodies): (Vec<_>, Vec<_>) =
            this.bodies.iter().map(|body| body.build_arguments(py)).unzip();
        let checksums = shapes.iter().map(pickle::shape_checksum).collect::<PyResult<Vec<_>>>()?;
        let settings = PyDict::new(py);
        match this.fps(py)? {
            Some(fps) => settings.set_item("fps", fps)?,
            None => settings.set_item("dt", this.dt(py)?)?,
        }
        settings.set_item("colliders", this.colliders(py))?;
        settings.set_item("fields", this.fields(py)?)?;
        settings.set_item("links", this.link_arguments(py)?)?;
        settings.set_item("threads", this.shared.threads())?;
        settings.set_item("substeps", this.substeps(py)?)?;
        let (contact, self_contact) = this.shared.with(py, |s| (s.contact(), s.self_contact()))?;
        settings.set_item("contact", contact)?;
        settings.set_item("self_contact", self_contact)?;
        settings.set_item("sleep", this.sleep(py)?)?;
        let fields = this.bodies.iter().map(|body| body.field_arguments(py)).collect::<PyResult<Vec<_>>>()?;
        let mut arrays = Arrays::default();
        let follows = this.bodies.iter().map(|body| arrays.of(py, body));
        let follows = follows.collect::<PyResult<Vec<_>>>()?;
        let settings = pickle::dumps((bodies, settings, fields, follows).into_pyobject(py)?.as_any())?;
        let state = this.shared.with(py, |simulation| simulation.state())?;
        let data = encode(py, &(checksums, settings, state))?;
        (py.get_type::<Self>().getattr("_restore")?, (shapes, data)).into_pyobject(py)
    }

    /// Build a simulation and restore its state. Pickles call this function.
    #[classmethod]
    fn _restore<'py>(
        class: &Bound<'py, PyType>,
        shapes: Vec<Bound<'py, PyAny>>,
        data: &[u8],
    ) -> PyResult<Bound<'py, Self>> {
        let py = class.py();
        let (checksums, settings, state): (Vec<_>, Vec<u8>, SimulationState) = decode(py, data)?;
        let (settings_of, settings, fields, follows): (Vec<Bound<'py, PyDict>>, _, Vec<Vec<_>>, Vec<Vec<_>>) =
            pickle::loads(py, &settings)?.extract()?;
        let settings: Bound<'py, PyDict> = settings;
        if shapes.len() != checksums.len() {
            return Err(PyValueError::new_err(format!(
                "the pickle is damaged: it has {} bodies and {} shapes; save it again",
                checksums.len(),
                shapes.len()
            )));
        }
        let (mut bodies, mut animations) = (Vec::new(), Restored::default());
        let settings_of = settings_of.iter().zip(fields.into_iter().zip(follows));
        for ((shape, checksum), (settings, (fields, follows))) in
            shapes.into_iter().zip(checksums).zip(settings_of)
        {
            pickle::check_shape(&shape, checksum)?;
            let body = py.get_type::<Body>().call((shape,), Some(settings))?.cast_into()?;
            animations.add(&body, follows)?;
            add_fields(&body, fields)?;
            bodies.push(body);
        }
        let simulation = Bound::new(py, Self::build(PyTuple::new(py, bodies)?.as_any(), Some(&settings))?)?;
        simulation.get().bodies.iter().for_each(|body| body.attach(simulation.as_any()));
        let shared = &simulation.get().shared;
        shared.with(py, |simulation| simulation.restore(&state))?.map_err(error::from_core)?;
        Ok(simulation)
    }
}

/// Formats a count, such as "1 body" or "2 bodies".
fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// Return the SIMD level of this process, such as "avx2" or "neon". Results have the same bits at each.
#[pyfunction]
pub(crate) fn simd_level() -> &'static str {
    supple::simd_level()
}
