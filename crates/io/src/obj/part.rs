//! Selects the part of an OBJ file that is the surface of one body.

use std::collections::HashSet;

use nalgebra::Point3;

use super::Document;
use super::ObjError;
use super::error::ObjProblem;
use supple::Mesh;

/// The mesh of a whole OBJ file or of one of its objects or groups, and the indices of its `v` and faces in
/// the file.
#[derive(Clone, Debug)]
pub struct Part {
    mesh: Mesh,
    /// Name of the object or group; `None` for the whole file.
    object: Option<String>,
    /// `v` index of each mesh vertex, from 0; `None` if the indices are equal.
    vertices: Option<Vec<u32>>,
    /// Index of each face in the file, from 0, in order; `None` if the part has all faces.
    faces: Option<Vec<u32>>,
}

/// Marks a `v` that is not a vertex of the mesh.
const UNUSED: u32 = u32::MAX;

impl Document {
    /// Returns the mesh of the whole file, or of one object or group. The vertices of the whole file are all
    /// `v`, in order. The vertices of an object or group are the `v` that its faces use, in order.
    ///
    /// # Errors
    /// If no `o` or `g` with faces has the name (the error lists the known names), or the surface has no
    /// extent.
    pub fn mesh(&self, object: Option<&str>) -> Result<Mesh, ObjError> {
        Ok(self.part(object)?.into_mesh())
    }

    /// Returns the mesh like [`Document::mesh`], with the groups and maps of the file: see [`Part::with_groups`] and
    /// [`Part::with_maps`].
    ///
    /// # Errors
    /// As [`Document::mesh`].
    pub fn grouped_mesh(&self, object: Option<&str>) -> Result<Mesh, ObjError> {
        Ok(self.part(object)?.with_groups(self).with_maps(self).into_mesh())
    }

    /// Returns the mesh like [`Document::mesh`], with the indices that are needed to write it back to the
    /// file.
    ///
    /// # Errors
    /// As [`Document::mesh`].
    pub fn part(&self, object: Option<&str>) -> Result<Part, ObjError> {
        Part::new(self, object)
    }
}

impl Part {
    fn new(document: &Document, object: Option<&str>) -> Result<Self, ObjError> {
        let Some(name) = object else {
            let mesh = build(document, 0..document.face_count() as u32, None)?;
            return Ok(Self { mesh, object: None, vertices: None, faces: None });
        };
        let faces = faces_of(document, name)?;
        // For each `v`, its index among the mesh vertices.
        let mut index = vec![UNUSED; document.vertex_count()];
        for &face in &faces {
            for &vertex in document.face(face) {
                index[vertex as usize] = 0;
            }
        }
        let mut vertices = Vec::new();
        for (vertex, index) in index.iter_mut().enumerate().filter(|(_, index)| **index != UNUSED) {
            *index = vertices.len() as u32;
            vertices.push(vertex as u32);
        }
        let mesh = build(document, faces.iter().copied(), Some((&vertices, &index)))?;
        let object = Some(name.to_owned());
        Ok(Self { mesh, object, vertices: Some(vertices), faces: Some(faces) })
    }

    /// Returns the part whose mesh has the groups of the file: the vertices of the faces of each object, group and
    /// material, by their names.
    #[must_use]
    pub fn with_groups(self, document: &Document) -> Self {
        let faces: Vec<&[u32]> = self.mesh.faces().collect();
        let mut place = vec![UNUSED; document.face_count()];
        (0..).zip(self.faces()).for_each(|(face, in_file)| place[in_file as usize] = face);
        let vertices = |list: &mut dyn Iterator<Item = u32>| -> Vec<u32> {
            list.flat_map(|face| faces[face as usize].iter().copied()).collect()
        };
        let mut groups: Vec<(String, Vec<u32>)> = Vec::new();
        for group in document.all_groups() {
            let mut own = group.faces.iter().cloned().flatten().map(|face| place[face as usize]);
            groups.push((group.name.clone(), vertices(&mut own.by_ref().filter(|&face| face != UNUSED))));
        }
        // Another pass over the file.
        if document.has_materials() {
            let materials = document.appearance(&self).materials.into_iter();
            groups.extend(materials.map(|(name, list)| (name, vertices(&mut list.into_iter()))));
        }
        groups.retain(|(_, vertices)| !vertices.is_empty());
        let mesh = self.mesh.clone().with_groups(groups);
        Self { mesh, ..self }
    }

    /// Returns the part whose mesh has the maps of the file: see [`Document::maps`].
    #[must_use]
    pub fn with_maps(self, document: &Document) -> Self {
        let of_part = |values: Vec<f32>| match &self.vertices {
            None => values,
            Some(vertices) => vertices.iter().map(|&v| values[v as usize]).collect(),
        };
        let maps = document.maps().into_iter().map(|(name, values)| (name, of_part(values)));
        let mesh = self.mesh.clone().with_maps(maps).expect("a map has a number for each `v`");
        Self { mesh, ..self }
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Returns the name of the object or group; `None` for the whole file.
    pub fn object(&self) -> Option<&str> {
        self.object.as_deref()
    }

    /// Returns the mesh without the indices.
    pub fn into_mesh(self) -> Mesh {
        self.mesh
    }

    /// Returns the `v` index, from 0, of each mesh vertex.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = u32> {
        (0..self.mesh.vertices().len())
            .map(move |vertex| self.vertices.as_ref().map_or(vertex as u32, |map| map[vertex]))
    }

    /// Returns the index in the file, from 0, of each mesh face.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = u32> {
        (0..self.mesh.face_count()).map(move |face| self.faces.as_ref().map_or(face as u32, |map| map[face]))
    }
}

/// Returns the faces of all objects and groups with this name, each face once, in order.
fn faces_of(document: &Document, name: &str) -> Result<Vec<u32>, ObjError> {
    let named = || document.all_groups().iter().filter(|group| group.name == name);
    if named().next().is_none() {
        // An object and a group may have the same name.
        let mut listed = HashSet::new();
        let names = document.groups().map(|group| group.name.as_str());
        let known = names.filter(|name| listed.insert(*name)).map(str::to_owned).collect();
        return Err(document.error(ObjProblem::UnknownObject { name: name.to_owned(), known }));
    }
    let mut faces: Vec<u32> = named().flat_map(|group| group.faces.iter().cloned().flatten()).collect();
    faces.sort_unstable();
    faces.dedup();
    Ok(faces)
}

/// Builds the mesh of some faces of a file. `map` contains the `v` that become mesh vertices, and for each
/// `v` its index among them; `None` if all `v` become mesh vertices.
fn build(
    document: &Document,
    faces: impl Iterator<Item = u32> + Clone,
    map: Option<(&[u32], &[u32])>,
) -> Result<Mesh, ObjError> {
    let positions = document.positions();
    let vertices = match map {
        None => positions.iter().copied().map(Point3::from).collect(),
        Some((used, _)) => used.iter().map(|&vertex| Point3::from(positions[vertex as usize])).collect(),
    };
    let mut offsets = vec![0];
    let mut corners = Vec::new();
    for face in faces {
        let face = document.face(face);
        match map {
            None => corners.extend_from_slice(face),
            Some((_, index)) => corners.extend(face.iter().map(|&vertex| index[vertex as usize])),
        }
        offsets.push(corners.len() as u32);
    }
    Mesh::from_flat(vertices, offsets, corners).map_err(|error| document.error(ObjProblem::Mesh(error)))
}
