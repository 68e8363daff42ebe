//! The input of a body.

use std::sync::Arc;

use crate::obj::{Document, Part};
use supple::mesh::Mesh;

/// Input of a body: the origin of its surface.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// Arrays: OBJ frames contain only vertices and faces.
    Mesh(&'a Mesh),
    /// An OBJ file, and the part of the file that is the body. OBJ frames and point caches contain all
    /// vertices of the file, even if the body is only one of its objects; the vertices of the other objects
    /// do not move. PLY frames contain only the body.
    Document(&'a Arc<Document>, &'a Part),
}

impl Source<'_> {
    pub(super) fn mesh(&self) -> &Mesh {
        match self {
            Self::Mesh(mesh) => mesh,
            Self::Document(_, part) => part.mesh(),
        }
    }

    /// Returns the OBJ file and the part of it that is the body; `None` for arrays.
    pub(super) fn file(&self) -> Option<(&Document, &Part)> {
        match self {
            Self::Mesh(_) => None,
            Self::Document(document, part) => Some((document, part)),
        }
    }

    /// Returns the number of points in a point cache, which must equal the number of points of the mesh that
    /// it is applied to: all `v` of an OBJ file, or all vertices of a mesh.
    pub fn points(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.vertices().len(),
            Self::Document(document, _) => document.vertex_count(),
        }
    }
}
