//! Defines the plasticity of `supple.Body`.

use numpy::{PyArray1, PyArray3};
use pyo3::prelude::*;
use supple_io::scene::BodyData;

use super::Body;
use super::build::scene_key;
use crate::{arrays, error, keys};

#[pymethods]
impl Body {
    /// Plasticity: a dict with yield, creep and max; None if the body is elastic.
    ///
    /// Settable to such a dict, to True for its default values, or to None, from the next step on. None removes the
    /// plastic shapes, and the body returns to its rest shape; other values keep them.
    #[getter]
    fn plastic<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let material = self.read(py, |body| *body.material())?;
        keys::of_body(py, &BodyData { material, ..BodyData::default() }, "plastic")
    }

    #[setter]
    fn set_plastic(&self, py: Python<'_>, plastic: &Bound<'_, PyAny>) -> PyResult<()> {
        let plastic = scene_key("plastic", plastic)?.material.plastic;
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
