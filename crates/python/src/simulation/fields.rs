//! The acceleration fields of a simulation, as dicts with the keys of a scene.

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use supple_io::scene::FieldTable;

use super::{Simulation, tables};
use crate::{error, keys};

#[pymethods]
impl Simulation {
    /// Fields of acceleration: tuple of dict, with the keys of [[field]] in a scene: one of gravity, wind, drag, vortex and
    /// attract; strength, bodies; and box, sphere or plane.
    ///
    /// Settable, to a list of dicts; effective from the next step on. Keyframes of a strength are also taken as tuples
    /// (time, value).
    #[getter]
    pub(super) fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let fields = self.shared.with(py, |simulation| simulation.fields().to_vec())?;
        let dict = |field| keys::to_python(py, &serde_json::Value::Object(FieldTable(field).to_keys()));
        PyTuple::new(py, fields.into_iter().map(dict).collect::<PyResult<Vec<_>>>()?)
    }

    #[setter]
    fn set_fields(&self, py: Python<'_>, fields: &Bound<'_, PyAny>) -> PyResult<()> {
        let fields = tables::read_fields(fields)?;
        self.shared.with(py, |simulation| simulation.set_fields(fields))?.map_err(error::from_core)
    }
}
