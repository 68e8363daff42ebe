//! Properties of a body: the running state (copies out, whole arrays in), what is shown of it, and what of its material may
//! change between steps.

use nalgebra::{Point3, Vector3};
use numpy::{Element, PyArray1, PyArray2, PyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{Coordinate, RegionDamping, RegionSize, Stiffness};

use super::Body;
use super::build::{read_volume, volume_settings};
use crate::argument::{count, number};
use crate::arrays::{self, Side};
use crate::{error, report};

#[pymethods]
impl Body {
    /// (n, 3) float64: a copy of the positions of the lattice vertices.
    ///
    /// Set all of them with `body.positions = array`; velocities, pins and the rest stay as they are.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(arrays::of_points(py, self.read(py, supple::Body::positions)?))
    }

    #[setter]
    fn set_positions(&self, py: Python<'_>, positions: &Bound<'_, PyAny>) -> PyResult<()> {
        let positions = arrays::vectors(positions, "positions", Side::Is(self.count(py)?))?;
        let positions = || positions.into_iter().map(Point3::from).collect::<Vec<_>>();
        self.with(py, |body| body.set_positions(&positions()))?.map_err(error::value)
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
        let velocities = || velocities.into_iter().map(Vector3::from).collect::<Vec<_>>();
        self.with(py, |body| body.set_velocities(&velocities()))?.map_err(error::value)
    }

    /// (n, 3, 3) float64: the rotation of the region around each vertex from the rest pose, as of the last step.
    #[getter]
    fn rotations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        Ok(arrays::of_matrices(py, &self.read(py, supple::Body::rotations)?))
    }

    /// (n,) float64: density x cell_size^3 x occupied cells / 8.
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.read(py, supple::Body::masses)?))
    }

    /// (n, 3) float64: the goal positions of the current positions. No time passes.
    fn goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(arrays::of_points(py, self.read(py, supple::Body::goals)?))
    }

    /// (n, 3) float64: the lattice after the volume correction, in the precision that is shown (float32,
    /// from the body's own origin); without a correction the positions.
    fn corrected_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = self.displayed(py, |displayed| displayed.positions().collect::<Vec<_>>())?;
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
        self.show_rows(py, out, Rows::Positions)
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
        self.show_rows(py, out, Rows::Normals)
    }

    /// The volume as it is shown, in cubed scene units: by the measure that is kept, or with the correction off by the best
    /// measure of the body. Never negative.
    #[getter]
    fn volume(&self, py: Python<'_>) -> PyResult<f64> {
        self.displayed(py, |displayed| displayed.volume_report().after)
    }

    /// The volume by each measure at rest, now, and after the correction: a VolumeReport.
    fn volume_report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report::of_volume(py, &self.displayed(py, |displayed| displayed.volume_report())?)
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

    /// Half-width of the regions in cells: as given, at most the extent of the lattice. Can be set, which replaces a
    /// stiffness_radius and takes as long as building the regions does.
    #[getter]
    fn half_width(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, supple::Body::half_width)
    }

    #[setter]
    fn set_half_width(&self, py: Python<'_>, half_width: &Bound<'_, PyAny>) -> PyResult<()> {
        let cells = count(half_width, "half_width", 1)?;
        self.with(py, |body| body.set_region_size(RegionSize::Cells(cells)))?.map_err(error::value)
    }

    /// How the volume is kept in what is shown: a dict with measure, scope, field, max_correction. Can be set to such a
    /// dict, or to the name of a measure, or to "off"; takes as long as building the correction does.
    #[getter]
    fn volume_options<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let options = self.read(py, supple::Body::volume_options)?;
        volume_settings(py, &options)
    }

    #[setter]
    fn set_volume_options(&self, py: Python<'_>, volume: &Bound<'_, PyAny>) -> PyResult<()> {
        let options = read_volume(volume)?;
        self.with(py, |body| body.set_volume(options))?.map_err(error::value)
    }

    /// Mass per volume.
    #[getter]
    fn density(&self, py: Python<'_>) -> PyResult<f64> {
        self.read(py, |body| body.material().density)
    }
}

/// Properties of a material that two keys can give: each reads None where the other one is set, and replaces it.
macro_rules! alternatives {
    ($($(#[$doc:meta])* $key:ident, $set:ident: $material:ident is $kind:ident::$variant:ident by $change:ident;)*) => {
        #[pymethods]
        impl Body {$(
            $(#[$doc])*
            #[getter]
            fn $key(&self, py: Python<'_>) -> PyResult<Option<f64>> {
                self.read(py, |body| match body.material().$material {
                    $kind::$variant(value) => Some(value),
                    _ => None,
                })
            }

            #[setter]
            fn $set(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
                let value = number(value, stringify!($key))?;
                self.with(py, |body| body.$change($kind::$variant(value)))?.map_err(error::value)
            }
        )*}
    };
}

alternatives! {
    /// Half-width of the regions as a length, > 0; None where it is set in cells. Can be set, which replaces that.
    stiffness_radius, set_stiffness_radius: region_size is RegionSize::Radius by set_region_size;
    /// alpha per step, in (0, 1]; None where a frequency is set. Can be set, which replaces a frequency.
    stiffness, set_stiffness: stiffness is Stiffness::PerStep by set_stiffness;
    /// Frequency of a vertex about its goal in Hz, > 0; None where alpha is set. Can be set, which replaces alpha.
    frequency, set_frequency: stiffness is Stiffness::Frequency by set_stiffness;
    /// Region damping per step, in [0, 1]; None where a rate is set. Can be set, which replaces a rate.
    region_damping, set_region_damping: region_damping is RegionDamping::PerStep by set_region_damping;
    /// Region damping as a rate in 1/s, >= 0; None where it is set per step. Can be set, which replaces that.
    region_damping_rate, set_region_damping_rate: region_damping is RegionDamping::Rate by set_region_damping;
}

/// Rows of the mesh as it is shown, one per vertex.
#[derive(Clone, Copy)]
enum Rows {
    Positions,
    Normals,
}

impl Body {
    /// Number of lattice vertices.
    pub(super) fn count(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, |body| body.lattice().len())
    }

    /// The rows in the caller's array, or in a new one.
    fn show_rows<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
        rows: Rows,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Some(count) = self.read(py, |body| body.mesh().map(|mesh| mesh.vertices().len()))? else {
            return Err(PyValueError::new_err(
                "the body is a bare lattice and has no mesh to show; look at corrected_positions()",
            ));
        };
        let out = match out {
            Some(out) => out.clone(),
            None => PyArray2::<f64>::zeros(py, [count, 3], false).into_any(),
        };
        let array = arrays::check_out(&out, count)?;
        if let Ok(single) = out.cast::<PyArray2<f32>>() {
            self.write_rows(single, rows)?;
        } else if let Ok(double) = out.cast::<PyArray2<f64>>() {
            self.write_rows(double, rows)?;
        } else {
            let dtype = array.dtype();
            return Err(PyTypeError::new_err(format!(
                "out has dtype {dtype}; it must be float32 or float64"
            )));
        }
        Ok(out)
    }

    fn write_rows<T: Element + Coordinate>(&self, out: &Bound<'_, PyArray2<T>>, rows: Rows) -> PyResult<()> {
        arrays::fill(out, T::zero(), |to| {
            self.displayed(out.py(), |displayed| match rows {
                Rows::Positions => displayed.surface_into(to, None),
                Rows::Normals => displayed.normals_into(to),
            })
        })
    }
}
