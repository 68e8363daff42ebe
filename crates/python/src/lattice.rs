//! Defines `supple.Lattice`: the cubic cells that cover a shape, and the corners of the cells.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};
use supple::{LatticeOptions, Resolution};
use supple_io::counted;

use crate::argument::{self, Given, Settings};
use crate::arrays::{self, Axis};
use crate::error::{self, Exception};
use crate::interrupt::interruptible;
use crate::mesh::mesh_like;
use crate::pickle::{decode, encode};

/// A lattice of cubic cells. The corners of the cells are the simulated vertices.
///
/// Create a lattice with Lattice.from_mesh or Lattice.from_cells. Vertices and cells are sorted by z, then y,
/// then x; arrays with one row per vertex or cell have this order. len(lattice) is the number of vertices.
#[pyclass(frozen, module = "supple")]
pub(crate) struct Lattice {
    pub(crate) lattice: supple::Lattice,
    indices: PyOnceLock<Py<PyArray2<i64>>>,
    rest_positions: PyOnceLock<Py<PyArray2<f64>>>,
    cells: PyOnceLock<Py<PyArray2<i64>>>,
}

impl Lattice {
    pub(crate) fn from_core(lattice: supple::Lattice) -> Self {
        let (indices, rest_positions, cells) = (PyOnceLock::new(), PyOnceLock::new(), PyOnceLock::new());
        Self { lattice, indices, rest_positions, cells }
    }
}

