//! Adds pins and handles to a body, and lists them.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use supple::{Handle, Pin};

use super::{Body, Hold};
use crate::argument::Settings;
use crate::constraint;

/// Keyword arguments of `handle`. All except the first two are also the keyword arguments of `pin`.
const ARGUMENTS: [&str; 8] = ["keys", "interpolation", "box", "sphere", "plane", "vertices", "start", "end"];

#[pymethods]
impl Body {
    /// Pin a part of the body: fix the part in the pose that it has at `start`. Returns a Hold.
    ///
    /// Exactly one of box, sphere, plane and vertices selects the part. Shapes are in world space and are
    /// tested against the body at frame 0. A shape selects the corners of every cell that contains a mesh
    /// vertex inside the shape. On a bare lattice a shape selects the lattice vertices inside the shape.
    ///
    /// box : ((3,), (3,))
    ///     Minimum and maximum corner.
    /// sphere : ((3,), float)
    ///     Center and radius.
    /// plane : ((3,), (3,))
    ///     Point and normal: selects the side that the normal points to.
    /// vertices : (k,) int or (n,) bool
    ///     Lattice vertices: indices, or a mask.
    /// start, end : float, default 0 and None
    ///     Time window of the pin in seconds. Without end the pin stays active.
    ///
    /// Parts may overlap: of the pins and handles that are active, the one that was added last moves the
    /// common vertices, and when it ends, the one before it moves them again.
    ///
    /// Raises ValueError for an empty selection; the message gives the distance to the nearest vertex.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, box=None, sphere=None, plane=None, vertices=None, start=0.0, end=None)"
    )]
    fn pin(slf: &Bound<'_, Self>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Hold> {
        let settings = Settings::from_call(options, "pin()", &ARGUMENTS[2..], &constraint::OPTIONAL)?;
        let selection = constraint::selection(&settings, "pin()", slf.get().count(slf.py())?)?;
        let pin = Pin { selection, window: constraint::window(&settings)? };
        Hold::add(slf, |body| body.pin(&pin))
    }

    /// Move a part of the body along keyframes. Returns a Hold.
    ///
    /// keys : list of (time, translate, rotate), or of dicts with these names
    ///     Keyframes, relative to the pose that the part has at `start`. time: seconds, strictly increasing.
    ///     translate: (3,) length, default 0. rotate: (3,) degrees about the fixed axes x, then y, then z
    ///     through the mean position of the selected lattice vertices at `start`, default 0; or a quaternion x, y, z,
    ///     w, a rotation matrix or a scipy Rotation, which become the angles nearest to those of the keyframe before.
    /// interpolation : "linear", "smooth" or "cubic", default "linear"
    ///     How translations and angles go from one keyframe to the next: "linear", with constant velocity; "smooth",
    ///     from rest to rest; "cubic", through the keyframes with a continuous velocity and without overshoot.
    ///
    /// The other arguments and the errors are the same as for pin.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, keys, interpolation='linear', box=None, sphere=None, plane=None, vertices=None, start=0.0, end=None)"
    )]
    fn handle(slf: &Bound<'_, Self>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Hold> {
        let settings = Settings::from_call(options, "handle()", &ARGUMENTS, &constraint::OPTIONAL)?;
        let selection = constraint::selection(&settings, "handle()", slf.get().count(slf.py())?)?;
        let keys = settings.get("keys")?.ok_or_else(|| PyTypeError::new_err("handle() needs keys="))?;
        let window = constraint::window(&settings)?;
        let keys = constraint::keys(&keys)?;
        let interpolation = constraint::interpolation(&settings)?.unwrap_or_default();
        let handle = Handle { selection, keys, interpolation, window };
        Hold::add(slf, |body| body.handle(&handle))
    }

    /// Pins and handles that were not released, in the order in which they were added: tuple of Hold.
    ///
    /// Pins and handles of a scene come first: the pins of the body, then its handles.
    #[getter]
    fn holds<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let indices: Vec<usize> =
            slf.get().read(slf.py(), |body| body.constraints().map(supple::Constraint::index).collect())?;
        PyTuple::new(slf.py(), indices.into_iter().map(|index| Hold::new(slf, index)))
    }
}
