//! Defines properties of `supple.Body`: the state (getters copy, setters replace whole arrays), the displayed
//! surface, and the options of the volume correction.

use nalgebra::{Point3, Vector3};
use numpy::{Element, PyArray1, PyArray2, PyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use supple::Coordinate;
use supple_io::scene::BodyData;

use super::build::scene_key;
use super::{Body, SharedBody};
use crate::arrays::{self, Axis};
use crate::mesh::Mesh;
use crate::{error, keys, report};

#[pymethods]
impl Body {
    /// Positions of the lattice vertices: (n, 3) float64, a read-only copy.
    ///
    /// Assign a whole array to set them, or change entries with edit(). Velocities, pins and all other state
    /// are unchanged.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(arrays::frozen(arrays::from_points(py, self.read(py, supple::Body::positions)?)))
    }

    #[setter]
    fn set_positions(&self, py: Python<'_>, positions: &Bound<'_, PyAny>) -> PyResult<()> {
        let positions = self.read_positions(positions)?;
        self.with(py, |body| body.set_positions(&positions))?.map_err(error::value)
    }

    /// Velocities of the lattice vertices in length/s: (n, 3) float64, a read-only copy.
    ///
    /// Assign a whole array to set them, or change entries with edit(). Positions, pins and all other state
    /// are unchanged.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let velocities = self.read(py, |body| body.velocities().into_iter().map(Into::into).collect())?;
        Ok(arrays::frozen(arrays::from_vectors(py, velocities)))
    }

    #[setter]
    fn set_velocities(&self, py: Python<'_>, velocities: &Bound<'_, PyAny>) -> PyResult<()> {
        let velocities = self.read_velocities(velocities)?;
        self.with(py, |body| body.set_velocities(&velocities))?.map_err(error::value)
    }

    /// Return a context manager for a change of single positions and velocities.
    ///
    /// It yields an object with the writable arrays positions and velocities: (n, 3) float64. At the end of
    /// the `with` block the arrays that differ from the state are written to the body, or nothing if the block
    /// raises an exception or an array has an invalid value.
    ///
    ///     with body.edit() as state:
    ///         state.positions[top, 1] += 0.1
    fn edit<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("supple.edits")?.getattr("Edit")?.call1((slf,))
    }

    /// Set the positions, the velocities or both; None leaves them unchanged. If an array has an invalid
    /// value, nothing is set. Edit calls this function.
    fn _set_state(
        &self,
        py: Python<'_>,
        positions: Option<&Bound<'_, PyAny>>,
        velocities: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let positions = positions.map(|positions| self.read_positions(positions)).transpose()?;
        let velocities = velocities.map(|velocities| self.read_velocities(velocities)).transpose()?;
        let set = |body: &mut supple::Body| {
            let before = body.snapshot();
            positions.map_or(Ok(()), |positions| body.set_positions(&positions))?;
            velocities.map_or(Ok(()), |velocities| body.set_velocities(&velocities)).inspect_err(|_| {
                body.restore(&before).expect("the snapshot is of this body");
            })
        };
        self.with(py, set)?.map_err(error::value)
    }

    /// Rotation of the region around each vertex, from the rest pose, as of the last step: (n, 3, 3) float64,
    /// read-only. If half_width is 0.5, it is the mean of the cells around the vertex.
    #[getter]
    fn rotations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        Ok(arrays::frozen(arrays::from_matrices(py, &self.read(py, supple::Body::rotations)?)))
    }

    /// Masses of the lattice vertices: (n,) float64, read-only.
    ///
    /// A mass is density x cell_size^3 / 8 x the sum of the filled shares of the cells that share the vertex. The
    /// filled share of a cell is the part of it inside the mesh, at least 0.05; 1 with an open mesh and for a bare
    /// lattice.
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(arrays::frozen(PyArray1::from_vec(py, self.read(py, supple::Body::masses)?)))
    }

    /// Copy the positions of the lattice vertices: (n, 3), as the attribute positions, and into a given array.
    ///
    /// out : (n, 3) float32 or float64, optional
    ///     Array to write to and return. Default: a new float64 array.
    #[pyo3(signature = (out=None))]
    fn lattice_positions<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, out, Rows::LatticePositions)
    }

    /// Copy the velocities of the lattice vertices in length/s: (n, 3), as the attribute velocities, and into a given
    /// array.
    ///
    /// out : (n, 3) float32 or float64, optional
    ///     Array to write to and return. Default: a new float64 array.
    #[pyo3(signature = (out=None))]
    fn lattice_velocities<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, out, Rows::LatticeVelocities)
    }

    /// Compute the goal positions at the current positions, without advancing time: (n, 3) float64.
    fn goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(arrays::from_points(py, self.read(py, supple::Body::goals)?))
    }

    /// Compute the lattice positions after the volume correction: (n, 3) float64.
    ///
    /// Without a correction, returns the positions before the correction. All positions are rounded to
    /// float32 relative to the origin of the body, as for the displayed surface.
    fn corrected_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let positions = self.displayed(py, |displayed| displayed.positions().collect::<Vec<_>>())?;
        Ok(arrays::from_points(py, positions))
    }

    /// Evaluate the displayed surface, after the volume correction: (k, 3), mesh vertices in input order. When the
    /// body breaks, further vertices follow: see faces and topology_version.
    ///
    /// out : (k, 3) float32 or float64, optional
    ///     Array to write to and return. Default: a new float64 array.
    ///
    /// Raises ValueError for a bare lattice, which has no mesh.
    #[pyo3(signature = (out=None))]
    fn surface<'py>(&self, py: Python<'py>, out: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, out, Rows::Positions)
    }

    /// Evaluate the unit normals of the displayed surface: (k, 3).
    ///
    /// A normal is zero if all faces of its vertex are degenerate.
    ///
    /// out : (k, 3) float32 or float64, optional
    ///     Array to write to and return. Default: a new float64 array.
    ///
    /// Raises ValueError for a bare lattice, which has no mesh.
    #[pyo3(signature = (out=None))]
    fn surface_normals<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, out, Rows::Normals)
    }

    /// Evaluate the velocities of the vertices of the surface in scene units per second: (k, 3).
    ///
    /// They are the velocities of the lattice by the weights of the skin. The motion of the volume correction relative to
    /// the lattice is not in them.
    ///
    /// out : (k, 3) float32 or float64, optional
    ///     Array to write to and return. Default: a new float64 array.
    ///
    /// Raises ValueError for a bare lattice, which has no mesh.
    #[pyo3(signature = (out=None))]
    fn surface_velocities<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.rows(py, out, Rows::Velocities)
    }

    /// Volume after the correction, in cubed scene units, never negative.
    ///
    /// The volume is by the measure of the correction or, with volume "off", by the measure that "auto" would
    /// choose.
    #[getter]
    fn volume(&self, py: Python<'_>) -> PyResult<f64> {
        self.displayed(py, |displayed| displayed.volume_report().after)
    }

    /// Return a VolumeReport: the volume by each measure at rest, before and after the correction.
    fn volume_report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report::volume_report(py, &self.displayed(py, |displayed| displayed.volume_report())?)
    }

    /// Return the displayed surface as a trimesh.Trimesh.
    ///
    /// uv : bool, default False
    ///     Whether the mesh has the texture coordinates and materials of the model file from which the body was read. A
    ///     vertex with several texture coordinates is then several vertices, as in trimesh itself, and the vertex
    ///     attribute "input_vertex" of the result is the index of each vertex in input order. The file is read again.
    ///
    /// Without uv, vertices are in input order. Faces with more than three corners are fanned into triangles. A body of
    /// a trimesh.Trimesh or of a file that trimesh reads keeps texture coordinates, materials and colors, and ignores
    /// uv. Needs trimesh (`pip install trimesh`). Raises ValueError for a bare lattice, which has no mesh, and
    /// MeshError if uv needs a file that has changed.
    #[pyo3(signature = (*, uv=false))]
    fn to_trimesh<'py>(slf: &Bound<'py, Self>, uv: bool) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("supple.interchange")?.call_method1("to_trimesh", (slf, uv))
    }

    /// The texture coordinates and materials of the model file of the body, or None; see `Mesh::appearance`.
    fn _appearance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        let (shape, _) = self.build_arguments(py);
        shape.cast::<Mesh>().map_or(Ok(None), |mesh| mesh.get().appearance(py))
    }

    /// The `visual` of the trimesh.Trimesh from which the body was built, or None.
    #[getter]
    fn _visual(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        let (shape, _) = self.build_arguments(py);
        shape.cast::<Mesh>().ok()?.get().visual.as_ref().map(|visual| visual.clone_ref(py))
    }

    /// Return a picture and a table for notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("supple.notebook")?.call_method1("picture_html", (slf,))
    }

    /// Open a viewer window with the simulation of the body, or with only the body if it is not in a
    /// simulation: see supple.view.
    fn show<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("supple.viewer")?.call_method1("view", (slf,))
    }

    /// How the mesh follows the lattice: "linear" or "smooth".
    #[getter]
    fn skin(&self, py: Python<'_>) -> PyResult<&'static str> {
        Ok(self.read(py, supple::Body::skin)?.name())
    }

    /// Options of the volume correction: a dict with measure, scope, field and max_correction.
    ///
    /// Settable to such a dict, the name of a measure, or "off". Setting the options rebuilds the correction.
    #[getter]
    fn volume_options<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let volume = self.read(py, supple::Body::volume_options)?;
        keys::of_body(py, &BodyData { volume, ..BodyData::default() }, "volume")
    }

    #[setter]
    fn set_volume_options(&self, py: Python<'_>, volume: &Bound<'_, PyAny>) -> PyResult<()> {
        let options = scene_key("volume", volume)?.volume;
        self.with(py, |body| body.set_volume(options))?.map_err(error::value)
    }
}

