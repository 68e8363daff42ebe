//! Arrays of the running state: copies out, whole arrays in.

use nalgebra::{Point3, Vector3};
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;

use super::Body;
use crate::arrays::{self, Side};
use crate::error;

#[pymethods]
impl Body {
    /// (n, 3) float64: a copy of the positions of the lattice vertices.
    ///
    /// Set all of them with `body.positions = array`; velocities, pins and the rest stay as they are.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = self.read(py, supple::Body::positions)?;
        Ok(arrays::of_points(py, positions))
    }

    #[setter]
    fn set_positions(&self, py: Python<'_>, positions: &Bound<'_, PyAny>) -> PyResult<()> {
        let positions = arrays::vectors(positions, "positions", Side::Is(self.count(py)?))?;
        let set = self.with(py, |body| {
            let positions: Vec<Point3<f64>> = positions.into_iter().map(Point3::from).collect();
            body.set_positions(&positions)
        });
        set?.map_err(error::value)
    }

    /// (n, 3) float64: a copy of the velocities of the lattice vertices, length/s.
    ///
    /// Set all of them with `body.velocities = array`; positions, pins and the rest stay as they are.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let velocities = self.read(py, |body| body.velocities().into_iter().map(Into::into).collect())?;
        Ok(arrays::of_vectors(py, velocities))
    }

    #[setter]
    fn set_velocities(&self, py: Python<'_>, velocities: &Bound<'_, PyAny>) -> PyResult<()> {
        let velocities = arrays::vectors(velocities, "velocities", Side::Is(self.count(py)?))?;
        let set = self.with(py, |body| {
            let velocities: Vec<Vector3<f64>> = velocities.into_iter().map(Vector3::from).collect();
            body.set_velocities(&velocities)
        });
        set?.map_err(error::value)
    }

    /// (n, 3, 3) float64: the rotation of the region around each vertex from the rest pose, as of the last step.
    #[getter]
    fn rotations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let rotations = self.read(py, supple::Body::rotations)?;
        Ok(arrays::of_matrices(py, &rotations))
    }

    /// (n,) float64: density x cell_size^3 x occupied cells / 8.
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let masses = self.read(py, supple::Body::masses)?;
        Ok(arrays::of_numbers(py, masses))
    }
}

impl Body {
    /// Number of lattice vertices.
    pub(super) fn count(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, |body| body.lattice().len())
    }
}
