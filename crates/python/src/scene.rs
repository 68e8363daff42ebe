//! Loads scenes as live simulations, and runs them to frames on disk.

use std::ffi::CString;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};
use supple::Collider;
use supple_io::run::{
    BodyReport, Flow, Input, Job, Note, Observer, Prepared, Progress, Resume, RunError, RunReport, Softened,
    UnkeptVolume, prepare, preroll,
};
use supple_io::scene::{BodyData, OutputData, Scene, SceneError, Up};

use crate::argument::{self, Settings};
use crate::body::{SharedBody, SharedSimulation, Storage, body_keys};
use crate::error::{self, Exception};
use crate::interrupt::interruptible;
use crate::mesh::Mesh;
use crate::simulation::{Simulation, warn};
use crate::{collider, keys, report};

/// Level of the stack of the code that calls `supple.load_scene` or `supple.run`, which are Python functions.
const CALLER: i32 = 2;

/// Load a scene file as a simulation at time zero. `overrides` contains strings `KEY=VALUE`.
#[pyfunction]
pub(crate) fn load_scene<'py>(
    py: Python<'py>,
    path: &Bound<'py, PyAny>,
    overrides: Vec<String>,
) -> PyResult<Bound<'py, Simulation>> {
    let scene = open(path, &overrides)?;
    let described = scene.clone();
    let build = move || {
        let mut prepared = prepare(&described)?;
        preroll(&mut prepared.simulation, described.simulation.preroll, |_| true)
            .map_err(RunError::Simulation)?;
        Ok(prepared)
    };
    let prepared = interruptible(py, build)?.map_err(run_error)?;
    let simulation = to_python(py, &scene, &prepared.inputs, Arc::new(Mutex::new(prepared.simulation)))?;
    warn(py, &prepared.cautions, CALLER)?;
    Ok(simulation)
}

/// Creates the Python object of the simulation of a scene.
fn to_python<'py>(
    py: Python<'py>,
    scene: &Scene,
    inputs: &[Input],
    simulation: Arc<Mutex<supple::Simulation>>,
) -> PyResult<Bound<'py, Simulation>> {
    let colliders: Vec<Collider> = {
        let simulation = simulation.lock().unwrap_or_else(PoisonError::into_inner);
        let collider = |index| simulation.collider(index).description().clone();
        (0..simulation.collider_count()).map(collider).collect()
    };
    let shared = Arc::new(SharedSimulation::new(simulation, scene.simulation.threads));
    let bodies = scene.bodies.iter().zip(inputs).enumerate().map(|(index, (data, input))| {
        let path = scene.base.join(&data.mesh);
        let mesh = Mesh::from_file(input.part.mesh().clone(), &path, data.object.as_deref());
        let shape = Bound::new(py, mesh)?.into_any();
        let arguments = (shape, settings(py, data)?);
        Ok(Arc::new(SharedBody::new(Storage::In(shared.clone(), index), arguments)))
    });
    let bodies = bodies.collect::<PyResult<_>>()?;
    let colliders = colliders.iter().map(|collider| collider::to_python(py, collider));
    let colliders = PyTuple::new(py, colliders.collect::<PyResult<Vec<_>>>()?)?;
    Bound::new(py, Simulation::from_parts(shared, bodies, &colliders)?)
}

/// Converts the scene keys of a body to keyword arguments of `Body`.
fn settings<'py>(py: Python<'py>, data: &BodyData) -> PyResult<Bound<'py, PyDict>> {
    let settings = PyDict::new(py);
    let keys = body_keys();
    for (key, value) in data.to_keys().iter().filter(|(key, _)| keys.contains(key) && *key != "object") {
        settings.set_item(key, keys::to_python(py, value)?)?;
    }
    Ok(settings)
}

/// Keyword arguments of `supple.run`.
const KEYS: [&str; 10] = [
    "output",
    "format",
    "frames",
    "progress",
    "every",
    "start_frame",
    "stats",
    "resume",
    "from_frame",
    "threads",
];

/// Keyword arguments of `supple.run` that may be `None`, which means the value of the scene, or no callback
/// or statistics.
const OPTIONAL: [&str; 7] = ["output", "format", "frames", "progress", "stats", "from_frame", "threads"];

