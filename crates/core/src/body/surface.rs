//! The displayed mesh of a body.

use super::piece_mesh::PieceMesh;
use crate::lattice::{Embedding, Lattice};
use crate::mesh::Mesh;
use crate::skin::{Skin, SkinKind};
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
    /// Creates the surface of a mesh in the cells of a lattice. `pieces`: of a broken body.
    pub(super) fn new(
        mesh: Mesh,
        embedding: Embedding,
        (lattice, skin): (&Lattice, SkinKind),
        pieces: Option<Box<PieceMesh>>,
    ) -> Self {
        let embedding = match skin {
            SkinKind::Linear => embedding,
            SkinKind::Smooth => embedding.smoothed(lattice),
        };
        Self { mesh, embedding, skin: Skin::default(), pieces }
    }

    /// Returns the surface as the volume correction reads it.
    pub(super) fn volume_surface(&self) -> volume::Surface<'_> {
        volume::Surface { mesh: &self.mesh, embedding: &self.embedding }
    }
}
