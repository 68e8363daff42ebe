//! Defines the plasticity of `supple.Body`.

use numpy::{PyArray1, PyArray3};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use supple::Plasticity;

use super::Body;
use crate::argument::{Settings, wrong_type};
use crate::arrays;
use crate::error;

/// Keys of the plasticity, as in a scene.
const KEYS: [&str; 3] = ["yield", "creep", "max"];

/// Reads the plasticity: a dict, True for the defaults, or False or None for an elastic body.
pub(super) fn read_plastic(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<Plasticity>> {
    let default = Plasticity::default();
    if value.is_none() {
        return Ok(None);
    }
    if let Ok(plastic) = value.cast::<PyBool>() {
        return Ok(plastic.is_true().then_some(default));
    }
    let dict = value.cast::<PyDict>().map_err(|_| {
        wrong_type(value, name, "a dict like {\"yield\": 0.05}, True for its default values, or None")
    })?;
    let settings = Settings::from_dict(dict, name, &KEYS)?;
    Ok(Some(Plasticity {
        yield_strain: settings.number("yield")?.unwrap_or(default.yield_strain),
        creep: settings.number("creep")?.unwrap_or(default.creep),
        max: settings.number("max")?.unwrap_or(default.max),
    }))
}

/// Converts the plasticity to the equivalent dict.
pub(crate) fn plastic_settings<'py>(
    py: Python<'py>,
    plastic: Option<Plasticity>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(Plasticity { yield_strain, creep, max }) = plastic else { return Ok(None) };
    let settings = PyDict::new(py);
    for (key, value) in KEYS.into_iter().zip([yield_strain, creep, max]) {
        settings.set_item(key, value)?;
    }
    Ok(Some(settings))
}

#[pymethods]
impl Body {
    /// Plasticity: a dict with yield, creep and max; None if the body is elastic.
    ///
    /// Settable to such a dict, to True for its default values, or to None, from the next step on. None removes the
    /// plastic shapes, and the body returns to its rest shape; other values keep them.
    #[getter]
    fn plastic<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        plastic_settings(py, self.read(py, |body| body.material().plastic)?)
    }

    #[setter]
    fn set_plastic(&self, py: Python<'_>, plastic: &Bound<'_, PyAny>) -> PyResult<()> {
        let plastic = read_plastic(plastic, "plastic")?;
        self.with(py, |body| body.set_plastic(plastic))?.map_err(error::value)
    }

    /// Plastic strain of the region around each vertex: (n,) float64, read-only. It is |S - 1|, the Frobenius norm,
    /// with the plastic shape S: 0 where the body has its rest shape, and everywhere without plasticity. If half_width is
    /// 0.5, it is the mean of the cells around the vertex.
    #[getter]
    fn plastic_strain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(arrays::frozen(PyArray1::from_vec(py, self.read(py, supple::Body::plastic_strain)?)))
    }

    /// Plastic shape S of the region around each vertex: (n, 3, 3) float64, read-only; if half_width is 0.5, of each cell:
    /// (m, 3, 3). It is a symmetric matrix of determinant 1, in the rest pose: the identity where the body has its rest shape, and everywhere without
    /// plasticity.
    #[getter]
    fn plastic_shapes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        Ok(arrays::frozen(arrays::from_matrices(py, &self.read(py, supple::Body::plastic_shapes)?)))
    }

    /// Reset the plastic shapes: from the next step on, the body returns to its rest shape. Without plasticity,
    /// nothing changes.
    fn reset_plastic(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, supple::Body::reset_plastic)
    }
}
