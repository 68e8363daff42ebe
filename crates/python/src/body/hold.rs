//! Defines `supple.Hold`: a pin or a handle of a body.

use std::hash::{DefaultHasher, Hash, Hasher};

use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use pyo3::{PyTraverseError, PyVisit};
use supple::{Constraint, ConstraintError, HoldForce, Interpolation, MeshAnimation};
use supple_io::counted;

use super::Body;
use super::quantities::need_simulation;
use crate::argument::choice;
use crate::pickle::{decode, encode};
use crate::{animation, arrays, constraint, error};

/// A keyframe as a tuple: time, translate, rotate.
type KeyTuple = (f64, (f64, f64, f64), (f64, f64, f64));

/// A pin or a handle of a body.
///
/// Body.pin and Body.handle return it, and Body.holds lists those that were not released. A Hold is pickled
/// together with its body. Only active, body, release and released can be used after a release.
#[pyclass(frozen, module = "supple")]
pub(crate) struct Hold {
    body: Py<Body>,
    /// See [`Constraint::index`].
    index: usize,
}

impl Hold {
    /// Returns the pin or handle of a body with an index.
    pub(super) fn new(body: &Bound<'_, Body>, index: usize) -> Self {
        Self { body: body.clone().unbind(), index }
    }

    /// Adds a pin or handle to the body with `add`.
    pub(super) fn add(
        body: &Bound<'_, Body>,
        add: impl FnOnce(&mut supple::Body) -> Result<(), supple::Error> + Send,
    ) -> PyResult<Self> {
        let index = body.get().with(body.py(), |body| add(body).map(|()| body.constraint_count() - 1))?;
        Ok(Self::new(body, index.map_err(error::from_core)?))
    }

    /// Calls `read` with the pin or handle.
    fn read<R: Send>(&self, py: Python<'_>, read: impl FnOnce(&Constraint) -> R + Send) -> PyResult<R> {
        self.body.get().read(py, |body| body.constraint(self.index).map(read))?.map_err(hold_error)
    }

    /// Returns the animation that a handle follows.
    fn animation(&self, py: Python<'_>) -> PyResult<Option<MeshAnimation>> {
        self.read(py, |hold| hold.followed().map(|(animation, _)| animation.clone()))
    }

    /// Returns a vector of the force of the pin or handle as an array. `name` is that of the property.
    fn load<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        vector: impl FnOnce(HoldForce) -> [f64; 3],
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let force = self.body.get().in_context(py, |body| body.hold_force(self.index))?;
        let force = need_simulation(force.map_err(hold_error)?, name)?;
        Ok(arrays::frozen(PyArray1::from_slice(py, &vector(force))))
    }
}

/// Converts an error of a pin or handle.
fn hold_error(error: ConstraintError) -> PyErr {
    match error {
        ConstraintError::Released { .. } => PyValueError::new_err(
            "the pin or handle was released; add another one with body.pin() or body.handle()",
        ),
        error => error::value(error),
    }
}

#[pymethods]
impl Hold {
    /// Body that the pin or handle belongs to.
    #[getter]
    fn body(&self, py: Python<'_>) -> Py<Body> {
        self.body.clone_ref(py)
    }

