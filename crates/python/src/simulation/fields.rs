//! The acceleration fields of a simulation, as dicts with the keys of a scene.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use serde::Deserialize;
use supple::Field;
use supple_io::scene::{FieldTable, nearest};

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
        let fields = read(fields)?;
        self.shared.with(py, |simulation| simulation.set_fields(fields))?.map_err(error::from_core)
    }
}

/// The argument `fields`.
#[derive(Deserialize)]
struct FieldList {
    fields: Vec<FieldTable>,
}

/// Reads the argument `fields`: a list of dicts, or one.
pub(super) fn read(fields: &Bound<'_, PyAny>) -> PyResult<Vec<Field>> {
    let FieldList { fields } = tables::read(fields, "fields", &["strength"])?;
    Ok(fields.into_iter().map(|FieldTable(field)| field).collect())
}

/// Checks that the bodies on which fields act are bodies with these names.
pub(super) fn check_bodies(fields: &[Field], names: &[&str]) -> PyResult<()> {
    for (index, field) in fields.iter().enumerate() {
        field.validate().map_err(error::from_core)?;
        if let Some(name) = field.bodies.iter().find(|name| !names.contains(&name.as_str())) {
            let way_out = nearest(name, names).map(|name| format!("; the nearest name is {name:?}"));
            return Err(PyValueError::new_err(format!(
                "fields[{index}].bodies names {name:?}, and no body of the simulation has this name{}",
                way_out.unwrap_or_default()
            )));
        }
    }
    Ok(())
}
