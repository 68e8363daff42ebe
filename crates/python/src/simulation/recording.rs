//! Records a simulation into a file, and shows runs as films.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple_io::films::{self, FilmError, FilmRequest};
use supple_io::run::{self, RecordingOptions};
use supple_io::scene::OutputData;

use super::Simulation;
use crate::argument::{self, Settings, wrong_type};
use crate::body::SharedSimulation;
use crate::error::Exception;
use crate::{error, keys};

/// Keyword arguments of a recording; of them, `up`, `fps` and `film_view` may be `None`.
const KEYS: [&str; 9] = [
    "up",
    "scale",
    "fps",
    "meters_per_unit",
    "glb_error",
    "usd_velocities",
    "film_size",
    "film_view",
    "film_color",
];
const OPTIONAL: [&str; 3] = ["up", "fps", "film_view"];

/// A file with the surfaces of a simulation; see supple.Recorder.
#[pyclass(frozen, module = "supple._core")]
pub(crate) struct Recording {
    shared: Arc<SharedSimulation>,
    path: PathBuf,
    /// `None` when the recording has ended.
    recording: Mutex<Option<run::Recording>>,
}

#[pymethods]
impl Recording {
    /// Start a file.
    #[new]
    #[pyo3(
        signature = (simulation, path, **options),
        text_signature = "(simulation, path, *, up=None, scale=1.0, fps=None, meters_per_unit=1.0, glb_error=0.001, \
                          usd_velocities=False, film_size=(800, 600), film_view=None, film_color='material')"
    )]
    fn new(
        simulation: &Bound<'_, PyAny>,
        path: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let py = simulation.py();
        let simulation = simulation
            .cast::<Simulation>()
            .map_err(|_| wrong_type(simulation, "simulation", "a supple.Simulation"))?;
        let path = argument::path(path, "path")?;
        let settings = Settings::from_call(options, "Recorder()", &KEYS, &OPTIONAL)?;
        let output: OutputData = keys::read(settings.iter(), |key, value| keys::value(value, key).map(Some))?;
        let mut options = RecordingOptions::default();
        options.formats = output.format_options();
        (options.up, options.scale, options.fps) = (output.up, output.scale, output.fps);
        let shared = simulation.get().shared.clone();
        let start = |simulation: &mut supple::Simulation| run::Recording::create(&path, simulation, &options);
        let recording = shared.with(py, start)?.map_err(error::output)?;
        Ok(Self { shared, path, recording: Mutex::new(Some(recording)) })
    }

    /// Append a frame with the present state.
    fn record(&self, py: Python<'_>) -> PyResult<()> {
        let write = |simulation: &mut supple::Simulation| {
            let mut recording = self.recording.lock().unwrap_or_else(PoisonError::into_inner);
            recording.as_mut().map(|recording| recording.write(simulation))
        };
        match self.shared.with(py, write)? {
            Some(written) => written.map_err(error::output),
            None => {
                let path = self.path.display();
                Err(PyValueError::new_err(format!("the recording {path} has ended; start another Recorder")))
            }
        }
    }

    /// Number of frames so far; None when the recording has ended.
    #[getter]
    fn frames(&self, py: Python<'_>) -> Option<u64> {
        let read = || {
            let recording = self.recording.lock().unwrap_or_else(PoisonError::into_inner);
            recording.as_ref().map(run::Recording::frames)
        };
        py.detach(read)
    }

    /// Complete the file. Returns lines about what it holds approximately or not at all. Does nothing when the recording
    /// has ended.
    fn close(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let finish = || {
            let recording = self.recording.lock().unwrap_or_else(PoisonError::into_inner).take();
            recording.map_or(Ok(Vec::new()), run::Recording::finish)
        };
        py.detach(finish).map_err(error::output)
    }
}

/// Keyword arguments of [`film`]; of them, these may be `None`.
const FILM_KEYS: [&str; 5] = ["up", "fps", "film_size", "film_view", "film_color"];
const FILM_OPTIONAL: [&str; 3] = ["up", "fps", "film_view"];

/// Write a film of a run on disk. Returns the number of frames.
#[pyfunction]
#[pyo3(
    signature = (run, path, **options),
    text_signature = "(run, path, *, up=None, fps=None, film_size=(800, 600), film_view=None, film_color='material')"
)]
pub(crate) fn film(
    run: &Bound<'_, PyAny>,
    path: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<usize> {
    let (input, output) = (argument::path(run, "run")?, argument::path(path, "path")?);
    let settings = Settings::from_call(options, "film()", &FILM_KEYS, &FILM_OPTIONAL)?;
    let given: OutputData = keys::read(settings.iter(), |key, value| keys::value(value, key).map(Some))?;
    let mut request = FilmRequest::default();
    (request.look, request.fps, request.up) = (given.film(), given.fps, given.up.unwrap_or_default());
    run_film(run.py(), &input, &output, &request)
}

fn run_film(py: Python<'_>, input: &Path, output: &Path, request: &FilmRequest) -> PyResult<usize> {
    py.detach(|| films::film(input, output, request)).map_err(|error| match error {
        FilmError::Read { path, source } if source.raw_os_error().is_some() => error::from_io(&path, &source),
        error if error.is_input() => error::value(error),
        error => Exception::Output.with(error.to_string()),
    })
}
