//! Defines `supple.Mesh`: a surface mesh from arrays, a model file or the mesh object of another library.

use std::path::{Path, PathBuf};

use numpy::{Element, PyArray1, PyArray2, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyOverflowError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};
use supple::{ColliderFault, CollisionMesh};
use supple_io::{counted, model};

use crate::appearance::Source;
use crate::argument::{self, is_from_python, wrong_type};
use crate::arrays::{self, Axis};
use crate::error::{self, Exception};
use crate::pickle::{decode, encode};

/// A surface mesh: vertices and polygons.
///
/// Mesh(vertices, faces)
///
/// vertices : (n, 3) float
///     Positions, finite. Vertices at exactly the same position are welded: they move together.
/// faces : (m, 3) or (m, 4) int, or a list of faces of any size
///     Vertex indices of each face, from 0, counter-clockwise seen from outside.
///
/// Open, non-manifold, flipped and self-intersecting surfaces are valid. Raises MeshError for an index out of
/// range, a position that is not finite, a mesh without faces or a mesh without extent.
#[pyclass(frozen, module = "supple")]
pub(crate) struct Mesh {
    pub(crate) mesh: supple::Mesh,
    vertices: PyOnceLock<Py<PyArray2<f64>>>,
    faces: PyOnceLock<Py<PyArray2<i64>>>,
    /// The `visual` of the `trimesh.Trimesh` from which the mesh was made: texture coordinates, materials, colors.
    pub(crate) visual: Option<Py<PyAny>>,
    /// The model file of the mesh.
    source: Option<Source>,
    /// The mesh as the shape of colliders.
    collision: PyOnceLock<Result<CollisionMesh, ColliderFault>>,
}

impl Mesh {
    pub(crate) fn from_core(mesh: supple::Mesh) -> Self {
        let (vertices, faces, collision) = (PyOnceLock::new(), PyOnceLock::new(), PyOnceLock::new());
        Self { mesh, vertices, faces, visual: None, source: None, collision }
    }

    /// Attaches the `visual` of a `trimesh.Trimesh` with the same triangles.
    fn with_visual(self, visual: Option<Py<PyAny>>) -> Self {
        Self { visual, ..self }
    }

    /// Returns the mesh of a model file, or of its object or group with the name `object`.
    pub(crate) fn from_file(mesh: supple::Mesh, path: &Path, object: Option<&str>) -> Self {
        let source = Source::new(path, object);
        Self { source: Some(source), ..Self::from_core(mesh) }
    }

    /// Reads the texture coordinates and materials of the file of the mesh; `None` without a file.
    pub(crate) fn appearance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        self.source.as_ref().map(|source| source.appearance(py, &self.mesh)).transpose()
    }

    /// Returns the mesh of a collider.
    pub(crate) fn from_collision(py: Python<'_>, mesh: &CollisionMesh) -> Self {
        let core = Self::from_core(mesh.mesh().clone());
        if mesh.animation().is_none() && !mesh.is_inverted() {
            // The lock is empty.
            let _ = core.collision.set(py, Ok(mesh.clone()));
        }
        core
    }

    /// Returns the mesh as the shape of colliders. It is built at the first call.
    pub(crate) fn collision_mesh(&self, py: Python<'_>) -> Result<CollisionMesh, ColliderFault> {
        self.collision.get_or_init(py, || CollisionMesh::new(self.mesh.clone())).clone()
    }
}

/// Returns lists of values by name: dict of name to a read-only array.
fn by_name<'py, T: Copy, N: Element>(
    py: Python<'py>,
    lists: &[(String, Vec<T>)],
    number: impl Fn(T) -> N,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, values) in lists {
        let values = values.iter().map(|&value| number(value)).collect();
        dict.set_item(name, arrays::frozen(PyArray1::from_vec(py, values)))?;
    }
    Ok(dict)
}

#[pymethods]
impl Mesh {
    #[new]
    #[pyo3(signature = (vertices, faces))]
    fn new(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Self> {
        let points = read_vertices(vertices).map_err(|e| Exception::Mesh.wrap_value_error(e))?;
        mesh_from_faces(faces, points).map_err(|e| Exception::Mesh.wrap_value_error(e))
    }

    /// Return the mesh of an object of another library; of a trimesh.Scene all meshes, at their places in the scene.
    ///
    /// mesh : trimesh.Trimesh, trimesh.Scene, meshio.Mesh, open3d.geometry.TriangleMesh, pyvista.PolyData, an object with
    ///     vertices and faces, or a path
    ///
    /// The order of the vertices and faces is kept. Texture coordinates, materials and colors of trimesh are kept for
    /// Body.to_trimesh. A mesh argument, such as that of Body, may also be the object itself.
    #[staticmethod]
    fn from_trimesh<'py>(mesh: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Self>> {
        mesh_like(mesh, "mesh", None)
    }

