//! `supple.Mesh`: a surface, from arrays, from an OBJ file, or from another library's mesh.

use std::path::{Path, PathBuf};

use numpy::{PyArray1, PyArray2, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyOverflowError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use crate::argument::{self, wrong_type};
use crate::arrays::{self, Side};
use crate::error::{self, Exception};

/// A surface mesh: vertices and polygons.
///
/// Mesh(vertices, faces)
///
/// vertices : (n, 3) float
///     Positions, finite. Vertices at exactly the same position move alike.
/// faces : (m, 3) or (m, 4) int, or a list of faces of any size
///     The vertices of each face, counted from 0, counter-clockwise seen from outside.
///
/// Open, non-manifold, flipped and self-intersecting surfaces are taken as they are. MeshError is raised for an index
/// out of range, a position that is not finite, no face at all, or no extent.
#[pyclass(frozen, module = "supple")]
pub(crate) struct Mesh {
    pub(crate) mesh: supple::Mesh,
    vertices: PyOnceLock<Py<PyArray2<f64>>>,
    faces: PyOnceLock<Py<PyArray2<i64>>>,
}

impl Mesh {
    pub(crate) fn from_core(mesh: supple::Mesh) -> Self {
        Self { mesh, vertices: PyOnceLock::new(), faces: PyOnceLock::new() }
    }
}

#[pymethods]
impl Mesh {
    #[new]
    #[pyo3(signature = (vertices, faces))]
    fn new(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Self> {
        let points = read_vertices(vertices).map_err(|e| Exception::Mesh.of_value_error(e))?;
        of_faces(faces, points).map_err(|e| Exception::Mesh.of_value_error(e))
    }

    /// (n, 3) float64, read-only: the vertices in input order.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<f64>> {
        let vertices = || self.mesh.vertices().iter().map(|&p| p.into()).collect();
        self.vertices.get_or_init(py, || arrays::constant(py, vertices())).bind(py)
    }

    /// (m, 3) int64, read-only: the faces, larger ones fanned into triangles from their first vertex.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<i64>> {
        let faces = || self.mesh.triangles().iter().map(|face| face.map(i64::from)).collect();
        self.faces.get_or_init(py, || arrays::constant(py, faces())).bind(py)
    }

    /// The enclosed volume, never negative. For an open mesh it says little.
    #[getter]
    fn volume(&self, py: Python<'_>) -> f64 {
        py.detach(|| self.mesh.volume())
    }

    /// Whether the surface encloses a volume: equal positions welded, the directed uses of each edge cancel.
    #[getter]
    fn is_closed(&self, py: Python<'_>) -> bool {
        py.detach(|| self.mesh.is_closed())
    }

    /// (2, 3) float64: least and greatest coordinates of the vertices that faces use.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let (low, high) = self.mesh.bounds();
        arrays::of_points(py, vec![low, high])
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let closed = if self.is_closed(py) { "closed" } else { "open" };
        format!(
            "<supple.Mesh: {} vertices, {} faces, {closed}>",
            self.mesh.vertices().len(),
            self.mesh.face_count()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, mesh) = (slf.py(), &slf.get().mesh);
        let sizes: Vec<i64> = mesh.faces().map(|face| face.len() as i64).collect();
        let corners: Vec<i64> = mesh.faces().flatten().map(|&corner| i64::from(corner)).collect();
        let arrays = (slf.get().vertices(py), PyArray1::from_vec(py, sizes), PyArray1::from_vec(py, corners));
        let restore = py.get_type::<Self>().getattr("_from_polygons")?;
        Ok((restore, arrays).into_pyobject(py)?.into_any())
    }

    /// A mesh from its vertices, the number of corners of each face, and all corners one after another.
    #[classmethod]
    fn _from_polygons(
        _class: &Bound<'_, PyType>,
        vertices: &Bound<'_, PyAny>,
        sizes: &Bound<'_, PyAny>,
        corners: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let points = read_vertices(vertices)?;
        let sizes = arrays::integers(sizes, "sizes", &[Side::Any("m")])?;
        let corners = arrays::integers(corners, "corners", &[Side::Any("k")])?;
        let sizes: Vec<usize> = sizes.as_slice()?.iter().map(|&size| size.max(0) as usize).collect();
        let corners = corners.as_slice()?;
        if sizes.iter().sum::<usize>() != corners.len() {
            return Err(PyValueError::new_err("sizes do not add up to the number of corners"));
        }
        of_polygons(&sizes, corners, points)
    }
}