/// Run a scene to frames on disk. `overrides` contains strings `KEY=VALUE`.
#[pyfunction]
#[pyo3(
    signature = (path, overrides, **options),
    text_signature = "(path, overrides, *, output=None, format=None, frames=None, progress=None, every=1, start_frame=0, stats=None, resume=False, from_frame=None, threads=None)"
)]
pub(crate) fn run<'py>(
    py: Python<'py>,
    path: &Bound<'py, PyAny>,
    overrides: Vec<String>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = Settings::from_call(options, "run()", &KEYS, &OPTIONAL)?;
    let mut scene = open(path, &overrides)?;
    if let Some(format) = options.get("format")? {
        let convert = |key: &str, value: &Bound<'py, PyAny>| keys::value(value, key).map(Some);
        scene.output.format = keys::read::<OutputData>([("format".to_owned(), format)], convert)?.format;
    }
    let simulation = &mut scene.simulation;
    simulation.frames = options.count_u32("frames", 0)?.unwrap_or(simulation.frames);
    simulation.threads = options.count("threads", 0)?.unwrap_or(simulation.threads);
    let output = options.read("output", argument::path)?.unwrap_or_else(|| scene.output_directory());
    let mut job = Job::new(scene, output);
    job.scene_file = Some(argument::path(path, "path")?);
    job.every = options.count_u32("every", 1)?.unwrap_or(job.every);
    job.start_frame = options.count_u32("start_frame", 0)?.unwrap_or(job.start_frame);
    job.stats = options.read("stats", argument::path)?;
    job.resume = options.read("resume", resume)?.unwrap_or(job.resume);
    job.from = options.count_u32("from_frame", 0)?;
    let callback = options.read("progress", argument::callable)?;
    let mut observer = CallbackObserver {
        scene: &job.scene,
        start_frame: job.start_frame,
        callback,
        simulation: None,
        raised: None,
    };
    let report = py.detach(|| job.run(&mut observer));
    if let Some(raised) = observer.raised {
        return Err(raised);
    }
    run_report(py, &report.map_err(run_error)?)
}

/// Reads the argument `resume`: a boolean or "auto".
fn resume(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Resume> {
    match value.is_instance_of::<PyString>() {
        true => argument::choice(value, name, &[("auto", Resume::Auto)]),
        false => {
            let expected = "True, False or \"auto\"";
            let is_set = value.extract::<bool>();
            is_set.map(Resume::from).map_err(|error| argument::conversion_error(error, value, name, expected))
        }
    }
}

/// Checks for Ctrl-C and calls the `progress` callback after each frame. A `KeyboardInterrupt` or an
/// exception of the callback stops the run.
struct CallbackObserver<'a> {
    scene: &'a Scene,
    /// Number of frame 0 in file names.
    start_frame: u32,
    callback: Option<Py<PyAny>>,
    /// The simulation that the callback can read and change.
    simulation: Option<Py<Simulation>>,
    /// The exception that stops the run.
    raised: Option<PyErr>,
}

impl Observer for CallbackObserver<'_> {
    fn prepare(&mut self, scene: &Scene) -> Result<Prepared, RunError> {
        let scene = scene.clone();
        let prepared = Python::attach(|py| interruptible(py, move || prepare(&scene)));
        prepared.unwrap_or_else(|raised| {
            self.raised = Some(raised);
            Err(RunError::Stopped)
        })
    }

    fn preroll(&mut self, _done: f64) -> Flow {
        match Python::attach(|py| py.check_signals()) {
            Ok(()) => Flow::Continue,
            Err(raised) => {
                self.raised = Some(raised);
                Flow::Stop
            }
        }
    }

    fn built(&mut self, simulation: &Arc<Mutex<supple::Simulation>>, inputs: &[Input]) {
        if self.callback.is_some() {
            let simulation = simulation.clone();
            match Python::attach(|py| to_python(py, self.scene, inputs, simulation).map(Bound::unbind)) {
                Ok(simulation) => self.simulation = Some(simulation),
                Err(error) => self.raised = Some(error),
            }
        }
    }

    fn note(&mut self, note: &Note) {
        let warned = Python::attach(|py| match note {
            Note::Caution(caution) => warn(py, std::slice::from_ref(caution), CALLER),
            Note::Restarted { .. } => {
                let category = py.import("supple.errors")?.getattr("ResumeWarning")?;
                PyErr::warn(py, &category, &CString::new(note.message(self.start_frame))?, CALLER)
            }
            _ => Ok(()),
        });
        self.raised = self.raised.take().or(warned.err());
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        if self.raised.is_some() {
            return Flow::Stop;
        }
        let proceed = Python::attach(|py| -> PyResult<bool> {
            py.check_signals()?;
            let Some(callback) = &self.callback else { return Ok(true) };
            let Progress { frame, last, time, elapsed } = progress;
            let fields = (*frame, *last, *time, elapsed.as_secs_f64(), &self.simulation);
            let result = callback.bind(py).call1((report::new_report(py, "Progress", fields)?,))?;
            Ok(result.extract::<bool>().unwrap_or(true))
        });
        let proceed = proceed.unwrap_or_else(|error| {
            self.raised = Some(error);
            false
        });
        if proceed { Flow::Continue } else { Flow::Stop }
    }
}