    /// Vertex positions in input order: (n, 3) float64, read-only.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<f64>> {
        let vertices = || self.mesh.vertices().iter().map(|&p| p.into()).collect();
        self.vertices.get_or_init(py, || arrays::read_only(py, vertices())).bind(py)
    }

    /// Triangles: (m, 3) int64, read-only. Larger faces are fans from their first vertex, or ears if they are concave.
    #[getter]
    pub(crate) fn faces<'py>(&self, py: Python<'py>) -> &Bound<'py, PyArray2<i64>> {
        let faces = || self.mesh.triangles().iter().map(|face| face.map(i64::from)).collect();
        self.faces.get_or_init(py, || arrays::read_only(py, faces())).bind(py)
    }

    /// Enclosed volume, never negative. The volume of an open mesh is not meaningful.
    #[getter]
    fn volume(&self, py: Python<'_>) -> f64 {
        py.detach(|| self.mesh.volume())
    }

    /// Whether the surface is closed: after welding equal positions, the directed uses of each edge cancel.
    #[getter]
    fn is_closed(&self, py: Python<'_>) -> bool {
        py.detach(|| self.mesh.is_closed())
    }

    /// Named groups of vertices: dict of name to (k,) int64 array, in increasing order. A mesh from a file has those of the
    /// objects, groups and materials of the file. Body.pin(group=...) and its like select by them.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, self.mesh.groups(), i64::from)
    }

    /// Numbers of the vertices by name: dict of name to (n,) float64 array. A mesh from a file has the colors of its vertices
    /// ("red", "green", "blue", "alpha", in [0, 1]) and other numbers of GLB and PLY. Body.pin(map=...) and its like take
    /// them as weights.
    #[getter]
    fn maps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, self.mesh.maps(), f64::from)
    }

    /// Bounding box of the vertices that faces use: (2, 3) float64, the minimum and maximum corners.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let (low, high) = self.mesh.bounds();
        arrays::from_points(py, vec![low, high])
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let closed = if self.is_closed(py) { "closed" } else { "open" };
        format!(
            "<supple.Mesh: {}, {}, {closed}>",
            counted(self.mesh.vertices().len(), "vertex"),
            counted(self.mesh.face_count(), "face")
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let (py, mesh) = (slf.py(), &slf.get().mesh);
        let vertices: Vec<[f64; 3]> = mesh.vertices().iter().map(|&p| p.into()).collect();
        let faces: Vec<&[u32]> = mesh.faces().collect();
        let restore = py.get_type::<Self>().getattr("_restore")?;
        let data = encode(py, &(vertices, faces, &slf.get().source, mesh.groups(), mesh.maps()))?;
        match &slf.get().visual {
            Some(visual) => (restore, (data, visual)).into_pyobject(py),
            None => (restore, (data,)).into_pyobject(py),
        }
    }

    /// Restore a mesh. Pickles call this function.
    #[classmethod]
    #[pyo3(signature = (data, visual=None))]
    fn _restore(class: &Bound<'_, PyType>, data: &[u8], visual: Option<Py<PyAny>>) -> PyResult<Self> {
        type Named<T> = Vec<(String, Vec<T>)>;
        type Data = (Vec<[f64; 3]>, Vec<Vec<u32>>, Option<Source>, Named<u32>, Named<f32>);
        let (vertices, faces, source, groups, maps): Data = decode(class.py(), data)?;
        let mesh = supple::Mesh::new(vertices, &faces).map_err(error::from_core)?.with_groups(groups);
        let mesh = mesh.with_maps(maps).map_err(error::from_core)?;
        Ok(Self { source, ..Self::from_core(mesh).with_visual(visual) })
    }
}

/// Read a mesh from an OBJ, GLB, glTF, STL or PLY file.
///
/// path : str or os.PathLike
///     The content of the file determines its format.
/// object : str, optional
///     Reads only the object or group with this name: of an `o` or `g` statement, a node of glTF or a solid of STL.
///
/// Raises FileNotFoundError or another OSError for a file that cannot be read, and MeshError, with file and
/// line or element, for an invalid mesh.
#[pyfunction]
#[pyo3(signature = (path, object=None))]
pub(crate) fn read_obj(path: &Bound<'_, PyAny>, object: Option<&Bound<'_, PyAny>>) -> PyResult<Mesh> {
    let object = object.map(|object| argument::text(object, "object")).transpose()?;
    read_mesh(path.py(), &argument::path(path, "path")?, object.as_deref())
}

/// Reads a mesh from a model file: all of it, or only the object or group with the name `object`.
fn read_mesh(py: Python<'_>, path: &Path, object: Option<&str>) -> PyResult<Mesh> {
    let mesh = py.detach(|| model::read(path, object)).map_err(error::from_model)?;
    Ok(Mesh::from_file(mesh, path, object))
}

/// Endings of files that trimesh reads.
const READ_BY_TRIMESH: [&str; 2] = ["off", "3mf"];

/// Types of mesh arguments, for messages.
const MESH_LIKE: &str = "a supple.Mesh, a path, an object with vertices and faces, or a mesh of trimesh, meshio, Open3D or \
                         PyVista";