    /// Lattice vertices, in increasing order: (k,) int64, read-only.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let vertices: Vec<i64> = self.read(py, |hold| hold.vertices().iter().map(|&v| v.into()).collect())?;
        Ok(arrays::frozen(PyArray1::from_vec(py, vertices)))
    }

    /// Keyframes of a handle: tuple of (time, translate, rotate). None for a pin and for an animation. Replace them
    /// with set_keys.
    #[getter]
    fn keys<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        let tuple = |key: &supple::Key| -> KeyTuple { (key.time, key.translate.into(), key.rotate.into()) };
        let keys: Option<Vec<KeyTuple>> =
            self.read(py, |hold| hold.keys().map(|keys| keys.iter().map(tuple).collect()))?;
        keys.map(|keys| PyTuple::new(py, keys)).transpose()
    }

    /// Interpolation between the keyframes of a handle: "linear", "smooth" or "cubic". None for a pin and for an
    /// animation.
    #[getter]
    fn interpolation(&self, py: Python<'_>) -> PyResult<Option<&'static str>> {
        self.read(py, |hold| hold.interpolation().map(Interpolation::name))
    }

    /// Positions of the animation that a handle follows: (f, n, 3) float32, read-only. None for a pin and for
    /// keyframes.
    #[getter]
    fn follow<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.animation(py)?.map(|animation| animation::array(py, &animation)).transpose()
    }

    /// Frames per second of the animation that a handle follows, or None.
    #[getter]
    fn follow_fps(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        Ok(self.animation(py)?.map(|animation| 1.0 / animation.interval()))
    }

    /// Time in seconds of the first frame of the animation that a handle follows, or None.
    #[getter]
    fn follow_start(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        Ok(self.animation(py)?.map(|animation| animation.start()))
    }

    /// Whether the pin or handle acted in the last step.
    #[getter]
    fn active(&self, py: Python<'_>) -> PyResult<bool> {
        self.body.get().read(py, |body| body.constraint(self.index).is_ok_and(Constraint::is_active))
    }

    /// Whether the pin or handle was released.
    #[getter]
    fn released(&self, py: Python<'_>) -> PyResult<bool> {
        self.body.get().read(py, |body| body.constraint(self.index).is_err())
    }

    /// Start of the time window in seconds.
    #[getter]
    fn start(&self, py: Python<'_>) -> PyResult<f64> {
        self.read(py, |hold| hold.window().start)
    }

    /// End of the time window in seconds, or None.
    ///
    /// A pin or handle whose window has ended acts again if the time of the simulation is set back.
    #[getter]
    fn end(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.read(py, |hold| Some(hold.window().end).filter(|end| end.is_finite()))
    }

    /// Weight of a soft goal: a number, a list of (time, value), or a dict with the keys keys and interpolation; 1 if the
    /// positions are prescribed.
    #[getter]
    fn weight<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let weight = self.read(py, |hold| hold.goal().map_or(1.0.into(), |goal| goal.weight.clone()))?;
        constraint::curve_to_python(py, &weight)
    }

    /// Force that the pin or handle exerts on the body in the next step, in mass x length/s^2: (3,) float64,
    /// read-only.
    ///
    /// It is what the held part needs, beside the elastic forces and gravity, to move as prescribed; zero if the pin or
    /// handle did not act in the last step. The reaction of the elastic damping is included, contacts, external forces
    /// on the held part and region damping are not. Where keyframes change the velocity, the force is that of the
    /// change within one step. Computing it takes as long as a step. Raises ValueError outside a simulation.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.load(py, "force", |load| load.force.into())
    }

    /// Torque that belongs to force, about the mean position of the lattice vertices of the pin or handle, in
    /// mass x length^2/s^2: (3,) float64, read-only.
    #[getter]
    fn torque<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.load(py, "torque", |load| load.torque.into())
    }

    /// Release the part permanently, from the next step on. A second call has no effect.
    ///
    /// A released pin or handle takes no memory and no time. One whose window has ended does.
    fn release(&self, py: Python<'_>) -> PyResult<()> {
        self.body.get().with(py, |body| body.release(self.index))?.map_err(hold_error)
    }

    /// Replace the keyframes, from the next step on. A pin that gets keyframes becomes a handle. A handle that
    /// followed an animation moves along them from the pose that the part has before the next step.
    ///
    /// keys : list of (time, translate, rotate), as for Body.handle
    ///     Relative to the pose that the part had when the pin or handle became active.
    /// interpolation : "linear", "smooth" or "cubic", optional
    ///     Default: as before, "linear" for a pin.
    ///
    /// Raises ValueError if the pin or handle was released.
    #[pyo3(signature = (keys, interpolation=None))]
    fn set_keys(
        &self,
        py: Python<'_>,
        keys: &Bound<'_, PyAny>,
        interpolation: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let keys = constraint::keys(keys)?;
        let read = |value| choice(value, "interpolation", &Interpolation::NAMED);
        let interpolation = interpolation.map(read).transpose()?;
        let set = |body: &mut supple::Body| body.set_keys(self.index, &keys, interpolation);
        self.body.get().with(py, set)?.map_err(hold_error)
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.body)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.index == other.index && self.body.is(&other.body)
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        (self.body.as_ptr().addr(), self.index).hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        self.body.get().read(py, |body| {
            let what = match body.constraint(self.index) {
                Ok(hold) => describe(hold),
                Err(ConstraintError::Released { .. }) => "released".to_owned(),
                Err(error) => error.to_string(),
            };
            format!("<supple.Hold {} of body {:?}: {what}>", self.index, body.name())
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, this) = (slf.py(), slf.get());
        let restore = py.get_type::<Self>().getattr("_of")?;
        (restore, (&this.body, encode(py, &this.index)?)).into_pyobject(py)
    }

    /// Return the pin or handle of a body with an index. Pickles call this function.
    #[staticmethod]
    fn _of(body: &Bound<'_, Body>, index: &[u8]) -> PyResult<Self> {
        Ok(Self::new(body, decode(body.py(), index)?))
    }
}

/// Describes a pin or handle: kind, part, time window, and whether it is active.
fn describe(hold: &Constraint) -> String {
    let kind = match (hold.keys(), hold.followed()) {
        (Some(keys), _) => format!("handle with {}", counted(keys.len(), "key")),
        (None, Some((animation, _))) => {
            format!("handle that follows {}", counted(animation.samples(), "frame"))
        }
        (None, None) => "pin".to_owned(),
    };
    let window = match hold.window() {
        window if window.end.is_finite() => format!("from {} to {} s", window.start, window.end),
        window => format!("from {} s on", window.start),
    };
    let vertices = match hold.vertices().len() {
        1 => "1 lattice vertex".to_owned(),
        count => format!("{count} lattice vertices"),
    };
    let active = if hold.is_active() { ", active" } else { "" };
    format!("{kind} on {vertices}, {window}{active}")
}
