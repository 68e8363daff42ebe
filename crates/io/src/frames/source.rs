//! The input of a body.

use std::sync::Arc;

use super::Format;
use super::ply::Ply;
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

    /// Returns the number of points in a point cache, which must equal the number of points of the mesh that
    /// it is applied to: all `v` of an OBJ file, or all vertices of a mesh.
    pub fn points(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.vertices().len(),
            Self::Document(document, _) => document.vertex_count(),
        }
    }

    /// Returns the size of a frame on disk, in bytes. The size is exact for PLY and PC2, and approximate for OBJ. For
    /// USD it leaves out normals and colliders. For HTML it is that of the positions on disk while a run writes them;
    /// in the page they are compressed.
    pub fn frame_bytes(&self, format: Format) -> u64 {
        match (format, self) {
            (Format::Pc2, _) => 12 * self.points() as u64,
            (Format::Ply, _) => Ply::new(self.mesh()).len(self.mesh().vertices().len()),
            (Format::Obj, Self::Mesh(mesh)) => {
                // Per vertex, approximately: `v`, a line end, and three numbers of nine digits, each with a
                // point and a blank. Per corner: an index and a blank. Per face: `f` and a line end.
                let corners: usize = mesh.faces().map(<[u32]>::len).sum();
                let digits = mesh.vertices().len().checked_ilog10().unwrap_or(0) as usize + 2;
                (34 * mesh.vertices().len() + digits * corners + 2 * mesh.face_count()) as u64
            }
            (Format::Obj, Self::Document(document, _)) => document.bytes().len() as u64,
            // The points and their bounds.
            (Format::Usd, _) => 12 * self.mesh().vertices().len() as u64 + 48,
            (Format::Html, _) => 6 * self.mesh().vertices().len() as u64,
        }
    }
}
