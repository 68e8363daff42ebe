//! What is shown of a body: goals, the corrected lattice, the surface, reports. Nothing here changes what follows.

use numpy::{Element, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use supple::Coordinate;

use super::Body;
use crate::arrays::{self, Out, fill};
use crate::report;

#[pymethods]
impl Body {
    /// (n, 3) float64: the goal positions of the current positions. No time passes.
    fn goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let goals = self.read(py, supple::Body::goals)?;
        Ok(arrays::of_points(py, goals))
    }

    /// (n, 3) float64: the lattice after the volume correction, in the precision that is shown (float32,
    /// from the body's own origin); without a correction the positions.
    fn corrected_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = self.shown(py, |shown| shown.positions().collect::<Vec<_>>())?;
        Ok(arrays::of_points(py, positions))
    }

    /// The mesh as it is shown, its vertices in input order: moved by the lattice after the volume correction.
    ///
    /// out : (k, 3) float32 or float64, optional
    ///     Written to, and returned, in place of a new float64 array.
    ///
    /// ValueError for a bare lattice, which has no mesh.
    #[pyo3(signature = (out=None))]
    fn surface<'py>(&self, py: Python<'py>, out: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        match self.out(py, out)? {
            Out::Single(array) => self.write_surface(array),
            Out::Double(array) => self.write_surface(array),
        }
    }

    /// Unit normals of the mesh as it is shown, one per vertex; zero where no face has area.
    ///
    /// out : (k, 3) float32 or float64, optional
    ///     Written to, and returned, in place of a new float64 array.
    ///
    /// ValueError for a bare lattice, which has no mesh.
    #[pyo3(signature = (out=None))]
    fn surface_normals<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        match self.out(py, out)? {
            Out::Single(array) => self.write_normals(array),
            Out::Double(array) => self.write_normals(array),
        }
    }

    /// The volume as it is shown, in cubed scene units: by the measure that is kept, or with the correction off by the best
    /// measure of the body. Never negative.
    #[getter]
    fn volume(&self, py: Python<'_>) -> PyResult<f64> {
        self.shown(py, |shown| shown.volume_report().after)
    }

    /// The volume by each measure at rest, now, and after the correction: a VolumeReport.
    fn volume_report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let volume = self.shown(py, |shown| shown.volume_report())?;
        report::of_volume(py, &volume)
    }

    /// The mesh as it is shown, as a trimesh.Trimesh: vertices in input order, larger faces fanned into triangles.
    ///
    /// Needs trimesh (`pip install "supple[trimesh]"`). ValueError for a bare lattice, which has no mesh.
    fn to_trimesh<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("supple.interchange")?.call_method1("to_trimesh", (slf,))
    }

    /// Opens a window on the body, with its simulation if it lives in one: see supple.view.
    fn show<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("supple.viewer")?.call_method1("view", (slf,))
    }
}

impl Body {
    /// The array that a surface goes to: the caller's, or a new one.
    fn out<'py>(&self, py: Python<'py>, out: Option<&Bound<'py, PyAny>>) -> PyResult<Out<'py>> {
        let Some(rows) = self.read(py, |body| body.mesh().map(|mesh| mesh.vertices().len()))? else {
            return Err(PyValueError::new_err(
                "the body is a bare lattice and has no mesh to show; look at corrected_positions()",
            ));
        };
        match out {
            Some(array) => Out::new(array, rows),
            None => Ok(Out::Double(PyArray2::zeros(py, [rows, 3], false))),
        }
    }

    fn write_surface<'py, T: Element + Coordinate>(
        &self,
        array: Bound<'py, PyArray2<T>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = array.py();
        fill(&array, T::zero(), |rows| self.shown(py, |shown| shown.surface_into(rows, None)))?;
        Ok(array.into_any())
    }

    fn write_normals<'py, T: Element + Coordinate>(
        &self,
        array: Bound<'py, PyArray2<T>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = array.py();
        fill(&array, T::zero(), |rows| self.shown(py, |shown| shown.normals_into(rows)))?;
        Ok(array.into_any())
    }
}