/// Reads the surface of a Wavefront OBJ file.
///
/// path : str or os.PathLike
/// object : str, optional
///     Only the `o` or `g` of this name.
///
/// Raises FileNotFoundError (or another OSError) for a file that cannot be read, and MeshError, with file and line, for
/// one that is no usable mesh.
#[pyfunction]
#[pyo3(signature = (path, object=None))]
pub(crate) fn read_obj(path: &Bound<'_, PyAny>, object: Option<&Bound<'_, PyAny>>) -> PyResult<Mesh> {
    let object = object.map(|object| argument::text(object, "object")).transpose()?;
    read_part(path.py(), &argument::path(path, "path")?, object.as_deref())
}

fn read_part(py: Python<'_>, path: &Path, object: Option<&str>) -> PyResult<Mesh> {
    let mesh = py.detach(|| supple_io::obj::read_object(path, object));
    mesh.map(Mesh::from_core).map_err(error::of_obj)
}

/// A mesh where one is asked for: a `Mesh`, a path, or anything with `vertices` and `faces`, such as a
/// `trimesh.Trimesh`.
pub(crate) fn mesh_like<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    object: Option<String>,
) -> PyResult<Bound<'py, Mesh>> {
    let py = value.py();
    if let Ok(path) = value.extract::<PathBuf>() {
        return Bound::new(py, read_part(py, &path, object.as_deref())?);
    }
    if object.is_some() {
        return Err(PyValueError::new_err("object is for a mesh that is read from a file: give a path"));
    }
    if let Ok(mesh) = value.cast::<Mesh>() {
        return Ok(mesh.clone());
    }
    match (value.getattr("vertices"), value.getattr("faces")) {
        (Ok(vertices), Ok(faces)) => Bound::new(py, Mesh::new(&vertices, &faces)?),
        _ => Err(wrong_type(value, name, "a supple.Mesh, a path, or something with vertices and faces")),
    }
}

/// A mesh from the number of corners of each face, and all corners one after another.
fn of_polygons(sizes: &[usize], corners: &[i64], points: Vec<[f64; 3]>) -> PyResult<Mesh> {
    let vertices = points.len();
    let within = |corner: &i64| (0..vertices as i64).contains(corner);
    if let Some(at) = corners.iter().position(|corner| !within(corner)) {
        let mut end = 0;
        let face = sizes.iter().position(|size| {
            end += size;
            end > at
        });
        return Err(Exception::Mesh.with(format!(
            "face {} refers to vertex {} of {vertices} (counted from 0)",
            face.unwrap_or_default(),
            corners[at]
        )));
    }
    let corners: Vec<u32> = corners.iter().map(|&corner| corner as u32).collect();
    let mut rest = &corners[..];
    let faces: Vec<&[u32]> =
        sizes.iter().map(|&size| rest.split_off(..size).expect("a corner each")).collect();
    supple::Mesh::new(points, &faces).map(Mesh::from_core).map_err(error::of)
}

/// `(n, 3)`; what is not finite is left to the core, which names the vertex.
fn read_vertices(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    let array = arrays::floats(value, "vertices", &[Side::Any("n"), Side::Is(3)])?;
    Ok(array.as_slice()?.as_chunks().0.to_vec())
}

/// A mesh of faces as `(m, 3)` or `(m, 4)`, or as a list of faces of any size.
fn of_faces(faces: &Bound<'_, PyAny>, points: Vec<[f64; 3]>) -> PyResult<Mesh> {
    if !faces.is_instance_of::<PyUntypedArray>() {
        match faces.extract::<Vec<Vec<i64>>>() {
            Ok(lists) => return of_lists(&lists, points),
            Err(error) if error.is_instance_of::<PyOverflowError>(faces.py()) => {
                return Err(PyValueError::new_err(format!(
                    "faces has an index beyond 64 bits; there are {} vertices",
                    points.len()
                )));
            }
            Err(_) => {}
        }
    }
    let array = arrays::integers(faces, "faces", &[Side::Any("m"), Side::Between(3, 4)])?;
    of_polygons(&vec![array.shape()[1]; array.shape()[0]], array.as_slice()?, points)
}

fn of_lists(lists: &[Vec<i64>], points: Vec<[f64; 3]>) -> PyResult<Mesh> {
    let sizes: Vec<usize> = lists.iter().map(Vec::len).collect();
    if let Some(face) = sizes.iter().position(|&size| size < 3) {
        let message = format!("faces[{face}] has {} corners; a face has at least 3", sizes[face]);
        return Err(PyValueError::new_err(message));
    }
    of_polygons(&sizes, &lists.concat(), points)
}
