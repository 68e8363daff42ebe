//! The input of the cut.

use super::faces::{BrokenFaces, CutSurface};
use super::planes::{CrackPlane, Planes};
use crate::lattice::Lattice;
use crate::mesh::Mesh;

/// The mesh, the lattice and the cracks.
pub(super) struct Input<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) lattice: &'a Lattice,
    pub(super) cracks: &'a [CrackPlane],
    pub(super) planes: &'a Planes,
    pub(super) faces: &'a BrokenFaces,
    pub(super) surface: CutSurface,
}
