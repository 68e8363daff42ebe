//! Steps and frames of `supple.Simulation`, and warnings about materials that the steps cannot reach.

use std::ffi::CString;
use std::sync::PoisonError;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use supple::{Elasticity, Softened};

use super::Simulation;
use super::substeps::{AUTO, substeps as read_substeps};
use crate::argument::{self, Given};
use crate::body::{APART, SharedSimulation};
use crate::error;

/// Target run time between two checks for signals such as Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(10);

/// The number of steps between two checks for signals.
pub(super) struct Batch {
    steps: u64,
    are_apart: bool,
}

impl Batch {
    /// Begins with a single step. `are_apart`: whether bodies are faster with many steps at once.
    pub(super) fn new(are_apart: bool) -> Self {
        Self { steps: 1, are_apart }
    }

    /// Returns how many of the remaining steps to make next. If Python functions give forces, which act in a single step,
    /// that is one.
    pub(super) fn next_of(&self, remaining: u64, has_fields: bool) -> u64 {
        if has_fields { 1 } else { self.steps.min(remaining) }
    }

    /// Follows the run time of a number of steps.
    pub(super) fn follow(&mut self, steps: u64, elapsed: Duration) {
        self.steps = if elapsed < SIGNAL_INTERVAL / 2 { steps.saturating_mul(2) } else { steps.div_ceil(2) };
        if self.are_apart {
            let (greatest, time) = APART;
            let fitting = time.as_secs_f64() * steps as f64 / elapsed.as_secs_f64();
            self.steps = self.steps.max(fitting.min(greatest.into()) as u64);
        }
    }
}

#[pymethods]
impl Simulation {
    /// Length of a step in seconds, from 1e-12 to 1e6.
    ///
    /// Settable without fps; the time stays the same. With fps it is 1 / (fps x steps_per_frame): set substeps.
    #[getter]
    pub(super) fn dt(&self, py: Python<'_>) -> PyResult<f64> {
        self.shared.with(py, |simulation| simulation.dt())
    }

    #[setter]
    fn set_dt(&self, py: Python<'_>, dt: &Bound<'_, PyAny>) -> PyResult<()> {
        let dt = argument::number(dt, "dt")?;
        let set = |simulation: &mut supple::Simulation| match simulation.fps() {
            Some(fps) => Err(PyValueError::new_err(format!(
                "dt cannot be set, because the simulation has fps = {fps}; set substeps, the number of steps per frame"
            ))),
            None => simulation.set_dt(dt).map_err(error::from_core),
        };
        self.shared.with(py, set)?
    }

    /// Number of frames per second, or None if the step length dt was given.
    #[getter]
    pub(super) fn fps(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.shared.with(py, |simulation| simulation.fps())
    }

    /// Number of steps per frame in force. If substeps is "auto", it can change until the first step.
    #[getter]
    fn steps_per_frame(&self, py: Python<'_>) -> PyResult<u64> {
        self.shared.with(py, |simulation| simulation.substeps())
    }

    /// Number of steps per frame as it was set: "auto" or int, at least 1.
    ///
    /// Settable, also to "auto" with fps: the next step then chooses the number anew, for the bodies and motions at
    /// that time. With fps, dt changes.
    #[getter]
    pub(super) fn substeps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (is_auto, steps) = self
            .shared
            .with(py, |simulation| (simulation.has_automatic_substeps(), simulation.substeps()))?;
        if is_auto { Ok(PyString::new(py, AUTO).into_any()) } else { Ok(steps.into_pyobject(py)?.into_any()) }
    }

    #[setter]
    fn set_substeps(&self, py: Python<'_>, substeps: &Bound<'_, PyAny>) -> PyResult<()> {
        let substeps = read_substeps(substeps, "substeps")?;
        self.shared.with(py, |simulation| simulation.set_substeps(substeps))?.map_err(error::from_core)
    }

    /// Advance the simulation by n steps of length dt.
    ///
    /// n : int, default 1
    ///     Number of steps, at least 0.
    ///
    /// Other Python threads continue to run. Ctrl-C interrupts between two steps; steps that have begun end in the
    /// background, within about a second if a step is not longer. The first step warns with
    /// MaterialWarning if steps are too long for the material of a body, and so does the first one after the
    /// material or the step length changed.
    #[pyo3(signature = (n=Given(None)), text_signature = "($self, n=1)")]
    fn step<'py>(&self, py: Python<'py>, n: Given<'py>) -> PyResult<()> {
        let count = n.read("n", |n, name| argument::count(n, name, 0))?.unwrap_or(1) as u64;
        match count {
            0 => Ok(()),
            count => self.in_call(py, || {
                let (_, batch) = self.first_step(py)?;
                self.steps(py, count - 1, batch)
            }),
        }
    }

    /// Advance the simulation by whole frames, of steps_per_frame steps each. It needs fps.
    ///
    /// frames : int, default 1
    ///     Number of frames, at least 0.
    ///
    /// Other Python threads continue to run. Ctrl-C interrupts between two steps, and warnings are as for step.
    /// Raises ValueError without fps.
    #[pyo3(signature = (frames=Given(None)), text_signature = "($self, frames=1)")]
    fn advance<'py>(&self, py: Python<'py>, frames: Given<'py>) -> PyResult<()> {
        let frames = frames.read("frames", |n, name| argument::count(n, name, 0))?.unwrap_or(1) as u64;
        if self.fps(py)?.is_none() {
            return Err(PyValueError::new_err(
                "advance() needs the number of frames per second; build the Simulation with fps= in place of dt=, \
                 or use step(n)",
            ));
        }
        if frames == 0 {
            return Ok(());
        }
        self.in_call(py, || {
            // The first step may choose the number of steps per frame.
            let (steps_per_frame, batch) = self.first_step(py)?;
            self.steps(py, frames.saturating_mul(steps_per_frame) - 1, batch)
        })
    }
}

