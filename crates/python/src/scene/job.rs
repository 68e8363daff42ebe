//! A scene run to frames on disk.

use std::sync::{Arc, Mutex};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use supple_io::frames::Format;
use supple_io::run::{Flow, Input, Job, Observer, Outcome, Progress, RunReport};
use supple_io::scene::Scene;

use super::load::live;
use super::{of_run, open};
use crate::argument;
use crate::report::{self, Report};
use crate::settings::Settings;
use crate::simulation::Simulation;

/// The keyword arguments of `supple.run`.
const KEYS: [&str; 9] =
    ["output", "format", "frames", "progress", "every", "start_frame", "stats", "resume", "threads"];

/// Those that may be `None`: as the scene has it, or not asked for.
const OPTIONAL: [&str; 6] = ["output", "format", "frames", "progress", "stats", "threads"];

/// Runs a scene to frames on disk; `overrides` are `KEY=VALUE`.
#[pyfunction]
#[pyo3(
    signature = (path, overrides, **options),
    text_signature = "(path, overrides, *, output=None, format=None, frames=None, progress=None, every=1, start_frame=0, stats=None, resume=False, threads=None)"
)]
pub(crate) fn run<'py>(
    py: Python<'py>,
    path: &Bound<'py, PyAny>,
    overrides: Vec<String>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = Settings::of_call(options, "run()", &KEYS, &OPTIONAL)?;
    let mut scene = open(path, &overrides)?;
    if let Some(format) = options.get("format")? {
        let formats = Format::ALL.map(|format| (format.name(), format));
        scene.output.format = argument::choice(&format, "format", &formats)?;
    }
    if let Some(frames) = options.count_u32("frames", 0)? {
        scene.simulation.frames = frames;
    }
    if let Some(threads) = options.count("threads", 0)? {
        scene.simulation.threads = threads;
    }
    let output = options.path("output")?.unwrap_or_else(|| scene.output_folder());
    let mut job = Job::new(scene, output);
    job.every = options.count_u32("every", 1)?.unwrap_or(job.every);
    job.start_frame = options.count_u32("start_frame", 0)?.unwrap_or(job.start_frame);
    job.stats = options.path("stats")?;
    job.resume = options.boolean("resume")?.unwrap_or(job.resume);
    let callback = options.get("progress")?.map(Bound::unbind);
    let mut onlooker = Onlooker { scene: &job.scene, callback, simulation: None, raised: None };
    let report = py.detach(|| job.run(&mut onlooker));
    if let Some(raised) = onlooker.raised {
        return Err(raised);
    }
    of_report(py, &report.map_err(of_run)?)
}

/// Lets Ctrl-C through and calls back after each frame; what either raises stops the run.
struct Onlooker<'a> {
    scene: &'a Scene,
    callback: Option<Py<PyAny>>,
    /// What the callback may look at and change.
    simulation: Option<Py<Simulation>>,
    raised: Option<PyErr>,
}

impl Observer for Onlooker<'_> {
    fn built(&mut self, simulation: &Arc<Mutex<supple::Simulation>>, inputs: &[Input]) {
        if self.callback.is_some() {
            let live =
                Python::attach(|py| live(py, self.scene, inputs, simulation.clone()).map(Bound::unbind));
            match live {
                Ok(simulation) => self.simulation = Some(simulation),
                Err(error) => self.raised = Some(error),
            }
        }
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        if self.raised.is_some() {
            return Flow::Stop;
        }
        let goes_on = Python::attach(|py| -> PyResult<bool> {
            py.check_signals()?;
            let Some(callback) = &self.callback else { return Ok(true) };
            let Progress { frame, last, time, elapsed } = progress;
            let fields = (*frame, *last, *time, elapsed.as_secs_f64(), &self.simulation);
            let progress = Report::Progress.make(py, fields)?;
            let answer = callback.bind(py).call1((progress,))?;
            Ok(answer.extract::<bool>().unwrap_or(true))
        });
        match goes_on {
            Ok(true) => Flow::Continue,
            Ok(false) => Flow::Stop,
            Err(error) => {
                self.raised = Some(error);
                Flow::Stop
            }
        }
    }
}

/// A `supple.reports.RunReport`.
fn of_report<'py>(py: Python<'py>, run: &RunReport) -> PyResult<Bound<'py, PyAny>> {
    let mut bodies = Vec::with_capacity(run.bodies.len());
    for body in &run.bodies {
        let volume = report::of_volume(py, &body.volume)?;
        bodies.push(Report::Body.make(py, (&body.name, body.lattice_vertices, volume))?);
    }
    let outcome = match run.outcome {
        Outcome::Finished => "finished",
        Outcome::Stopped => "stopped",
        Outcome::AlreadyFinished => "already finished",
    };
    let bodies = PyTuple::new(py, bodies)?;
    let elapsed = run.elapsed.as_secs_f64();
    let RunReport { directory, resumed_after, last, simulated, written, substeps, .. } = run;
    let values = (directory, outcome, resumed_after, last, simulated, written, substeps, elapsed, bodies);
    Report::Run.make(py, values)
}
