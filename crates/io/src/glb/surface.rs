//! Splits the vertices of a mesh, so that each has one normal and one pair of texture coordinates, as glTF needs.

use std::collections::BTreeMap;
use std::ops::Range;

use supple::mesh::Mesh;

use super::Materials;
use crate::obj::{Document, Part};

/// The surface of a body, as vertices and triangles of glTF.
#[derive(Debug)]
pub(crate) struct SplitSurface {
    /// The mesh vertex of each vertex, in ascending order.
    vertices: Vec<u32>,
    /// The normal of each vertex: a `vn` of the file if `has_file_normals`, otherwise that of a mesh vertex.
    normals: Vec<u32>,
    /// Whether all faces have `vn`.
    has_file_normals: bool,
    /// Texture coordinates of each vertex, with the origin at the upper left; empty if the input has none.
    pub(super) coordinates: Vec<[f32; 2]>,
    /// The corners of the triangles of each material, by the index of the material.
    pub(super) primitives: BTreeMap<usize, Vec<u32>>,
}

impl SplitSurface {
    /// Splits the vertices of a mesh. `file`: the OBJ file with the texture coordinates, normals and materials. Adds the
    /// materials that it uses to `materials`.
    pub(crate) fn new(mesh: &Mesh, file: Option<(&Document, &Part)>, materials: &mut Materials) -> Self {
        let vn = file.and_then(|(document, part)| corner_normals(document, part));
        let appearance = file.map(|(document, part)| document.appearance(part)).unwrap_or_default();
        let has_textures = !appearance.corners.is_empty();
        // The vertex, the normal and the texture coordinates of each corner.
        let corner_of = |(corner, &vertex): (usize, &u32)| {
            let normal = vn.as_ref().map_or(vertex, |vn| vn[corner]);
            [vertex, normal, if has_textures { appearance.corners[corner] } else { 0 }]
        };
        let corners: Vec<[u32; 3]> = mesh.faces().flatten().enumerate().map(corner_of).collect();
        let mut split = corners.clone();
        split.sort_unstable();
        split.dedup();

        let mut material_of: Vec<Option<usize>> = vec![None; mesh.face_count()];
        for (material, faces) in materials.of_body(mesh, file, &appearance) {
            faces.iter().for_each(|&face| material_of[face as usize] = Some(material));
        }
        let mut primitives: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        let (mut triangles, mut first) = (mesh.triangles().iter(), 0);
        for (face, material) in mesh.faces().zip(material_of) {
            let of_face = triangles.by_ref().take(face.len().saturating_sub(2));
            let material = material.unwrap_or_else(|| materials.default_of(mesh));
            primitives.entry(material).or_default().extend(of_face.flatten().map(|vertex| {
                let corner = first + face.iter().position(|other| other == vertex).unwrap_or(0);
                split.partition_point(|other| *other < corners[corner]) as u32
            }));
            first += face.len();
        }
        primitives.retain(|_, corners| !corners.is_empty());
        let coordinates = split.iter().map(|&[_, _, texture]| {
            let [u, v] = appearance.coordinates[texture as usize];
            [u, 1.0 - v]
        });
        Self {
            coordinates: if has_textures { coordinates.collect() } else { Vec::new() },
            vertices: split.iter().map(|&[vertex, ..]| vertex).collect(),
            normals: split.iter().map(|&[_, normal, _]| normal).collect(),
            has_file_normals: vn.is_some(),
            primitives,
        }
    }

    /// Returns the number of vertices.
    pub(crate) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Returns whether the normals are `vn` of the file.
    pub(crate) fn has_file_normals(&self) -> bool {
        self.has_file_normals
    }

    /// Returns the positions of the vertices, from those of the mesh.
    pub(crate) fn positions<'a>(&'a self, of_mesh: &'a [[f32; 3]]) -> impl Iterator<Item = [f32; 3]> + 'a {
        self.vertices.iter().map(|&vertex| of_mesh[vertex as usize])
    }

    /// Returns the normals of the vertices, from the `vn` of the file or those of the mesh vertices.
    pub(crate) fn normals<'a>(&'a self, normals: &'a [[f32; 3]]) -> impl Iterator<Item = [f32; 3]> + 'a {
        self.normals.iter().map(|&normal| normals[normal as usize])
    }
}

/// A body, and its points among the samples: positions, then as many normals.
#[derive(Clone, Copy)]
pub(crate) struct BodyPoints<'a> {
    pub(crate) name: &'a str,
    pub(crate) surface: &'a SplitSurface,
    /// The first position.
    pub(crate) first: usize,
}

impl BodyPoints<'_> {
    /// Returns the positions.
    pub(crate) fn positions(&self) -> Range<usize> {
        self.first..self.first + self.surface.len()
    }

    /// Returns the normals.
    pub(crate) fn normals(&self) -> Range<usize> {
        let first = self.positions().end;
        first..first + self.surface.len()
    }
}

/// Returns the `vn` of each corner of a part, from 0; `None` if a face has none.
fn corner_normals(document: &Document, part: &Part) -> Option<Vec<u32>> {
    let mut corners = Vec::new();
    for face in part.faces() {
        corners.extend_from_slice(document.face_normals(face)?);
    }
    Some(corners)
}