/// Creates a `supple.reports.RunReport`.
fn run_report<'py>(py: Python<'py>, run: &RunReport) -> PyResult<Bound<'py, PyAny>> {
    let body = |body: &BodyReport| {
        let volume = report::volume_report(py, &body.volume)?;
        let unkept = body.unkept_volume.map(|unkept| {
            let UnkeptVolume { frames, written, worst_frame, worst_error, .. } = unkept;
            report::new_report(py, "UnkeptVolume", (frames, written, worst_frame, worst_error))
        });
        let softened = body.softened.map(|softened| {
            let Softened { key, specified, in_force, factor, substeps, needed_substeps, .. } = softened;
            report::new_report(py, "Softened", (key, specified, in_force, factor, substeps, needed_substeps))
        });
        let crushed = body.crushed.map_or(0, |crushed| crushed.frames);
        let (unkept, softened) = (unkept.transpose()?, softened.transpose()?);
        let fields = (&body.name, body.lattice_vertices, volume, unkept, crushed, softened);
        report::new_report(py, "BodyReport", fields)
    };
    let bodies = run.bodies.iter().map(body).collect::<PyResult<Vec<_>>>()?;
    let outcome = run.outcome.name();
    let bodies = PyTuple::new(py, bodies)?;
    let elapsed = run.elapsed.as_secs_f64();
    let RunReport { directory, resumed_after, last, simulated, written, substeps, .. } = run;
    let files = PyTuple::new(py, &run.files)?;
    let values =
        (directory, outcome, resumed_after, last, simulated, written, substeps, elapsed, bodies, files);
    report::new_report(py, "RunReport", values)
}

/// Opens a scene file (TOML), or creates the default scene of a model.
fn open(path: &Bound<'_, PyAny>, overrides: &[String]) -> PyResult<Scene> {
    let py = path.py();
    let path = argument::path(path, "path")?;
    py.detach(|| {
        // A missing file gives FileNotFoundError for any file extension.
        if let Err(missing) = std::fs::metadata(&path) {
            return Err(SceneError::Read { path, source: missing });
        }
        Scene::open(&path, Up::default(), overrides)
    })
    .map_err(scene_error)
}

/// Converts an error of a scene.
fn scene_error(error: SceneError) -> PyErr {
    match error {
        SceneError::Read { path, source } => error::from_io(&path, &source),
        SceneError::Mesh(error) => error::from_model(error),
        error => Exception::Scene.with(python_message(&error)),
    }
}

/// Formats an error. The argument `overrides` is called as in Python, not as on the command line.
fn python_message(error: &impl std::fmt::Display) -> String {
    error.to_string().replace("--set ", "overrides: ")
}

/// Converts an error of a run.
fn run_error(error: RunError) -> PyErr {
    let message = python_message(&error);
    match error {
        RunError::Scene(error) => scene_error(error),
        RunError::MeshFile { path, source, .. } => error::from_io(&path, &source),
        RunError::Mesh(error) => error::from_model(error),
        RunError::Body { source: supple::Error::Mesh(_), .. } => Exception::Mesh.with(message),
        RunError::Body { source: supple::Error::Lattice(_), .. } => Exception::Lattice.with(message),
        error if error.is_input() && !matches!(error, RunError::OutputIsAFile { .. }) => {
            Exception::Scene.with(message)
        }
        _ => Exception::Output.with(message),
    }
}
