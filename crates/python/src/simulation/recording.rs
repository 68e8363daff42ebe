//! Records a simulation into a USD stage or a page.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple_io::run::{self, RecordingOptions};
use supple_io::scene::OutputData;

use super::Simulation;
use crate::argument::{self, Settings, wrong_type};
use crate::body::SharedSimulation;
use crate::{error, keys};

/// Keyword arguments of a recording; of them, `up` and `fps` may be `None`.
const KEYS: [&str; 6] = ["up", "scale", "fps", "meters_per_unit", "glb_error", "usd_velocities"];
const OPTIONAL: [&str; 2] = ["up", "fps"];

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
                          usd_velocities=False)"
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
        let output = keys::read(settings.iter(), |key, value| keys::value(value, key).map(Some))?;
        let OutputData { up, scale, fps, meters_per_unit, glb_error, usd_velocities, .. } = output;
        let mut options = RecordingOptions::default();
        (options.up, options.scale, options.fps) = (up, scale, fps);
        (options.meters_per_unit, options.glb_error) = (meters_per_unit, glb_error);
        options.usd_velocities = usd_velocities;
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