/// The rows to evaluate: one per lattice vertex, or one per mesh vertex of the displayed surface.
#[derive(Clone, Copy)]
enum Rows {
    LatticePositions,
    LatticeVelocities,
    Positions,
    Normals,
    Velocities,
}

impl Rows {
    /// Returns the number of rows of a body, and whether the body broke; `None` for the surface of a bare lattice.
    fn size(self, body: &supple::Body) -> Option<(usize, bool)> {
        match self {
            Self::LatticePositions | Self::LatticeVelocities => {
                Some((body.lattice().len(), body.topology_version() > 0))
            }
            Self::Positions | Self::Normals | Self::Velocities => mesh_size(body),
        }
    }
}

impl Body {
    /// Reads an array of positions, one per lattice vertex.
    fn read_positions(&self, positions: &Bound<'_, PyAny>) -> PyResult<Vec<Point3<f64>>> {
        let rows = Axis::Is(self.count(positions.py())?);
        Ok(arrays::vectors(positions, "positions", rows)?.into_iter().map(Point3::from).collect())
    }

    /// Reads an array of velocities, one per lattice vertex.
    fn read_velocities(&self, velocities: &Bound<'_, PyAny>) -> PyResult<Vec<Vector3<f64>>> {
        let rows = Axis::Is(self.count(velocities.py())?);
        Ok(arrays::vectors(velocities, "velocities", rows)?.into_iter().map(Vector3::from).collect())
    }