#[pymethods]
impl Lattice {
    /// Create the lattice of a mesh: the cells that the surface passes through or encloses.
    ///
    /// mesh : Mesh, path, an object with vertices and faces, or a mesh of trimesh, meshio, Open3D or PyVista
    /// vertices : int, default 1000
    ///     Target number of lattice vertices, at least 8. The actual number is within 5 % of the target where
    ///     the shape allows.
    /// cell_size : float
    ///     Edge of a cell, > 0. Mutually exclusive with vertices.
    /// join : bool, default True
    ///     Whether bridges of cells join separate parts. If False, each part is a separate component.
    /// memory_limit : int, default half of the machine's memory
    ///     Limit in bytes of the memory of the lattice and a simulation of it.
    ///
    /// Raises LatticeError for a lattice that cannot be built or exceeds the memory limit, MeshError for an
    /// invalid mesh and ValueError for a value out of range.
    #[classmethod]
    #[pyo3(
        signature = (mesh, **settings),
        text_signature = "(mesh, *, vertices=None, cell_size=None, join=True, memory_limit=None)"
    )]
    fn from_mesh(
        _class: &Bound<'_, PyType>,
        mesh: &Bound<'_, PyAny>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let py = mesh.py();
        let known = ["vertices", "cell_size", "join", "memory_limit"];
        let optional = &["vertices", "cell_size", "memory_limit"];
        let settings = Settings::from_call(settings, "from_mesh()", &known, optional)?;
        let mesh = mesh_like(mesh, "mesh", None)?;
        settings.exclusive("vertices", "cell_size")?;
        let mut options = LatticeOptions::default();
        let vertices = settings.count("vertices", 8)?.map(Resolution::Vertices);
        let resolution = vertices.or(settings.number("cell_size")?.map(Resolution::CellSize));
        options.resolution = resolution.unwrap_or(options.resolution);
        options.join = settings.read("join", argument::boolean)?.unwrap_or(options.join);
        let memory_limit = settings.count("memory_limit", 0)?.map(|bytes| bytes as u64);
        options.memory_limit = Some(memory_limit.unwrap_or_else(supple_io::memory_limit));
        let mesh = mesh.get().mesh.clone();
        let lattice = interruptible(py, move || supple::Lattice::from_mesh(&mesh, &options))?;
        lattice.map(Self::from_core).map_err(error::from_core)
    }

    /// Create a lattice from an array of occupied cells.
    ///
    /// cells : (nx, ny, nz) bool
    ///     True for occupied cells; the first axis is x.
    /// cell_size : float, default 1
    ///     Edge of a cell, > 0.
    /// origin : (3,) float, default 0
    ///     Position of the vertex with indices (0, 0, 0).
    /// join : bool, default True
    ///     Whether bridges of cells join separate parts. If False, each part is a separate component.
    ///
    /// Raises LatticeError if no cell is occupied or a value is invalid.
    #[classmethod]
    #[pyo3(
        signature = (cells, cell_size=Given(None), origin=Given(None), join=Given(None)),
        text_signature = "(cells, cell_size=1.0, origin=(0, 0, 0), join=True)"
    )]
    fn from_cells<'py>(
        _class: &Bound<'py, PyType>,
        cells: &Bound<'py, PyAny>,
        cell_size: Given<'py>,
        origin: Given<'py>,
        join: Given<'py>,
    ) -> PyResult<Self> {
        let py = cells.py();
        let cell_size = cell_size.read("cell_size", argument::number)?.unwrap_or(1.0);
        let join = join.read("join", argument::boolean)?.unwrap_or(true);
        let wrap = |e| Exception::Lattice.wrap_value_error(e);
        let cells = occupied(cells).map_err(wrap)?;
        let origin = origin.read("origin", arrays::vector).map_err(wrap)?.unwrap_or_default();
        Self::build(py, cells, cell_size, origin, join)
    }

    /// Grid coordinates of the vertices: (n, 3) int64, read-only.
    ///
    /// If the lattice was created by from_cells, the vertex (0, 0, 0) is the corner of cells[0, 0, 0] with
    /// the smallest coordinates.
    #[getter]
    fn indices<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<i64>> {
        let indices = || self.lattice.indices().iter().map(|index| index.map(i64::from)).collect();
        self.indices.get_or_init(py, || arrays::read_only(py, indices())).bind(py)
    }

    /// Rest positions of the vertices, origin + cell_size * indices: (n, 3) float64, read-only.
    #[getter]
    fn rest_positions<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<f64>> {
        let rest = |vertex| self.lattice.rest_position(vertex).into();
        let positions = || (0..self.lattice.len() as u32).map(rest).collect();
        self.rest_positions.get_or_init(py, || arrays::read_only(py, positions())).bind(py)
    }

    /// Grid coordinates of the occupied cells: (m, 3) int64, read-only.
    ///
    /// The grid coordinates of a cell are the grid coordinates of its corner with the smallest coordinates.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<i64>> {
        let cells = || self.lattice.cells().iter().map(|index| index.map(i64::from)).collect();
        self.cells.get_or_init(py, || arrays::read_only(py, cells())).bind(py)
    }

    /// Vertices at the corners of the cells: (m, 8) int64, read-only. Corner i is at +x if i & 1, at +y if i & 2,
    /// and at +z if i & 4. Of a broken body, cells on the two sides of a crack have vertices of their own.
    #[getter]
    fn cell_corners<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let count = self.lattice.cells().len();
        let corners = (0..count as u32).flat_map(|cell| self.lattice.cell_corners(cell).map(i64::from));
        Ok(arrays::frozen(PyArray1::from_iter(py, corners).reshape([count, 8])?))
    }

    /// Edge of a cell.
    #[getter]
    fn cell_size(&self) -> f64 {
        self.lattice.cell_size()
    }

    /// Position of the vertex with indices (0, 0, 0): (3,) float64.
    #[getter]
    fn origin<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.lattice.origin().coords.as_slice())
    }

    /// Number of connected components of the graph of lattice vertices and links.
    #[getter]
    fn component_count(&self) -> usize {
        self.lattice.components().count
    }

    fn __len__(&self) -> usize {
        self.lattice.len()
    }

    fn __repr__(&self) -> String {
        format!(
            "<supple.Lattice: {} vertices, {} of {:.4}, {} kB>",
            self.lattice.len(),
            counted(self.lattice.cells().len(), "cell"),
            self.lattice.cell_size(),
            self.lattice.memory().div_ceil(1000)
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, lattice) = (slf.py(), &slf.get().lattice);
        if !lattice.broken_joints().is_empty() {
            let message = "the lattice of a broken body cannot be pickled or copied; pickle or copy the body";
            return Err(PyValueError::new_err(message));
        }
        let restore = py.get_type::<Self>().getattr("_restore")?;
        let data = (lattice.cells(), lattice.cell_size(), <[f64; 3]>::from(lattice.origin()));
        (restore, (encode(py, &data)?,)).into_pyobject(py)
    }

    /// Restore a lattice without adding bridges. Pickles call this function.
    #[classmethod]
    fn _restore(class: &Bound<'_, PyType>, data: &[u8]) -> PyResult<Self> {
        let (cells, cell_size, origin): (Vec<[i32; 3]>, f64, [f64; 3]) = decode(class.py(), data)?;
        Self::build(class.py(), cells, cell_size, origin, false)
    }
}

impl Lattice {
    /// Builds the lattice of occupied cells.
    fn build(
        py: Python<'_>,
        cells: Vec<[i32; 3]>,
        cell_size: f64,
        origin: [f64; 3],
        join: bool,
    ) -> PyResult<Self> {
        let limit = supple_io::memory_limit();
        let build = move || supple::Lattice::from_cells_within(limit, &cells, cell_size, origin, join);
        interruptible(py, build)?.map(Self::from_core).map_err(error::from_core)
    }
}

/// Returns the indices of the true entries of an `(nx, ny, nz)` array.
fn occupied(cells: &Bound<'_, PyAny>) -> PyResult<Vec<[i32; 3]>> {
    let cells = arrays::booleans(cells, "cells", &[Axis::Any("nx"), Axis::Any("ny"), Axis::Any("nz")])?;
    let shape = cells.shape();
    let (ny, nz) = (shape[1], shape[2]);
    if shape.iter().any(|&length| length > 1 << 30) {
        return Err(PyValueError::new_err("cells has an axis of more than 2^30 cells"));
    }
    let occupied = cells.as_slice()?.iter().enumerate().filter(|(_, occupied)| **occupied);
    Ok(occupied.map(|(k, _)| [k / nz / ny, k / nz % ny, k % nz].map(|index| index as i32)).collect())
}
