//! The mesh of the pieces of a body, and its origin.

use crate::fracture::{FaceSource, Origin};
use crate::mesh::{Mesh, RefinedMesh};

/// The map from the mesh of a whole body to the mesh of its pieces.
#[derive(Clone, Debug)]
pub struct PieceMesh {
    pub(super) whole: Mesh,
    pub(super) origins: Vec<Origin>,
    pub(super) face_sources: Vec<FaceSource>,
    pub(super) cap_uvs: Vec<[f64; 2]>,
}

impl PieceMesh {
    /// Returns where the vertices and faces of a refined mesh lie on the mesh `whole` that it was refined from. It has
    /// no caps.
    pub fn of_refined(whole: &Mesh, refined: &RefinedMesh) -> Self {
        let given = (0..whole.vertices().len() as u32).map(Origin::Vertex);
        let new = refined.points.iter().map(|&(vertices, weights)| match weights {
            [_, t, 0.0] if t > 0.0 => Origin::Edge { vertices: [vertices[0], vertices[1]], t },
            _ => Origin::Face { vertices, weights },
        });
        let source = |&(face, is_part): &(u32, bool)| match is_part {
            true => FaceSource::Part(face),
            false => FaceSource::Whole(face),
        };
        Self {
            whole: whole.clone(),
            origins: given.chain(new).collect(),
            face_sources: refined.sources.iter().map(source).collect(),
            cap_uvs: Vec::new(),
        }
    }

    /// Returns the mesh of the whole body, in the model's frame.
    pub fn whole(&self) -> &Mesh {
        &self.whole
    }

    /// Returns where each vertex of the pieces lies on the mesh of the whole body, shape `(k,)`.
    pub fn origins(&self) -> &[Origin] {
        &self.origins
    }

    /// Returns the origin of each face of the pieces. Faces of the surfaces of cracks come last.
    pub fn face_sources(&self) -> &[FaceSource] {
        &self.face_sources
    }

    /// Returns texture coordinates in the planes of the cracks, in the length unit of the mesh: one pair for each
    /// corner of each face of the surfaces of cracks, in the order of the faces.
    pub fn cap_uvs(&self) -> &[[f64; 2]] {
        &self.cap_uvs
    }
}