/// Converts a mesh argument: a `Mesh`, a path, a `trimesh.Scene`, an object with `vertices` and `faces`, such as a
/// `trimesh.Trimesh`, or a mesh of meshio, Open3D or PyVista.
pub(crate) fn mesh_like<'py>(
    value: &Bound<'py, PyAny>,
    name: &str,
    object: Option<String>,
) -> PyResult<Bound<'py, Mesh>> {
    let py = value.py();
    if let Ok(path) = value.extract::<PathBuf>() {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if ending.is_none_or(|ending| !READ_BY_TRIMESH.contains(&ending.as_str())) {
            return Bound::new(py, read_mesh(py, &path, object.as_deref())?);
        }
        if object.is_some() {
            return Err(PyValueError::new_err(
                "object needs an OBJ, GLB, glTF, STL or PLY file; load another file with trimesh",
            ));
        }
        let read = py.import("supple.interchange")?.call_method1("read_with_trimesh", (path,))?;
        return mesh_like(&read, name, None);
    }
    if object.is_some() {
        return Err(PyValueError::new_err("object needs a mesh that is read from a file; pass a path"));
    }
    if let Ok(mesh) = value.cast::<Mesh>() {
        return Ok(mesh.clone());
    }
    // A scene of trimesh.
    if value.getattr_opt("geometry")?.is_some() && value.hasattr("graph")? {
        let merged = py.import("supple.interchange")?.call_method1("merged", (value,))?;
        return mesh_like(&merged, name, None);
    }
    match (value.getattr_opt("vertices")?, value.getattr_opt("faces")?) {
        (Some(vertices), Some(faces)) => {
            let visual = py.import("supple.interchange")?.call_method1("visual", (value,))?;
            let visual = if visual.is_none() { None } else { Some(visual.unbind()) };
            Bound::new(py, Mesh::new(&vertices, &faces)?.with_visual(visual))
        }
        _ => {
            let arrays = py.import("supple.interchange")?.call_method1("arrays", (value,))?;
            let arrays: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)> = arrays.extract()?;
            let (vertices, faces) = arrays.ok_or_else(|| wrong_type(value, name, MESH_LIKE))?;
            Bound::new(py, Mesh::new(&vertices, &faces)?)
        }
    }
}

/// Creates a mesh from the number of corners of each face and the concatenated corners of all faces.
fn mesh_from_polygons(sizes: &[usize], corners: &[i64], points: Vec<[f64; 3]>) -> PyResult<Mesh> {
    let vertices = points.len();
    let in_range = |corner: &i64| (0..vertices as i64).contains(corner);
    if let Some(invalid) = corners.iter().position(|corner| !in_range(corner)) {
        let mut end = 0;
        let face = sizes.iter().position(|size| {
            end += size;
            end > invalid
        });
        return Err(Exception::Mesh.with(format!(
            "face {} refers to vertex {} of {vertices} (counted from 0)",
            face.unwrap_or_default(),
            corners[invalid]
        )));
    }
    let corners: Vec<u32> = corners.iter().map(|&corner| corner as u32).collect();
    let mut rest = &corners[..];
    let faces: Vec<&[u32]> =
        sizes.iter().map(|&size| rest.split_off(..size).expect("the sizes sum to the corners")).collect();
    supple::Mesh::new(points, &faces).map(Mesh::from_core).map_err(error::from_core)
}

/// Reads `(n, 3)` vertices. The core checks that they are finite, and its error names the vertex.
fn read_vertices(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    let array = arrays::floats(value, "vertices", &[Axis::Any("n"), Axis::Is(3)])?;
    Ok(array.as_slice()?.as_chunks().0.to_vec())
}

/// Creates a mesh from faces given as `(m, 3)`, `(m, 4)` or a list of faces of any size.
fn mesh_from_faces(faces: &Bound<'_, PyAny>, points: Vec<[f64; 3]>) -> PyResult<Mesh> {
    if !faces.is_instance_of::<PyUntypedArray>() {
        match faces.extract::<Vec<Vec<i64>>>() {
            Ok(lists) => return mesh_from_lists(&lists, points),
            Err(error) if is_from_python(&error, faces.py()) => return Err(error),
            Err(error) if error.is_instance_of::<PyOverflowError>(faces.py()) => {
                return Err(PyValueError::new_err(format!(
                    "faces has an index beyond 64 bits; there are {} vertices",
                    points.len()
                )));
            }
            Err(_) => {}
        }
    }
    let array = arrays::integers(faces, "faces", &[Axis::Any("m"), Axis::Between(3, 4)])?;
    mesh_from_polygons(&vec![array.shape()[1]; array.shape()[0]], array.as_slice()?, points)
}

/// Creates a mesh from one list of corners per face.
fn mesh_from_lists(lists: &[Vec<i64>], points: Vec<[f64; 3]>) -> PyResult<Mesh> {
    let sizes: Vec<usize> = lists.iter().map(Vec::len).collect();
    if let Some(face) = sizes.iter().position(|&size| size < 3) {
        let message = format!("faces[{face}] has {} corners; a face has at least 3", sizes[face]);
        return Err(PyValueError::new_err(message));
    }
    mesh_from_polygons(&sizes, &lists.concat(), points)
}