impl Simulation {
    /// Makes the steps of a call, and then ends the forces that act during a call.
    fn in_call(&self, py: Python<'_>, steps: impl FnOnce() -> PyResult<()>) -> PyResult<()> {
        let result = steps();
        self.shared.end_call(py, result.is_ok())?;
        result
    }

    /// Runs one step, and warns about bodies that are softer than their material for the first time since it or the
    /// step length changed. Returns the number of steps per frame, and the next batch.
    fn first_step(&self, py: Python<'_>) -> PyResult<(u64, Batch)> {
        apply_fields(py, [self])?;
        let (steps_per_frame, warnings, batch) = self.shared.with_long(py, |simulation, shared| {
            let (start, mut batch) = (Instant::now(), Batch::new(simulation.bodies_are_apart()));
            simulation.make_steps(1);
            batch.follow(1, start.elapsed());
            (simulation.substeps(), warnings_about_materials(simulation, shared), batch)
        })?;
        warn_softened(py, warnings)?;
        py.check_signals()?;
        Ok((steps_per_frame, batch))
    }

    /// Runs steps, and checks for signals between batches of them.
    fn steps(&self, py: Python<'_>, mut remaining: u64, mut batch: Batch) -> PyResult<()> {
        while remaining > 0 {
            let steps = batch.next_of(remaining, apply_fields(py, [self])?);
            let elapsed = self.shared.with_long(py, move |simulation, _| {
                let start = Instant::now();
                simulation.make_steps(steps);
                start.elapsed()
            })?;
            remaining -= steps;
            batch.follow(steps, elapsed);
            py.check_signals()?;
        }
        Ok(())
    }
}

/// Applies the forces of all force fields of simulations in their next steps. Returns whether there are fields. If a
/// function raises an error, no force is applied.
pub(super) fn apply_fields<'a>(
    py: Python<'_>,
    simulations: impl IntoIterator<Item = &'a Simulation>,
) -> PyResult<bool> {
    let mut evaluated = Vec::new();
    for simulation in simulations {
        if simulation.bodies.iter().any(|body| body.has_fields()) {
            let time = simulation.shared.with(py, |simulation| simulation.time())?;
            for body in &simulation.bodies {
                evaluated.push((body, body.field_forces(py, time)?));
            }
        }
    }
    let has_fields = !evaluated.is_empty();
    evaluated.into_iter().try_for_each(|(body, forces)| body.apply_fields(py, forces))?;
    Ok(has_fields)
}

/// Returns the warnings about bodies that are softer than their material for the first time since it or the step length
/// changed.
pub(super) fn warnings_about_materials(
    simulation: &supple::Simulation,
    shared: &SharedSimulation,
) -> Vec<String> {
    let mut last = shared.softened.lock().unwrap_or_else(PoisonError::into_inner);
    last.resize(simulation.bodies().len(), None);
    let mut warnings = Vec::new();
    for (index, last) in last.iter_mut().enumerate() {
        let softened = simulation.body(index).softened();
        if softened != *last {
            *last = softened;
            warnings.extend(softened.map(|softened| message(simulation, index, &softened)));
        }
    }
    warnings
}

/// Warns about materials.
pub(super) fn warn_softened(py: Python<'_>, warnings: Vec<String>) -> PyResult<()> {
    for warning in warnings {
        let category = py.import("supple.errors")?.getattr("MaterialWarning")?;
        PyErr::warn(py, &category, &CString::new(warning)?, 1)?;
    }
    Ok(())
}

/// Formats the warning that a body is softer than its material.
fn message(simulation: &supple::Simulation, index: usize, softened: &Softened) -> String {
    let body = simulation.body(index);
    let Softened { key, specified, in_force, factor, needed_rate, .. } = *softened;
    let part = if factor > 1.0 { format!(" of the part with the factor {factor}") } else { String::new() };
    let asked = match body.material().elasticity {
        Elasticity::Preset(preset) => format!("{:.4e} (material {:?})", specified, preset.name()),
        Elasticity::YoungsModulus(_) => format!("{specified:.4e}"),
        Elasticity::Regions { .. } => format!("{specified} Hz"),
    };
    let in_force = match body.material().elasticity {
        Elasticity::Regions { .. } => format!("{in_force:.4} Hz"),
        _ => format!("{in_force:.4e}"),
    };
    // The factor prevents a rounding error from increasing a whole number of steps by one.
    let substeps = |fps: f64| (needed_rate / fps * (1.0 - 1e-9)).ceil();
    let way_out = match simulation.fps() {
        None => format!(
            "build the Simulation with fps= and substeps=\"auto\", or with dt of at most {:.3e}",
            1.0 / needed_rate
        ),
        Some(fps) if simulation.has_automatic_substeps() => {
            format!("\"auto\" takes at most 1000 steps per frame; set substeps to at least {}", substeps(fps))
        }
        Some(fps) => format!("set substeps to \"auto\" or to at least {}", substeps(fps)),
    };
    format!(
        "body {:?} is softer than its material: {key}{part} = {asked} needs shorter steps than {:.3e} s, and {in_force} is in \
         force; {way_out}",
        body.name(),
        simulation.dt(),
    )
}
