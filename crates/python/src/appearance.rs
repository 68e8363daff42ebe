//! Reads the texture coordinates and materials of the model file of a mesh. This happens when they are asked for, so that
//! meshes which are only simulated take no memory and no time for them.

use std::path::{Path, PathBuf};

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use serde::{Deserialize, Serialize};
use supple_io::model::{self, ModelError};
use supple_io::obj::{Appearance, Image};

use crate::error::{self, Exception};

/// The model file of a mesh, and the name of the object or group that was read.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Source {
    path: PathBuf,
    object: Option<String>,
}

impl Source {
    pub(crate) fn new(path: &Path, object: Option<&str>) -> Self {
        // A later change of the working directory does not matter.
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Self { path, object: object.map(str::to_owned) }
    }

    /// Reads the file again. Returns a tuple of the coordinates, (k, 2); for each corner of the triangles its index in
    /// them, (m, 3), or no rows; and the materials: name, triangles, color with opacity, and the image: its path, its
    /// contents if it is inside of the file, or `None`.
    ///
    /// A file whose mesh differs from `mesh` is an error.
    pub(crate) fn appearance<'py>(
        &self,
        py: Python<'py>,
        mesh: &supple::Mesh,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let read = || {
            let document = model::read_document(&self.path)?;
            let part = document.part(self.object.as_deref())?;
            let is_same = part.mesh().vertices() == mesh.vertices() && part.mesh().faces().eq(mesh.faces());
            Ok::<_, ModelError>(is_same.then(|| (document.appearance(&part), document.material_colors())))
        };
        let Some((found, colors)) = py.detach(read).map_err(error::from_model)? else {
            let path = self.path.display();
            let message = format!("{path} has changed since the mesh was read; read it again");
            return Err(Exception::Mesh.with(message));
        };
        let (corners, triangles_of) = triangles(mesh, &found);
        let materials = found.materials.iter().map(|(name, faces)| {
            let color = colors.get(name).cloned().unwrap_or_default();
            let [r, g, b] = color.diffuse;
            let of_face = |&face: &u32| triangles_of[face as usize]..triangles_of[face as usize + 1];
            let triangles = PyArray1::from_vec(py, faces.iter().flat_map(of_face).collect());
            let image = match color.image {
                Some(Image::File(path)) => Some(path.into_pyobject(py)?.into_any()),
                Some(Image::Embedded(image)) => Some(PyBytes::new(py, &image.bytes).into_any()),
                _ => None,
            };
            (name, triangles, [r, g, b, color.opacity], image).into_pyobject(py)
        });
        let materials = materials.collect::<PyResult<Vec<_>>>()?;
        let coordinates: Vec<f64> = found.coordinates.iter().flatten().map(|&x| f64::from(x)).collect();
        let coordinates = PyArray1::from_vec(py, coordinates).reshape([found.coordinates.len(), 2])?;
        let rows = corners.len() / 3;
        (coordinates, PyArray1::from_vec(py, corners).reshape([rows, 3])?, materials).into_pyobject(py)
    }
}

/// Divides the faces of a mesh into triangles, as `Mesh.faces` does. Returns the texture coordinates of their corners,
/// and for each face the index of its first triangle, with the number of all triangles at the end.
fn triangles(mesh: &supple::Mesh, found: &Appearance) -> (Vec<i64>, Vec<i64>) {
    let (mut corner, mut corners, mut first) = (0, Vec::new(), vec![0]);
    let mut triangles = mesh.triangles().iter();
    for (face, index) in mesh.faces().zip(0..) {
        let of_mesh = triangles.by_ref().take(face.len() - 2);
        if let Some(of_face) = found.corners.get(corner..corner + face.len()) {
            let at = |vertex: &u32| face.iter().position(|other| other == vertex).unwrap_or(0);
            corners.extend(of_mesh.flatten().map(|vertex| i64::from(of_face[at(vertex)])));
        } else {
            of_mesh.for_each(drop);
        }
        corner += face.len();
        first.push(first[index] + face.len() as i64 - 2);
    }
    (corners, first)
}
