//! Pins and handles.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{Handle, Pin};

use super::Body;
use crate::settings::Settings;
use crate::{error, keys, selection};

#[pymethods]
impl Body {
    /// Holds a part of the body as it is at `from_`.
    ///
    /// box : ((3,), (3,)), least and greatest corner; sphere : (center, radius); plane : (point, normal), the side that
    /// the normal points to; or vertices : (k,) int or (n,) bool, lattice vertices
    ///     What is held. Shapes are in world space at frame 0: the mesh vertices inside, and with them the lattice
    ///     vertices of their cells; for a bare lattice the vertices inside.
    /// from_, until : float, seconds
    ///     Default: from the start, for ever.
    ///
    /// ValueError if nothing is inside, with the nearest distance.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, box=None, sphere=None, plane=None, vertices=None, from_=0.0, until=None)"
    )]
    fn pin(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let settings =
            Settings::new(options, "pin()", &["box", "sphere", "plane", "vertices", "from_", "until"])?;
        let selection = selection::read(&settings, "pin()", self.count(py))?;
        let pin = Pin { selection, window: selection::read_window(&settings)? };
        self.with(py, |body| body.pin(&pin)).map_err(error::of)
    }

    /// Moves a part of the body along keys, relative to the pose that it has at `from_`.
    ///
    /// keys : list of (time, translate, rotate)
    ///     Seconds, strictly increasing; (3,) length; (3,) degrees about the fixed axes x, then y, then z through the
    ///     centre of what is held. Linear in time, angles too. A dict with these names is taken as well.
    ///
    /// The other arguments are those of pin.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, keys, box=None, sphere=None, plane=None, vertices=None, from_=0.0, until=None)"
    )]
    fn handle(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let known = ["keys", "box", "sphere", "plane", "vertices", "from_", "until"];
        let settings = Settings::new(options, "handle()", &known)?;
        let selection = selection::read(&settings, "handle()", self.count(py))?;
        let keys = settings.get("keys")?.map_or(Ok(Vec::new()), |keys| keys::read(&keys))?;
        let handle = Handle { selection, keys, window: selection::read_window(&settings)? };
        self.with(py, |body| body.handle(&handle)).map_err(error::of)
    }
}
