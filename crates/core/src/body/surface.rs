//! The displayed mesh of a body.

use super::piece_mesh::PieceMesh;
use crate::lattice::Embedding;
use crate::mesh::Mesh;
use crate::skin::Skin;
use crate::volume;

/// The displayed mesh, and its embedding in the lattice.
#[derive(Debug)]
pub(crate) struct Surface {
    pub(crate) mesh: Mesh,
    pub(crate) embedding: Embedding,
    pub(crate) skin: Skin,
    /// `None` while the body is whole.
    pub(super) pieces: Option<Box<PieceMesh>>,
}

impl Surface {
    /// Returns the surface as the volume correction reads it.
    pub(super) fn volume_surface(&self) -> volume::Surface<'_> {
        volume::Surface { mesh: &self.mesh, embedding: &self.embedding }
    }
}
