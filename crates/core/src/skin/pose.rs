//! The input of an evaluation.

use crate::lattice::{Embedding, Slopes};
use crate::mesh::Mesh;
use crate::simd::moving::Moving;
use crate::simd::xyzx::Xyzx;
use crate::state::BodyFrame;

/// The input of an evaluation: the mesh, its embedding, and the positions of the lattice vertices.
#[derive(Clone, Copy)]
pub(crate) struct Pose<'a> {
    pub mesh: &'a Mesh,
    pub embedding: &'a Embedding,
    /// Position of each lattice vertex, in cells from the origin of the body frame.
    pub lattice: &'a [Xyzx],
    /// Slopes of the lattice, if the skin is smooth.
    pub slopes: Option<Slopes<'a>>,
    /// The motions of the mesh vertices to `lattice`, if they are known. Only for a smooth skin.
    pub motion: Option<SurfaceMotion<'a>>,
    /// The body frame: its origin and cell size in world space.
    pub frame: &'a BodyFrame,
}

/// The mesh vertices as points that move along straight lines, `p + lambda v`. The points of a component of the lattice
/// have the same `lambda`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceMotion<'a> {
    /// The mesh vertices, in the order of [`Embedding::by_cell`], relative to the center of their component.
    pub points: &'a [Moving],
    /// Component of each lattice vertex.
    pub component_of_vertex: &'a [u32],
    /// Motion of each component.
    pub components: &'a [ComponentMotion],
}

/// The motion of the points of a component of the lattice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ComponentMotion {
    /// The scale `lambda`, in cells.
    pub lambda: f32,
    /// The center, in cells from the origin of the body frame: `(x, y, z, x)`.
    pub center: Xyzx,
}

impl Pose<'_> {
    /// Returns the position of one mesh vertex.
    pub(super) fn position(&self, vertex: usize) -> Xyzx {
        self.embedding.position(vertex, self.lattice, self.slopes)
    }
}