    /// Returns the number of lattice vertices.
    pub(super) fn count(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, |body| body.lattice().len())
    }

    /// Returns the numbers of lattice vertices and of mesh vertices.
    pub(super) fn counts(&self, py: Python<'_>) -> PyResult<[usize; 2]> {
        let mesh = |body: &supple::Body| body.mesh().map_or(0, |mesh| mesh.vertices().len());
        self.read(py, |body| [body.lattice().len(), mesh(body)])
    }
}

impl SharedBody {
    /// Evaluates the displayed surface into the array `out`.
    pub(crate) fn write_surface(&self, out: &Bound<'_, PyAny>) -> PyResult<()> {
        self.rows(out.py(), Some(out), Rows::Positions).map(drop)
    }

    /// Evaluates rows into the array `out`, or into a new array.
    fn rows<'py>(
        &self,
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
        rows: Rows,
    ) -> PyResult<Bound<'py, PyAny>> {
        // Another thread can break the body between the two locks; the lengths are then compared again.
        loop {
            let Some(size) = self.read(py, |body| rows.size(body))? else {
                return Err(PyValueError::new_err(
                    "the body is a bare lattice without a mesh; use corrected_positions()",
                ));
            };
            let out = match out {
                Some(out) => out.clone(),
                None => PyArray2::<f64>::zeros(py, [size.0, 3], false).into_any(),
            };
            arrays::check_out(&out, "out", size)?;
            let is_written = match out.cast::<PyArray2<f32>>() {
                Ok(single) => self.write_rows(single, rows)?,
                Err(_) => self.write_rows(out.cast::<PyArray2<f64>>()?, rows)?,
            };
            if is_written {
                return Ok(out);
            }
        }
    }

    /// Evaluates rows into `out`. Returns false if it has another number of rows.
    fn write_rows<T: Element + Coordinate>(
        &self,
        out: &Bound<'_, PyArray2<T>>,
        rows: Rows,
    ) -> PyResult<bool> {
        let mut is_written = false;
        arrays::fill(out, T::zero(), |target| {
            is_written = self.in_context(out.py(), |body| {
                if rows.size(&body).is_none_or(|(count, _)| count != target.len()) {
                    return false;
                }
                match rows {
                    Rows::LatticePositions => body.positions_into(target),
                    Rows::LatticeVelocities => body.velocities_into(target),
                    Rows::Positions => self.display().evaluate(body).surface_into(target, None),
                    Rows::Normals => self.display().evaluate(body).normals_into(target),
                    Rows::Velocities => {
                        for (row, velocity) in target.iter_mut().zip(body.surface_velocities()) {
                            *row = velocity.map(nalgebra::convert).into();
                        }
                    }
                }
                true
            })?;
            Ok(())
        })?;
        Ok(is_written)
    }
}

/// Returns the number of vertices of the mesh of a body, and whether the body broke; `None` for a bare lattice.
pub(crate) fn mesh_size(body: &supple::Body) -> Option<(usize, bool)> {
    Some((body.mesh()?.vertices().len(), body.topology_version() > 0))
}
