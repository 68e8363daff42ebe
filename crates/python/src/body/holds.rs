//! Pins and handles, and the `Hold` that each gives.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{Handle, Pin};

use super::Body;
use crate::argument::Settings;
use crate::{arrays, constraint, error};

/// The arguments of handle; those of pin but for the first.
const ARGUMENTS: [&str; 7] = ["keys", "box", "sphere", "plane", "vertices", "start", "end"];

#[pymethods]
impl Body {
    /// Holds a part of the body as it is at `start`. Returns a Hold.
    ///
    /// box : ((3,), (3,)), least and greatest corner; sphere : (center, radius); plane : (point, normal), the side that
    /// the normal points to; or vertices : (k,) int or (n,) bool, lattice vertices
    ///     What is held. Shapes are in world space at frame 0: the mesh vertices inside, and with them the lattice
    ///     vertices of their cells; for a bare lattice the vertices inside.
    /// start, end : float, seconds
    ///     Default: from the start, for ever.
    ///
    /// ValueError if nothing is inside, with the nearest distance.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, box=None, sphere=None, plane=None, vertices=None, start=0.0, end=None)"
    )]
    fn pin(slf: &Bound<'_, Self>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Hold> {
        let settings = Settings::of_call(options, "pin()", &ARGUMENTS[1..], &constraint::OPTIONAL)?;
        let selection = constraint::selection(&settings, "pin()", slf.get().count(slf.py())?)?;
        let pin = Pin { selection, window: constraint::window(&settings)? };
        Hold::add(slf, |body| body.pin(&pin))
    }

    /// Moves a part of the body along keys, relative to the pose that it has at `start`. Returns a Hold.
    ///
    /// keys : list of (time, translate, rotate)
    ///     Seconds, strictly increasing; (3,) length; (3,) degrees about the fixed axes x, then y, then z through the
    ///     center of what is held. Linear in time, angles too. A dict with these names is taken as well.
    ///
    /// The other arguments are those of pin.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, keys, box=None, sphere=None, plane=None, vertices=None, start=0.0, end=None)"
    )]
    fn handle(slf: &Bound<'_, Self>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Hold> {
        let settings = Settings::of_call(options, "handle()", &ARGUMENTS, &constraint::OPTIONAL)?;
        let selection = constraint::selection(&settings, "handle()", slf.get().count(slf.py())?)?;
        let keys = settings.get("keys")?.ok_or_else(|| PyTypeError::new_err("handle() needs keys="))?;
        let window = constraint::window(&settings)?;
        let handle = Handle { selection, keys: constraint::keys(&keys)?, window };
        Hold::add(slf, |body| body.handle(&handle))
    }

    /// Pulls at a part of the body in the next step. Forces add up.
    ///
    /// force : (3,) float, kg length/s^2
    ///     The whole force, shared by the lattice vertices of the part by mass.
    /// box, sphere, plane, vertices
    ///     The part, as for pin.
    #[pyo3(
        signature = (force, **options),
        text_signature = "($self, force, *, box=None, sphere=None, plane=None, vertices=None)"
    )]
    fn apply_force(
        &self,
        py: Python<'_>,
        force: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let settings = Settings::of_call(options, "apply_force()", &constraint::SHAPES, &constraint::SHAPES)?;
        let selection = constraint::selection(&settings, "apply_force()", self.count(py)?)?;
        let force = arrays::vector(force, "force")?;
        self.with(py, |body| body.apply_force(force, &selection))?.map_err(error::of)
    }
}

/// A pin or a handle of a body, as pin and handle return it.
#[pyclass(frozen, module = "supple")]
pub(crate) struct Hold {
    body: Py<Body>,
    index: usize,
}

impl Hold {
    fn add(
        body: &Bound<'_, Body>,
        add: impl FnOnce(&mut supple::Body) -> Result<(), supple::Error> + Send,
    ) -> PyResult<Self> {
        let index = body.get().with(body.py(), |body| add(body).map(|()| body.constraint_count() - 1))?;
        Ok(Self { body: body.clone().unbind(), index: index.map_err(error::of)? })
    }
}

#[pymethods]
impl Hold {
    /// The body that is held.
    #[getter]
    fn body(&self, py: Python<'_>) -> Py<Body> {
        self.body.clone_ref(py)
    }

    /// Lets go for good, from the next step on.
    fn release(&self, py: Python<'_>) -> PyResult<()> {
        self.body.get().with(py, |body| body.release(self.index))?.map_err(error::value)
    }

    /// Gives other keys, from the next step on, relative to the pose that was captured when the hold began.
    ///
    /// keys : list of (time, translate, rotate), as for Body.handle
    fn set_keys(&self, py: Python<'_>, keys: &Bound<'_, PyAny>) -> PyResult<()> {
        let keys = constraint::keys(keys)?;
        self.body.get().with(py, |body| body.set_keys(self.index, &keys))?.map_err(error::value)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let name = self.body.get().read(py, |body| body.name().to_owned())?;
        Ok(format!("<supple.Hold {} of body {name:?}>", self.index))
    }
}
